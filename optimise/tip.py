"""(d) Tip mass, welded or free to spin: what it does to the peak, and what the effective kinetic energy predicts."""

from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

from jaxbuffer import Design, first_impact, replace
from jaxbuffer.output.formats import csv_text

from .study import Sweeps, config, figure, write

MASSES = np.geomspace(0.02, 0.2, 25)  # kg


def main(folder: Path, resume: bool = False, executor: Executor | None = None) -> None:
    """Sweeps of the tip's mass at every scenario of the study, welded and free, as table and figure."""
    study, sweeps, rows = config("tip"), Sweeps(folder, resume, executor), []
    for free in (False, True):
        for scenario in study.scenarios:
            design: Design = replace(study.design, {"probe.free_tip": free, "probe.tip_mass": MASSES})
            sweep = sweeps.found(design, scenario, study.options.duration, study.options.rtol)
            first = sweeps.found(design, scenario, FIRST, study.options.rtol)
            for mass, peak, begin, code in zip(MASSES, sweep.peak_force, first.peak_force, sweep.code, strict=True):
                closed = first_impact(replace(design, {"probe.tip_mass": float(mass)}), scenario)
                numbers = [float(x) for x in (mass, peak, begin, closed.elastic_peak, closed.effective_energy)]
                rows.append([free, float(scenario.approach_speed), *numbers, int(code)])
    header = ["free_tip", "approach_speed [m/s]", "tip_mass [kg]", "peak_force [N]", "first_peak [N]"]
    write(folder, "tip.csv", csv_text([*header, "closed_form [N]", "T_c [J]", "outcome"], rows))

    def draw(axes: Any) -> None:
        for k, scenario in enumerate(study.scenarios):
            speed = float(scenario.approach_speed)
            for free, style in ((False, "-"), (True, "--")):
                mine = np.array([row[2:] for row in rows if row[0] == free and row[1] == speed])
                label = f"{speed:g} m/s, {'free' if free else 'welded'}"
                axes[0].plot(1e3 * mine[:, 0], mine[:, 1], style, color=f"C{k}", label=label)
                axes[1].plot(1e3 * mine[:, 0], mine[:, 2] / mine[:, 3], style, color=f"C{k}", label=label)
                axes[2].plot(1e3 * mine[:, 0], mine[:, 1] / mine[:, 3], style, color=f"C{k}", label=label)
        for one, title, y in zip(
            axes,
            ("Peak of the whole capture", "First impact over its closed form", "Peak over the first's closed form"),
            ("peak force [N]", "ratio [-]", "ratio [-]"),
            strict=True,
        ):
            one.set(title=title, xlabel="tip mass [g]", ylabel=y, xscale="log")
        axes[0].legend()

    figure(folder, "tip.png", draw, columns=3)


FIRST = 1e-3  # s, longer than a first impact and shorter than the time until the second
