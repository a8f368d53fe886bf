"""The limits that a tuned design breaks: where, how far, which variables stand against them, and what would help."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ...value_text import with_unit
from ..problem.problem import Problem
from ..problem.variable import Variable
from ..search.checks import PeakForceBound
from ..search.constraints import Breach, QuantityLimit, Reached
from ..search.evaluation import Evaluation
from ..search.goal import Goal

LEAST = 1e-6  # change of a limited quantity, relative to its limit, for a change of 1 % of a variable: less is none
WEAK = 0.1  # change relative to the strongest variable's: one with less is not named
WEAK_AT_BOUND = 0.01  # the same of a variable at its bound
FARTHEST = 10.0  # times a variable's value: beyond it no guess is made
LEVERS, LEAST_LEVER = 6, 0.05  # levers of the first impact in a line, and the least elasticity of one [-]


class BrokenLimit(NamedTuple):
    """A limit that is broken in some load cases.

    ``excess``: in the worst load case, relative to the limit [-]; ``heading``: the limit, in how many load cases it is
    broken, the worst of them; ``reason``: which variables stand against it, to first order, "" where no slope tells;
    ``at_bounds``: paths of those whose bound does, if wider bounds may be enough; ``beneath``: the lower bound that the
    limit lies under and what would lower that, "" where it lies under none: no variable within its bounds keeps it
    then.
    """

    excess: float
    heading: str
    reason: str = ""
    at_bounds: tuple[str, ...] = ()
    beneath: str = ""

    def __str__(self) -> str:
        return "; ".join(filter(None, (self.heading, self.beneath or self.reason)))


def broken_limits(goal: Goal, point: Evaluation, bound: PeakForceBound | None = None) -> list[BrokenLimit]:
    """Return the limits that a design breaks, the worst first; slopes are those of the evaluation.

    ``bound``: what is known of the first impacts, None for nothing.
    """
    limits = [_described(goal, point, breach, bound) for breach in goal.breaches(point)]
    if failed := goal.failed(point):
        limits.append(BrokenLimit(np.inf, failed))
    if limits or not goal.require_success or np.all(point.succeeded):
        # Excess is relative, so that limits in different units can be compared.
        return sorted(limits, key=lambda limit: -limit.excess)
    # Load cases end otherwise than they must, and no limit and no margin says it.
    reasons = sorted({goal.problem.mechanism.outcomes(int(code)).reason for code in point.code[~point.succeeded]})
    count = f"broken in {int(np.sum(~point.succeeded))} of {len(point.code)} scenarios"
    return [BrokenLimit(1.0, f"{goal.problem.success}: {count} ({'; '.join(reasons)})")]


def _described(goal: Goal, point: Evaluation, breach: Breach, bound: PeakForceBound | None) -> BrokenLimit:
    """Return a broken limit with its worst load case and, where it has slopes, what stands against it."""
    constraint = breach.constraint
    heading, reached = constraint.heading(point, breach), constraint.reached(point, breach.case)
    if reached is None:
        return BrokenLimit(breach.largest, heading)
    broken = _broken(goal, point, breach, heading, reached)
    return broken._replace(beneath=_beneath(constraint, bound)) if isinstance(constraint, QuantityLimit) else broken


def _beneath(constraint: QuantityLimit, bound: PeakForceBound | None) -> str:
    """Return that a limit lies under its quantity's lower bound, and what would lower that; "" where it does not."""
    problem, limit, shown = constraint.problem, constraint.limit, constraint.quantity.in_figures
    least = None if bound is None else bound.least.get(limit.name)
    if bound is None or least is None or limit.lowest or limit.keeps(least.value):
        return ""
    value = limit.told_apart(least.value, *shown)
    reached = Reached(least.value, limit.bound, limit.bound, least.slope, True, shown)
    # Within the bounds nothing is left to gain: that is what makes it the lower bound.
    widened = [_words(problem, reached, it) for it in helpful_variables(problem, least.scaled, reached) if it.at_bound]
    outside = {path: it for path, it in least.elasticities.items() if path not in problem.paths}
    levers = levers_text(outside)
    lowered = [f"with {' or '.join(widened)}"] if widened else []
    lowered += [f"by numbers that are no variables, {levers}"] if levers else []
    return (
        f"it lies under the lower bound of {limit.name}, {value}{problem.at_case(least.case)}: within the bounds of the"
        " variables the first impact alone, which no buffer softens, has that much"
        + (f"; that would fall {' or '.join(lowered)}" if lowered else "")
    )


def levers_text(elasticities: Mapping[str, float], most: int = LEVERS) -> str:
    """Return the strongest of some elasticities of the first impact in words: "+0.84 % per 1 % of cone.half_angle"."""
    strongest = sorted(elasticities.items(), key=lambda it: -abs(it[1]))[:most]
    texts = [f"{path} {with_unit(value, '', 2, sign=True)}" for path, value in strongest if abs(value) >= LEAST_LEVER]
    return f"in per cent for 1 % more of each: {', '.join(texts)}" if texts else ""


def _broken(goal: Goal, point: Evaluation, breach: Breach, heading: str, reached: Reached) -> BrokenLimit:
    influences = helpful_variables(goal.problem, point.scaled, reached)
    at_bound = [it for it in influences if it.at_bound]
    short, way = _short_of_limit(reached, at_bound), "fall" if reached.falls else "rise"
    # Which variables at a bound stand against the quantity, and which would help within their bounds.
    outside, inside = (
        [_words(goal.problem, reached, it) for it in influences if it.at_bound is at] for at in (True, False)
    )
    lines = [] if influences else ["no variable changes it: the limit can't be kept by these variables"]
    if outside:
        lines.append(f"it would {way} with {' or '.join(outside)}")
    if inside:
        lines.append(f"within the bounds it would {way} with {' or '.join(inside)}, as far as other limits let it")
    reason = "; ".join([*lines, *([short] if short else [])])
    at_bounds = () if short else tuple(it.variable.path for it in at_bound)
    return BrokenLimit(breach.largest, heading, reason, at_bounds)


class Influence(NamedTuple):
    """The influence of a variable on a quantity.

    ``change`` of the quantity for 1 % more of the variable, in the quantity's unit; ``up``: whether more of the
    variable helps; ``at_bound``: whether its bound stands against that.
    """

    variable: Variable
    value: float
    change: float
    up: bool
    at_bound: bool

    def value_at_limit(self, reached: Reached) -> float | None:
        """Return where the variable brings the quantity to its limit, if the quantity goes as a power of it.

        **Returns:** None for what has no sign of its own, and beyond a factor of `FARTHEST`.
        """
        if reached.value * reached.limit <= 0.0 or self.value <= 0.0:
            return None
        # A weak variable overflows, which the comparison below takes for too far.
        with np.errstate(over="ignore"):
            times = float(np.exp(0.01 * reached.value * np.log(reached.limit / reached.value) / self.change))
        return self.value * times if 1.0 / FARTHEST <= times <= FARTHEST else None


def helpful_variables(problem: Problem, scaled: Float[np.ndarray, " variables"], reached: Reached) -> list[Influence]:
    """Return the variables that bring a quantity nearer to its limit to first order, the strongest first; ``scaled``:
    the variables of the design.

    Those whose effect is none, or weak beside the strongest one's, are left out.
    """
    influences, values = list[Influence](), problem.values(scaled)
    for variable, value, by in zip(problem.variables, values, reached.slope, strict=True):
        # The slope by the variable itself is that by the scaled one over d value / d scaled.
        change = 0.01 * float(by) * abs(float(value)) / variable.slope(float(value))
        up = (change < 0.0) == reached.falls
        at_bound = variable.at_bound(float(value)) == f"at {'high' if up else 'low'} bound"
        influences.append(Influence(variable, float(value), change, up, at_bound))
    strongest = max((abs(it.change) for it in influences), default=0.0)
    # A variable at its bound may be named with a weaker effect: its bound is what the user can widen.
    least = {True: WEAK_AT_BOUND * strongest, False: WEAK * strongest}
    strong = [it for it in influences if abs(it.change) > max(least[it.at_bound], LEAST * reached.size)]
    return sorted(strong, key=lambda it: -abs(it.change))


def _short_of_limit(reached: Reached, at_bound: list[Influence]) -> str:
    """Return that even much wider bounds would not keep a limit, by the powers of the variables with which its quantity
    goes; "" where they may, or where nothing can be said."""
    if not at_bound or reached.value * reached.limit <= 0.0:
        return ""
    powers = sum(abs(it.change / (0.01 * reached.value)) for it in at_bound)
    with np.errstate(over="ignore"):
        times = float(FARTHEST ** (-powers if reached.falls == (reached.value > 0.0) else powers))
    best = reached.value * times
    if best <= reached.limit if reached.falls else best >= reached.limit:
        return ""
    symbol, factor = reached.shown
    return (
        f"bounds {FARTHEST:g} times as far would leave it at about {with_unit(factor * best, symbol, 2)}: numbers that"
        " are no variables decide it"
    )


def _words(problem: Problem, reached: Reached, it: Influence) -> str:
    """Say what more or less of a variable does, and of one at its bound how far about it would have to go beyond."""
    path, (symbol, factor) = it.variable.path, reached.shown
    change = abs(factor * it.change) * (-1.0 if reached.falls else 1.0)
    effect = f"({with_unit(change, symbol, 2, sign=True)} per 1 %)"
    if not it.at_bound:
        return f"{'more' if it.up else 'less'} {path} {effect}"
    bound = with_unit(*problem.shown(path, it.variable.high if it.up else it.variable.low))
    far = ""
    if (enough := it.value_at_limit(reached)) is not None:
        far = f", {'to' if it.up else 'down to'} about {with_unit(*problem.shown(path, enough), 2)}"
    return f"{path} {'above' if it.up else 'below'} its bound of {bound}{far} {effect}"
