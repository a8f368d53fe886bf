"""One stage of a tuning: an objective, the constraints as rows g ≤ 0, and both to first order in a step."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from ...mechanisms.limit import beyond
from ...value_text import percent_text
from ..problem.cases import Case
from ..problem.objective import Limits, Objective
from ..problem.problem import Problem
from .constraints import Breach, Ceiling, Constraint, EndMargin, QuantityLimit, constraints_of
from .evaluation import Evaluation

ROOM = 1e-4  # relative distance from each limit that steps aim at, so that what the model neglects breaks none
NEARBY = 0.01  # relative room to a limit below which the limit stands in the way
NO_PEAK = -1e9  # N, of a slot without an impact: below every peak, so that it is never the largest


class Tangent(NamedTuple):
    """The quantities of every load case to first order in a step of the scaled variables.

    After a step d the peaks are ``peaks + peaks_slope @ d``, and so on; the rest changes with the largest peak too, by
    ``by_peak`` [unit/N].
    """

    peaks: Float[np.ndarray, "cases peaks"]
    rest: Float[np.ndarray, "cases rest"]
    margin: Float[np.ndarray, " cases"]
    peaks_slope: Float[np.ndarray, "cases peaks variables"]
    rest_slope: Float[np.ndarray, "cases rest variables"]
    margin_slope: Float[np.ndarray, "cases variables"]
    by_peak: Float[np.ndarray, "cases rest"]

    @property
    def largest(self) -> Float[np.ndarray, " cases"]:
        """Return the largest peak of each load case [N], 0 without an impact."""
        return np.max(self.peaks, axis=1, initial=0.0)

    @staticmethod
    def of(evaluation: Evaluation) -> "Tangent":
        """Return the first-order model at an evaluated design."""
        peaks = np.where(evaluation.peaks > 0.0, evaluation.peaks, NO_PEAK)
        return Tangent(peaks, *(getattr(evaluation, name) for name in Tangent._fields[1:]))

    def after(self, step: Float[np.ndarray, " variables"]) -> tuple[np.ndarray, np.ndarray]:
        """Return the problem's quantities (cases, quantities) and margins (cases,) after a step."""
        # The maximum is taken after the step: another impact may be the largest by then.
        peak = np.max(self.peaks + self.peaks_slope @ step, axis=1, initial=0.0)
        rest = self.rest + self.rest_slope @ step + self.by_peak * (peak - self.largest)[:, None]
        # Without peaks none of the quantities is the largest.
        quantities = np.column_stack([peak, rest]) if self.peaks.shape[1] else rest
        return quantities, self.margin + self.margin_slope @ step


@dataclasses.dataclass(frozen=True)
class Goal:
    """The objective and the constraints of one stage. Rows are relative: 0 on the limit, 0.1 ten per cent above it."""

    problem: Problem
    objective: Objective
    ceiling: Ceiling | None = None

    def __post_init__(self) -> None:
        """Let an objective without weights be the problem's main quantity alone."""
        object.__setattr__(self, "objective", self.objective.of(self.problem.main_quantity))

    def value(self, evaluation: Evaluation) -> float:
        """Return the true objective [N]: largest peaks, no smoothing."""
        return self._value(evaluation.quantities)

    def _value(self, quantities: np.ndarray) -> float:
        return self.objective.aggregate(quantities @ self.weights)

    @functools.cached_property
    def weights(self) -> Float[np.ndarray, " quantities"]:
        """Return the objective's weights of the problem's quantities."""
        return self.objective.vector(self.problem.names)

    def slope(
        self, evaluation: Evaluation, case_weights: Float[np.ndarray, " cases"]
    ) -> Float[np.ndarray, " variables"]:
        """Return the objective's slope by the scaled variables, with given weights of the load cases."""
        by_case = np.einsum("q,cqn->cn", self.weights, evaluation.quantities_slope)
        return np.asarray(case_weights @ by_case)

    @functools.cached_property
    def limits(self) -> Limits:
        """Return the problem's limits and those that always hold."""
        return self.problem.limits.with_always(self.problem.mechanism.always(self.problem.design))

    @functools.cached_property
    def constraints(self) -> tuple[Constraint, ...]:
        """Return what each load case must keep, and the ceiling."""
        return constraints_of(self.problem, self.limits, self.ceiling)

    @property
    def on_quantities(self) -> list[QuantityLimit]:
        """Return the limits on the problem's quantities."""
        return [it for it in self.constraints if isinstance(it, QuantityLimit)]

    @property
    def require_success(self) -> bool:
        """Return whether each load case must end as the problem asks, and a margin says how near it is to that."""
        return any(isinstance(it, EndMargin) for it in self.constraints)

    def rows(
        self, quantities: Float[np.ndarray, "cases quantities"], margin: Float[np.ndarray, " cases"]
    ) -> Float[np.ndarray, " rows"]:
        """Return all constraints that have slopes: limits by quantity, then margins, then the ceiling."""
        parts = [it.rows(quantities, margin) for it in self.constraints]
        return np.concatenate([*parts, np.zeros(0)])  # nothing at all cannot be put together

    def excess(self, evaluation: Evaluation) -> Float[np.ndarray, " rows"]:
        """Return by how much each row, and each load case's count of impacts, is above its limit."""
        rows = self.rows(evaluation.quantities, evaluation.margin)
        return np.concatenate([beyond(rows), self.without_slopes(evaluation)])

    def without_slopes(self, evaluation: Evaluation) -> Float[np.ndarray, " rows"]:
        """Return the part of `excess` without slopes: impacts above their limit, and load cases without numbers."""
        counted = [limit.excess(evaluation.impacts) for limit in self.limits.of_impacts]
        return np.concatenate([*counted, (~evaluation.solved).astype(float)])

    def feasible(self, evaluation: Evaluation) -> bool:
        """Return whether every constraint holds in every load case, and every one ends as it must."""
        ended = not self.require_success or np.all(evaluation.succeeded)
        return bool(ended) and not np.any(self.excess(evaluation))

    def excess_by_case(self, evaluation: Evaluation) -> Float[np.ndarray, " cases"]:
        """Return by how much each load case is above its limits, all of them together; infinite where a number is not
        known, and 0 where it keeps them and ends as it must."""
        each = [beyond(it.numbers(evaluation)) for it in self.constraints if it.of_cases]
        total = np.sum([*each, (~evaluation.solved).astype(float)], axis=0)
        # A case that breaks no limit but misses its end must not pass for one that keeps all: the least excess says so.
        missed = self.require_success & ~evaluation.succeeded & (total == 0.0)
        return np.asarray(np.where(missed, np.finfo(float).tiny, total))

    def merit(self, evaluation: Evaluation, scale: float, penalty: float) -> float:
        """Return what a step must lower: objective over ``scale`` plus ``penalty`` times the `excess`."""
        return self.value(evaluation) / scale + penalty * float(np.sum(self.excess(evaluation)))

    def predicted_merit(
        self, tangent: Tangent, step: Float[np.ndarray, " variables"], scale: float, penalty: float
    ) -> float:
        """Return the `merit` after a step to first order."""
        quantities, margin = tangent.after(step)
        above = beyond(self.rows(quantities, margin))
        return self._value(quantities) / scale + penalty * float(np.sum(above))

    def excess_after(self, tangent: Tangent, step: Float[np.ndarray, " variables"]) -> float:
        """Return by how much all rows together are above their limits after a step, to first order."""
        return float(np.sum(beyond(self.rows(*tangent.after(step)))))

    def broken(self, evaluation: Evaluation) -> list[str]:
        """Return a sentence for each constraint that fails, which names the load case; the worst one comes first."""
        lines = []
        for k in self.worst_first(evaluation):
            if here := self.broken_in(evaluation, k):
                lines += [f"{self.problem.in_sentence(k)}: {text}" for text in here]
        ceilings = [it.breach(evaluation) for it in self.constraints if not it.of_cases]
        return lines + [it.constraint.sentence(evaluation, it) for it in ceilings if it.largest > 0.0]

    def breaches(self, evaluation: Evaluation) -> list[Breach]:
        """Return the constraints that a design breaks in load cases with numbers, the one farthest beyond first."""
        each = [it.breach(evaluation) for it in self.constraints]
        return sorted((it for it in each if it.largest > 0.0), key=lambda it: -it.largest)

    def obstacle(self, evaluation: Evaluation) -> str:
        """Return the constraint that a design is farthest beyond, by how much and in which load case, in words; ""
        where it keeps all."""
        if failed := self.failed(evaluation):
            return failed
        return next((it.constraint.sentence(evaluation, it) for it in self.breaches(evaluation)), "")

    def nearest_limit(self, evaluation: Evaluation) -> str:
        """Return the limit with the least room, and the load case that leaves it, in words; "" where each has more
        than `NEARBY`."""
        least, text = NEARBY, ""
        for it in self.on_quantities:
            numbers = it.numbers(evaluation)
            k = int(np.argmax(numbers))
            if evaluation.solved[k] and -numbers[k] < least:
                least = -float(numbers[k])
                room = percent_text(max(least, 0.0))
                text = f"{room} of room to {it.limit.line(it.quantity)}{self.problem.at_case(k)}"
        return text

    def failed(self, evaluation: Evaluation) -> str:
        """Return in how many load cases the simulation failed, in words; "" for none."""
        solved = evaluation.solved
        return "" if np.all(solved) else f"the simulation failed in {int(np.sum(~solved))} of {len(solved)} scenarios"

    def worst_first(self, evaluation: Evaluation) -> list[int]:
        """Return the load cases by how far they are above their limits, those without numbers first."""
        return [int(k) for k in np.argsort(-self.excess_by_case(evaluation), kind="stable")]

    def broken_in(self, evaluation: Evaluation, k: int, cases: Sequence[Case] | None = None) -> list[str]:
        """Return what fails in one load case. ``cases``: those of the evaluation, by default the problem's."""
        problem, outcome = self.problem, self.problem.mechanism.outcomes(int(evaluation.code[k]))
        if not evaluation.solved[k]:
            own = f" or {', '.join(problem.quantities)} is not finite" if problem.quantities else ""
            return [f"the simulation failed{own}"]
        lines, stricter = [], problem.end is not None and not evaluation.succeeded[k]
        if self.require_success and (beyond(-evaluation.margin[k]) > 0.0 or stricter):
            lines.append(f"not {problem.success} ({EndMargin(problem).lack(evaluation, k, cases)})")
        elif not evaluation.succeeded[k] and (self.require_success or problem.limits.require_success):
            lines.append(outcome.reason)
        # A search takes the duration for a time that a run waited for in vain; here that is unknown and keeps no limit.
        known = np.where(problem.known(evaluation.code[k : k + 1])[0], evaluation.quantities[k], np.nan)
        values = dict(zip(problem.names, known.tolist(), strict=True))
        return lines + self.limits.broken(values, int(evaluation.impacts[k]), problem.catalogue)
