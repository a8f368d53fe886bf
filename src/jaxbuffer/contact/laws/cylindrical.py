"""A pin in a hole: the laws that give the force outright, and the names of all of them.

The logarithmic ones, which give the penetration of a force, are in `logarithmic`.
"""

from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

import jax.numpy as jnp

from ..._types import Scalar, Values
from ...errors import InputError, check_choice, check_number, concrete
from .damping import damping_factor
from .hysteresis import PowerLaw
from .logarithmic import DubowskyFreudenstein, Esdu78035, Goldsmith, Johnson, Radzimovsky
from .pin_in_hole import LEAST, PinInHoleLaw
from .stiffness import ball_stiffness

SMALL = 0.1  # δ/ΔR below which Liu's energy is summed as a series
TERMS = 16  # of the series: its first neglected term is below 0.1^16
STEPS = 5  # of Newton's method on a double logarithmic scale, where Liu's curves are nearly straight
MM = 1e-3  # m
LEAST_MM, BEND_MM, MOST_MM = 0.005, 0.34954, 10.0  # clearances [mm] between which Pereira's fit holds, and its pieces


class SphereInSphere(PowerLaw, PinInHoleLaw):
    """K δ^{3/2} of a ball in a spherical socket, K = (4/3) E* √(R_B R_J/ΔR): what most papers run for a pin (M54).

    The length has no part in it; for a pin it is several times too soft.
    """

    source: ClassVar[str] = "Hertz 1881; for joints Lankarani & Nikravesh 1990"
    validity: ClassVar[str] = "balls; contact small against them. Several times too soft for a pin"

    @property
    def stiffness(self) -> Scalar:
        """Return K [N/m^1.5]."""
        return ball_stiffness(self.relative_radius, 1.0 / self.modulus)

    @property
    def exponent(self) -> Scalar:
        """Return 3/2."""
        return 1.5

    @property
    def limit_force(self) -> Scalar:
        """Return the force [N] at which the contact's radius √(R δ) is R_J/√10, as in M57."""
        return self.elastic(jnp.asarray(0.1 * self.journal_radius**2 / self.relative_radius))


class Liu(PinInHoleLaw):
    """(k/2) δ √(δ/(2 (ΔR + δ))) (M102)."""

    source: ClassVar[str] = "Liu, Zhang & Yang 2007"
    validity: ClassVar[str] = "small clearances and large loads too, after its authors"
    unit: ClassVar[str] = "-"

    def elastic(self, penetration: Values) -> Values:
        y = jnp.where(penetration > LEAST, penetration, self.clearance) / self.clearance
        return self._unit_force() * jnp.where(penetration > LEAST, y * jnp.sqrt(y / (1.0 + y)), 0.0)

    def energy(self, penetration: Values) -> Values:
        """Return the integral of the force [J] in closed form, as a series where that would cancel (M103)."""
        y = jnp.where(penetration > LEAST, penetration, self.clearance) / self.clearance
        near, far = jnp.where(y < SMALL, y, SMALL), jnp.where(y < SMALL, SMALL, y)
        series, coefficient = jnp.zeros_like(y), 1.0
        for k in range(TERMS):  # of y^{3/2} (1 + y)^{-1/2}, integrated term by term
            series = series + coefficient / (k + 2.5) * near**k
            coefficient *= -(k + 0.5) / (k + 1.0)
        closed = 0.75 * jnp.arcsinh(jnp.sqrt(far)) + (0.5 * far - 0.75) * jnp.sqrt(far * (1.0 + far))
        stored = jnp.where(y < SMALL, near * near * jnp.sqrt(near) * series, closed)
        return self._unit_force() * self.clearance * jnp.where(penetration > LEAST, stored, 0.0)

    def depth(self, force: Scalar) -> Scalar:
        return self._inverse(self.elastic, self.elastic_slope, force, self._unit_force(), 1.5)

    def depth_storing(self, energy: Scalar) -> Scalar:
        return self._inverse(self.energy, self.elastic, energy, 0.4 * self._unit_force() * self.clearance, 2.5)

    def elastic_slope(self, penetration: Values) -> Values:
        """Return dF/dδ [N/m] for δ > 0."""
        y = penetration / self.clearance
        return self.elastic(penetration) / penetration * (1.5 - 0.5 * y / (1.0 + y))

    def _unit_force(self) -> Scalar:
        """Return k ΔR/√8 [N]."""
        return self.line_stiffness * self.clearance / 8.0**0.5

    def _inverse(self, function, slope, value: Scalar, unit: Scalar, exponent: float) -> Scalar:
        """Return the δ [m] at which a ``function`` that begins as ``unit`` times (δ/ΔR)^exponent takes a ``value``."""
        positive = jnp.asarray(value, float) > 0.0
        # Guarded as in `base.power`: a power of zero has no derivative.
        target = jnp.where(positive, value, unit)
        depth = self.clearance * (target / unit) ** (1.0 / exponent)
        for _ in range(STEPS):
            reached = function(depth)
            depth = depth * (target / reached) ** (reached / (depth * slope(depth)))
        return jnp.where(positive, depth, 0.0)


class Pereira(PowerLaw, PinInHoleLaw):
    """A fit to the logarithmic laws, (0.965 ΔR + 0.0965) E* L/ΔR δⁿ in mm and N, n(ΔR) (M104).

    Its clearances reach from 0.005 to 10 mm; beyond them n stays what it is at the end. It was published with the
    damping factor of "lankarani-nikravesh". A slip to know: n = Y ΔR^-0.005 is also seen as (Y ΔR)^-0.005.
    """

    source: ClassVar[str] = "Pereira, Ramalho & Ambrósio 2011, a pin inside a hole"
    validity: ClassVar[str] = "clearances of 0.005 to 10 mm: a fit"
    unit: ClassVar[str] = "N/m^n"

    @property
    def exponent(self) -> Scalar:
        """Return n [-]."""
        gap = jnp.clip(jnp.asarray(self.clearance, float) / MM, LEAST_MM, MOST_MM)
        narrow = gap < BEND_MM
        inner = jnp.where(narrow, gap, BEND_MM)
        base = jnp.where(narrow, 1.51 * jnp.log(1000.0 * inner) ** -0.151, 0.0151 * gap + 1.151)
        return base * gap**-0.005

    @property
    def stiffness(self) -> Scalar:
        """Return K [N/mⁿ]."""
        gap = self.clearance / MM
        per_mm = (0.965 * gap + 0.0965) / gap * (self.modulus * MM**2) * (self.length / MM)
        return per_mm * MM**-self.exponent


PIN_IN_HOLE_LAWS: Mapping[str, type[PinInHoleLaw]] = MappingProxyType(
    {
        "sphere": SphereInSphere,
        "johnson": Johnson,
        "radzimovsky": Radzimovsky,
        "goldsmith": Goldsmith,
        "dubowsky-freudenstein": DubowskyFreudenstein,
        "esdu-78035": Esdu78035,
        "liu": Liu,
        "pereira": Pereira,
    }
)
"""The laws of a pin in a hole by name."""


def pin_in_hole_law(
    name: str,
    *,
    bush_radius: Scalar,
    clearance: Scalar,
    length: Scalar,
    modulus: Scalar,
    damping: str = "lankarani-nikravesh",
    restitution: Scalar = 1.0,
) -> PinInHoleLaw:
    """Make a law of a pin in a hole by its name, with an author's damping factor.

    **Arguments:**

    - ``name``: a key of `PIN_IN_HOLE_LAWS`.
    - ``bush_radius``: R_B, of the hole [m].
    - ``clearance``: ΔR, the hole's radius less the pin's, below ``bush_radius`` [m].
    - ``length``: L of the contact along the axis [m].
    - ``modulus``: E* [Pa], see `contact_modulus`.
    - ``damping``: a key of `DAMPING_FACTORS`.
    - ``restitution``: e in (0, 1] that the damping is asked for [-].

    **Raises:** `InputError` for names and numbers that do not fit; traced numbers pass.

    >>> from jaxbuffer.contact.laws import contact_modulus, pin_in_hole_law
    >>> modulus = contact_modulus(207e9, 0.3, 207e9, 0.3)
    >>> law = pin_in_hole_law("johnson", bush_radius=10e-3, clearance=0.5e-3, length=40e-3, modulus=modulus)
    >>> f"{1e6 * float(law.depth(1e3)):.5f} µm"
    '0.64794 µm'
    """
    check_choice("law of a pin in a hole", name, PIN_IN_HOLE_LAWS)
    for field, value, unit in (
        ("bush_radius", bush_radius, "m"),
        ("clearance", clearance, "m"),
        ("length", length, "m"),
        ("modulus", modulus, "Pa"),
    ):
        check_number(field, value, unit, low=0.0, low_open=True, high_open=True)
    check_number("restitution", restitution, "", low=0.0, high=1.0, low_open=True)
    hole, gap = concrete(bush_radius), concrete(clearance)
    if hole is not None and gap is not None and not (gap < hole).all():
        raise InputError(f"clearance = {clearance:g} m must be below the hole's radius, {bush_radius:g} m")
    return PIN_IN_HOLE_LAWS[name](bush_radius, clearance, length, modulus, damping_factor(damping, restitution))
