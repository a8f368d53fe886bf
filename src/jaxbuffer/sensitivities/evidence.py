"""Evidence against or for a gradient, from runs solved so tightly that differences of them mean something."""

import functools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .._types import Scalar
from ..cluster.pool import Pool
from ..errors import InputError
from ..fields import Part, with_values
from ..hybrid import Solver
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.quantity import PEAK_FORCE
from ..mechanisms.run import Run, value_of
from ..run.request import check_pair
from ..run.simulate import simulate
from ..run.stepper import Events, stepper_of
from .differences import Difference, balanced_direction, difference, side_by_side

NOISE = 10.0 * Events.difference_tolerance  # relative error that a solve which is differenced leaves in a quantity
FLOOR = 1e-3  # elasticities below count as this large when an error is made relative
FAINT = 1e-6  # of the largest peak: impacts below are no landmarks
TRUSTED = 3e-3  # estimated relative error up to which a gradient is trusted: no trusted one was off by 1 %
SETTLED = 3e-4  # relative uncertainty of a difference that is small enough
DIRECTIONS = 3  # in which `together` takes differences, at most


class Evidence(NamedTuple):
    """Errors of elasticities, absolute [-], each (quantities, paths): ``by_tolerance``: change to the gradient at
    another tolerance; ``by_differences``: distance from differences of tight solves, whose own ``uncertainty`` comes
    next; ``solves`` spent on them; ``thorough``: a difference for each path, or one to three along all."""

    by_tolerance: np.ndarray
    by_differences: np.ndarray
    uncertainty: np.ndarray
    solves: int
    thorough: bool


class TightSolve(NamedTuple):
    """A tight solve at any values of the parameters, small enough to be sent to another process.

    ``design`` and ``scenario`` of the ``mechanism``, in which the parameters at ``paths`` are changed; ``names``: the
    quantities; ``duration`` [s] and ``solver`` as for `simulate`; ``code``: the outcome of the run in question;
    ``course``: contacts of its impacts, up to the one with the peak.
    """

    mechanism: Mechanism
    design: Part
    scenario: Part
    paths: tuple[str, ...]
    names: tuple[str, ...]
    duration: Scalar
    solver: Solver | str | None
    code: int
    course: list[int]

    def inputs(self, values: np.ndarray) -> tuple[Part, Part]:
        """Return the design and scenario with the parameters at these values."""
        return with_values(self.design, self.scenario, dict(zip(self.paths, values, strict=True)))

    def at(self, values: np.ndarray) -> np.ndarray:
        """Return all quantities with the parameters at these values.

        The peak force is that of the same impact throughout, so that a swap of peaks is no part of a difference; where
        the impacts up to it are no longer the same ones, or the outcome is another, there is nothing to compare: NaN.
        """
        rtol = stepper_of(self.mechanism).difference_tolerance
        return self.values_of(simulate(*self.inputs(values), self.duration, rtol=rtol, solver=self.solver))

    def values_of(self, run: Run) -> np.ndarray:
        """Return all quantities of a run, NaN where they can't be compared."""
        if int(run.code) != self.code:
            return np.full(len(self.names), np.nan)
        values = np.array([value_of(run, name) for name in self.names])
        if self.course and (peak := self.mechanism.name_of(PEAK_FORCE)) in self.names:
            contacts, forces = _impacts(run)
            same = contacts[: len(self.course)] == self.course
            values[self.names.index(str(peak))] = forces[len(self.course) - 1] if same else np.nan
        return values


def course_of(run: Run) -> list[int]:
    """Return the contacts of a run's impacts, up to the one with the peak."""
    contacts, forces = _impacts(run)
    return contacts[: int(np.argmax(forces)) + 1] if forces.size else []


class TightSolves:
    """Quantities of tight solves after relative moves of the parameters, each solved once.

    **Arguments:** ``solve``: one of them; ``values``: the parameters' own (parameters,); ``moves``: what counts as a
    relative move of 1, alike; ``pool``: who solves.
    """

    def __init__(self, solve: TightSolve, values: np.ndarray, moves: np.ndarray, pool: Pool) -> None:
        self.solve, self.values, self.moves, self.pool = solve, values, moves, pool
        self.known: dict[bytes, np.ndarray] = {}

    def inside(self, direction: np.ndarray, move: float) -> bool:
        """Return whether all parameters are in range after a relative ``move`` along a ``direction``."""
        # The checks that a user's numbers pass through know all ranges.
        try:
            moved = self.solve.inputs(self._moved(direction, move))
            check_pair(self.solve.mechanism, *moved)
        except InputError:
            return False
        return True

    def after(self, moves: Sequence[tuple[np.ndarray, float]]) -> list[np.ndarray]:
        """Return all quantities after each of these moves, a direction and a length each."""
        parameters = [self._moved(*move) for move in moves]
        # One-sided differences share the unmoved point, which is solved once.
        new = {values.tobytes(): values for values in parameters if values.tobytes() not in self.known}
        if new:
            self.known |= zip(new, self.pool.map(self.solve.at, new.values()), strict=True)
        return [self.known[values.tobytes()] for values in parameters]

    def _moved(self, direction: np.ndarray, move: float) -> np.ndarray:
        return np.asarray(self.values + move * direction * self.moves)


def _impacts(run: Run) -> tuple[list[int], np.ndarray]:
    """Return the contacts and peak forces of all impacts that exert some: a contact touched and left at once is found
    in one solve and missed in another."""
    forces = np.asarray(run.impacts.peak_force)
    real = forces > FAINT * np.max(forces)
    return np.asarray(run.impacts.contact)[real].tolist(), forces[real]


def each(tight: TightSolves, elasticities: np.ndarray, sizes: np.ndarray, by_tolerance: np.ndarray) -> Evidence:
    """Take a difference by each parameter.

    **Arguments:** ``elasticities`` (quantities, paths) to be judged; ``sizes``: each quantity's value, which makes its
    change relative; ``by_tolerance``: the other evidence.
    """
    settled = [SETTLED * np.maximum(np.abs(column), FLOOR) * sizes for column in elasticities.T]
    differences = _differences(tight, list(np.eye(elasticities.shape[1])), settled)
    value, uncertainty = (np.stack([part[k] / sizes for part in differences], axis=1) for k in (0, 1))
    return Evidence(by_tolerance, np.abs(elasticities - value), uncertainty, len(tight.known), True)


def together(tight: TightSolves, elasticities: np.ndarray, sizes: np.ndarray, by_tolerance: np.ndarray) -> Evidence:
    """Take a difference along all parameters; its error is charged to each of them as if that one alone were wrong.

    A parameter that changes a quantity far less than the others do is so charged with what may be their errors. The
    quantities for which that leaves most in doubt get a direction of their own.
    """
    size = np.maximum(np.abs(elasticities), FLOOR)
    finite = np.flatnonzero(np.all(np.isfinite(elasticities), axis=1))
    if not finite.size:
        unknown = np.full(size.shape, np.nan)
        return Evidence(by_tolerance, unknown, unknown, 0, False)
    errors = _along(tight, [finite], elasticities, sizes)
    worst = np.max(np.max(errors[0], axis=0) / size, axis=1)
    doubtful = [k for k in finite[np.argsort(-worst[finite])] if TRUSTED < worst[k] < np.inf][: DIRECTIONS - 1]
    if doubtful and finite.size > 1:
        errors += _along(tight, [np.array([k]) for k in doubtful], elasticities, sizes)
    # Of each elasticity the direction that leaves it least in doubt; NaN is the error where none could be differenced.
    larger = np.nan_to_num(np.max(errors, axis=1), nan=np.inf)
    best = np.take_along_axis(np.array(errors), np.argmin(larger, axis=0)[None, None], axis=0)[0]
    return Evidence(by_tolerance, best[0], best[1], len(tight.known), False)


def _along(
    tight: TightSolves, groups: list[np.ndarray], elasticities: np.ndarray, sizes: np.ndarray
) -> list[np.ndarray]:
    """Take a difference along a direction for each group of quantities; return for each the distance from it and its
    uncertainty (2, quantities, paths), charged to each parameter."""
    directions = [balanced_direction(elasticities[group], FLOOR) for group in groups]
    settled = np.full((len(groups), len(sizes)), np.inf)
    for row, group, direction in zip(settled, groups, directions, strict=True):
        # The parameter that changes a quantity least needs the smallest uncertainty.
        size = np.maximum(np.abs(elasticities[group]), FLOOR)
        row[group] = SETTLED * np.min(size * np.abs(direction), axis=1) * sizes[group]
    differences = _differences(tight, directions, list(settled))
    return [
        np.stack([np.abs(elasticities @ direction - value / sizes), uncertainty / sizes])[:, :, None]
        / np.abs(direction)
        for direction, (value, uncertainty, _) in zip(directions, differences, strict=True)
    ]


def _differences(tight: TightSolves, directions: list[np.ndarray], settled: list[np.ndarray]) -> list[Difference]:
    """Take a difference along each direction."""
    halvings = [
        difference(functools.partial(tight.inside, direction), enough, NOISE)
        for direction, enough in zip(directions, settled, strict=True)
    ]
    return side_by_side(halvings, lambda moves: tight.after([(directions[k], move) for k, move in moves]))
