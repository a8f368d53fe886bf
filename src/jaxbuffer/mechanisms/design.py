"""The capture mechanism's design and scenario: every number an engineer may choose, validated at construction."""

import dataclasses
import math
from typing import Any, ClassVar

import equinox as eqx
import numpy as np

from .._types import Scalar
from ..contact import LAWS, hertz_stiffness
from ..errors import (
    InputError,
    as_number,
    check_choice,
    check_entries,
    check_flag,
    check_number,
    check_type,
    concrete,
    same_shape,
)

ALUMINIUM_DENSITY = 2740.0  # kg/m³, the paper's section 7
ROD_RADIUS = 0.009  # m, r_p of Table 2
TIP_RADIUS = 0.015  # m, R_tip of Table 2
PROBE_LENGTH = 0.2  # m, L_P of Table 2
HERTZ_EXPONENT = 1.5  # -


def number(default: float | None, unit: str, **limits: Any) -> Any:
    """A differentiable field with its unit and allowed range; lists of numbers become arrays."""
    return eqx.field(default=default, converter=as_number, metadata={"unit": unit, "limits": limits})


def choice(default: str, *options: str) -> Any:
    """A static field that takes one of a few words."""
    return eqx.field(default=default, static=True, metadata={"choices": options})


POSITIVE: dict[str, Any] = {"low": 0.0, "low_open": True}
NON_NEGATIVE: dict[str, Any] = {"low": 0.0}


class Part(eqx.Module):
    """A group of fields that checks each against its declared range; ``section`` is its name in dotted paths."""

    section: ClassVar[str] = ""

    def __check_init__(self) -> None:
        prefix = f"{self.section}." if self.section else ""
        for field in dataclasses.fields(self):
            value, path = getattr(self, field.name), prefix + field.name
            if "choices" in field.metadata:
                check_choice(path, value, field.metadata["choices"])
            elif "flag" in field.metadata:
                check_flag(path, value)
            elif "unit" in field.metadata:
                if value is not None or field.default is not None:
                    check_number(path, value, field.metadata["unit"], **field.metadata["limits"])
            elif isinstance(field.default, Part):
                check_type(path, value, type(field.default), f"{type(field.default).__name__}(…)")
        self.check_together()

    def check_together(self) -> None:
        """Raise `InputError` where fields, each good in itself, don't go together."""


class Active(Part):
    """The active vehicle S, which carries the probe."""

    section: ClassVar[str] = "active"
    mass: Scalar = number(21.9706, "kg", **POSITIVE)
    inertia: Scalar = number(0.445, "kg m²", **POSITIVE)
    hinge_offset: Scalar = number(0.1365, "m", **NON_NEGATIVE)


class Passive(Part):
    """The passive vehicle T, which carries the cone."""

    section: ClassVar[str] = "passive"
    mass: Scalar = number(23.5731, "kg", **POSITIVE)
    inertia: Scalar = number(0.5206, "kg m²", **POSITIVE)


class Buffer(Part):
    """Axial and torsional spring-dampers, the cylinder between them, and the buffer's end.

    ``max_stroke``: stroke at which the buffer is at its end (None: ``free_length``, where the spring's ends meet). A
    run that gets there ends as "bottomed", unless ``stop_stiffness`` is given: an end stop then pushes the probe out
    again with F_s = max(0, k_s (s - s_m) + c_s ṡ) while the stroke s exceeds s_m; only ``free_length`` ends that run.
    ``damping``: "physical" damps L̇; "published" damps the whole rate of D, the paper's eq. 10, which does not conserve
    angular momentum.
    """

    section: ClassVar[str] = "buffer"
    k_A: Scalar = number(500.0, "N/m", **POSITIVE)
    c_A: Scalar = number(5.0, "N s/m", **NON_NEGATIVE)
    k_T: Scalar = number(300.0, "N m/rad", **POSITIVE)
    c_T: Scalar = number(2.0, "N m s/rad", **NON_NEGATIVE)
    free_length: Scalar = number(0.1365, "m", **POSITIVE)
    cylinder_mass: Scalar = number(1.0, "kg", **POSITIVE)
    cylinder_length: Scalar = number(0.1365, "m", **POSITIVE)
    max_stroke: Scalar | None = number(None, "m", **POSITIVE)
    stop_stiffness: Scalar | None = number(None, "N/m", **POSITIVE)
    stop_damping: Scalar = number(0.0, "N s/m", **NON_NEGATIVE)
    damping: str = choice("physical", "physical", "published")

    def check_together(self) -> None:
        if self.max_stroke is not None:
            check_entries("buffer.max_stroke", self.max_stroke, "m", 0.0, self.free_length, high_open=False)
        damping = concrete(self.stop_damping)
        if self.stop_stiffness is None and damping is not None and np.any(damping != 0.0):
            shown = f"buffer.stop_damping = {float(damping.flat[np.argmax(damping)]):g} N s/m"
            raise InputError(f"{shown} needs an end stop: give buffer.stop_stiffness [N/m] too")

    @property
    def end(self) -> Scalar:
        """The stroke at which the buffer, or its end stop if there is one, begins to be at its end [m]."""
        return self.free_length if self.max_stroke is None else self.max_stroke

    @property
    def longest_stroke(self) -> Scalar:
        """The stroke that ends a run as "bottomed" [m]: an end stop lets the spring's ends meet."""
        return self.end if self.stop_stiffness is None else self.free_length


class Probe(Part):
    """The rod and its ball tip, welded to the rod or (``free_tip``) spinning freely about its centre."""

    section: ClassVar[str] = "probe"
    length: Scalar = number(PROBE_LENGTH, "m", **POSITIVE)
    rod_mass: Scalar = number(ALUMINIUM_DENSITY * math.pi * ROD_RADIUS**2 * PROBE_LENGTH, "kg", **POSITIVE)
    tip_radius: Scalar = number(TIP_RADIUS, "m", **POSITIVE)
    tip_mass: Scalar = number(ALUMINIUM_DENSITY * 4.0 / 3.0 * math.pi * TIP_RADIUS**3, "kg", **POSITIVE)
    free_tip: bool = eqx.field(default=False, static=True, metadata={"flag": True})


class Cone(Part):
    """The cone on the passive vehicle. ``length`` is measured along the flank, ``offset`` from throat plane to T."""

    section: ClassVar[str] = "cone"
    half_angle: Scalar = number(math.pi / 4, "rad", low=0.0, high=math.pi / 2, low_open=True, high_open=True)
    offset: Scalar = number(0.096, "m", **NON_NEGATIVE)
    throat_radius: Scalar = number(0.015, "m", **POSITIVE)
    length: Scalar = number(0.0735, "m", **POSITIVE)


class Contact(Part):
    """Tip against flank: a normal law, regularised Coulomb friction.

    ``law``: one of `contact.laws.LAWS`; each takes those fields that it has. ``restitution`` is what is asked of the
    laws with hysteresis; kelvin-voigt takes ``linear_stiffness`` and ``damping``, adams ``stiffness`` [N/m^exponent],
    ``exponent``, ``damping`` and ``ramp_depth``. Their defaults are as stiff and as lossy as Table 2's law at the depth
    of its first impact. ``stiffness`` None means computed from ``young_modulus``, ``poisson_ratio`` (both sides) and
    the tip radius.
    ``yield_stress`` of the softer side, if given, lets the answer say where the materials yield.
    ``memory``: "event" holds the speed of the last touchdown, located as an event (the exact model); "smooth" lets it
    follow the approach speed within ``memory_time`` while out of contact, and rounds the onset over ``onset_length``.
    ``arms``: "moving" acts at the foot; "published" freezes the arms at first contact as the paper does (eq. 21).
    """

    section: ClassVar[str] = "contact"
    law: str = choice("lankarani-nikravesh", *LAWS)
    stiffness: Scalar | None = number(None, "N/m^1.5", **POSITIVE)
    restitution: Scalar = number(0.9, "-", low=0.0, high=1.0, low_open=True)
    friction: Scalar = number(0.33, "-", **NON_NEGATIVE)
    slip_speed: Scalar = number(1e-3, "m/s", **POSITIVE)
    young_modulus: Scalar = number(71.7e9, "Pa", **POSITIVE)
    poisson_ratio: Scalar = number(0.3, "-", low=-1.0, high=0.5, low_open=True)
    yield_stress: Scalar | None = number(None, "Pa", **POSITIVE)
    linear_stiffness: Scalar = number(1.5e7, "N/m", **POSITIVE)
    damping: Scalar = number(80.0, "N s/m", **NON_NEGATIVE)
    exponent: Scalar = number(1.5, "-", low=1.0)
    ramp_depth: Scalar = number(1e-6, "m", **POSITIVE)
    onset_length: Scalar = number(1e-8, "m", **POSITIVE)
    memory_time: Scalar = number(2e-4, "s", **POSITIVE)
    memory: str = choice("event", "event", "smooth")
    arms: str = choice("moving", "moving", "published")

    def check_together(self) -> None:
        exponent = concrete(self.exponent)
        if exponent is not None and np.any(exponent != HERTZ_EXPONENT):
            shown = f"contact.exponent = {float(exponent.flat[0]):g}"
            if self.law != "adams":
                raise InputError(f"{shown}: only contact.law = 'adams' has an exponent other than {HERTZ_EXPONENT}")
            if self.stiffness is None:
                raise InputError(f"{shown} needs contact.stiffness in N/m^exponent: Hertz's is in N/m^{HERTZ_EXPONENT}")
        if self.memory == "smooth" and LAWS[self.law].jumps:
            raise InputError(
                f"contact.law = {self.law!r}: its force jumps at touchdown; contact.memory must be 'event'"
            )


class Design(Part):
    """The whole mechanism; the defaults are the paper's Table 2 (assumed values are marked in the documentation)."""

    active: Active = Active()
    passive: Passive = Passive()
    buffer: Buffer = Buffer()
    probe: Probe = Probe()
    cone: Cone = Cone()
    contact: Contact = Contact()

    def check_together(self) -> None:
        # The tip must pass the mouth; what the throat lets through is an outcome, not an input error.
        cone = _known("cone", self.cone.throat_radius, self.cone.length, self.cone.half_angle)
        if cone is not None:
            throat, length, angle = cone
            check_entries("probe.tip_radius", self.probe.tip_radius, "m", 0.0, throat + length * np.sin(angle))

    @property
    def contact_stiffness(self) -> Scalar:
        """K [N/m^1.5], as given or by the paper's eq. 3-4."""
        if self.contact.stiffness is not None:
            return self.contact.stiffness
        modulus, ratio = self.contact.young_modulus, self.contact.poisson_ratio
        return hertz_stiffness(self.probe.tip_radius, modulus, ratio, modulus, ratio)


class Scenario(Part):
    """How the vehicles meet: the tip touches the lower flank at t = 0.

    **Arguments:** ``approach_speed`` v0 [m/s]; ``contact_distance`` b [m], slant distance of the first contact from the
    throat edge; ``misalignment`` θ_T0 [rad]; ``passive_rate`` θ̇_T0 [rad/s].
    """

    section: ClassVar[str] = "scenario"
    approach_speed: Scalar = number(0.1, "m/s", **POSITIVE)
    contact_distance: Scalar = number(0.0435, "m", **POSITIVE)
    misalignment: Scalar = number(0.0, "rad", low=-math.pi / 2, high=math.pi / 2, low_open=True, high_open=True)
    passive_rate: Scalar = number(0.0, "rad/s")


def check_fit(design: Design, scenario: Scenario) -> None:
    """Raise `InputError` where scenario and design don't fit: the first contact off the flank, the tip in the other
    flank at the start, or not facing the flank. Where numbers are arrays, each scenario meets its own design."""
    check_type("design", design, Design, "the design first, such as jb.table2(), then the scenario")
    check_type("scenario", scenario, Scenario, "the design first, then a scenario, such as jb.Scenario()")
    cone, tip = design.cone, design.probe.tip_radius
    start = _known("probe.tip_radius and cone", tip, cone.throat_radius, cone.half_angle)
    least = 0.0 if start is None else least_contact_distance(*start)
    too_low = "; nearer to the throat the tip would be in the other flank at the start"
    distance = scenario.contact_distance
    check_entries("scenario.contact_distance", distance, "m", least, cone.length, too_low=too_low, high_open=False)
    if (angle := _known("cone", cone.half_angle)) is not None:
        limit = np.minimum(angle[0], math.pi / 2 - angle[0])
        check_entries("scenario.misalignment", scenario.misalignment, "rad", -limit, limit)


def _known(path: str, *values: Scalar) -> list[Any] | None:
    """Numbers as they are, or as arrays of one shape if some are arrays; None if some are traced."""
    if all(type(value) is float for value in values):
        return list(values)
    arrays = [concrete(value) for value in values]
    return None if any(array is None for array in arrays) else same_shape(path, arrays)


def least_contact_distance(tip_radius: Any, throat_radius: Any, half_angle: Any, xp: Any = np) -> Any:
    """How far from the throat edge the tip must touch the lower flank so as not to reach into the upper one [m].

    The flanks are mirror images, rims included, and the tip's centre is its radius away from the lower one: it is
    farther from the upper one exactly where it is below the axis, R cos β - R_c - b sin β < 0.
    ``xp``: NumPy, or jax.numpy for traced numbers.
    """
    return xp.maximum((tip_radius * xp.cos(half_angle) - throat_radius) / xp.sin(half_angle), 0.0)


def table2() -> Design:
    """The mechanism of the paper's Table 2 and section 7, with the assumptions its text leaves open."""
    return Design()


def rigid_probe(design: Design | None = None) -> Design:
    """The paper's "traditional rigid probe" as a baseline: the buffer made stiff enough to act as a weld.

    1e10 N/m and 1e8 N m/rad: the first impact of Table 2 is then 1037.8 N, 0.4 % below its value for springs ten times
    stiffer (1042.0 N), while 1e8 N/m and 1e6 N m/rad, stiff as they look, still take a third of it (712.6 N). Damping
    of 1e5 N s/m and 1e3 N m s/rad keeps the stiff modes from ringing. The paper states no value ("high enough").
    """
    from .paths import replace

    stiff = {"buffer.k_A": 1e10, "buffer.c_A": 1e5, "buffer.k_T": 1e8, "buffer.c_T": 1e3}
    return replace(design if design is not None else table2(), stiff)
