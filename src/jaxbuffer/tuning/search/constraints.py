"""What every load case of a tuning must keep, in its four kinds: a limit on a quantity, one on the number of impacts,
the end that runs must have, and a ceiling on another objective."""

import abc
import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ...fields import Part, get
from ...mechanisms.limit import IMPACTS, Limit, beyond
from ...mechanisms.mechanism import RequiredEnd
from ...mechanisms.quantity import Quantity
from ...value_text import digits_apart, percent_text, with_unit
from ..problem.cases import Case
from ..problem.objective import Limits, Objective
from ..problem.problem import Problem
from .evaluation import Evaluation
from .programme import Row, StepModel


class Breach(NamedTuple):
    """A constraint that is broken, and by how much in each load case [-], 0 where it is kept or not known; of a ceiling
    the excess is a single one."""

    constraint: "Constraint"
    excess: Float[np.ndarray, " cases"]

    @property
    def case(self) -> int:
        """Return the load case that is farthest beyond."""
        return int(np.argmax(self.excess))

    @property
    def largest(self) -> float:
        """Return the excess there [-]."""
        return float(self.excess[self.case])


class Reached(NamedTuple):
    """What is limited, in one load case, with the slopes that tell what would change it.

    ``value``; ``limit``; ``size``, relative to which a change counts; ``slope`` by the scaled variables; ``falls``:
    whether it must fall, or else rise; ``shown``: the unit of figures, and how many of those its own unit is.
    """

    value: float
    limit: float
    size: float
    slope: Float[np.ndarray, " variables"]
    falls: bool
    shown: tuple[str, float]


@dataclasses.dataclass(frozen=True)
class Constraint(abc.ABC):
    """A constraint of a problem. Its numbers are relative: 0 on the limit, 0.1 ten per cent beyond it."""

    problem: Problem

    limited = True  # a number above 0 breaks something
    of_cases = True  # it has a number for each load case, not one for all

    @property
    @abc.abstractmethod
    def title(self) -> str:
        """Return what is limited, in words."""

    @property
    def bound(self) -> str:
        """Return the limit in words, after a comma: ", limit ≤ 25 mm"; "" where there is none."""
        return ""

    @abc.abstractmethod
    def text(self, number: float) -> str:
        """Return one of its numbers in the unit of what is limited: "25.1 mm"."""

    @abc.abstractmethod
    def numbers(self, point: Evaluation) -> Float[np.ndarray, " cases"]:
        """Return its number in each load case, NaN where it is not known."""

    def values(self, point: Evaluation) -> Float[np.ndarray, " cases"]:
        """Return its number in each load case, infinite where the run failed."""
        return np.where(point.solved, self.numbers(point), np.inf)

    @abc.abstractmethod
    def slopes(self, point: Evaluation) -> Float[np.ndarray, "cases parameters"]:
        """Return the slopes of its numbers by what the evaluation has slopes by, 0 where there are none."""

    def breach(self, point: Evaluation) -> Breach:
        """Return by how much each load case with numbers breaks it."""
        return Breach(self, np.where(point.solved, beyond(self.numbers(point)), 0.0))

    @abc.abstractmethod
    def rows(
        self, quantities: Float[np.ndarray, "cases quantities"], margin: Float[np.ndarray, " cases"]
    ) -> Float[np.ndarray, " rows"]:
        """Return its numbers from the problem's quantities and the margins; none of what has no slopes."""

    @abc.abstractmethod
    def tangent_rows(self, model: StepModel) -> list[Row]:
        """Return `rows` to first order, as rows of the programme that finds a step."""

    @property
    def lowered(self) -> tuple[str, ...]:
        """Return the quantities that the constraint keeps from rising."""
        return ()

    @abc.abstractmethod
    def sentence(self, point: Evaluation, breach: Breach) -> str:
        """Return how it is broken in its worst load case, in words."""

    def heading(self, point: Evaluation, breach: Breach) -> str:
        """Return the limit, in how many load cases it is broken, and the worst of them, in words."""
        cases, k = self.problem.cases, breach.case
        line, worst = self.line_and_worst(point, k)
        count = f"broken in {int(np.sum(breach.excess > 0.0))} of {len(cases)} scenarios"
        return f"{line}: {count}, worst {worst} at {self.problem.in_sentence(k)}"

    def line_and_worst(self, point: Evaluation, k: int) -> tuple[str, str]:
        """Return the limit, and what a load case that breaks it reaches, in words."""
        raise NotImplementedError

    def reached(self, point: Evaluation, k: int) -> Reached | None:
        """Return what is limited in a load case with its slopes; None for what has none."""
        return None


@dataclasses.dataclass(frozen=True)
class QuantityLimit(Constraint):
    """A limit on one of the problem's quantities."""

    limit: Limit

    @property
    def column(self) -> int:
        """Return the number of the quantity among the problem's."""
        return self.problem.names.index(self.limit.name)

    @property
    def quantity(self) -> Quantity:
        """Return what is limited."""
        return self.problem.catalogue[self.limit.name]

    @property
    def title(self) -> str:
        return self.quantity.title

    @property
    def bound(self) -> str:
        return f", limit {self.limit.bound_text(*self.quantity.in_figures)}"

    def text(self, number: float) -> str:
        return self.quantity.in_words(self.limit.bound * (1.0 + self.limit.sign * number), 5)

    def numbers(self, point: Evaluation) -> Float[np.ndarray, " cases"]:
        return self.limit.rows(point.quantities[:, self.column])

    def slopes(self, point: Evaluation) -> Float[np.ndarray, "cases parameters"]:
        slopes = self.limit.slopes(point.quantities_slope[:, self.column])
        return np.where(point.solved[:, None], slopes, 0.0)

    def rows(self, quantities: np.ndarray, margin: np.ndarray) -> np.ndarray:
        return self.limit.rows(quantities[:, self.column])

    def tangent_rows(self, model: StepModel) -> list[Row]:
        one = np.zeros(len(self.problem.names))
        # Relative to the limit, and with the sign that makes a lower limit an upper one.
        one[self.column] = self.limit.slopes(1.0)
        weighted = [model.weighted(k, one) for k in model.cases]
        return [(entries, self.limit.sign - constant, sources) for entries, constant, sources in weighted]

    @property
    def lowered(self) -> tuple[str, ...]:
        return () if self.limit.lowest else (self.limit.name,)

    def sentence(self, point: Evaluation, breach: Breach) -> str:
        problem, limit, quantity, k = self.problem, self.limit, self.quantity, breach.case
        by = f" by {percent_text(breach.largest, '.3g')}" if np.isfinite(breach.largest) else ""
        text = f"{limit.sentence(float(point.quantities[k, self.column]), quantity)}{by}{problem.at_case(k)}"
        # Beside a limit on the peak force stands the first impact, where that alone is above it.
        first = float(np.max(point.first, initial=0.0))
        softened = limit.lowest or limit.name != problem.peak_quantity or problem.mechanism.tuning.lower_bound is None
        if softened or limit.keeps(first):
            return text
        return f"{text}, and the first impact, which no buffer softens, has {quantity.in_words(first, 4)}"

    def line_and_worst(self, point: Evaluation, k: int) -> tuple[str, str]:
        value = float(point.quantities[k, self.column])
        return self.limit.line(self.quantity), self.limit.told_apart(value, *self.quantity.in_figures)

    def reached(self, point: Evaluation, k: int) -> Reached:
        value, slope = float(point.quantities[k, self.column]), point.quantities_slope[k, self.column]
        bound = self.limit.bound
        return Reached(value, bound, bound, slope, not self.limit.lowest, self.quantity.in_figures)


@dataclasses.dataclass(frozen=True)
class ImpactsLimit(Constraint):
    """A limit on the number of impacts, which has no slope: it jumps from one whole number to the next."""

    limit: Limit

    @property
    def title(self) -> str:
        return IMPACTS

    @property
    def bound(self) -> str:
        return f", limit {self.limit.bound_text()}"

    def text(self, number: float) -> str:
        return f"{self.limit.bound * (1.0 + number):.0f}"

    def numbers(self, point: Evaluation) -> Float[np.ndarray, " cases"]:
        return self.limit.rows(point.impacts)

    def slopes(self, point: Evaluation) -> Float[np.ndarray, "cases parameters"]:
        return np.zeros_like(point.margin_slope)

    def rows(self, quantities: np.ndarray, margin: np.ndarray) -> np.ndarray:
        return np.zeros(0)

    def tangent_rows(self, model: StepModel) -> list[Row]:
        return []

    def sentence(self, point: Evaluation, breach: Breach) -> str:
        count = f"{point.impacts[breach.case]} impacts are above {self.limit.bound:.0f}"
        return f"{count}{self.problem.at_case(breach.case)}"

    def line_and_worst(self, point: Evaluation, k: int) -> tuple[str, str]:
        return f"{IMPACTS} {self.limit.bound_text()}", f"{point.impacts[k]}"


@dataclasses.dataclass(frozen=True)
class EndMargin(Constraint):
    """The end that runs must have, by the mechanism's margin, which is positive where a run ends so."""

    @property
    def title(self) -> str:
        return str(self.problem.mechanism.tuning.margin).replace("_", " ")

    def text(self, number: float) -> str:
        return f"{-number:.3g}"

    def numbers(self, point: Evaluation) -> Float[np.ndarray, " cases"]:
        return -point.margin

    def slopes(self, point: Evaluation) -> Float[np.ndarray, "cases parameters"]:
        return np.where(point.solved[:, None], -point.margin_slope, 0.0)

    def rows(self, quantities: np.ndarray, margin: np.ndarray) -> np.ndarray:
        return -margin

    def tangent_rows(self, model: StepModel) -> list[Row]:
        return [model.margin_row(k) for k in model.cases]

    def sentence(self, point: Evaluation, breach: Breach) -> str:
        k = breach.case
        return f"not {self.problem.success} ({self.lack(point, k)}){self.problem.at_case(k)}"

    def lack(self, point: Evaluation, k: int, cases: Sequence[Case] | None = None) -> str:
        """Return how far a load case is from the end, in words. ``cases``: those of the evaluation, by default the
        problem's."""
        problem, mechanism = self.problem, self.problem.mechanism
        outcome, end = mechanism.outcomes(int(point.code[k])), problem.end
        if end is None or not end.quantity:
            return f"{mechanism.tuning.margin} {point.margin[k]:.3g}"
        if not mechanism.succeeded(int(outcome)):
            return str(outcome.reason)
        value = float(point.quantities[k, problem.names.index(end.quantity)])
        design = (problem.cases if cases is None else cases)[k].of(problem.built(point.scaled))
        return end_limit(end, design).sentence(value, problem.catalogue[end.quantity])

    def heading(self, point: Evaluation, breach: Breach) -> str:
        text, end = super().heading(point, breach), self.problem.end
        if end is not None and end.quantity:
            return text
        margin = str(self.problem.mechanism.tuning.margin)
        return f"{text} ({margin}: {self.problem.mechanism.quantities[margin].description})"

    def line_and_worst(self, point: Evaluation, k: int) -> tuple[str, str]:
        return str(self.problem.success), self.lack(point, k)

    def reached(self, point: Evaluation, k: int) -> Reached:
        problem, mechanism, end = self.problem, self.problem.mechanism, self.problem.end
        if end is not None and end.quantity and mechanism.succeeded(int(point.code[k])):
            # The run comes as far as its quantity is known, and that is too large.
            q, quantity = problem.names.index(end.quantity), mechanism.quantities[end.quantity]
            bound = end_limit(end, problem.built(point.scaled)).bound
            slope = point.quantities_slope[k, q]
            return Reached(float(point.quantities[k, q]), bound, bound, slope, True, quantity.in_figures)
        unit = mechanism.quantities[str(mechanism.tuning.margin)].unit
        return Reached(float(point.margin[k]), 0.0, 1.0, point.margin_slope[k], False, (unit, 1.0))


@dataclasses.dataclass(frozen=True)
class Ceiling(Constraint):
    """A ceiling: an objective that must not rise above ``value`` [N] while another one is lowered."""

    objective: Objective
    value: float

    of_cases = False

    @property
    def title(self) -> str:
        return str(self.objective)

    def text(self, number: float) -> str:
        shown = self.objective.shown(self.value + number * self.scale, self.problem.catalogue)
        return with_unit(*shown, 5)

    @property
    def scale(self) -> float:
        """Return the size by which its row is made relative [N]."""
        # A ceiling of zero has no size to be relative to.
        return abs(self.value) or 1.0

    def reaches(self, quantities: Float[np.ndarray, "cases quantities"]) -> float:
        """Return the value of the objective under the ceiling [N]."""
        return self.objective.aggregate(quantities @ self.objective.vector(self.problem.names))

    def numbers(self, point: Evaluation) -> Float[np.ndarray, " one"]:
        return self.rows(point.quantities, point.margin)

    def slopes(self, point: Evaluation) -> Float[np.ndarray, "one parameters"]:
        weights = self.objective.vector(self.problem.names)
        cases = self.objective.case_weights(point.quantities @ weights)
        return np.einsum("c,q,cqn->n", cases, weights, point.quantities_slope)[None] / self.scale

    def breach(self, point: Evaluation) -> Breach:
        return Breach(self, beyond(self.numbers(point)))

    def rows(self, quantities: np.ndarray, margin: np.ndarray) -> np.ndarray:
        return np.array([self.reaches(quantities) / self.scale - self.value / self.scale])

    def tangent_rows(self, model: StepModel) -> list[Row]:
        return [(model.aggregate(self.objective, self.scale, 0.0), self.value / self.scale, ())]

    @property
    def lowered(self) -> tuple[str, ...]:
        return tuple(self.objective.weights)

    def sentence(self, point: Evaluation, breach: Breach) -> str:
        now, catalogue = self.reaches(point.quantities), self.problem.catalogue
        (now, symbol), (value, _) = (self.objective.shown(it, catalogue) for it in (now, self.value))
        reached = with_unit(now, symbol, digits_apart(now, value, 5))
        return f"{self.objective}: {reached} is above {with_unit(value, symbol)}"

    def heading(self, point: Evaluation, breach: Breach) -> str:
        return self.sentence(point, breach)


def constraints_of(problem: Problem, limits: Limits, ceiling: Ceiling | None = None) -> tuple[Constraint, ...]:
    """Return the constraints of a problem: limits by quantity, the end of runs, the ceiling, the number of impacts."""
    # A margin says how near each load case is to the end that it must have.
    ends = limits.require_success and problem.mechanism.tuning.margin is not None
    return (
        *(QuantityLimit(problem, limit) for limit in limits.each),
        *((EndMargin(problem),) if ends else ()),
        *(() if ceiling is None else (ceiling,)),
        *(ImpactsLimit(problem, limit) for limit in limits.of_impacts),
    )


def end_limit(end: RequiredEnd, design: Part) -> Limit:
    """Return the limit on the quantity of an end, below which a run ends so: a number of the design."""
    return Limit(end.quantity, float(get(design, end.threshold)))
