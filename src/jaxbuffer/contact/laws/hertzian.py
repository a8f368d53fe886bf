"""Hertz's law and its relatives with hysteresis (M35): they differ in χ̂ alone.

χ̂(e) comes from the restitution e asked for by an energy argument, each author's own. What two free bodies then do
follows from χ̂ exactly (M46); only `ExactRestitution` delivers what it is asked for.
"""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp

from ..._types import Scalar, Values
from .base import ContactLaw, power, root
from .restitution import damping_delivering, psi, restitution_delivered


class HystereticLaw(ContactLaw):
    """Base of the laws K δⁿ max(0, 1 + χ̂ δ̇/δ̇⁻) (M35).

    - ``stiffness``: K [N/mⁿ].
    - ``hysteresis``: χ̂ [-], the damping force over the elastic one at the speed of touchdown.
    - ``exponent``: n [-], 3/2 for a ball.
    """

    stiffness: eqx.AbstractVar[Scalar]
    exponent: float = eqx.field(default=1.5, static=True, kw_only=True)

    @property
    def hysteresis(self) -> Scalar:
        """χ̂ [-]."""
        raise NotImplementedError

    def elastic(self, penetration: Values) -> Values:
        """K δⁿ [N], zero for δ ≤ 0, with finite derivatives there."""
        return self.stiffness * power(penetration, self.exponent)

    def energy(self, penetration: Values) -> Values:
        """K δⁿ⁺¹/(n + 1) [J] (M37)."""
        return self.elastic(penetration) * penetration / (self.exponent + 1.0)

    def depth(self, force: Scalar) -> Scalar:
        """(F/K)^(1/n) [m] (M72)."""
        return root(force / self.stiffness, self.exponent)

    def force(self, penetration: Values, approach_speed: Values, touchdown_speed: Values) -> Values:
        return self.elastic(penetration) * jnp.maximum(0.0, 1.0 + self.hysteresis * approach_speed / touchdown_speed)

    def time_scale(self, mass: Scalar, speed: Scalar) -> Scalar:
        if self.exponent == 1.5:
            return (mass**2 / (self.stiffness**2 * speed)) ** 0.2
        return (mass * speed ** (1.0 - self.exponent) / self.stiffness) ** (1.0 / (self.exponent + 1.0))

    def delivered_restitution(self, mass: Scalar = 1.0, speed: Scalar = 1.0) -> Scalar:
        """The restitution [-] that solves M46 with d = χ̂, the same for any mass [kg] and speed [m/s]."""
        return restitution_delivered(self.hysteresis)

    def max_penetration(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Deepest penetration [m] of two free bodies (M48). ``mass``: effective [kg]; ``speed``: [m/s]."""
        n = self.exponent + 1.0
        return (-n * mass * speed**2 / self.stiffness * psi(self.hysteresis)) ** (1.0 / n)


class Hertz(HystereticLaw):
    """χ̂ = 0: no loss (M38). ``stiffness``: K [N/m^1.5]."""

    source: ClassVar[str] = "Hertz 1881"
    validity: ClassVar[str] = "elastic, contact small against the radii, no friction"
    stiffness: Scalar

    @property
    def hysteresis(self) -> Scalar:
        return 0.0


class RestitutionLaw(HystereticLaw):
    """Base of the laws that ask for a restitution.

    - ``stiffness``: K [N/m^1.5].
    - ``restitution``: e in (0, 1] [-].
    """

    stiffness: Scalar
    restitution: Scalar


class HuntCrossley(RestitutionLaw):
    """χ̂ = 3 (1 - e)/2 (M39)."""

    source: ClassVar[str] = "Hunt & Crossley 1975"
    validity: ClassVar[str] = "e near 1: first order in 1 - e"

    @property
    def hysteresis(self) -> Scalar:
        return 1.5 * (1.0 - self.restitution)


class HerbertMcWhannell(RestitutionLaw):
    """χ̂ = 6 (1 - e)/((2 e - 1)² + 3) (M40)."""

    source: ClassVar[str] = "Herbert & McWhannell 1977"
    validity: ClassVar[str] = "e near 1: first order in 1 - e"

    @property
    def hysteresis(self) -> Scalar:
        e = self.restitution
        return 6.0 * (1.0 - e) / ((2.0 * e - 1.0) ** 2 + 3.0)


class LankaraniNikravesh(RestitutionLaw):
    """χ̂ = 3 (1 - e²)/4, the paper's law (M41)."""

    source: ClassVar[str] = "Lankarani & Nikravesh 1990"
    validity: ClassVar[str] = "e near 1: first order in 1 - e"

    @property
    def hysteresis(self) -> Scalar:
        return 0.75 * (1.0 - self.restitution * self.restitution)


class LeeWang(RestitutionLaw):
    """χ̂ = 3 (1 - e)/4 (M42)."""

    source: ClassVar[str] = "Lee & Wang 1983"
    validity: ClassVar[str] = "e = 1 only: half of the loss that is asked for"

    @property
    def hysteresis(self) -> Scalar:
        return 0.75 * (1.0 - self.restitution)


class Gonthier(RestitutionLaw):
    """χ̂ = (1 - e²)/e (M43)."""

    source: ClassVar[str] = "Gonthier, McPhee, Lange & Piedbœuf 2004"
    validity: ClassVar[str] = "all e, best towards 0; at e = 0.9 a quarter too much loss"

    @property
    def hysteresis(self) -> Scalar:
        return (1.0 - self.restitution * self.restitution) / self.restitution


class Flores(RestitutionLaw):
    """χ̂ = 8 (1 - e)/(5 e) (M44)."""

    source: ClassVar[str] = "Flores, Machado, Silva & Martins 2011"
    validity: ClassVar[str] = "all e; low by up to 0.046 (e = 0.24)"

    @property
    def hysteresis(self) -> Scalar:
        return 1.6 * (1.0 - self.restitution) / self.restitution


class HuGuo(RestitutionLaw):
    """χ̂ = 3 (1 - e)/(2 e) (M45)."""

    source: ClassVar[str] = "Hu & Guo 2015"
    validity: ClassVar[str] = "all e; low by up to 0.035 (e = 0.2)"

    @property
    def hysteresis(self) -> Scalar:
        return 1.5 * (1.0 - self.restitution) / self.restitution


class ExactRestitution(RestitutionLaw):
    """χ̂ solves M46, so that two free bodies part at exactly e times their approach speed.

    - ``stiffness``: K [N/mⁿ].
    - ``restitution``: e in (0, 1] [-].
    - ``exponent``: n [-].
    - ``solved``: χ̂ [-], found once, when the law is built.
    """

    source: ClassVar[str] = "exact relation of the damped power law"
    validity: ClassVar[str] = "all e"
    solved: Scalar

    def __init__(self, stiffness: Scalar, restitution: Scalar, *, exponent: float = 1.5):
        self.stiffness, self.restitution, self.exponent = stiffness, restitution, exponent
        self.solved = damping_delivering(restitution)

    @property
    def hysteresis(self) -> Scalar:
        return self.solved
