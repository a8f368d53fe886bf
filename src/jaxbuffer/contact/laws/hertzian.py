"""Hertz's law and its relatives with hysteresis (M35): they differ in χ̂ alone (`damping`).

What two free bodies do under them follows from χ̂ exactly (M46); only `ExactRestitution` delivers what it is asked for.
"""

from typing import ClassVar

import equinox as eqx
import jax.numpy as jnp

from ..._types import Scalar, Values
from .damping import (
    carvalho_martins,
    flores,
    gonthier,
    herbert_mcwhannell,
    hu_guo,
    hunt_crossley,
    lankarani_nikravesh,
    lee_wang,
)
from .hysteresis import PowerLaw
from .restitution import damping_delivering, psi, restitution_delivered


class HystereticLaw(PowerLaw):
    """Base of the laws K δⁿ max(0, 1 + χ̂ δ̇/δ̇⁻) (M35).

    - ``stiffness``: K [N/mⁿ].
    - ``hysteresis``: χ̂ [-], the damping force over the elastic one at the speed of touchdown.
    - ``exponent``: n [-], 3/2 for a ball.
    """

    exponent: float = eqx.field(default=1.5, static=True, kw_only=True)


class Hertz(HystereticLaw):
    """χ̂ = 0: no loss (M38). ``stiffness``: K [N/m^1.5]."""

    source: ClassVar[str] = "Hertz 1881"
    validity: ClassVar[str] = "elastic, contact small against the radii, no friction"
    stiffness: Scalar

    @property
    def hysteresis(self) -> Scalar:
        return 0.0


class DampedHertz(Hertz):
    """K δ^{3/2} max(0, 1 + a δ̇): Hunt and Crossley's law as they wrote it, with a constant a instead of one for a
    restitution at the touchdown's speed (M109). Faster impacts lose more.

    ``stiffness``: K [N/m^1.5]; ``damping``: a [s/m].
    """

    source: ClassVar[str] = "Hunt & Crossley 1975"
    validity: ClassVar[str] = "a v small against 1: the restitution is about 1 - 2 a v/3"
    damping: Scalar

    def force(self, penetration: Values, approach_speed: Values, touchdown_speed: Values) -> Values:
        return self.elastic(penetration) * jnp.maximum(0.0, 1.0 + self.damping * approach_speed)

    def delivered_restitution(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Return the restitution by M46 with d = a v [-]."""
        return restitution_delivered(self.damping * speed)

    def max_penetration(self, mass: Scalar, speed: Scalar) -> Scalar:
        """Return the deepest penetration by M48 with d = a v [m]."""
        # M48 solved for the stored energy: ψ is negative.
        return self.depth_storing(-mass * speed**2 * psi(self.damping * speed))


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
        return hunt_crossley(self.restitution)


class HerbertMcWhannell(RestitutionLaw):
    """χ̂ = 6 (1 - e)/((2 e - 1)² + 3) (M40)."""

    source: ClassVar[str] = "Herbert & McWhannell 1977"
    validity: ClassVar[str] = "e near 1: first order in 1 - e"

    @property
    def hysteresis(self) -> Scalar:
        return herbert_mcwhannell(self.restitution)


class LankaraniNikravesh(RestitutionLaw):
    """χ̂ = 3 (1 - e²)/4, the paper's law (M41)."""

    source: ClassVar[str] = "Lankarani & Nikravesh 1990"
    validity: ClassVar[str] = "e near 1: first order in 1 - e"

    @property
    def hysteresis(self) -> Scalar:
        return lankarani_nikravesh(self.restitution)


class LeeWang(RestitutionLaw):
    """χ̂ = 3 (1 - e)/4 (M42)."""

    source: ClassVar[str] = "Lee & Wang 1983"
    validity: ClassVar[str] = "e = 1 only: half of the loss that is asked for"

    @property
    def hysteresis(self) -> Scalar:
        return lee_wang(self.restitution)


class Gonthier(RestitutionLaw):
    """χ̂ = (1 - e²)/e (M43)."""

    source: ClassVar[str] = "Gonthier, McPhee, Lange & Piedbœuf 2004"
    validity: ClassVar[str] = "all e, best towards 0; at e = 0.9 a quarter too much loss"

    @property
    def hysteresis(self) -> Scalar:
        return gonthier(self.restitution)


class Flores(RestitutionLaw):
    """χ̂ = 8 (1 - e)/(5 e) (M44)."""

    source: ClassVar[str] = "Flores, Machado, Silva & Martins 2011"
    validity: ClassVar[str] = "all e; low by up to 0.046 (e = 0.24)"

    @property
    def hysteresis(self) -> Scalar:
        return flores(self.restitution)


class HuGuo(RestitutionLaw):
    """χ̂ = 3 (1 - e)/(2 e) (M45)."""

    source: ClassVar[str] = "Hu & Guo 2015"
    validity: ClassVar[str] = "all e; low by up to 0.035 (e = 0.2)"

    @property
    def hysteresis(self) -> Scalar:
        return hu_guo(self.restitution)


class CarvalhoMartins(RestitutionLaw):
    """χ̂ = 3 (1 - e) (11 - e)/(2 (1 + 9 e)), below e = 1/3 Gonthier's (M93)."""

    source: ClassVar[str] = "Carvalho & Martins 2019; below e = 1/3 Gonthier et al. 2004"
    validity: ClassVar[str] = "all e; within 0.0053 (e = 0.24), from e = 1/2 on within 0.0002"

    @property
    def hysteresis(self) -> Scalar:
        return carvalho_martins(self.restitution)


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
