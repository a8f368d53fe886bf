"""Levers of limits: the numbers of a design that change a limited quantity most, by their elasticities."""

import math
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from rich.table import Table

from ...fields import get, paths
from ...hybrid import Solver
from ...mechanisms.quantity import Catalogue
from ...mechanisms.run import Run
from ...sensitivities.sensitivity import sensitivity
from ...tables import table
from ...value_text import number_text
from ..problem.problem import Problem
from ..search.checks import PeakForceBound
from ..search.evaluation import Evaluation
from ..search.goal import Goal

SHOWN = 3  # levers of a limit
FAR = 0.5  # room of a limit that a mechanism always has, beyond which its levers are not shown
LEAST = 0.005  # elasticity, below which a number is no lever
FIRST_IMPACT = "first_impact"  # what is named so among limits: the lower bound of the peak force


class Lever(NamedTuple):
    """A number that changes a quantity: its ``path``, the quantity's ``elasticity`` by it, in per cent for 1 % more of
    the number [-], and whether it is a ``variable`` of the problem."""

    path: str
    elasticity: float
    variable: bool

    def __str__(self) -> str:
        text = f"{self.path} {number_text(self.elasticity, 2, sign=True)}"
        return text if self.variable else f"[{text}]"


Levers = Mapping[str, Sequence[Lever]]  # by quantity
NO_LEVERS: Levers = MappingProxyType({})


def strongest(elasticities: Mapping[str, float], variables: Collection[str]) -> list[Lever]:
    """Return the three levers with the largest elasticities; none that is not known or next to nothing."""
    known = {path: it for path, it in elasticities.items() if math.isfinite(it) and abs(it) >= LEAST}
    ordered = sorted(known.items(), key=lambda it: -abs(it[1]))[:SHOWN]
    return [Lever(path, it, path in variables) for path, it in ordered]


def tuned_levers(goal: Goal, after: Evaluation, bound: PeakForceBound | None) -> dict[str, list[Lever]]:
    """Return the levers of each limited quantity among the variables, in the load case that is nearest to its limit.

    Those of the peak force's lower bound, the first impact, are numbers that are no variables too.

    **Arguments:** ``after``: the design in all load cases, with slopes; ``bound``: of its first impacts.
    """
    problem, found = goal.problem, list[tuple[float, str, list[Lever]]]()
    for it in goal.on_quantities:
        numbers = it.numbers(after)
        if not np.any(known := np.isfinite(numbers) & after.solved):
            continue
        case = int(np.argmax(np.where(known, numbers, -np.inf)))
        room = -float(numbers[case])
        if it.limit.name not in problem.limits.names and room > FAR:
            continue
        reached = it.reached(after, case)
        by = _elasticities(problem, after, reached.value, reached.slope)
        found.append((room, it.limit.name, strongest(by, problem.paths)))
    # What stands in the way first.
    levers = {name: each for _, name, each in sorted(found, key=lambda it: it[0])}
    if bound is not None and bound.elasticities:
        levers[FIRST_IMPACT] = strongest(bound.elasticities, problem.paths)
    return {name: each for name, each in levers.items() if each}


def run_levers(
    run: Run, names: Collection[str], variables: Collection[str], duration: float, rtol: float, solver: Solver | str
) -> dict[str, list[Lever]]:
    """Return the levers of limited quantities in one run, among all numbers of its design above 0.

    It is differentiated by each of them, which takes several times as long as the run, and a program of its own.

    **Arguments:** ``names`` of the quantities, of which those without derivatives are left out; ``variables``: paths of
    the problem's; ``duration`` [s], ``rtol`` [-], ``solver``: of the run.
    """
    mechanism, design = run.mechanism, run.design
    known = [name for name in names if name in mechanism.quantities and mechanism.quantities[name].differentiable]
    values = {path: get(design, path) for path in paths(design)}
    numbers = [path for path, it in values.items() if isinstance(it, float) and it > 0.0]
    if not known or not numbers:
        return {}
    found = sensitivity(
        design, run.scenario, numbers, duration, quantities=known, rtol=rtol, solver=solver, certify="none"
    )
    each = zip(known, found.elasticities.tolist(), strict=True)
    levers = {name: strongest(dict(zip(found.paths, row, strict=True)), variables) for name, row in each}
    return {name: it for name, it in levers.items() if it}


def _elasticities(
    problem: Problem, after: Evaluation, value: float, slope: Sequence[float] | np.ndarray
) -> dict[str, float]:
    """Return the elasticities of a value by the variables, from its slopes by the scaled ones."""
    if not value:
        return {}
    each = zip(problem.variables, problem.values(after.scaled), np.asarray(slope).tolist(), strict=False)
    return {it.path: float(by) * float(x) / (it.slope(float(x)) * value) for it, x, by in each}


def lever_table(levers: Levers, catalogue: Catalogue) -> Table | None:
    """Return the levers as people are shown them, a row for each limit; None where there are none."""
    if not levers:
        return None
    outside = any(not it.variable for each in levers.values() for it in each)
    brackets = "; in brackets numbers that are no variables" if outside else ""
    made = table(f"Levers: change in % for 1 % more{brackets}", ("limit", "", "", ""))
    for name, each in levers.items():
        made.add_row(lever_title(name, catalogue), *map(str, each), *[""] * (SHOWN - len(each)))
    return made


def lever_title(name: str, catalogue: Catalogue) -> str:
    """Return what is limited, in words."""
    quantity = catalogue.get(name)
    return (quantity.title if quantity is not None else "") or name.replace("_", " ")


def levers_record(levers: Levers) -> dict[str, list[dict[str, object]]]:
    """Return levers as a record."""
    return {
        name: [{"path": it.path, "elasticity": it.elasticity, "variable": it.variable} for it in each]
        for name, each in levers.items()
    }
