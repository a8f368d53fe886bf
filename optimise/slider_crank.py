"""(g) The slider-crank: counterweight, clearance and the rod's section tuned, and a random search beside it."""

from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

from jaxbuffer import Problem, Tuned, get, replace, simulate
from jaxbuffer.output.formats import csv_text
from jaxbuffer.study.config import Config

from .study import Sweeps, config, figure, tuned, write

DRAWN, ROUNDS, NARROWER = 256, 4, 0.4  # of the random search: designs a round, rounds, width of each to the one before
MORE, TIGHT = 12, 1e-10  # modes and rtol, to check the tuned design with
SEEN = ("peak_force", "torque_ripple", "rod_stress", "slider_acceleration")
UNITS = ("N", "N m", "Pa", "m/s²")


def main(folder: Path, resume: bool = False, executor: Executor | None = None) -> None:
    """The tuning, the random search beside it, and the tuned design with more modes and at a tighter tolerance."""
    study = config("slider_crank")
    problem = study.problem()
    result = tuned(study, folder, resume, executor)
    rows = searched(study, Sweeps(folder, resume, executor))
    best = rows[int(np.argmin(np.where(rows[:, -1] > 0.0, rows[:, -2], np.inf)))]
    lines = [
        ["tuned", *(float(x) for x in seen_of(study, result.design, {}))],
        ["random search", *(float(x) for x in best)],
        [f"tuned, {MORE} modes", *(float(x) for x in seen_of(study, result.design, {"rod.modes": MORE}))],
        [f"tuned, rtol {TIGHT:g}", *(float(x) for x in seen_of(study, result.design, {}, TIGHT))],
        ["start", *(float(x) for x in seen_of(study, problem.design, {}))],
    ]
    headings = [*(v.path for v in problem.variables), *(f"{a} [{b}]" for a, b in zip(SEEN, UNITS, strict=True))]
    headings += ["objective [N]", "kept"]
    write(folder, "slider_crank.csv", csv_text(["design", *headings], lines))
    write(folder, "search.csv", csv_text(headings, rows.tolist()))
    for name, *numbers in lines:
        print(f"{name:20}", *(f"{x:.5g}" for x in numbers))
    draw_search(folder, problem, rows, result)


def seen_of(study: Config, design: Any, changes: dict[str, Any], rtol: float | None = None) -> np.ndarray:
    """Variables, the worst of each quantity over the speeds, objective, and whether the limits are kept, of one design
    with ``changes``."""
    problem, options = study.problem(), study.options
    one = replace(design, changes)
    runs = [simulate(one, each, options.duration, rtol=rtol or options.rtol) for each in problem.scenarios_met]
    values = np.array([[[float(run.quantity(name)) for name in SEEN]] for run in runs])
    chosen = np.array([[float(x) for x in values_of(problem, design)]])
    return worst_rows(problem, chosen, values)[0]


def values_of(problem: Problem, design: Any) -> list[float]:
    """The variables of a design."""
    return [float(get(design, variable.path)) for variable in problem.variables]


def worst_rows(problem: Problem, chosen: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Rows of designs: ``chosen`` (designs, variables) and ``values`` (speeds, designs, quantities) as in `seen_of`."""
    weights = problem.objective.vector(SEEN)
    objective = np.max(values @ weights, axis=0)
    worst = np.max(values, axis=0)
    limits = np.array([problem.limits.at_most.get(name, np.inf) for name in SEEN])
    feasible = np.all(worst <= limits * (1.0 + 1e-9), axis=1)
    return np.column_stack([chosen, worst, objective, feasible])


def searched(study: Config, sweeps: Sweeps) -> np.ndarray:
    """Designs drawn at random, each round about the best of those before and in a narrower box."""
    problem, options = study.problem(), study.options
    drawn, rows = np.random.default_rng(0), np.empty((0, len(problem.variables) + len(SEEN) + 2))
    centre, width = np.full(len(problem.variables), 0.5), 1.0
    for _ in range(ROUNDS):
        low = np.clip(centre - 0.5 * width, 0.0, 1.0 - width)
        scaled = low + width * drawn.random((DRAWN, len(problem.variables)))
        chosen = np.array([[v.value(x) for v, x in zip(problem.variables, row, strict=True)] for row in scaled])
        many = replace(problem.design, {v.path: chosen[:, k] for k, v in enumerate(problem.variables)})
        runs = [sweeps.found(many, each, options.duration, options.rtol) for each in problem.scenarios_met]
        values = np.array([np.array([getattr(run, name) for name in SEEN]).T for run in runs])
        rows = np.concatenate([rows, worst_rows(problem, chosen, values)])
        best = rows[int(np.argmin(np.where(rows[:, -1] > 0.0, rows[:, -2], np.inf)))]
        centre = np.array([v.scaled(x) for v, x in zip(problem.variables, best, strict=False)])
        width *= NARROWER
    return rows


def draw_search(folder: Path, problem: Problem, rows: np.ndarray, result: Tuned) -> None:
    """Objective over each variable, of the random designs and of the tuned one."""
    names = [variable.path for variable in problem.variables]

    def draw(axes: Any) -> None:
        feasible, left = rows[rows[:, -1] > 0.0], rows[rows[:, -1] == 0.0]
        for one, k, name in zip(axes, range(len(names)), names, strict=True):
            one.plot(left[:, k], left[:, -2], ".", color="#BBBBBB", markersize=2, label="beyond a limit")
            one.plot(feasible[:, k], feasible[:, -2], ".", color="C0", markersize=2, label="within limits")
            one.plot(values_of(problem, result.design)[k], result.objective[1], "*", color="C3", label="tuned")
            one.set(xlabel=name, ylabel="objective [N]")
        axes[0].legend()

    figure(folder, "slider_crank.png", draw, columns=len(names))
