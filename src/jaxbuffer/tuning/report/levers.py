"""Levers of limits: the numbers of a design that change a limited quantity most, by their elasticities."""

import math
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from rich.table import Table

from ...fields import Part, get, paths
from ...hybrid import Solver
from ...mechanisms.quantity import Catalogue
from ...mechanisms.run import Run
from ...sensitivities.sensitivity import sensitivity
from ...tables import table
from ...value_text import number_text
from ..search.checks import PeakForceBound
from ..search.evaluation import Evaluation, Evaluator
from ..search.goal import Goal
from .governing import governed_quantities

SHOWN = 3  # levers of a limit
LEAST = 0.005  # elasticity, below which a number is no lever
NO_VARIABLES = "numbers that are no variables"
DECIDING = "in the load case that decides"
ASK = "levers among all numbers: --levers on, also with --resume, which repeats no search (in Python: levers=True)"
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


def tuned_levers(
    goal: Goal, after: Evaluation, bound: PeakForceBound | None, others: Levers = NO_LEVERS
) -> dict[str, list[Lever]]:
    """Return the levers of each limited quantity and of the objectives among the variables, in the load cases that
    decide them.

    Those of the peak force's lower bound, the first impact, are numbers that are no variables too.

    **Arguments:** ``after``: the design in all load cases, with slopes; ``bound``: of its first impacts; ``others``:
    levers that are no variables, which follow those that are.
    """
    problem, places = goal.problem, {case: case for case in range(len(after.code))}
    # Slopes are by the scaled variables: these make them slopes by the variables' logarithms.
    pairs = zip(problem.variables, problem.values(after.scaled), strict=True)
    sizes = np.array([float(x) / it.slope(float(x)) for it, x in pairs])
    levers = dict[str, list[Lever]]()
    for it in governed_quantities(goal, after):
        by = dict(zip(problem.paths, (it.elasticities(after, places) * sizes).tolist(), strict=True))
        levers[it.name] = [*strongest(by, problem.paths), *others.get(it.name, ())]
    if bound is not None and bound.elasticities:
        levers[FIRST_IMPACT] = strongest(bound.elasticities, problem.paths)
    return {name: each for name, each in levers.items() if each}


def levers_by_numbers(
    goal: Goal, after: Evaluation, evaluator: Evaluator, chosen: Collection[str]
) -> dict[str, list[Lever]]:
    """Return the levers of each limited quantity and of the objectives among all numbers of a design above 0, in the
    load cases that decide them: first the strongest of those that are ``chosen``, then of the others.

    Each of these load cases is run once more, with derivatives by all of these numbers. One by which a slope is not
    known is no lever.

    **Arguments:** ``after``: the design in all load cases; ``evaluator`` of the same problem.
    """
    problem, decided = goal.problem, governed_quantities(goal, after)
    cases = sorted({case for it in decided for case in it.weights})
    addresses = numbers_above_zero(problem.built(after.scaled))
    if not cases or not addresses:
        return {}
    point = evaluator.by_numbers(after.scaled, [problem.cases[k] for k in cases], addresses, evaluator.tight)
    places, levers = {case: place for place, case in enumerate(cases)}, dict[str, list[Lever]]()
    for it in decided:
        # A run that fails with derivatives has none.
        if not all(point.solved[places[case]] for case in it.weights):
            continue
        by = dict(zip(addresses, it.elasticities(point, places).tolist(), strict=True))
        inside, outside = ({path: by[path] for path in by if (path in chosen) == kind} for kind in (True, False))
        levers[it.name] = [*strongest(inside, chosen), *strongest(outside, chosen)]
    return {name: each for name, each in levers.items() if each}


def numbers_above_zero(design: Part) -> list[str]:
    """Return the paths of the numbers of a design that have elasticities."""
    values = {path: get(design, path) for path in paths(design)}
    return [path for path, it in values.items() if isinstance(it, float) and it > 0.0]


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
    numbers = numbers_above_zero(design)
    if not known or not numbers:
        return {}
    found = sensitivity(
        design, run.scenario, numbers, duration, quantities=known, rtol=rtol, solver=solver, certify="none"
    )
    each = zip(known, found.elasticities.tolist(), strict=True)
    levers = {name: strongest(dict(zip(found.paths, row, strict=True)), variables) for name, row in each}
    return {name: it for name, it in levers.items() if it}


def lever_table(levers: Levers, catalogue: Catalogue, where: str = "", others: str = NO_VARIABLES) -> Table | None:
    """Return the levers as people are shown them, a row for each limit; None where there are none.

    **Arguments:** ``where`` they are, in words; ``others``: what levers in brackets are, which have a row of their own
    where one is too short.
    """
    if not levers:
        return None
    outside = any(not it.variable for each in levers.values() for it in each)
    heading = f"Levers: change in % for 1 % more{where and f', {where}'}"
    made = table(f"{heading}; in brackets {others}" if outside else heading, ("limit", "", "", ""))
    for name, each in levers.items():
        one_row = len(each) <= SHOWN
        rows = [each] if one_row else [[it for it in each if it.variable == inside] for inside in (True, False)]
        for place, row in enumerate(filter(None, rows)):
            title = "" if place else lever_title(name, catalogue)
            made.add_row(title, *map(str, row), *[""] * (SHOWN - len(row)))
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
