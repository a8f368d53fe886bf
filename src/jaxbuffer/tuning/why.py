"""Why a design is infeasible: each broken limit, where it is broken worst, and which variables hold it back."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .evaluation import Evaluation
from .goal import Goal
from .problem import Variable

LEAST = 1e-6  # change of a limited quantity, relative to its limit, for a change of 1 % of a variable: less is none
WEAK = 0.1  # change relative to the strongest variable's: one with less is not named
WEAK_AT_BOUND = 0.01  # the same of a variable at its bound
FARTHEST = 10.0  # times a variable's value: beyond it no guess is made


class Stated(NamedTuple):
    """A limit in its worst case: the quantity's ``value``, its ``limit`` and ``size``, of which a change counts; its
    ``slope`` by the scaled variables; whether it must fall (``falls``) or rise; ``shown``: the unit of figures, and how
    many of those its own unit is."""

    value: float
    limit: float
    size: float
    slope: Float[np.ndarray, " variables"]
    falls: bool
    shown: tuple[str, float]


class BrokenLimit(NamedTuple):
    """A limit that some cases do not keep to.

    ``excess``: of the worst case, relative to the limit [-]; ``heading``: the limit, in how many cases it is broken,
    the worst of them; ``reason``: which variables hold it back, to first order, "" where no slope tells; ``held``:
    paths of those whose bound does.
    """

    excess: float
    heading: str
    reason: str = ""
    held: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.heading}; {self.reason}" if self.reason else self.heading


def broken_limits(goal: Goal, point: Evaluation) -> list[BrokenLimit]:
    """The limits that a design breaks, the worst first; slopes are those of the evaluation."""
    solved, found = point.solved, list[BrokenLimit]()
    for q, limit in goal.limited():
        excess = np.where(solved, point.quantities[:, q] / limit - np.sign(limit), 0.0)
        if np.any(excess > 0.0):
            found.append(_of_quantity(goal, point, q, limit, excess))
    if goal.must_succeed and np.any(solved & (point.margin < 0.0)):
        found.append(_of_margin(goal, point, np.where(solved, -point.margin, 0.0)))
    return sorted([*found, *_without_slopes(goal, point)], key=lambda limit: -limit.excess)


def _of_quantity(
    goal: Goal, point: Evaluation, q: int, limit: float, excess: Float[np.ndarray, " cases"]
) -> BrokenLimit:
    """An upper limit, or with a minus sign a lower one."""
    problem, k = goal.problem, int(np.argmax(excess))
    name = problem.names[q]
    symbol, factor = shown = problem.catalogue[name].in_figures
    value, falls = float(point.quantities[k, q]), limit > 0.0
    heading = _heading(
        goal,
        f"{name} {'≤' if falls else '≥'} {factor * abs(limit):g} {symbol}".rstrip(" -"),
        excess,
        f"{factor * value:.4g} {symbol}".rstrip(" -"),
    )
    return _told(
        goal, point, excess, heading, Stated(value, abs(limit), abs(limit), point.quantities_slope[k, q], falls, shown)
    )


def _of_margin(goal: Goal, point: Evaluation, excess: Float[np.ndarray, " cases"]) -> BrokenLimit:
    """How the runs must end, by the mechanism's margin."""
    mechanism, k = goal.problem.mechanism, int(np.argmax(excess))
    assert mechanism.margin is not None
    quantity = mechanism.quantities[mechanism.margin]
    worst = f"{mechanism.margin} {point.margin[k]:.3g} {quantity.unit}".rstrip(" -")
    heading = f"{_heading(goal, str(mechanism.success), excess, worst)} ({mechanism.margin}: {quantity.description})"
    stated = Stated(float(point.margin[k]), 0.0, 1.0, point.margin_slope[k], False, (quantity.unit, 1.0))
    return _told(goal, point, excess, heading, stated)


def _told(
    goal: Goal, point: Evaluation, excess: Float[np.ndarray, " cases"], heading: str, stated: Stated
) -> BrokenLimit:
    held = tuple(it.variable.path for it in helping(goal, point, stated) if it.at_bound)
    return BrokenLimit(float(np.max(excess)), heading, reason(goal, point, stated), held)


def _heading(goal: Goal, stated: str, excess: Float[np.ndarray, " cases"], worst: str) -> str:
    cases = goal.problem.cases
    where = cases[int(np.argmax(excess))].label(cases)
    return f"{stated}: broken in {int(np.sum(excess > 0.0))} of {len(cases)} scenarios, worst {worst} at {where}"


class Helping(NamedTuple):
    """A variable that moves a quantity: ``change`` of it for 1 % more of the variable, in the quantity's unit; ``up``:
    whether more of the variable helps; ``at_bound``: whether its bound stands against that."""

    variable: Variable
    value: float
    change: float
    up: bool
    at_bound: bool


def helping(goal: Goal, point: Evaluation, stated: Stated) -> list[Helping]:
    """The variables that bring a quantity nearer to its limit, the strongest first, to first order; without those whose
    effect is none, or weak beside the strongest one's."""
    problem, found = goal.problem, list[Helping]()
    values = problem.values(point.scaled)
    for variable, value, by in zip(problem.variables, values, stated.slope, strict=True):
        change = 0.01 * float(by) * abs(float(value)) / variable.slope(float(value))
        up = (change < 0.0) == stated.falls
        at_bound = variable.at_bound(float(value)) == f"at {'high' if up else 'low'} bound"
        found.append(Helping(variable, float(value), change, up, at_bound))
    strongest = max((abs(it.change) for it in found), default=0.0)
    least = {True: WEAK_AT_BOUND * strongest, False: WEAK * strongest}
    named = [it for it in found if abs(it.change) > max(least[it.at_bound], LEAST * stated.size)]
    return sorted(named, key=lambda it: -abs(it.change))


def reason(goal: Goal, point: Evaluation, stated: Stated) -> str:
    """Which variables at a bound hold a limited quantity back, and which would help within their bounds."""
    way = "fall" if stated.falls else "rise"
    every = helping(goal, point, stated)
    if not every:
        return "no variable changes it: the limit can't be kept by these variables"
    held = [_beyond(goal, stated, it) for it in every if it.at_bound]
    inside = [
        f"{'more' if it.up else 'less'} {it.variable.path} {_effect(stated, it)}" for it in every if not it.at_bound
    ]
    lines = [f"it would {way} with {' or '.join(held)}"] if held else []
    if inside:
        lines.append(f"within the bounds it would {way} with {' or '.join(inside)}, as far as other limits let it")
    return "; ".join(lines)


def _beyond(goal: Goal, stated: Stated, it: Helping) -> str:
    """A variable beyond its bound, and how far about it would have to go."""
    path, problem = it.variable.path, goal.problem
    bound = problem.said(path, it.variable.high if it.up else it.variable.low)
    enough = _enough(stated, it)
    far = "" if enough is None else f", {'to' if it.up else 'down to'} about {problem.said(path, enough, 2)}"
    return f"{it.variable.path} {'above' if it.up else 'below'} its bound of {bound}{far} {_effect(stated, it)}"


def _effect(stated: Stated, it: Helping) -> str:
    sign, (symbol, factor) = "-" if stated.falls else "+", stated.shown
    return f"({sign}{abs(factor * it.change):.2g} {symbol}".rstrip(" -") + " per 1 %)"


def _enough(stated: Stated, it: Helping) -> float | None:
    """The variable's value at which the quantity would reach its limit if it went as a power of the variable; None for
    what has no sign of its own, and beyond a factor of `FARTHEST`."""
    if stated.value * stated.limit <= 0.0 or it.value <= 0.0:
        return None
    with np.errstate(over="ignore"):
        times = float(np.exp(0.01 * stated.value * np.log(stated.limit / stated.value) / it.change))
    return it.value * times if 1.0 / FARTHEST <= times <= FARTHEST else None


def _without_slopes(goal: Goal, point: Evaluation) -> list[BrokenLimit]:
    """What no slope tells of: impacts, failed simulations, other ways to end, the first objective's ceiling."""
    found, problem, solved = list[BrokenLimit](), goal.problem, point.solved
    most = problem.limits.impacts
    if most is not None and np.any(point.impacts > most):
        excess = np.maximum(point.impacts / most - 1.0, 0.0)
        heading = _heading(goal, f"impacts ≤ {most}", excess, str(int(np.max(point.impacts))))
        found.append(BrokenLimit(float(np.max(excess)), heading))
    if not np.all(solved):
        count = f"the simulation failed in {int(np.sum(~solved))} of {len(solved)} scenarios"
        found.append(BrokenLimit(np.inf, count))
    if goal.ceiling is not None and (now := goal.first_value(point)) > goal.ceiling.value:
        first, catalogue = goal.ceiling.objective, problem.catalogue
        heading = f"{first}: {first.said(now, catalogue)} is above {first.said(goal.ceiling.value, catalogue)}"
        found.append(BrokenLimit(now / goal.ceiling.scale - goal.ceiling.value / goal.ceiling.scale, heading))
    return found
