"""In which order a system's numbers stand: the one place that knows it, for positions, velocities and forces."""

from typing import NamedTuple, TypeVar

import numpy as np
from jaxtyping import Array, Float

from ..plane import PLANE, Vector

Numbers = TypeVar("Numbers", Array, np.ndarray)
X, Y, ANGLE = range(PLANE.positions)  # of one body in the plane


class Coordinates(NamedTuple):
    """The order of positions, or of velocities: those of one body after the other, in the plane x, y and angle (M4), in
    space as `space.SPACE` has them (M209), then the modal coordinates, body by body. Whatever has an entry for each, in
    the last axis, is read by it: accelerations and forces stand as velocities do.

    - ``bodies``: how many there are.
    - ``modes``: number of modes of each body; empty: all bodies are rigid.
    - ``each``: how many numbers one body has, modal ones left out: `Basis.positions` or `Basis.velocities`.
    """

    bodies: int
    modes: tuple[int, ...] = ()
    each: int = PLANE.positions

    @property
    def count(self) -> int:
        """Return how many numbers there are."""
        return self.each * self.bodies + sum(self.modes)

    def columns(self, body: int) -> tuple[int, ...]:
        """Return which numbers are a body's: in the plane x, y and its angle, then its modal ones."""
        modal, first = self.modal(body), self.each * body
        return (*range(first, first + self.each), *range(modal.start, modal.stop))

    def modal(self, body: int) -> slice:
        """Return where the modal coordinates of a body stand."""
        first = self.each * self.bodies + sum(self.modes[:body])
        return slice(first, first + (self.modes[body] if self.modes else 0))

    def placements(self, values: Float[Numbers, "*axes numbers"]) -> Float[Numbers, "*axes bodies each"]:
        """Return the entries of all bodies, modal ones left out: in the plane x, y and angle."""
        return values[..., : self.each * self.bodies].reshape(*values.shape[:-1], self.bodies, self.each)

    @staticmethod
    def translation(values: Float[Numbers, " coordinates"], body: int) -> Vector:
        """Return the entries of a body's x and y, in the plane."""
        first = PLANE.positions * body
        return Vector(values[first + X], values[first + Y])

    @staticmethod
    def angle(values: Float[Numbers, "*axes coordinates"], body: int) -> Float[Numbers, "*axes"]:
        """Return the entry of a body's angle, in the plane."""
        return values[..., PLANE.positions * body + ANGLE]
