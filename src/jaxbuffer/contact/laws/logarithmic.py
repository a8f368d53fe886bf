"""Laws of a pin in a hole in which the penetration is a force times its logarithm (M96).

They differ in one length c alone. With y = δ/c and x = F/(k c) all of them are y = -x ln x, whose inverse is x = y/u,
where u - ln u = -ln y (M97): the one equation that is solved. It has no answer beyond y = 1/e, where dδ/dF = 0; from
half the force of that point on, the law goes on along its tangent (M98).
"""

import math
from typing import ClassVar

import jax
import jax.numpy as jnp

from ..._types import Scalar, Values
from .pin_in_hole import LEAST, PinInHoleLaw

STEPS = 2  # of the iteration: to rounding for every t above that of END_U
END_X = 0.5 / math.e  # where the tangent begins: half of the force at which dδ/dF = 0
END_U = 1.0 + math.log(2.0)  # -ln x there
END_Y = END_X * END_U
END_SLOPE = 1.0 / (END_U - 1.0)  # dx/dy = 1/(u - 1) (M98)
END_ENERGY = END_X**2 * (2.0 * END_U - 1.0) / 4.0


@jax.custom_jvp
def lambert(t: Values) -> Values:
    """Return the u > 1 that solves u - ln u = t for t > 1: -W₋₁(-exp(-t)) of Lambert's function (M97).

    The start is Chatzigeorgiou's upper bound (2013). The iteration is that of Fritsch, Shafer and Crowley (1973): of
    fourth order, with one logarithm a step.
    """
    u = 1.0 + jnp.sqrt(2.0 * (t - 1.0)) + (t - 1.0)
    for _ in range(STEPS):
        slope, missing = u - 1.0, t + jnp.log(u) - u
        q = 2.0 * slope * (slope + 2.0 * missing / 3.0)
        u = u + u * missing / slope * (q + missing) / (q + 2.0 * missing)
    return u


# The derivative follows from the equation itself, without one of the iteration.
@lambert.defjvp
def _lambert_jvp(primals: tuple, tangents: tuple) -> tuple:
    u = lambert(*primals)
    return u, u / (u - 1.0) * tangents[0]


class LogarithmicLaw(PinInHoleLaw):
    """Base of the laws δ = s ln(c/s), s = F/k, k = π E* L (M96); fields as in `PinInHoleLaw`."""

    unit: ClassVar[str] = "-"

    @property
    def log_length(self) -> Scalar:
        """Return c [m], in which the laws differ."""
        raise NotImplementedError

    @property
    def limit_force(self) -> Scalar:
        """Return k c/(2 e) [N], half of the force at which dδ/dF = 0: from there on the law is its tangent (M98)."""
        return self.line_stiffness * self.log_length * END_X

    def elastic(self, penetration: Values) -> Values:
        """Return k c x(δ/c) [N], zero for δ ≤ 0, with finite derivatives there."""
        x, _, _ = self._part(penetration)
        return self.line_stiffness * self.log_length * x

    def energy(self, penetration: Values) -> Values:
        """Return ∫F dδ = F δ - ∫δ dF = k c² x² (2 u - 1)/4 [J] (M97), beyond the limit the tangent's (M98)."""
        x, u, beyond = self._part(penetration)
        stored = jnp.where(beyond > 0.0, END_ENERGY + 0.5 * (END_X + x) * beyond, 0.25 * x * x * (2.0 * u - 1.0))
        return self.line_stiffness * self.log_length**2 * stored

    def depth(self, force: Scalar) -> Scalar:
        """Return s ln(c/s) [m] (M96), beyond the limit the tangent's (M98)."""
        x = jnp.asarray(force, float) / (self.line_stiffness * self.log_length)
        within = (x > LEAST) & (x < END_X)
        # Guarded as in `power`: the branch that is not taken must have finite derivatives.
        inner = jnp.where(within, x, END_X)
        # Beyond the end the law is its tangent, which has no logarithm.
        y = jnp.where(x < END_X, -inner * jnp.log(inner), END_Y + (x - END_X) / END_SLOPE)
        return self.log_length * jnp.where(x > LEAST, y, 0.0)

    def depth_storing(self, energy: Scalar) -> Scalar:
        """Return the penetration [m] at which the spring has stored an ``energy`` [J], in closed form: w = 2 u - 1
        solves w - ln w = -1 - ln(4 V/(k c²)), M97's equation again (M99)."""
        v = jnp.asarray(energy, float) / (self.line_stiffness * self.log_length**2)
        within = (v > LEAST) & (v < END_ENERGY)
        u = 0.5 * (1.0 + lambert(-1.0 - jnp.log(4.0 * jnp.where(within, v, END_ENERGY))))
        beyond = 2.0 * jnp.where(within, 0.0, v - END_ENERGY)
        squared = jnp.where(beyond > 0.0, END_X**2 + END_SLOPE * beyond, END_X**2)
        y = jnp.where(v < END_ENERGY, u * jnp.exp(-u), END_Y + beyond / (END_X + jnp.sqrt(squared)))
        return self.log_length * jnp.where(v > LEAST, y, 0.0)

    def _part(self, penetration: Values) -> tuple[Values, Values, Values]:
        """Return x = F/(k c) [-], u within the limit [-], and y beyond it [-]."""
        y = penetration / self.log_length
        inside, within = penetration > LEAST, y < END_Y
        u = lambert(-jnp.log(jnp.where(inside & within, y, END_Y)))
        beyond = jnp.where(within, 0.0, y - END_Y)
        x = jnp.where(within, jnp.where(inside, y, 0.0) / u, END_X + END_SLOPE * beyond)
        return x, u, beyond


class Johnson(LogarithmicLaw):
    """δ = s [ln(4 ΔR/s) - 1]: c = 4 ΔR/e (M100)."""

    source: ClassVar[str] = "Johnson 1985"
    validity: ClassVar[str] = "contact narrow against the pin; long cylinders in half-spaces"

    @property
    def log_length(self) -> Scalar:
        return 4.0 / math.e * self.clearance


class Radzimovsky(LogarithmicLaw):
    """δ = s [2/3 + ln(4 R_B/b) + ln(4 R_J/b)], b = 1.60 √(F' R/E*): c = 16 e^(2/3) ΔR/(1.60² π) (M100).

    Some write b = 2 √(F' R/(π E*)) = 1.128 √(F' R/E*), Hertz's half-width, which makes δ 6 to 9 % larger.
    """

    source: ClassVar[str] = "Radzimovsky 1953, b = 1.60 √(F'R/E*)"
    validity: ClassVar[str] = "contact narrow against the pin"

    @property
    def log_length(self) -> Scalar:
        return 16.0 * math.exp(2.0 / 3.0) / (1.60**2 * math.pi) * self.clearance


class Goldsmith(LogarithmicLaw):
    """δ = s [ln(L/(F R (σ_i + σ_j))) + 1]: c = e·(1 m²)/R (M100), a curiosity.

    The logarithm's argument is not a pure number: the answer depends on the unit of length. Here it is the metre.
    """

    source: ClassVar[str] = "Goldsmith 1960"
    validity: ClassVar[str] = "none: its answer depends on the unit of length, here the metre"

    @property
    def log_length(self) -> Scalar:
        return math.e / self.relative_radius


class DubowskyFreudenstein(LogarithmicLaw):
    """δ = s [ln(L² ΔR/(s R_B R_J)) + 1]: c = e L²/R (M100)."""

    source: ClassVar[str] = "Dubowsky & Freudenstein 1971, m = 3"
    validity: ClassVar[str] = "contact narrow against the pin"

    @property
    def log_length(self) -> Scalar:
        return math.e * self.length * self.length / self.relative_radius


class Esdu78035(LogarithmicLaw):
    """δ = s [ln(4 ΔR/s) + 1]: c = 4 e ΔR, Johnson's with +1 for -1 (M100)."""

    source: ClassVar[str] = "ESDU 78035"
    validity: ClassVar[str] = "contact narrow against the pin"

    @property
    def log_length(self) -> Scalar:
        return 4.0 * math.e * self.clearance
