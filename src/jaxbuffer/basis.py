"""What the plane and space both offer, so that bodies, joints and forces are written once for either."""

from abc import abstractmethod
from typing import Any, ClassVar, Generic, TypeVar

import equinox as eqx
from jaxtyping import Array, Float

from ._types import Scalar, stacked

V = TypeVar("V")
T = TypeVar("T")
F = TypeVar("F")

Entry = Scalar | Float[Array, "..."]
"""A number, or a row of numbers treated alike."""

Rows = list[list[Scalar]]
"""The lower half of a symmetric matrix."""


class PositionRate(eqx.Module):
    """How positions change with velocities, q̇ = N(q) v, at one position q; in the plane q̇ is v itself.

    Both ways are linear, and take columns one by one.
    """

    @property
    def surplus(self) -> int:
        """Return how many more numbers positions have than velocities."""
        return 0

    def of(self, v: Float[Array, "velocities *columns"]) -> Float[Array, "coordinates *columns"]:
        """Return N(q) v."""
        return v

    def velocity(self, rate: Float[Array, "coordinates *columns"]) -> Float[Array, "velocities *columns"]:
        """Return the v with N(q) v = ``rate``."""
        return rate


class Basis(eqx.Module, Generic[V, T, F]):
    """Vectors V, turns T (a spin, a moment, a rotation) and frames F of bodies, of the plane or of space.

    Vectors of both have ``+``, ``-``, ``*`` by a number, ``dot`` and ``cross``, which is a turn; frames have ``turn``,
    ``unturn``, ``in_axes``, ``from_axes``, ``x_axis``, ``velocity_at``, ``rate_of`` and ``centripetal``.

    - ``dimensions``: components of a vector.
    - ``positions``, ``velocities``: numbers of one body's position and of its velocity.
    - ``inertia_turns``: whether the inertia of a rigid body, in inertial axes, changes as it turns; its share of the
      mass matrix is then a block.
    """

    dimensions: ClassVar[int]
    positions: ClassVar[int]
    velocities: ClassVar[int]
    inertia_turns: ClassVar[bool]

    @abstractmethod
    def vector(self, *components: Entry) -> V:
        """Return the vector of some components; those that are left out are zero."""

    @abstractmethod
    def turn(self, *components: Entry) -> T:
        """Return the turn of some components."""

    @property
    @abstractmethod
    def unit_vectors(self) -> tuple[V, ...]:
        """Return the inertial axes."""

    @property
    @abstractmethod
    def unit_turns(self) -> tuple[T, ...]:
        """Return the turn of size one about each axis there is."""

    @abstractmethod
    def along_axes(self, arm: V) -> tuple[tuple[Scalar, ...], ...]:
        """Return for each inertial axis how the speed along it of a point at an ``arm`` goes with the body's
        velocities."""

    @abstractmethod
    def frames(self, q: Float[Array, " coordinates"], v: Float[Array, " velocities"], bodies: int) -> tuple[F, ...]:
        """Return the frames of bodies, whose positions and velocities come first in ``q`` and ``v``."""

    @abstractmethod
    def ground(self) -> F:
        """Return the inertial frame, at rest."""

    @abstractmethod
    def position_rate(self, q: Float[Array, " coordinates"], bodies: int) -> PositionRate:
        """Return N(q) of bodies, whose positions come first in ``q``."""

    @abstractmethod
    def relative_rotation(self, first: F, second: F) -> T:
        """Return the rotation that takes the first frame to the second, as a turn in inertial axes [rad]."""

    @abstractmethod
    def diagonal(self, mass: Scalar, inertia: Any) -> tuple[Scalar, ...]:
        """Return a rigid body's share of the mass matrix' diagonal, Python's 0 where `inertia_block` has it."""

    @abstractmethod
    def inertia_block(self, frame: F, inertia: Any) -> Rows:
        """Return the inertia about the centre of mass in inertial axes [kg m²], where it turns."""

    @abstractmethod
    def spin_momentum(self, frame: F, inertia: Any) -> T:
        """Return the angular momentum about the centre of mass [kg m²/s]."""

    @abstractmethod
    def gyroscopic_moment(self, frame: F, inertia: Any) -> T:
        """Return the moment that changes the spin of a free body [N m], where its inertia turns."""


AnyBasis = Basis[Any, Any, Any]
"""The plane or space."""


def components(turn: Any) -> tuple[Entry, ...]:
    """Return a turn's components: of the plane it is a number, of space a vector."""
    return tuple(turn) if isinstance(turn, tuple) else (turn,)


def turn_array(turn: Any) -> Float[Array, "..."]:
    """Return a turn as an array: of the plane a number, of space three."""
    return stacked(turn) if isinstance(turn, tuple) else turn


def squared(turn: Any) -> Scalar:
    """Return the square of a turn's size."""
    first, *others = (entry * entry for entry in components(turn))
    return sum(others, start=first)


def is_zero(value: Any) -> bool:
    """Return whether a value is Python's 0, which is known to be zero when a program is compiled."""
    return isinstance(value, float) and bool(value == 0.0)


def plus(a: Entry, b: Entry) -> Entry:
    """Return a + b; what is Python's 0 costs nothing."""
    return b if is_zero(a) else a if is_zero(b) else a + b


def less(a: Entry, b: Entry) -> Entry:
    """Return a - b; what is Python's 0 costs nothing."""
    return a if is_zero(b) else -b if is_zero(a) else a - b


def times(a: Entry, b: Entry) -> Entry:
    """Return a b; what is Python's 0 or 1 costs nothing."""
    if is_zero(a) or is_zero(b):
        return 0.0
    one = [isinstance(factor, float) and factor == 1.0 for factor in (a, b)]
    return b if one[0] else a if one[1] else a * b
