"""Evidence against or for a gradient, from runs solved so tightly that differences of them mean something."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .._types import Scalar
from ..errors import InputError
from ..fields import Part
from ..hybrid import Solver
from ..mechanisms.mechanism import Stepping
from ..mechanisms.quantity import value_of
from ..mechanisms.registry import mechanism_of
from ..mechanisms.run import Run
from ..run.request import check_pair
from ..run.simulate import simulate
from .differences import balanced_direction, difference

CHECK_TOLERANCE = 1e-11  # of the solves that are differenced
NOISE = 10.0 * CHECK_TOLERANCE  # relative error that such a solve leaves in a quantity
FLOOR = 1e-3  # elasticities below count as this large when an error is made relative
FAINT = 1e-6  # of the largest peak: impacts below are no landmarks
SETTLED = 3e-4  # relative uncertainty of a difference that is small enough


class Evidence(NamedTuple):
    """Errors of elasticities, absolute [-], each (quantities, paths): ``by_tolerance``: change to the gradient at
    another tolerance; ``by_differences``: distance from differences of tight solves, whose own ``uncertainty`` comes
    next; ``solves`` spent on them; ``thorough``: a difference for each path, or one for all together."""

    by_tolerance: np.ndarray
    by_differences: np.ndarray
    uncertainty: np.ndarray
    solves: int
    thorough: bool


class TightSolves:
    """Quantities of tight solves after a relative move of the parameters.

    The peak force is that of the same impact throughout, so that a swap of peaks is no part of a difference; where the
    impacts up to it are no longer the same ones, or the outcome is another, there is nothing to compare: NaN.

    **Arguments:** ``inputs``: design and scenario from the parameters' values; ``run``: the one in question, at
    ``values``; ``moves``: what counts as a relative move of 1; ``names``: the quantities; the rest as for `simulate`.
    """

    def __init__(
        self,
        inputs: Callable[[np.ndarray], tuple[Part, Part]],
        run: Run,
        values: np.ndarray,
        moves: np.ndarray,
        names: tuple[str, ...],
        duration: Scalar,
        solver: Solver | None,
    ) -> None:
        self.inputs, self.values, self.moves, self.names = inputs, values, moves, names
        self.duration, self.solver = duration, solver
        system = run.mechanism.system
        self.rtol = system.difference_tolerance if isinstance(system, Stepping) else CHECK_TOLERANCE
        self.code = int(run.code)
        contacts, forces = _impacts(run)
        self.active = int(np.argmax(forces)) if forces.size else -1
        self.course = contacts[: self.active + 1]
        self.known: dict[bytes, np.ndarray] = {}

    def inside(self, direction: np.ndarray, move: float) -> bool:
        """Whether all parameters are in range after a relative move of that length along a direction."""
        try:
            moved = self.inputs(self.values + move * direction * self.moves)
            check_pair(mechanism_of(moved[0]), *moved)
        except InputError:
            return False
        return True

    def at(self, direction: np.ndarray, move: float) -> np.ndarray:
        """All quantities after such a move."""
        values = self.values + move * direction * self.moves
        key = values.tobytes()
        if key not in self.known:
            inputs = self.inputs(values)
            self.known[key] = self._seen(simulate(*inputs, self.duration, rtol=self.rtol, solver=self.solver))
        return self.known[key]

    def _seen(self, run: Run) -> np.ndarray:
        if int(run.code) != self.code:
            return np.full(len(self.names), np.nan)
        found = np.array([value_of(run, name) for name in self.names])
        if self.course and "peak_force" in self.names:
            contacts, forces = _impacts(run)
            same = contacts[: self.active + 1] == self.course
            found[self.names.index("peak_force")] = forces[self.active] if same else np.nan
        return found


def _impacts(run: Run) -> tuple[list[int], np.ndarray]:
    """Contacts and peak forces of all impacts that exert some: a contact touched and left at once is found
    in one solve and missed in another."""
    forces = np.asarray(run.impacts.peak_force)
    real = forces > FAINT * np.max(forces)
    return np.asarray(run.impacts.contact)[real].tolist(), forces[real]


def each(tight: TightSolves, elasticities: np.ndarray, sizes: np.ndarray, by_tolerance: np.ndarray) -> Evidence:
    """A difference by each parameter.

    **Arguments:** ``elasticities`` (quantities, paths) to be judged; ``sizes``: each quantity's value, which makes its
    change relative; ``by_tolerance``: the other evidence.
    """
    value, uncertainty = np.empty(elasticities.shape), np.empty(elasticities.shape)
    for k, column in enumerate(np.eye(elasticities.shape[1])):
        settled = SETTLED * np.maximum(np.abs(elasticities[:, k]), FLOOR) * sizes
        found = _difference(tight, column, settled)
        value[:, k], uncertainty[:, k] = found[0] / sizes, found[1] / sizes
    return Evidence(by_tolerance, np.abs(elasticities - value), uncertainty, len(tight.known), True)


def together(tight: TightSolves, elasticities: np.ndarray, sizes: np.ndarray, by_tolerance: np.ndarray) -> Evidence:
    """One difference along all parameters, which change the first quantity by the same amount each; what it misses by
    is held against every single one of them."""
    direction = balanced_direction(elasticities[0], FLOOR)
    size = np.maximum(np.abs(elasticities), FLOOR)
    share = np.mean(size * np.abs(direction), axis=1)  # of a typical parameter in the directional change
    value, uncertainty = _difference(tight, direction, SETTLED * share * sizes)
    missed = np.abs(elasticities @ direction - value / sizes)
    spread = size / share[:, None]
    return Evidence(
        by_tolerance, missed[:, None] * spread, (uncertainty / sizes)[:, None] * spread, len(tight.known), False
    )


def _difference(tight: TightSolves, direction: np.ndarray, settled: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    found = difference(
        lambda move: tight.at(direction, move), lambda move: tight.inside(direction, move), settled, NOISE
    )
    return found.value, found.uncertainty
