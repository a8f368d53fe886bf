"""(f) The bar dropped on a plate that bends: contact and plate tuned, and a scan without gradients beside it."""

import itertools
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

from jaxbuffer import Tuned, replace, simulate
from jaxbuffer.output.formats import csv_text
from jaxbuffer.study.config import Config

from .study import Sweeps, config, figure, tuned, write

POINTS, ROUNDS, NARROWER = 7, 6, 0.45  # of the scan: values a variable, grids, width of each to the one before
MANY = 24  # modes, to check the tuned design with
SCANNED = ("peak_force", "penetration", "plate_deflection")


def main(folder: Path, resume: bool = False, executor: Executor | None = None) -> None:
    """The tuning, the scan beside it, and the tuned design's peak with more modes."""
    study = config("bar")
    result = tuned(study, folder, resume, executor)
    rows = scan(study, Sweeps(folder, resume, executor))
    best = min((row for row in rows if row[-1]), key=lambda row: row[3])
    worst = result.after.quantities.max(axis=0)
    most = simulate(replace(result.design, {"plate.modes": MANY}), highest(study), study.options.duration)
    lines = [
        ["tuned", *(float(value) for value in values_of(result)), float(worst[0])],
        ["scanned", *best[:4]],
        [f"tuned, {MANY} modes", *(float(value) for value in values_of(result)), float(most.peak_force)],
    ]
    names = [variable.path for variable in study.problem().variables]
    write(folder, "bar.csv", csv_text(["design", *names, "peak_force [N]"], lines))
    write(folder, "scan.csv", csv_text([*names, "peak_force [N]", "penetration [m]", "deflection [m]", "kept"], rows))
    peaks = [f"{row[-1]:.6g} N" for row in lines]
    print(f"tuned {peaks[0]}, best of {len(rows)} scanned {peaks[1]}, tuned with {MANY} modes {peaks[2]}")

    def draw(axes: Any) -> None:
        feasible, left = [np.array([row for row in rows if row[-1] == flag]) for flag in (True, False)]
        for one, k, name in zip(axes, range(3), names, strict=True):
            one.loglog(left[:, k], left[:, 3], ".", color="#BBBBBB", markersize=2, label="beyond a limit")
            one.loglog(feasible[:, k], feasible[:, 3], ".", color="C0", markersize=2, label="within limits")
            one.loglog(values_of(result)[k], worst[0], "*", color="C3", markersize=10, label="tuned")
            one.set(xlabel=name, ylabel="peak force from 194 mm [N]")
        axes[0].legend()

    figure(folder, "bar.png", draw, columns=3)


def values_of(result: Tuned) -> list[float]:
    """The tuned variables."""
    design = result.design
    return [float(x) for x in (design.impact.stiffness, design.impact.damping, design.plate.thickness)]


def highest(study: Config) -> Any:
    """The scenario of the greatest height, whose peak is the worst."""
    return max(study.problem().scenarios_met, key=lambda scenario: float(scenario.height))


def scan(study: Config, sweeps: Sweeps) -> list[list[Any]]:
    """Grids of designs dropped from the greatest height, each narrower and about the best of the one before."""
    problem = study.problem()
    low = np.log([variable.low for variable in problem.variables])
    high = np.log([variable.high for variable in problem.variables])
    limits = problem.limits.at_most
    centre, width, rows = 0.5 * (low + high), high - low, []
    for _ in range(ROUNDS):
        start = np.clip(centre - 0.5 * width, low, high - width)
        axes = [np.exp(np.linspace(a, a + w, POINTS)) for a, w in zip(start, width, strict=True)]
        grid = np.array(list(itertools.product(*axes)))
        changes = {variable.path: grid[:, k] for k, variable in enumerate(problem.variables)}
        many, options = replace(problem.design, changes), study.options
        sweep = sweeps.found(many, highest(study), options.duration, options.rtol)
        values = np.array([getattr(sweep, name) for name in SCANNED]).T
        feasible = (values[:, 1] <= limits["penetration"]) & (values[:, 2] <= limits["plate_deflection"])
        numbers = np.concatenate([grid, values], axis=1)
        rows += [[*map(float, row), bool(good)] for row, good in zip(numbers, feasible, strict=True)]
        best = int(np.argmin(np.where(feasible, values[:, 0], np.inf)))
        centre, width = np.log(grid[best]), NARROWER * width
    return rows
