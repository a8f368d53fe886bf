"""What the plane and space both offer, so that bodies, joints and forces are written once for either."""

from abc import abstractmethod
from typing import Any, ClassVar, Generic, TypeVar

import equinox as eqx
from jaxtyping import Array, Float

from ._types import Scalar

V = TypeVar("V")
T = TypeVar("T")
F = TypeVar("F")

Rows = list[list[Scalar]]


class Basis(eqx.Module, Generic[V, T, F]):
    """Vectors V, turns T (a spin, a moment, a rotation) and frames F of bodies, of the plane or of space.

    Vectors of both have ``+``, ``-``, ``*`` by a number, ``dot`` and ``cross``, which is a turn; frames have ``turn``,
    ``unturn``, ``velocity_at``, ``rate_of`` and ``centripetal``.

    - ``dimensions``: components of a vector.
    - ``positions``, ``velocities``: numbers of one body's position and of its velocity.
    """

    dimensions: ClassVar[int]
    positions: ClassVar[int]
    velocities: ClassVar[int]

    @abstractmethod
    def vector(self, *components: Scalar) -> V:
        """Return the vector of some components; those that are left out are zero."""

    @abstractmethod
    def entries(self, turn: T) -> tuple[Scalar, ...]:
        """Return a turn's components, in the order of a body's velocities."""

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
    def position_rate(
        self, q: Float[Array, "coordinates *columns"], v: Float[Array, "velocities *columns"], bodies: int
    ) -> Float[Array, "coordinates *columns"]:
        """Return q̇ = N(q) v, linear in ``v``, of bodies and of whatever follows them."""

    @abstractmethod
    def velocity(
        self, q: Float[Array, "coordinates *columns"], rate: Float[Array, "coordinates *columns"], bodies: int
    ) -> Float[Array, "velocities *columns"]:
        """Return the v with N(q) v = ``rate``, linear in it."""

    @abstractmethod
    def relative_rotation(self, first: F, second: F) -> T:
        """Return the rotation that takes the first frame to the second, as a turn in inertial axes [rad]."""

    @abstractmethod
    def reference_axes(self, angle: Any) -> tuple[V, ...]:
        """Return the axes of a first body in those of a second one, which the first is turned by ``angle`` against."""

    @abstractmethod
    def diagonal(self, mass: Scalar, inertia: Any) -> tuple[Scalar, ...]:
        """Return a body's share of the mass matrix' diagonal, Python's 0 where `inertia_block` takes its place."""

    @abstractmethod
    def inertia_block(self, frame: F, inertia: Any) -> Rows:
        """Return the lower half of the inertia in inertial axes [kg m²]; empty where `diagonal` has it."""

    @abstractmethod
    def spin_momentum(self, frame: F, inertia: Any) -> T:
        """Return the angular momentum about the centre of mass [kg m²/s]."""

    @abstractmethod
    def gyroscopic_moment(self, frame: F, inertia: Any) -> T | None:
        """Return the moment that the body's own spin exerts on it [N m]; None where there is none."""


def is_zero(value: Any) -> bool:
    """Return whether a value is Python's 0, which is known to be zero when a program is compiled."""
    return isinstance(value, float) and value == 0.0
