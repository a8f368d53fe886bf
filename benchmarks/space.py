"""What a capture in space costs: at equal accuracy beside a compiled loop of its own, DOP853 on equations in minimal
coordinates written by hand, and at default settings beside the plane's capture.

How long its programs compile beside the plane's, in seconds of processor:
python -m benchmarks equations --mechanism capture --mechanism capture3d --seconds
"""

from __future__ import annotations

from functools import partial
from typing import Annotated

import typer

from . import ours
from .accuracy import RTOLS, TARGET, Result, Setting, cheapest, errors, measured, race
from .names import chosen
from .peers.reference import Reference
from .peers.solvers import ABSOLUTE
from .peers.space import Parameters, capture
from .peers.space.chain import MOVES_S, STATES
from .peers.space.check import references
from .plan import of_tests

import jaxbuffer as jb  # isort: skip # after `ours`, which configures JAX

import numpy as np

from jaxbuffer.tables import table, text

PEER = "compiled DOP853"
MOST = 3.5  # [-] of the plane's time


def tolerances(rtol: float, parts: tuple[float, float]) -> np.ndarray:
    """Absolute tolerances (35,) as parts of the relative one, of positions and of rates."""
    allowed = np.full(STATES, rtol * parts[1])
    allowed[:MOVES_S] = rtol * parts[0]
    return allowed


def peer_curves(parameters: Parameters, exact: Reference, repeats: int) -> list[list[Setting]]:
    """The peer's work-precision curves, one for each choice of absolute tolerances."""
    capture(parameters, RTOLS[-1], 1e-6)  # compiles
    return [
        [
            measured(
                PEER,
                f"rtol {rtol:.0e}, atol {parts[0]:g} and {parts[1]:g} rtol",
                partial(capture, parameters, rtol, tolerances(rtol, parts)),
                partial(errors, exact=exact),
                repeats,
            )
            for rtol in RTOLS
        ]
        for parts in ABSOLUTE
    ]


def own_curve(design: jb.Design3D, scenario: jb.Scenario3D, exact: Reference, repeats: int) -> list[Setting]:
    """The product's curve, as a user calls it, from Python numbers to Python numbers."""

    def run(rtol: float) -> Result:
        return ours.result(jb.simulate(design, scenario, exact.parameters.T, rtol=rtol))

    run(RTOLS[-1])  # compiles
    return [
        measured(ours.NAME, f"rtol {rtol:.0e}", partial(run, rtol), partial(errors, exact=exact), repeats)
        for rtol in RTOLS
    ]


def beside_the_peer(exact: Reference, repeats: int) -> list[str]:
    """A row of a reference capture: both times at equal accuracy [ms], their ratio, and the settings."""
    case = of_tests("docking3d.reference").CASES[exact.name]
    curves = peer_curves(exact.parameters, exact, repeats)
    pair = cheapest([own_curve(case.design, case.scenario, exact, repeats)], TARGET), cheapest(curves, TARGET)
    if pair[0] is None or pair[1] is None:
        missing = " and ".join(name for name, one in zip((ours.NAME, PEER), pair, strict=True) if one is None)
        return [exact.name, "", "", "", f"{missing}: nowhere within {TARGET:g}"]
    mine, theirs = race(list(pair), repeats)
    times = [f"{1e3 * one.seconds:.3g}" for one in (mine, theirs)]
    return [exact.name, *times, f"{theirs.seconds / mine.seconds:.3g}", f"{mine.tolerances}; {theirs.tolerances}"]


def beside_the_plane(repeats: int) -> str:
    """A line: Table 2's capture in space over the plane's, at default settings, in turns."""

    def plane() -> Result:
        return ours.result(jb.simulate(jb.table2(), jb.Scenario()))

    def space() -> Result:
        return ours.result(jb.simulate(jb.docking3d(), jb.Scenario3D(azimuth=0.7)))

    for run in (plane, space):
        run()  # compiles
    settings = [measured(ours.NAME, "default", run, lambda _: {"none": 0.0}) for run in (plane, space)]
    flat, deep = (1e3 * setting.seconds for setting in race(settings, repeats))
    met = "at most" if deep <= MOST * flat else "MORE than"
    return f"in space {deep:.2f} ms, in the plane {flat:.2f} ms: {deep / flat:.2f} times, {met} {MOST}"


def main(
    case: Annotated[list[str] | None, typer.Option(help="of a reference capture; all captures unless given")] = None,
    repeats: Annotated[int, typer.Option(help="runs of which the quickest counts")] = 10,
) -> int:
    """Print the table; the exit status."""
    known = {each.name: each for each in references() if each.outcome == "captured"}
    shown = table(f"Warm times in ms, peak force and end time within {TARGET:g}")
    for heading in ("capture", ours.NAME, PEER, "times as fast", "settings"):
        shown.add_column(heading, justify="left" if heading in ("capture", "settings") else "right")
    for name in chosen(case, known, "capture"):
        shown.add_row(*beside_the_peer(known[name], repeats))
    print(text(shown))
    print(beside_the_plane(repeats))
    return 0
