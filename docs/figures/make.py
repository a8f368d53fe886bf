"""The labelled drawing of the capture mechanism: `PYTHONPATH=src python docs/figures/make.py` writes capture.svg.

Everything in it is drawn from the design of Table 2 by `View.drawing`, at the start of a capture with a
misalignment large enough to be seen.
"""

from pathlib import Path

import jaxbuffer as jb

jb.configure()

import matplotlib  # noqa: E402 # after JAX's settings
import numpy as np  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402

from jaxbuffer.mechanisms.drawing import Spot  # noqa: E402
from jaxbuffer.mechanisms.probe_cone.bodies import B, P, S, T, probe_masses  # noqa: E402
from jaxbuffer.mechanisms.probe_cone.drawing import (  # noqa: E402
    TIP,
    drawing,
    mouth,
)
from jaxbuffer.mechanisms.probe_cone.start import start_motion  # noqa: E402
from jaxbuffer.output.sketch import sketch  # noqa: E402
from jaxbuffer.output.style import STYLE, svg  # noqa: E402

MISALIGNMENT, HINGE = 8.0, 10.0  # °, drawn larger than in most captures
STROKE = 0.035  # m
INK = "#222222"


def frames(design, scenario):
    """The bodies' frames at the start, with the active vehicle turned about the hinge and the probe pushed in."""
    masses = probe_masses(design)
    places = np.array(start_motion(design, scenario, masses)[0]).reshape(4, 3)
    hinge = Spot(B, design.buffer.cylinder_length / 2.0).at(places) + np.array([STROKE, 0.0])
    turn = -np.radians(HINGE)
    places[S] = [*(hinge - design.active.hinge_offset * np.array([np.cos(turn), np.sin(turn)])), turn]
    places[B, 0] += STROKE
    tip = Spot(P, float(masses.front)).at(places)
    return np.vstack([places, [*tip, 0.0]])


def arrow(axes, text, to, at):
    """A word with an arrow to a point."""
    style = {"arrowstyle": "->", "color": INK, "linewidth": 0.9, "shrinkB": 1.0}
    axes.annotate(text, to, at, arrowprops=style, ha="center", va="center", fontsize=9, zorder=6)


def arc(axes, centre, radius, first, last, text, off):
    """An angle [°] with its name."""
    angle = np.radians(np.linspace(first, last, 40))
    x, y = centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)
    axes.plot(x, y, color="#B2182B", linewidth=1.4, zorder=5)
    middle = np.radians(0.5 * (first + last))
    place = (centre[0] + radius * np.cos(middle), centre[1] + radius * np.sin(middle))
    arrow(axes, text, place, (place[0] + off[0], place[1] + off[1]))


def length(axes, first, last, text, side=0.012):
    """A length between two points of one height, with its name."""
    axes.annotate("", first, last, arrowprops={"arrowstyle": "<->", "color": "#B2182B", "shrinkA": 0, "shrinkB": 0})
    axes.text(0.5 * (first[0] + last[0]), first[1] + side, text, ha="center", va="center", fontsize=9)


def main():
    """Draw it and write it."""
    design = jb.table2()
    scenario = jb.Scenario(misalignment=np.radians(MISALIGNMENT))
    at, picture = frames(design, scenario), drawing(design)
    with matplotlib.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(9.0, 5.6), layout="constrained")
        axes = figure.subplots()
        named = sketch(axes, picture.shapes, at)
        hinge, tip, centre = Spot(B, design.buffer.cylinder_length / 2.0).at(at), at[TIP, :2], at[T, :2]
        far, wide = mouth(design)
        throat = -design.cone.offset
        arrow(axes, "throat", Spot(T, throat).at(at), (0.03, -0.12))
        arrow(axes, "capture plane", Spot(T, throat - 0.0106, 1.25 * wide).at(at), (-0.19, 0.25))
        arrow(axes, "upper flank", Spot(T, 0.6 * far + 0.4 * throat, 0.6 * wide + 0.006).at(at), (-0.2, 0.15))
        lower = Spot(T, 0.85 * far + 0.15 * throat, -0.85 * wide - 0.15 * design.cone.throat_radius).at(at)
        arrow(axes, "lower flank", lower, (-0.2, -0.15))
        arrow(axes, "tip", tip + np.array([-0.005, 0.014]), (-0.17, 0.045))
        arrow(axes, "hinge", hinge + np.array([0.0, 0.028]), (-0.235, 0.08))
        rear = Spot(P, -float(probe_masses(design).rear)).at(at)
        length(axes, (rear[0], hinge[1] - 0.045), (hinge[0], hinge[1] - 0.045), "stroke", -0.014)
        for x in (rear[0], hinge[0]):
            axes.plot([x, x], [hinge[1] - 0.055, hinge[1]], ":", color="#B2182B", linewidth=0.9, zorder=5)
        axis = np.array([0.0, 0.24])
        axes.plot(*(centre[:, None] + np.outer([1.0, 0.0], axis)), ":", color=INK, linewidth=0.8, zorder=4)
        turned = np.radians(MISALIGNMENT)
        axes.plot(*(centre[:, None] + np.outer([np.cos(turned), np.sin(turned)], axis)), ":", color=INK, zorder=4)
        arc(axes, centre, 0.2, 0.0, MISALIGNMENT, "misalignment", (0.0, 0.12))
        back = np.array([0.0, -0.22])
        lean = np.radians(-HINGE)
        axes.plot(*(hinge[:, None] + np.outer([1.0, 0.0], back)), ":", color=INK, zorder=4)
        axes.plot(*(hinge[:, None] + np.outer([np.cos(lean), np.sin(lean)], back)), ":", color=INK, zorder=4)
        arc(axes, hinge, 0.2, 180.0 - HINGE, 180.0, "hinge angle", (0.0, 0.1))
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        shown = {part: artist for part, artist in named.items() if part != "capture plane"}
        figure.legend(list(shown.values()), list(shown), loc="outside lower center", ncols=3)
        target = Path(__file__).parent / "capture.svg"
        target.write_bytes(svg(figure))


if __name__ == "__main__":
    main()
