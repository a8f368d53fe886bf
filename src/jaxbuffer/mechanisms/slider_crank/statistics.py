"""What can be said of a motion beyond the impacts that can be foretold one by one: means over turns."""

from typing import NamedTuple

import jax
import numpy as np
import scipy
from jaxtyping import Float

from ...errors import InputError
from ...hybrid import Kind
from ...multibody import Coordinates
from ...value_text import with_unit
from ..layout import positions
from ..run import Run
from .sensors import BODIES, CRANK

LEAST_TURNS = 4
LEAST_BLOCKS = 8
POINTS_BETWEEN = 16  # times between two events at which the crank's angle is evaluated


class Mean(NamedTuple):
    """A ``mean`` over turns with its ``standard_error``, both in ``unit``; ``by_turn``: the values, shape (turns,)."""

    mean: float
    standard_error: float
    unit: str
    by_turn: Float[np.ndarray, " turns"]

    def __str__(self) -> str:
        return f"{self.mean:.5g} ± {with_unit(self.standard_error, self.unit, 2)}"


class TurnStatistics(NamedTuple):
    """Means over the whole turns of a run.

    ``turns``: how many, the first one left out; ``impacts`` that begin in a turn [-]; ``largest_force`` and
    ``mean_peak`` of those impacts' peaks [N], over the turns that have any; ``contact_share`` [-].
    """

    turns: int
    impacts: Mean
    largest_force: Mean
    mean_peak: Mean
    contact_share: Mean

    def __str__(self) -> str:
        means = {name: value for name, value in self._asdict().items() if isinstance(value, Mean)}
        return "\n".join(
            [f"Means over {self.turns} turns", *(f"  {name.replace('_', ' '):14} {it}" for name, it in means.items())]
        )


def turn_statistics(run: Run) -> TurnStatistics:
    """Return impacts, largest force, mean of the impacts' peaks and share of contact by turn of the crank, with the
    standard errors of their means.

    The first turn is left out: it begins where no steady motion would be. Turns that follow one another are alike, so
    an error comes from means of blocks of turns, as `standard_error` says.

    **Arguments:** ``run``: of a slider-crank, over at least six turns, with ``max_events`` large enough for all
    events.

    **Raises:** `InputError` for fewer than four whole turns after the first, or where events found no room.

    **Example:**

    >>> run = jb.simulate(jb.SliderCrank(), jb.SliderCrankScenario(), duration=20 * 0.012, max_events=2048)
    >>> found = jb.turn_statistics(run)
    >>> force = found.largest_force
    >>> print(f"{found.turns} turns, known to half of the largest force: {force.standard_error < force.mean / 2}")
    19 turns, known to half of the largest force: True
    """
    if overflown(run):
        raise InputError(f"the log lists {int(run.impacts.count)} of {int(run.impact_count)} impacts; raise max_events")
    starts = turn_starts(run)
    # The last entry is the end of the last whole turn, and the first turn is left out.
    turns = len(starts) - 2
    if turns < LEAST_TURNS:
        raise InputError(f"statistics need {LEAST_TURNS} whole turns after the first; this run has {max(turns, 0)}")
    hits = jax.tree.map(np.asarray, run.impacts)
    count = int(hits.count)
    turn = np.searchsorted(starts, hits.time[:count], side="right") - 1
    peaks = [hits.peak_force[:count][turn == k] for k in range(1, turns + 1)]
    largest, mean_peak = ([of(peak) if peak.size else np.nan for peak in peaks] for of in (np.max, np.mean))
    return TurnStatistics(
        turns,
        _mean([peak.size for peak in peaks], "-"),
        _mean(largest, "N"),
        _mean(mean_peak, "N"),
        _mean(contact_shares(run, starts)[1:], "-"),
    )


def overflown(run: Run) -> bool:
    """Return whether events found no room in the log."""
    return bool(np.asarray(run._located.overflown))


def turn_starts(run: Run) -> Float[np.ndarray, " turns"]:
    """Return when each turn begins, and the last whole one ends [s]. Between two events of the log the crank's angle is
    the cubic through its values and speeds at both."""
    log, scenario = run._located, run.scenario
    count = min(int(log.count), log.room)
    # The spline needs times that rise: of several events at one instant the first is taken.
    time, first = np.unique(np.append(0.0, np.asarray(log.time)[:count]), return_index=True)
    angles, speeds = (
        Coordinates.angle(positions(np.asarray(it)[:count, 0], BODIES), CRANK) for it in (log.rows, log.rates)
    )
    angle = np.append(float(np.asarray(scenario.crank_angle)), angles)[first]
    speed = np.append(float(np.asarray(scenario.crank_speed)), speeds)[first]
    between = np.linspace(0.0, 1.0, POINTS_BETWEEN, endpoint=False)
    times = np.append((time[:-1, None] + np.diff(time)[:, None] * between).ravel(), time[-1])
    # A crank may turn either way.
    turned = np.abs(scipy.interpolate.CubicHermiteSpline(time, angle - angle[0], speed)(times)) / (2.0 * np.pi)
    # The small number keeps a last turn that is whole but for rounding.
    return np.interp(np.arange(int(turned[-1] + 1e-9) + 1), turned, times)


def contact_shares(run: Run, starts: Float[np.ndarray, " turns"]) -> Float[np.ndarray, " turns"]:
    """Return the share of each turn in which a pin touches its bush."""
    log = run._located
    count = min(int(log.count), log.room)
    kind, time = np.asarray(log.kind)[:count], np.asarray(log.time)[:count]
    changes = np.isin(kind, (int(Kind.TOUCHDOWN), int(Kind.RELEASE)))
    touching = np.any(np.asarray(log.active)[:count] > 0.5, axis=1)
    # After its last change a contact stays as it is, to the end.
    ends = np.append(time[changes], max(float(time[-1]), starts[-1]))
    closed = np.append(0.0, np.cumsum(np.diff(ends) * touching[changes]))  # time in contact up to each change
    upto = np.interp(starts, np.append(0.0, ends), np.append(0.0, closed))
    return np.diff(upto) / np.diff(starts)


def _mean(values: list[float] | np.ndarray, unit: str) -> Mean:
    by_turn = np.asarray(values, float)
    # A turn without an impact has no peak: its NaN is left out of mean and error.
    known = by_turn[np.isfinite(by_turn)]
    mean = float(np.mean(known)) if known.size else np.nan
    return Mean(mean, standard_error(known), unit, by_turn)


def standard_error(values: Float[np.ndarray, " n"]) -> float:
    """Return the standard error of the mean of values that follow one another and may be alike (Flyvbjerg and Petersen
    1989): the largest of the errors that means of blocks of 1, 2, 4, … values give, at least eight blocks each; not a
    number of fewer than 2."""
    errors, size = [], 1
    while size == 1 or len(values) // size >= LEAST_BLOCKS:
        blocks = values[: len(values) // size * size].reshape(-1, size).mean(axis=1)
        if len(blocks) < 2:
            return float("nan")
        errors.append(float(np.std(blocks, ddof=1) / np.sqrt(len(blocks))))
        size *= 2
    return max(errors)
