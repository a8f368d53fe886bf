"""Hysteresis after Hunt and Crossley: what follows from the factor χ̂ for any spring, and for the power of a depth."""

from typing import TYPE_CHECKING

import equinox as eqx
import jax.numpy as jnp

from ..._types import Scalar, Values
from .base import ContactLaw, depth_at, power, root
from .restitution import psi, restitution_delivered


class DampedSpring(ContactLaw):
    """Base of the laws F_el(δ) max(0, 1 + χ̂ δ̇/δ̇⁻) (M94).

    - ``hysteresis``: χ̂ [-], the damping force over the elastic one at the speed of touchdown.
    """

    if TYPE_CHECKING:  # a field of some laws, a property of others

        @property
        def hysteresis(self) -> Scalar: ...
    else:
        hysteresis: eqx.AbstractVar[Scalar]

    def force(self, penetration: Values, approach_speed: Values, touchdown_speed: Values) -> Values:
        return self.elastic(penetration) * jnp.maximum(0.0, 1.0 + self.hysteresis * approach_speed / touchdown_speed)

    def depth_storing(self, energy: Scalar) -> Scalar:
        """Return the penetration [m] at which the spring has stored an ``energy`` [J]; zero, with no derivative, for
        energies ≤ 0. Found by bisection unless a law gives it in closed form."""
        return depth_at(self.energy, energy)

    def delivered_restitution(self, mass: Scalar = 1.0, speed: Scalar = 1.0) -> Scalar:
        """Return the restitution [-] that solves M46 with d = χ̂, the same for any mass [kg] and speed [m/s]."""
        return restitution_delivered(self.hysteresis)

    def max_penetration(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Return the deepest penetration [m] of two free bodies (M94). ``mass``: effective [kg]; ``speed``: [m/s]."""
        return self.depth_storing(-mass * speed**2 * psi(self.hysteresis))


class PowerLaw(DampedSpring):
    """Base of the damped springs K δⁿ (M35, M37, M48, M58, M72).

    - ``stiffness``: K [N/mⁿ].
    - ``exponent``: n [-].
    """

    if TYPE_CHECKING:

        @property
        def stiffness(self) -> Scalar: ...

        @property
        def exponent(self) -> Scalar: ...
    else:
        stiffness: eqx.AbstractVar[Scalar]
        exponent: eqx.AbstractVar[Scalar]

    def elastic(self, penetration: Values) -> Values:
        """Return K δⁿ [N], zero for δ ≤ 0, with finite derivatives there."""
        return self.stiffness * power(penetration, self.exponent)

    def energy(self, penetration: Values) -> Values:
        """Return K δⁿ⁺¹/(n + 1) [J] (M37)."""
        return self.elastic(penetration) * penetration / (self.exponent + 1.0)

    def depth(self, force: Scalar) -> Scalar:
        """Return (F/K)^(1/n) [m] (M72)."""
        return root(force / self.stiffness, self.exponent)

    def depth_storing(self, energy: Scalar) -> Scalar:
        """Return ((n + 1) V/K)^(1/(n + 1)) [m]."""
        return root((self.exponent + 1.0) * energy / self.stiffness, self.exponent + 1.0)

    def time_scale(self, mass: Scalar, speed: Scalar) -> Scalar:
        # One root for the usual exponent, whose general form takes two powers.
        if isinstance(self.exponent, float) and self.exponent == 1.5:
            return (mass**2 / (self.stiffness**2 * speed)) ** 0.2
        return (mass * speed ** (1.0 - self.exponent) / self.stiffness) ** (1.0 / (self.exponent + 1.0))
