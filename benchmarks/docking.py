"""How long docking until held takes beside a capture alone: runs, five derivatives, and a sweep of free starts.

python -m benchmarks docking [--starts 10000]
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Annotated

import jax
import numpy as np
import typer

import jaxbuffer as jb
from jaxbuffer.mechanisms.registry import mechanism_of
from jaxbuffer.sensitivities.gradients import gradients
from jaxbuffer.tables import table, text

FIVE = ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T", "probe.tip_mass")
REPEATS = 15  # of which the quickest counts
UNTIL = 20.0  # s
SMALL_LATCH = {"latch.stiffness": 2e4, "latch.damping": 100.0, "latch.turn_stiffness": 50.0, "latch.turn_damping": 2.0}
LARGE = {
    **{"active.mass": 350.0, "active.inertia": 90.0, "passive.mass": 800.0, "passive.inertia": 300.0},
    **{"buffer.k_A": 2500.0, "buffer.c_A": 60.0, "buffer.k_T": 200.0, "buffer.c_T": 20.0, "buffer.max_stroke": 0.12},
    "probe.tip_mass": 0.02,
}
LARGE_LATCH = {"latch.stiffness": 2e5, "latch.damping": 500.0}


def quickest(call: Callable[[], object]) -> float:
    """Return the quickest time of a call [ms], after one that compiles."""
    times = []
    for _ in range(REPEATS + 1):
        begin = time.perf_counter()
        jax.block_until_ready(jax.tree.leaves(call()))
        times.append(time.perf_counter() - begin)
    return 1e3 * min(times[1:])


def row(name: str, design: jb.Design, latch: dict[str, float], scenario: jb.Scenario) -> list[str]:
    """Return the times of one design, without latches and with them."""
    cells = [name]
    for one in (design, jb.replace(design, latch)):
        duration = mechanism_of(one).duration(one)
        at = [float(jb.get(one, path)) for path in FIVE]
        run = quickest(lambda one=one, duration=duration: jb.simulate(one, scenario, duration))
        slope = quickest(
            lambda one=one, duration=duration, at=at: (
                gradients(mechanism_of(one), one, scenario, FIVE, at, duration, rtol=1e-6).run
            )
        )
        cells += [f"{run:.1f}", f"{slope:.1f}"]
    return cells


def free_starts(count: int) -> str:
    """Return how many free starts are simulated in a second, of a grid over offset and approach speed."""
    side = round(count**0.5)
    over = {
        "scenario.offset": np.linspace(-0.05, 0.05, side),
        "scenario.approach_speed": np.linspace(0.05, 0.25, side),
    }
    design, scenario = jb.replace(jb.table2(), SMALL_LATCH), jb.Scenario(start="free")
    few = {name: values[:: side // 4] for name, values in over.items()}
    jb.sweep(design, scenario, over=few)
    begin = time.perf_counter()
    swept = jb.sweep(design, scenario, over=over)
    passed = time.perf_counter() - begin
    successes = int(np.sum(mechanism_of(design).succeeded(swept.code)))
    return f"{side * side} free starts: {passed:.1f} s, {side * side / passed:.0f} 1/s; {successes} held or latched"


def main(starts: Annotated[int, typer.Option(help="free starts of the sweep")] = 10_000) -> None:
    """Print the table."""
    jb.configure()
    times = table("Quickest warm times in ms")
    for heading in ("", "capture alone", "with five derivatives", "until held, or 20 s", "with five derivatives"):
        times.add_column(heading, justify="right" if heading else "left")
    times.add_row(*row("Table 2, 22 and 24 kg", jb.table2(), SMALL_LATCH, jb.Scenario()))
    large = jb.Scenario(approach_speed=0.16, misalignment=0.0174533)
    times.add_row(*row("350 and 800 kg", jb.replace(jb.table2(), LARGE), LARGE_LATCH, large))
    print(text(times))
    print(free_starts(starts))
