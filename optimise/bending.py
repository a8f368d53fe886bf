"""(f) A probe that bends, and play in the hinge: what they do to Table 2's peaks, its capture and its elasticities."""

import functools
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

from jaxbuffer import Design, Scenario, replace, sensitivity, simulate, table2, with_bending
from jaxbuffer.output.formats import csv_text

from .study import figure, write

FREQUENCIES = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)  # Hz, of the first mode
DAMPING = 0.02  # of the first mode
PLAYS = (1e-5, 2e-5, 5e-5, 1e-4, 2e-4)  # m
COUNTS = (2, 3, 4, 5, 6)  # of modes
MODES = 3  # in the other tables, the default: modes.csv says what more would change
FIRST = 1e-3  # s, longer than a first impact and shorter than the time until the second
QUANTITIES = ("peak_force", "peak_hinge_force", "end_time")
PARAMETERS = ("k_A", "c_A", "k_T", "c_T")
TIGHT = 1e-9  # tolerance of a second run: how far a peak's digits last


def main(folder: Path, resume: bool = False, executor: Executor | None = None) -> None:
    """Peaks first, as tables and a figure; then elasticities, whose programs take minutes to compile."""
    scenario, rigid = Scenario(), table2()
    counts = [
        (f, n, *first_peaks(with_bending(rigid, f, DAMPING, n), scenario)) for f in (5.0, 50.0, 500.0) for n in COUNTS
    ]
    header = ["frequency [Hz]", "modes", "first_peak [N]", "peak_force [N]", "highest [Hz]"]
    write(folder, "modes.csv", csv_text(header, counts))
    bent = [(f, with_bending(rigid, f, DAMPING, MODES)) for f in FREQUENCIES] + [(np.inf, rigid)]
    play = [(p, replace(rigid, {"hinge.play": p})) for p in PLAYS] + [(0.0, rigid)]
    for kind, header, what, draw in (
        ("peaks", PEAKS, peaks, draw_peaks),
        ("elasticities", ELASTICITIES, functools.partial(elasticities, executor), draw_elasticities),
    ):
        tables = [[(x, what(design, scenario)) for x, design in designs] for designs in (bent, play)]
        for first, rows in zip(("frequency [Hz]", "play [m]"), tables, strict=True):
            write(folder, f"{kind}_by_{first.split()[0]}.csv", csv_text([first, *header], [(x, *r) for x, r in rows]))
        figure(folder, f"{kind}.png", lambda axes, tables=tables, draw=draw: draw(axes, *tables), columns=2)


PEAKS = [
    *("outcome", "end_time [s]", "end_time at rtol 1e-9 [s]", "first_peak [N]", "peak_force [N]"),
    *("peak_force at rtol 1e-9 [N]", "peak_hinge_force [N]", "peak_hinge_force at rtol 1e-9 [N]", "bending [m]"),
    *("impacts", "energy [-]", "steps"),
]
ELASTICITIES = [
    *(f"d ln {q} / d ln {p}" for q in QUANTITIES for p in (*PARAMETERS, "tip_mass")),
    *(f"verdict {q}" for q in QUANTITIES),
]


def first_peaks(design: Design, scenario: Scenario) -> tuple[float, float, float]:
    """The first impact's peak, the whole capture's [N], and the highest mode's frequency [Hz]."""
    from jaxbuffer import bending_frequencies

    first, whole = simulate(design, scenario, FIRST, rtol=TIGHT), simulate(design, scenario)
    return float(first.peak_force), float(whole.peak_force), float(bending_frequencies(design)[-1])


def peaks(design: Design, scenario: Scenario) -> list[Any]:
    """What happens, and the same at a tight tolerance: how far the digits last."""
    run, tight = simulate(design, scenario), simulate(design, scenario, rtol=TIGHT)
    return [
        run.outcome.name,
        float(run.end_time),
        float(tight.end_time),
        float(simulate(design, scenario, FIRST, rtol=TIGHT).peak_force),
        float(run.peak_force),
        float(tight.peak_force),
        float(run.peak_hinge_force),
        float(tight.peak_hinge_force),
        float(run.bending),
        int(run.impact_count),
        float(run.balance.energy),
        int(run.attempts),
    ]


def elasticities(executor: Executor | None, design: Design, scenario: Scenario) -> list[Any]:
    """By the buffer's numbers and the tip's mass, with a verdict on each quantity's."""
    paths = [*(f"buffer.{name}" for name in PARAMETERS), "probe.tip_mass"]
    certified = sensitivity(design, scenario, wrt=paths, quantities=QUANTITIES, executor=executor)
    assert certified.certificate is not None
    return [*(float(x) for x in np.ravel(certified.elasticities)), *(v.name for v in certified.certificate.verdicts)]


def draw_peaks(axes: Any, bent: list[tuple[float, list[Any]]], play: list[tuple[float, list[Any]]]) -> None:
    """Peak forces over frequency and over play; their limits as dashed lines."""
    for one, (*rows, (_, limit)), scale, label, what in (
        (axes[0], bent, 1.0, "first bending frequency [Hz]", "rigid probe"),
        (axes[1], play, 1e3, "play in the hinge [mm]", "no play"),
    ):
        for k, (name, column) in enumerate((("first impact", 3), ("contact", 4), ("hinge", 6))):
            one.plot([scale * x for x, _ in rows], [row[column] for _, row in rows], "o-", color=f"C{k}", label=name)
            one.axhline(limit[column], ls="--", lw=0.8, color=f"C{k}")
        one.set(title=f"Peak forces; dashed: {what}", ylabel="force [N]", ylim=(0.0, None), xlabel=label, xscale="log")
    axes[0].legend()


def draw_elasticities(axes: Any, bent: list[tuple[float, list[Any]]], play: list[tuple[float, list[Any]]]) -> None:
    """Of the peak contact force; a cross where the certificate does not trust them."""
    for one, (*rows, (_, limit)), scale, label in (
        (axes[0], bent, 1.0, "first bending frequency [Hz]"),
        (axes[1], play, 1e3, "play in the hinge [mm]"),
    ):
        x = np.array([scale * at for at, _ in rows])
        trusted = np.array([row[-len(QUANTITIES)] == "trusted" for _, row in rows])
        for k, name in enumerate((*PARAMETERS, "tip_mass")):
            values = np.array([row[k] for _, row in rows])
            one.plot(x, values, "-", color=f"C{k}", lw=0.8, label=name)
            one.plot(x[trusted], values[trusted], "o", x[~trusted], values[~trusted], "x", color=f"C{k}")
            one.axhline(limit[k], ls="--", lw=0.6, color=f"C{k}")
        one.set(title="Peak force; ×: not trusted", ylabel="elasticity [-]", xlabel=label, xscale="log")
        if np.max(np.abs([row[: len(PARAMETERS) + 1] for _, row in rows])) > 1.0:
            one.set_yscale("symlog", linthresh=1.0)
    axes[0].legend(ncols=2)
