"""The joints at the rod's ends: pinned, or a pin with play in a bush."""

from collections.abc import Iterator
from typing import ClassVar

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool

from ..._types import Scalar
from ...contact import ContactLaw
from ...contact.laws import (
    DAMPING_FACTORS,
    PIN_IN_HOLE_LAWS,
    PinInHoleLaw,
    SphereInSphere,
    contact_modulus,
    pin_in_hole_law,
)
from ...contact.laws.hysteresis import PowerLaw
from ...errors import InputError, concrete, inside
from ...fields import NON_NEGATIVE, POSITIVE, Number, Part, absent, choice, chosen, chosen_in, number, on
from .blunt_impact import BluntImpact

ADAMS = "adams"
SPHERE_EXPONENT = 1.5  # -
SIDES = ("right of piston", "left of piston", "above piston", "below piston")
PLAY = chosen("joint", "clearance")  # without it there is no contact
LAWS_WITH_LENGTH = tuple(name for name in PIN_IN_HOLE_LAWS if name != "sphere")


class GivenStiffness(PowerLaw):
    """A ball in a spherical bush whose ``stiffness`` K [N/m^1.5] is given; ``hysteresis`` χ̂ [-] (M35)."""

    stiffness: Scalar
    hysteresis: Scalar
    exponent: float = eqx.field(default=SPHERE_EXPONENT, static=True)


class PinInBush(Part):
    """A pin in a bush, which is on the rod.

    The stiffness of the laws of `contact.laws.PIN_IN_HOLE_LAWS` comes from the materials unless it is given, which the
    law "sphere" allows; their damping factors are those of `contact.laws.DAMPING_FACTORS`. The law "adams" is IMPACT: k
    δ^e and a damper that sets in over a depth; over the onset depth its force comes in from zero with a finite slope,
    also for exponents below 1.
    """

    joint: str = choice("pinned", "pinned", "clearance", doc="pinned: without play; clearance: a pin in a larger bush")
    clearance: Number = number(
        5e-4, "m", **POSITIVE, needs=PLAY, doc="radial clearance, the bush's radius less the pin's"
    )
    bush_radius: Number = number(0.01, "m", **POSITIVE, needs=PLAY, doc="radius of the bush")
    length: Number = number(
        0.04,
        "m",
        **POSITIVE,
        needs=(*PLAY, *chosen("law", *LAWS_WITH_LENGTH)),
        doc="length of pin and bush along their axis",
    )
    law: str = choice("sphere", *PIN_IN_HOLE_LAWS, ADAMS, needs=PLAY, doc="contact law of pin in bush")
    damping: str = choice(
        "lankarani-nikravesh",
        *DAMPING_FACTORS,
        needs=(*PLAY, *chosen("law", *PIN_IN_HOLE_LAWS)),
        doc="damping factor of the law",
    )
    restitution: Number = number(
        0.9,
        "-",
        low=0.0,
        high=1.0,
        low_open=True,
        needs=(*PLAY, *chosen("law", *PIN_IN_HOLE_LAWS)),
        doc="restitution that is asked of the damping factor",
    )
    stiffness: Number = number(
        None,
        "N/m^e",
        **POSITIVE,
        needs=PLAY,
        doc="stiffness of the laws sphere and adams; not set: computed from the materials",
    )
    exponent: Number = number(
        1.5, "-", **POSITIVE, needs=(*PLAY, *chosen("law", ADAMS)), doc="exponent of the law adams"
    )
    viscous: Number = number(
        0.0, "N s/m", **NON_NEGATIVE, needs=(*PLAY, *chosen("law", ADAMS)), doc="damping of the law adams"
    )
    ramp_depth: Number = number(
        1e-6, "m", **POSITIVE, needs=(*PLAY, *chosen("law", ADAMS)), doc="depth over which that damping sets in"
    )
    onset_depth: Number = number(
        1e-8,
        "m",
        **POSITIVE,
        needs=(*PLAY, *chosen("law", ADAMS)),
        doc="depth over which a law that begins with a slope sets in",
    )
    friction: Number = number(0.0, "-", **NON_NEGATIVE, needs=PLAY, doc="coefficient of friction of pin in bush")
    slip_speed: Number = number(
        1e-3, "m/s", **POSITIVE, needs=(*PLAY, *on("friction")), doc="slip speed below which friction falls to zero"
    )
    young_modulus: Number = number(
        207e9, "Pa", **POSITIVE, needs=(*PLAY, *absent("stiffness")), doc="Young's modulus of pin and bush"
    )
    poisson_ratio: Number = number(
        0.3,
        "-",
        low=-1.0,
        high=0.5,
        low_open=True,
        needs=(*PLAY, *absent("stiffness")),
        doc="Poisson's ratio of pin and bush",
    )

    @property
    def by_components(self) -> bool:
        """Return whether the pin's contact is one for each direction."""
        return False

    @property
    def contacts(self) -> tuple[str, ...]:
        """Return the names of the pin's contacts, by their places."""
        if self.joint == "pinned":
            return ()
        return SIDES if self.by_components else (self.section.removesuffix("_pin"),)

    @property
    def radius(self) -> Scalar:
        """Return the radius of the pin [m]."""
        return self.bush_radius - self.clearance

    @property
    def by_materials(self) -> PinInHoleLaw:
        """Return the law of a pin in a hole with this name, that of a sphere for "adams"."""
        modulus, ratio = self.young_modulus, self.poisson_ratio
        return pin_in_hole_law(
            # IMPACT takes its stiffness from the materials as a sphere does, unless it is given.
            "sphere" if self.law == ADAMS else self.law,
            bush_radius=self.bush_radius,
            clearance=self.clearance,
            length=self.length,
            modulus=contact_modulus(modulus, ratio, modulus, ratio),
            damping=self.damping,
            restitution=self.restitution,
        )

    @property
    def contact_law(self) -> ContactLaw:
        """Return the normal law of the pin's contact."""
        by_materials = self.by_materials
        if self.law == ADAMS:
            assert isinstance(by_materials, SphereInSphere)
            stiffness = by_materials.stiffness if self.stiffness is None else self.stiffness
            return BluntImpact(stiffness, self.exponent, self.viscous, self.ramp_depth, self.onset_depth)
        # The hysteresis follows from the restitution alone, whatever the stiffness is.
        return by_materials if self.stiffness is None else GivenStiffness(self.stiffness, by_materials.hysteresis)

    def check_together(self) -> None:
        clearance, bush, exponent = concrete(self.clearance), concrete(self.bush_radius), concrete(self.exponent)
        if clearance is not None and bush is not None and not np.all(clearance < bush):
            raise InputError(f"{self.section}.clearance must be below {self.section}.bush_radius")
        if self.stiffness is not None and self.law not in ("sphere", ADAMS):
            raise InputError(
                f"{self.section}.stiffness: {self.section}.law = {self.law!r} takes its stiffness from the materials;"
                " change young_modulus or length"
            )
        free = self.law == ADAMS and self.stiffness is not None
        if exponent is not None and np.any(exponent != SPHERE_EXPONENT) and not free:
            raise InputError(
                f"{self.section}.exponent = {float(np.ravel(exponent)[0]):g}: only {self.section}.law = 'adams' with a"
                f" {self.section}.stiffness in N/m^e has another exponent than {SPHERE_EXPONENT}"
            )

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        yield inside(self.clearance, high=self.bush_radius, high_open=True)
        if self.law != ADAMS or self.stiffness is None:
            yield inside(self.exponent, low=SPHERE_EXPONENT, high=SPHERE_EXPONENT)


class PistonPin(PinInBush):
    """Between rod and slider; the pin is on the slider. See `PinInBush`.

    ``contact``: "round", or "components": the slider's two directions each on their own, as if the hole were square and
    fixed on the slider; the pin is then on the rod. ``memory_time``: of the contacts of both pins.
    """

    section: ClassVar[str] = "piston_pin"
    joint: str = choice(
        "clearance", "pinned", "clearance", doc="pinned: without play; clearance: a pin in a larger bush"
    )
    contact: str = choice(
        "round",
        "round",
        "components",
        needs=PLAY,
        doc="round; or components: each of the slider's directions on its own",
    )
    memory_time: Number = number(
        None,
        "s",
        **POSITIVE,
        needs=chosen_in(("joint", "crank_pin.joint"), "clearance"),
        doc="time in which a smooth contact's memory follows the approach speed; not set: events set it",
    )

    @property
    def by_components(self) -> bool:
        return self.joint == "clearance" and self.contact == "components"


class CrankPin(PinInBush):
    """Between crank and rod; the pin is on the crank. See `PinInBush`."""

    section: ClassVar[str] = "crank_pin"
