"""The contact of the tip with the cone, as a part of the design."""

from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from jaxtyping import Array, Bool

from ...contact import law_choice, law_class, laws_with
from ...errors import InputError, concrete, inside
from ...fields import NON_NEGATIVE, POSITIVE, Number, Part, choice, chosen, chosen_of, number, on

HERTZ_EXPONENT = 1.5  # -


class Contact(Part):
    """Tip against flank: a normal law and regularised Coulomb friction (M59).

    A law takes those of the fields that it has. The defaults of "kelvin-voigt" and "adams" are as stiff and as lossy as
    Table 2's law at the depth of its first impact. Computed from the materials and the tip's radius the stiffness is
    Hertz's (M53); of "adams" its unit is N/m^exponent. The smooth contact sets in over its onset length (M60), and its
    memory follows the approach speed (M61). Arms that move act at the foot (M33); the published ones are fixed on the
    passive vehicle (M34). A yield stress lets the answer say where the materials yield (M57).
    """

    section: ClassVar[str] = "contact"
    law: str = law_choice("lankarani-nikravesh")
    stiffness: Number = number(
        None,
        "N/m^1.5",
        **POSITIVE,
        needs=chosen_of("law", laws_with("stiffness")),
        doc="stiffness K; not set: computed from materials and tip radius",
    )
    restitution: Number = number(
        0.9,
        "-",
        low=0.0,
        high=1.0,
        low_open=True,
        needs=chosen_of("law", laws_with("restitution")),
        doc="restitution e that is asked of laws with hysteresis",
    )
    friction: Number = number(0.33, "-", **NON_NEGATIVE, doc="coefficient of friction μ")
    slip_speed: Number = number(
        1e-3, "m/s", **POSITIVE, needs=on("friction"), doc="slip speed v_s below which friction falls to zero"
    )
    young_modulus: Number = number(
        71.7e9, "Pa", **POSITIVE, doc="Young's modulus of the tip, and of a cone without its own"
    )
    poisson_ratio: Number = number(
        0.3, "-", low=-1.0, high=0.5, low_open=True, doc="Poisson's ratio of the tip, and of a cone without its own"
    )
    yield_stress: Number = number(
        None, "Pa", **POSITIVE, doc="yield stress of the softer side; not set: yielding is not looked at"
    )
    linear_stiffness: Number = number(
        1.5e7,
        "N/m",
        **POSITIVE,
        needs=chosen_of("law", laws_with("linear_stiffness")),
        doc="stiffness k of the law kelvin-voigt",
    )
    damping: Number = number(
        80.0,
        "N s/m",
        **NON_NEGATIVE,
        needs=chosen_of("law", laws_with("damping")),
        doc="damping c of the laws kelvin-voigt and adams",
    )
    exponent: Number = number(1.5, "-", low=1.0, doc="exponent n of the law adams")
    ramp_depth: Number = number(
        1e-6,
        "m",
        **POSITIVE,
        needs=chosen_of("law", laws_with("ramp_depth")),
        doc="depth d over which the damping of adams sets in",
    )
    onset_length: Number = number(
        1e-8, "m", **POSITIVE, needs=chosen("memory", "smooth"), doc="length ε over which the smooth contact sets in"
    )
    memory_time: Number = number(
        2e-4,
        "s",
        **POSITIVE,
        needs=chosen("memory", "smooth"),
        doc="time τ_m in which the smooth contact's memory follows the approach speed",
    )
    memory: str = choice(
        "event",
        "event",
        "smooth",
        doc="event: the speed of the last touchdown is held; smooth: it follows while out of contact",
    )
    arms: str = choice(
        "moving",
        "moving",
        "published",
        doc="moving: the force acts at the foot; published: where the first contact was",
    )

    def check_together(self) -> None:
        exponent = concrete(self.exponent)
        if exponent is not None and np.any(exponent != HERTZ_EXPONENT):
            shown = f"contact.exponent = {float(exponent.flat[0]):g}"
            if self.law != "adams":
                raise InputError(f"{shown}: only contact.law = 'adams' has an exponent other than {HERTZ_EXPONENT}")
            if not self.has("stiffness"):
                raise InputError(f"{shown} needs contact.stiffness in N/m^exponent: Hertz's is in N/m^{HERTZ_EXPONENT}")
        if self.memory == "smooth" and law_class(self.law).jumps:
            raise InputError(
                f"contact.law = {self.law!r}: its force jumps at touchdown; contact.memory must be 'event'"
            )

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if not (self.law == "adams" and self.has("stiffness")):
            yield inside(self.exponent, low=HERTZ_EXPONENT, high=HERTZ_EXPONENT)
