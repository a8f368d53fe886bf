"""One stage of a tuning: an objective, the constraints as rows g ≤ 0, and what both are to first order."""

import dataclasses
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .evaluation import Evaluation
from .objective import Objective
from .problem import Problem

ROOM = 1e-4  # relative distance from each limit that steps aim at, so that what the model neglects breaks none
NO_PEAK = -1e9  # N


@dataclasses.dataclass(frozen=True)
class Ceiling:
    """An objective that must not rise above ``value`` [N] while another one is lowered."""

    objective: Objective
    value: float

    @property
    def scale(self) -> float:
        """By which its row is made relative [N]."""
        return abs(self.value) or 1.0


class Tangent(NamedTuple):
    """Quantities of every case to first order in a step of the scaled variables: at a step d, ``peaks + peaks_slope @
    d`` …; the rest changes with the largest peak too, by ``by_peak`` [unit/N]."""

    peaks: Float[np.ndarray, "cases peaks"]
    rest: Float[np.ndarray, "cases rest"]
    margin: Float[np.ndarray, " cases"]
    peaks_slope: Float[np.ndarray, "cases peaks variables"]
    rest_slope: Float[np.ndarray, "cases rest variables"]
    margin_slope: Float[np.ndarray, "cases variables"]
    by_peak: Float[np.ndarray, "cases rest"]

    @property
    def largest(self) -> Float[np.ndarray, " cases"]:
        """Each case's largest peak [N], 0 without an impact."""
        return np.maximum(self.peaks[:, 0], 0.0)

    @staticmethod
    def of(evaluation: Evaluation) -> "Tangent":
        """The first-order model at an evaluated design; slots without an impact never are the largest."""
        peaks = np.where(evaluation.peaks > 0.0, evaluation.peaks, NO_PEAK)
        return Tangent(peaks, *(getattr(evaluation, name) for name in Tangent._fields[1:]))

    def after(self, step: Float[np.ndarray, " variables"]) -> tuple[np.ndarray, np.ndarray]:
        """The problem's quantities (cases, quantities) and margins (cases,) after a step."""
        peak = np.maximum(np.max(self.peaks + self.peaks_slope @ step, axis=1), 0.0)
        rest = self.rest + self.rest_slope @ step + self.by_peak * (peak - self.largest)[:, None]
        return np.column_stack([peak, rest]), self.margin + self.margin_slope @ step


@dataclasses.dataclass(frozen=True)
class Goal:
    """What a stage lowers and keeps to. Rows are relative: 0 on the limit, 0.1 ten per cent above it."""

    problem: Problem
    objective: Objective
    ceiling: Ceiling | None = None

    def value(self, evaluation: Evaluation) -> float:
        """The true objective [N]: largest peaks, no smoothing."""
        return self._value(self.objective, evaluation.quantities)

    def _value(self, objective: Objective, quantities: np.ndarray) -> float:
        return objective.aggregate(quantities @ self.weights(objective))

    def weights(self, objective: Objective) -> Float[np.ndarray, " quantities"]:
        """An objective's weights of the problem's quantities."""
        return objective.vector(self.problem.names)

    def limited(self) -> list[tuple[int, float]]:
        """Index into the problem's quantities and limit of every limited one, a lower limit with a minus sign: then
        ``value / limit`` stays at most the limit's sign."""
        limits = self.problem.limits
        most, least = {**self.problem.mechanism.always, **limits.at_most}, limits.at_least
        signed = [*most.items(), *((name, -limit) for name, limit in least.items())]
        return [(self.problem.names.index(name), float(limit)) for name, limit in signed]

    @property
    def must_succeed(self) -> bool:
        """Whether each case must end as the mechanism's runs should, and something tells how near it is to that."""
        return self.problem.limits.captured and self.problem.mechanism.margin is not None

    def rows(
        self, quantities: Float[np.ndarray, "cases quantities"], margin: Float[np.ndarray, " cases"]
    ) -> Float[np.ndarray, " rows"]:
        """All constraints that have slopes: limits by quantity, then captures, then the ceiling."""
        parts = [quantities[:, q] / limit - np.sign(limit) for q, limit in self.limited()]
        if self.must_succeed:
            parts.append(-margin)
        if self.ceiling is not None:
            ceiling = self.ceiling
            now = self._value(ceiling.objective, quantities)
            parts.append(np.array([now / ceiling.scale - ceiling.value / ceiling.scale]))
        return np.concatenate([*parts, np.zeros(0)])

    def excess(self, evaluation: Evaluation) -> Float[np.ndarray, " rows"]:
        """By how much each row, and each case's count of impacts, is above its limit."""
        rows = self.rows(evaluation.quantities, evaluation.margin)
        return np.concatenate([np.maximum(rows, 0.0), self.without_slopes(evaluation)])

    def without_slopes(self, evaluation: Evaluation) -> Float[np.ndarray, " rows"]:
        """The part of `excess` that no slope leads back from: impacts above their limit, and cases without numbers."""
        most = self.problem.limits.impacts
        counted = evaluation.impacts / most - 1.0 if most is not None else np.zeros(0)
        return np.maximum(np.concatenate([counted, (~evaluation.solved).astype(float)]), 0.0)

    def feasible(self, evaluation: Evaluation) -> bool:
        """Whether every constraint holds in every case."""
        return not np.any(self.excess(evaluation))

    def merit(self, evaluation: Evaluation, scale: float, penalty: float) -> float:
        """What a step must lower: objective over ``scale``, and ``penalty`` times all that is above its limit."""
        return self.value(evaluation) / scale + penalty * float(np.sum(self.excess(evaluation)))

    def predicted_merit(
        self, tangent: Tangent, step: Float[np.ndarray, " variables"], scale: float, penalty: float
    ) -> float:
        """`merit` after a step to first order."""
        quantities, margin = tangent.after(step)
        above = np.maximum(self.rows(quantities, margin), 0.0)
        return self._value(self.objective, quantities) / scale + penalty * float(np.sum(above))

    def excess_after(self, tangent: Tangent, step: Float[np.ndarray, " variables"]) -> float:
        """By how much all rows together are above their limits after a step, to first order."""
        return float(np.sum(np.maximum(self.rows(*tangent.after(step)), 0.0)))

    def broken(self, evaluation: Evaluation) -> list[str]:
        """One sentence for each constraint that fails, naming the case by its values, the worst case first."""
        lines, cases = [], self.problem.cases
        for k in self.worst_first(evaluation):
            found = self.broken_in(evaluation, k)
            if found:
                where = cases[k].label(cases)
                lines += [f"{where}: {text}" for text in found]
        if self.ceiling is not None and (now := self.first_value(evaluation)) > self.ceiling.value:
            objective, catalogue = self.ceiling.objective, self.problem.catalogue
            limit = objective.said(self.ceiling.value, catalogue)
            lines.append(f"{objective}: {objective.said(now, catalogue)} is above {limit}")
        return lines

    def worst_first(self, evaluation: Evaluation) -> list[int]:
        """The cases by how far they are above their limits, those without numbers first."""
        excess = self.excess(evaluation)
        if self.ceiling is not None:
            rows = len(self.rows(evaluation.quantities, evaluation.margin))
            excess = np.delete(excess, rows - 1)  # the ceiling's, which is no case's
        total = np.sum(np.nan_to_num(excess.reshape(-1, len(evaluation.code)), nan=np.inf), axis=0)
        return [int(k) for k in np.argsort(-total, kind="stable")]

    def first_value(self, evaluation: Evaluation) -> float:
        """The objective under the ceiling [N]."""
        assert self.ceiling is not None
        return self._value(self.ceiling.objective, evaluation.quantities)

    def broken_in(self, evaluation: Evaluation, k: int) -> list[str]:
        """What fails in one case."""
        found, margin, mechanism = [], evaluation.margin[k], self.problem.mechanism
        asked = self.problem.limits
        limits = dataclasses.replace(asked, at_most={**mechanism.always, **asked.at_most})
        outcome = mechanism.outcomes(int(evaluation.code[k]))
        if not evaluation.solved[k]:
            own = f" or {', '.join(self.problem.quantities)} is not finite" if self.problem.quantities else ""
            found.append(f"the simulation failed{own}")
        elif self.must_succeed and margin < 0.0:
            found.append(f"not {mechanism.success} ({mechanism.margin} {margin:.3g})")
        if evaluation.solved[k] and not evaluation.succeeded[k] and margin >= 0.0:
            found.append(outcome.reason)
        values = dict(zip(self.problem.names, evaluation.quantities[k].tolist(), strict=True))
        return found + limits.broken(values, int(evaluation.impacts[k]), self.problem.catalogue)
