"""What the laws of a pin in a hole share: radius, clearance, length, modulus, and the damping factor."""

import math

import jax.numpy as jnp

from ..._types import Scalar
from .hysteresis import DampedSpring

LEAST = 1e-300  # m, penetrations below it count as none: their logarithm may not exist


class PinInHoleLaw(DampedSpring):
    """Base of the laws of a pin in a hole (M94, M95). The penetration is the pin's eccentricity less the clearance.

    - ``bush_radius``: R_B, of the hole [m].
    - ``clearance``: ΔR, the hole's radius less the pin's [m]; given as such, since a difference would lose digits.
    - ``length``: L of the contact along the axis [m].
    - ``modulus``: E* [Pa], see `contact_modulus`.
    - ``hysteresis``: χ̂ [-], see `damping_factor`.
    """

    bush_radius: Scalar
    clearance: Scalar
    length: Scalar
    modulus: Scalar
    hysteresis: Scalar

    @property
    def journal_radius(self) -> Scalar:
        """Return R_J of the pin [m]."""
        return self.bush_radius - self.clearance

    @property
    def relative_radius(self) -> Scalar:
        """Return R = R_B R_J/ΔR [m] (M54)."""
        return self.bush_radius * self.journal_radius / self.clearance

    @property
    def line_stiffness(self) -> Scalar:
        """Return k = π E* L [N/m] (M95)."""
        return jnp.pi * self.modulus * self.length

    @property
    def limit_force(self) -> Scalar:
        """Return the force [N] above which the law means nothing any more, for warnings; infinite where none is
        known."""
        return math.inf

    def time_scale(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Return the largest penetration of a lossless impact over its speed [s] (M101)."""
        return self.depth_storing(0.5 * mass * speed * speed) / speed
