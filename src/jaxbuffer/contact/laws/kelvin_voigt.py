"""The linear spring-dashpot."""

from typing import ClassVar

import jax.numpy as jnp

from ..._types import Scalar, Values
from .base import ContactLaw


class KelvinVoigt(ContactLaw):
    """F = max(0, k δ + c δ̇): it starts with a jump to c δ̇⁻ and does not pull at the end (M49).

    The force is that of a closed contact; the caller says whether the contact is closed, since a function of δ alone
    can't hold the jump. Restitution and penetration are those of M50.

    - ``linear_stiffness``: k [N/m].
    - ``damping``: c [N s/m].
    """

    source: ClassVar[str] = "Kelvin & Voigt; without tension, Schwager & Pöschel 2007"
    validity: ClassVar[str] = "flat or compliant layers; e depends on the mass; force jumps at touchdown"
    unit: ClassVar[str] = "N/m"
    jumps: ClassVar[bool] = True
    linear_stiffness: Scalar
    damping: Scalar

    def elastic(self, penetration: Values) -> Values:
        return self.linear_stiffness * jnp.maximum(penetration, 0.0)

    def energy(self, penetration: Values) -> Values:
        return 0.5 * self.elastic(penetration) * penetration

    def depth(self, force: Scalar) -> Scalar:
        return force / self.linear_stiffness

    def force(self, penetration: Values, approach_speed: Values, touchdown_speed: Values) -> Values:
        return jnp.maximum(0.0, self.linear_stiffness * penetration + self.damping * approach_speed)

    def time_scale(self, mass: Scalar, speed: Scalar) -> Scalar:
        return 1.0 / (jnp.sqrt(self.linear_stiffness / mass) + self.damping / mass)

    def delivered_restitution(self, mass: Scalar, speed: Scalar = 1.0) -> Scalar:
        """Return the restitution [-] of two free bodies of an effective ``mass`` [kg], the same for any ``speed``
        (M50)."""
        return self._decay(mass) ** 2

    def max_penetration(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Return the deepest penetration of two free bodies [m] (M50). ``mass``: effective [kg]; ``speed``: [m/s]."""
        return speed * self._decay(mass) / jnp.sqrt(self.linear_stiffness / mass)

    def _decay(self, mass: Scalar) -> Scalar:
        """Return G of M50; arccos(ζ)/√(1 - ζ²) is smooth through ζ = 1, and is taken from its series near there."""
        zeta = self.damping / (2.0 * jnp.sqrt(self.linear_stiffness * mass))
        off = zeta - 1.0
        near = jnp.abs(off) < 1e-3
        # Each branch gets an argument that it can take: NaN of one that is not taken would reach the derivative.
        below, above = jnp.where(near | (off > 0.0), 0.5, zeta), jnp.where(near | (off < 0.0), 2.0, zeta)
        slow = jnp.arccos(below) / jnp.sqrt(1.0 - below * below)
        fast = jnp.arccosh(above) / jnp.sqrt(above * above - 1.0)
        series = 1.0 - off / 3.0 + 2.0 * off**2 / 15.0 - 2.0 * off**3 / 35.0 + 8.0 * off**4 / 315.0
        return jnp.exp(-zeta * jnp.where(near, series, jnp.where(off < 0.0, slow, fast)))
