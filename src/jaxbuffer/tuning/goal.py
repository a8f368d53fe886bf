"""One stage of a tuning: an objective, the constraints as rows g ≤ 0, and both to first order in a step."""

import dataclasses
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .evaluation import Evaluation
from .objective import Objective
from .problem import Problem

ROOM = 1e-4  # relative distance from each limit that steps aim at, so that what the model neglects breaks none
NO_PEAK = -1e9  # N, of a slot without an impact: below every peak, so that it is never the largest


@dataclasses.dataclass(frozen=True)
class Ceiling:
    """A ceiling is an objective that must not rise above ``value`` [N] while another one is lowered."""

    objective: Objective
    value: float

    @property
    def scale(self) -> float:
        """The size by which its row is made relative [N]."""
        return abs(self.value) or 1.0


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
        """The largest peak of each load case [N], 0 without an impact."""
        return np.maximum(self.peaks[:, 0], 0.0)

    @staticmethod
    def of(evaluation: Evaluation) -> "Tangent":
        """Return the first-order model at an evaluated design."""
        peaks = np.where(evaluation.peaks > 0.0, evaluation.peaks, NO_PEAK)
        return Tangent(peaks, *(getattr(evaluation, name) for name in Tangent._fields[1:]))

    def after(self, step: Float[np.ndarray, " variables"]) -> tuple[np.ndarray, np.ndarray]:
        """Return the problem's quantities (cases, quantities) and margins (cases,) after a step."""
        peak = np.maximum(np.max(self.peaks + self.peaks_slope @ step, axis=1), 0.0)
        rest = self.rest + self.rest_slope @ step + self.by_peak * (peak - self.largest)[:, None]
        return np.column_stack([peak, rest]), self.margin + self.margin_slope @ step


@dataclasses.dataclass(frozen=True)
class Goal:
    """The objective and the constraints of one stage. Rows are relative: 0 on the limit, 0.1 ten per cent above it."""

    problem: Problem
    objective: Objective
    ceiling: Ceiling | None = None

    def value(self, evaluation: Evaluation) -> float:
        """Return the true objective [N]: largest peaks, no smoothing."""
        return self._value(self.objective, evaluation.quantities)

    def _value(self, objective: Objective, quantities: np.ndarray) -> float:
        return objective.aggregate(quantities @ self.weights(objective))

    def weights(self, objective: Objective) -> Float[np.ndarray, " quantities"]:
        """Return an objective's weights of the problem's quantities."""
        return objective.vector(self.problem.names)

    def slope(
        self, evaluation: Evaluation, case_weights: Float[np.ndarray, " cases"]
    ) -> Float[np.ndarray, " variables"]:
        """Return the objective's slope by the scaled variables, with given weights of the load cases."""
        by_case = np.einsum("q,cqn->cn", self.weights(self.objective), evaluation.quantities_slope)
        return np.asarray(case_weights @ by_case)

    def signed_limits(self) -> list[tuple[int, float]]:
        """Return the index of each limited quantity in `Problem.names`, and its limit.

        A lower limit has a minus sign: then ``value / limit`` stays at most the limit's sign.
        """
        limits = self.problem.limits
        most, least = {**self.problem.mechanism.always(self.problem.design), **limits.at_most}, limits.at_least
        signed = [*most.items(), *((name, -limit) for name, limit in least.items())]
        return [(self.problem.names.index(name), float(limit)) for name, limit in signed]

    @property
    def must_succeed(self) -> bool:
        """Whether each load case must end as the mechanism's runs should, and a margin says how near it is to that."""
        return self.problem.limits.captured and self.problem.mechanism.tuning.margin is not None

    def rows(
        self, quantities: Float[np.ndarray, "cases quantities"], margin: Float[np.ndarray, " cases"]
    ) -> Float[np.ndarray, " rows"]:
        """Return all constraints that have slopes: limits by quantity, then margins, then the ceiling."""
        parts = [quantities[:, q] / limit - np.sign(limit) for q, limit in self.signed_limits()]
        if self.must_succeed:
            parts.append(-margin)
        if self.ceiling is not None:
            ceiling = self.ceiling
            now = self._value(ceiling.objective, quantities)
            parts.append(np.array([now / ceiling.scale - ceiling.value / ceiling.scale]))
        return np.concatenate([*parts, np.zeros(0)])  # nothing at all cannot be put together

    def excess(self, evaluation: Evaluation) -> Float[np.ndarray, " rows"]:
        """Return by how much each row, and each load case's count of impacts, is above its limit."""
        rows = self.rows(evaluation.quantities, evaluation.margin)
        return np.concatenate([np.maximum(rows, 0.0), self.without_slopes(evaluation)])

    def without_slopes(self, evaluation: Evaluation) -> Float[np.ndarray, " rows"]:
        """Return the part of `excess` without slopes: impacts above their limit, and load cases without numbers."""
        most = self.problem.limits.impacts
        counted = evaluation.impacts / most - 1.0 if most is not None else np.zeros(0)
        return np.maximum(np.concatenate([counted, (~evaluation.solved).astype(float)]), 0.0)

    def feasible(self, evaluation: Evaluation) -> bool:
        """Return whether every constraint holds in every load case."""
        return not np.any(self.excess(evaluation))

    def merit(self, evaluation: Evaluation, scale: float, penalty: float) -> float:
        """Return what a step must lower: objective over ``scale`` plus ``penalty`` times the `excess`."""
        return self.value(evaluation) / scale + penalty * float(np.sum(self.excess(evaluation)))

    def predicted_merit(
        self, tangent: Tangent, step: Float[np.ndarray, " variables"], scale: float, penalty: float
    ) -> float:
        """Return the `merit` after a step to first order."""
        quantities, margin = tangent.after(step)
        above = np.maximum(self.rows(quantities, margin), 0.0)
        return self._value(self.objective, quantities) / scale + penalty * float(np.sum(above))

    def excess_after(self, tangent: Tangent, step: Float[np.ndarray, " variables"]) -> float:
        """Return by how much all rows together are above their limits after a step, to first order."""
        return float(np.sum(np.maximum(self.rows(*tangent.after(step)), 0.0)))

    def broken(self, evaluation: Evaluation) -> list[str]:
        """Return a sentence for each constraint that fails, naming the load case by its values, the worst one first."""
        lines, cases = [], self.problem.cases
        for k in self.worst_first(evaluation):
            if here := self.broken_in(evaluation, k):
                where = cases[k].label(cases)
                lines += [f"{where}: {text}" for text in here]
        if self.ceiling is not None and (now := self.first_value(evaluation)) > self.ceiling.value:
            objective, catalogue = self.ceiling.objective, self.problem.catalogue
            limit = objective.said(self.ceiling.value, catalogue)
            lines.append(f"{objective}: {objective.said(now, catalogue)} is above {limit}")
        return lines

    def worst_first(self, evaluation: Evaluation) -> list[int]:
        """Return the load cases by how far they are above their limits, those without numbers first."""
        excess = self.excess(evaluation)
        if self.ceiling is not None:
            rows = len(self.rows(evaluation.quantities, evaluation.margin))
            excess = np.delete(excess, rows - 1)  # the ceiling's, which is no case's
        total = np.sum(np.nan_to_num(excess.reshape(-1, len(evaluation.code)), nan=np.inf), axis=0)
        return [int(k) for k in np.argsort(-total, kind="stable")]

    def first_value(self, evaluation: Evaluation) -> float:
        """Return the value of the objective under the ceiling [N]."""
        assert self.ceiling is not None
        return self._value(self.ceiling.objective, evaluation.quantities)

    def broken_in(self, evaluation: Evaluation, k: int) -> list[str]:
        """Return what fails in one load case."""
        lines, margin, mechanism = [], evaluation.margin[k], self.problem.mechanism
        limits = self.problem.limits
        limits = dataclasses.replace(limits, at_most={**mechanism.always(self.problem.design), **limits.at_most})
        outcome = mechanism.outcomes(int(evaluation.code[k]))
        if not evaluation.solved[k]:
            own = f" or {', '.join(self.problem.quantities)} is not finite" if self.problem.quantities else ""
            lines.append(f"the simulation failed{own}")
        elif self.must_succeed and margin < 0.0:
            lines.append(f"not {mechanism.success_of(self.problem.design)} ({mechanism.tuning.margin} {margin:.3g})")
        if evaluation.solved[k] and not evaluation.succeeded[k] and margin >= 0.0:
            lines.append(outcome.reason)
        values = dict(zip(self.problem.names, evaluation.quantities[k].tolist(), strict=True))
        return lines + limits.broken(values, int(evaluation.impacts[k]), self.problem.catalogue)
