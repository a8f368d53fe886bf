"""Why a design is infeasible: each broken limit, where it is broken worst, and which variables hold it back."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ..fields import unit
from .evaluation import Evaluation
from .goal import Goal

AT_BOUND = 1e-6  # of a variable's range
LEAST = 1e-3  # change of a limited quantity, relative to its limit, for a change of 1 % of a variable


class BrokenLimit(NamedTuple):
    """A limit that some cases do not keep to.

    ``excess``: of the worst case, relative to the limit [-]; ``heading``: the limit, in how many cases it is broken,
    the worst of them; ``reason``: which variables hold it back, to first order, "" where no slope tells.
    """

    excess: float
    heading: str
    reason: str = ""

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
    symbol, value = problem.catalogue[name].unit, float(point.quantities[k, q])
    stated = f"{name} {'≤' if limit > 0.0 else '≥'} {abs(limit):g} {symbol}".rstrip(" -")
    heading = _heading(goal, stated, excess, f"{value:.4g} {symbol}".rstrip(" -"))
    way = "fall" if limit > 0.0 else "rise"
    slope = point.quantities_slope[k, q]
    return BrokenLimit(float(excess[k]), heading, reason(goal, point, slope, abs(limit), way, symbol))


def _of_margin(goal: Goal, point: Evaluation, excess: Float[np.ndarray, " cases"]) -> BrokenLimit:
    """How the runs must end, by the mechanism's margin."""
    mechanism, k = goal.problem.mechanism, int(np.argmax(excess))
    assert mechanism.margin is not None
    quantity = mechanism.quantities[mechanism.margin]
    worst = f"{mechanism.margin} {point.margin[k]:.3g} {quantity.unit}".rstrip(" -")
    heading = f"{_heading(goal, str(mechanism.success), excess, worst)} ({mechanism.margin}: {quantity.description})"
    return BrokenLimit(float(excess[k]), heading, reason(goal, point, point.margin_slope[k], 1.0, "rise", ""))


def _heading(goal: Goal, stated: str, excess: Float[np.ndarray, " cases"], worst: str) -> str:
    cases = goal.problem.cases
    where = cases[int(np.argmax(excess))].label(cases)
    return f"{stated}: broken in {int(np.sum(excess > 0.0))} of {len(cases)} scenarios, worst {worst} at {where}"


def reason(
    goal: Goal, point: Evaluation, slope: Float[np.ndarray, " variables"], size: float, way: str, symbol: str
) -> str:
    """Which variables at a bound hold a quantity back that must ``way`` ("fall" or "rise"), to first order.

    **Arguments:** ``slope`` of the quantity [its unit] by the scaled variables; ``size``: its limit's, of which a
    change by `LEAST` counts; ``symbol``: its unit.
    """
    problem, held, inside = goal.problem, list[str](), list[str]()
    values = problem.values(point.scaled)
    for variable, scaled, value, by in zip(problem.variables, point.scaled, values, slope, strict=True):
        change = 0.01 * float(by) * abs(float(value)) / variable.slope(float(value))  # for 1 % more of the variable
        if abs(change) < LEAST * size:
            continue
        up = (change < 0.0) == (way == "fall")  # whether more of the variable helps
        helped = f"({'-' if way == 'fall' else '+'}{abs(change):.2g} {symbol}".rstrip() + " per 1 %)"
        if (scaled >= 1.0 - AT_BOUND) if up else (scaled <= AT_BOUND):
            bound = f"{variable.high if up else variable.low:g} {unit(problem.design, variable.path)}".rstrip(" -")
            held.append(f"{variable.path} {'above' if up else 'below'} its bound of {bound} {helped}")
        else:
            inside.append(f"{'more' if up else 'less'} {variable.path} {helped}")
    lines = [f"it would {way} with {' or '.join(held)}"] if held else []
    if inside:
        lines.append(f"within the bounds it would {way} with {' or '.join(inside)}, if nothing else stood against it")
    return "; ".join(lines) or (
        f"no variable changes it by more than {100.0 * LEAST:g} % of its limit a %: the limit can't be kept by these"
        " variables near this design"
    )


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
        heading = f"{goal.ceiling.objective}: {now:.5g} N is above {goal.ceiling.value:.5g} N"
        found.append(BrokenLimit(now / goal.ceiling.scale - goal.ceiling.value / goal.ceiling.scale, heading))
    return found
