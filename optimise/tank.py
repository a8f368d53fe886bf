"""(h) The drop onto a tank: cushion and wall tuned for the lightest wall, and CMA-ES without gradients beside it."""

import dataclasses
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np

from jaxbuffer import Problem, get, replace
from jaxbuffer.output.formats import csv_text
from jaxbuffer.tuning.search.evaluation import Evaluation, Evaluator

from .study import config, figure, tuned, write

DESIGNS = 300  # that CMA-ES evaluates, each at the greatest height alone
SOUND = 1150.0  # m/s in the liquid, to check the tuned design with
PENALTY = 10.0  # on a limit's relative excess, in masses of the start


def main(folder: Path, resume: bool = False, executor: Executor | None = None) -> None:
    """The tuning, CMA-ES beside it, and the best of each in all cases."""
    study = config("tank")
    problem = study.problem()
    result = tuned(study, folder, resume, executor)
    rows = searched(highest(problem))
    best = rows[int(np.argmin(rows[:, -1]))]
    with Evaluator(problem, slopes=False, executor=executor) as evaluator:
        start, gradients, without = evaluator([problem.start(), result.after.scaled, best[: len(problem.variables)]])
    with Evaluator(with_sound(problem, SOUND), slopes=False, executor=executor) as evaluator:
        (real,) = evaluator([result.after.scaled])
    lines = [
        [name, *(float(x) for x in problem.values(one.scaled)), *worst(problem, one), excess(problem, one)]
        for name, one in (("start", start), ("tuned", gradients), ("CMA-ES", without), (f"tuned, {SOUND:g} m/s", real))
    ]
    limited = [f"{name} [{problem.catalogue[name].unit}]" for name in limit_names(problem)]
    write(folder, "tank.csv", csv_text(["design", *problem.paths, *limited, "excess [-]"], lines))
    write(folder, "cma.csv", csv_text([*problem.paths, "wall_mass [kg]", "excess [-]", "merit [-]"], rows.tolist()))
    for name, *numbers in lines:
        print(f"{name:8}", *(f"{x:.5g}" for x in numbers))

    def draw(axes: Any) -> None:
        feasible = np.where(rows[:, -2] <= 0.0, rows[:, -3], np.inf)
        axes.plot(1 + np.arange(len(rows)), rows[:, -3], ".", color="#BBBBBB", label="CMA-ES, each design")
        axes.plot(1 + np.arange(len(rows)), np.minimum.accumulate(feasible), color="C0", label="CMA-ES, within limits")
        axes.axhline(result.objective[1], color="C3", label="tuned")
        axes.set(xlabel="designs", ylabel="mass of the wall [kg]")
        axes.legend()

    figure(folder, "tank.png", draw)


def with_sound(problem: Problem, speed: float) -> Problem:
    """The problem with another speed of sound in the liquid."""
    return dataclasses.replace(problem, design=replace(problem.design, {"contents.sound_speed": speed}))


def highest(problem: Problem) -> Problem:
    """The problem with the drops from the greatest height alone, whose forces and stresses are the largest."""
    most = max(get(case.scenario, "height") for case in problem.cases)
    return dataclasses.replace(
        problem, scenarios=[case for case in problem.cases if get(case.scenario, "height") == most]
    )


def limit_names(problem: Problem) -> list[str]:
    """The objective's quantity, then those with a limit."""
    return [*problem.objective.weights, *problem.limits.at_least, *problem.limits.at_most]


def worst(problem: Problem, one: Evaluation) -> list[float]:
    """Of each quantity asked for the worst over the cases."""
    least = problem.limits.at_least
    columns = {name: one.quantities[:, problem.names.index(name)] for name in limit_names(problem)}
    return [float(values.min() if name in least else values.max()) for name, values in columns.items()]


def excess(problem: Problem, one: Evaluation) -> float:
    """The largest relative excess over a limit [-]; 1 where a run is not whole."""
    if not np.all(one.succeeded):
        return 1.0
    over = [float(one.quantities[:, problem.names.index(n)].max()) / x - 1.0 for n, x in problem.limits.at_most.items()]
    under = [
        1.0 - float(one.quantities[:, problem.names.index(n)].min()) / x for n, x in problem.limits.at_least.items()
    ]
    return max(*over, *under)


def searched(problem: Problem) -> np.ndarray:
    """CMA-ES from the problem's start: scaled variables, mass, excess and merit of each design."""
    import cma

    size, rows = len(problem.variables), list[list[float]]()
    options = {"bounds": [[0.0] * size, [1.0] * size], "maxfevals": DESIGNS, "seed": 1, "verbose": -9}
    strategy = cma.CMAEvolutionStrategy(problem.start(), 0.1, options)
    with Evaluator(problem, slopes=False) as evaluator:
        first = worst(problem, evaluator([problem.start()])[0])[0]
        while not strategy.stop():
            drawn = strategy.ask()
            for scaled, one in zip(drawn, evaluator(drawn), strict=True):
                mass, over = worst(problem, one)[0], excess(problem, one)
                rows.append([*map(float, scaled), mass, over, mass / first + PENALTY * max(over, 0.0)])
            strategy.tell(drawn, [row[-1] for row in rows[-len(drawn) :]])
    return np.array(rows)
