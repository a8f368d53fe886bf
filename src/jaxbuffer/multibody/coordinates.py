"""In which order a system's coordinates stand: the one place that knows it, for positions, velocities and forces."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Float

from ..plane import Vector

Numbers = Array | np.ndarray
PLACEMENT = 3  # numbers that place a body: x, y and its angle
X, Y, ANGLE = range(PLACEMENT)


class Coordinates(NamedTuple):
    """The order of the coordinates: x, y and angle of one body after the other, then the modal coordinates, body by
    body (M4). Whatever has an entry for each, in the last axis, is read by it: velocities and accelerations too.

    - ``bodies``: how many there are.
    - ``modes``: number of modes of each body; empty: all bodies are rigid.
    """

    bodies: int
    modes: tuple[int, ...] = ()

    @property
    def count(self) -> int:
        """Return how many coordinates there are."""
        return PLACEMENT * self.bodies + sum(self.modes)

    def columns(self, body: int) -> tuple[int, ...]:
        """Return which coordinates are a body's: x, y, its angle, then its modal ones."""
        modal, first = self.modal(body), PLACEMENT * body
        return (*range(first, first + PLACEMENT), *range(modal.start, modal.stop))

    def modal(self, body: int) -> slice:
        """Return where the modal coordinates of a body stand."""
        first = PLACEMENT * self.bodies + sum(self.modes[:body])
        return slice(first, first + (self.modes[body] if self.modes else 0))

    def placements(self, values: Float[Numbers, "*axes coordinates"]) -> Float[Numbers, "*axes bodies 3"]:
        """Return the entries of x, y and angle of all bodies."""
        return values[..., : PLACEMENT * self.bodies].reshape(*values.shape[:-1], self.bodies, PLACEMENT)

    @staticmethod
    def translation(values: Float[Numbers, " coordinates"], body: int) -> Vector:
        """Return the entries of a body's x and y."""
        return Vector(values[PLACEMENT * body + X], values[PLACEMENT * body + Y])

    @staticmethod
    def angle(values: Float[Numbers, "*axes coordinates"], body: int) -> Float[Numbers, "*axes"]:
        """Return the entry of a body's angle."""
        return values[..., PLACEMENT * body + ANGLE]
