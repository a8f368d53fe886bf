"""The probe-cone mechanism's design, made of its parts, and its scenario; whether they fit each other."""

import dataclasses
import math
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from typing import Any, ClassVar, TypeVar

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from ..._types import Scalar
from ...contact import hertz_stiffness
from ...errors import InputError, check_entries, check_type, concrete, inside, same_shape
from ...fields import NON_NEGATIVE, POSITIVE, Number, Part, all_of, choice, number
from ...suggestions import same_name, same_word
from ..run import DesignOf
from .approach import Approach, rotation_matrix
from .capture import Capture
from .contact import Contact
from .parts import (
    Active,
    Cone,
    Control,
    Hinge,
    Latches,
    LockoutFields,
    Passive,
    Probe,
    ProbeBuffer,
    RodFields,
    Shock,
    ThrustFields,
)

C = TypeVar("C", bound=Capture)


class DockingDesign(DesignOf[C]):
    """What designs of a probe in a cone share, in the plane and in space."""

    active: eqx.AbstractVar[Active]
    buffer: eqx.AbstractVar[ProbeBuffer]
    probe: eqx.AbstractVar[RodFields]
    cone: eqx.AbstractVar[Cone]
    contact: eqx.AbstractVar[Contact]

    def check_together(self) -> None:
        # The tip must pass the mouth; what the throat lets through is an outcome, not an input error.
        cone = _known("cone", self.cone.throat_radius, self.cone.length, self.cone.half_angle)
        if cone is not None:
            throat, length, angle = cone
            mouth, above = throat + length * np.sin(angle), "; the ball must pass the mouth of cone.throat_radius and"
            above += " cone.length"
            check_entries("probe.tip_radius", self.probe.tip_radius, "m", 0.0, mouth, too_high=above)

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        # The same as `check_together`, for traced numbers.
        mouth = self.cone.throat_radius + self.cone.length * jnp.sin(self.cone.half_angle)
        yield inside(self.probe.tip_radius, high=mouth, high_open=True, **POSITIVE)

    @property
    def contact_stiffness(self) -> Scalar:
        """Return K [N/m^1.5], as given or from the materials (M53)."""
        if self.contact.has("stiffness"):
            return self.contact.stiffness
        return hertz_stiffness(self.probe.tip_radius, *self.materials)

    @property
    def materials(self) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        """Return Young's modulus [Pa] and Poisson's ratio [-] of the tip, then those of the cone."""
        tip, cone = self.contact, self.cone
        modulus = cone.young_modulus if cone.has("young_modulus") else tip.young_modulus
        ratio = cone.poisson_ratio if cone.has("poisson_ratio") else tip.poisson_ratio
        return tip.young_modulus, tip.poisson_ratio, modulus, ratio


class Design(DockingDesign[Capture]):
    """The whole mechanism; the defaults are the paper's Table 2, and what it leaves open is assumed (docs/model.md).

    - ``active``, ``passive``: the vehicles.
    - ``hinge``: its play, if it has any.
    - ``buffer``: springs, dampers and cylinder.
    - ``probe``: rod and tip.
    - ``cone``: on the passive vehicle.
    - ``contact``: tip against flank.
    - ``latch``: what holds the vehicles together after capture, if anything does.
    - ``lockout``: what holds the buffer's stroke after capture, if anything does.
    - ``shock``: frequencies at which shocks on the vehicles are wanted, if any.
    - ``control``: attitude control of the active vehicle, if it has any.

    **Raises:** `InputError` where a number is out of its range, and for a tip that does not pass the cone's mouth.

    **Example:** `replace` changes any of its numbers.

    >>> design = jb.replace(jb.Design(), {"buffer.k_A": 800.0, "probe.free_tip": True})
    >>> design.buffer.k_A, design.probe.free_tip, design.contact.law
    (800.0, True, 'lankarani-nikravesh')
    """

    active: Active = Active()
    passive: Passive = Passive()
    buffer: ProbeBuffer = ProbeBuffer()
    probe: Probe = Probe()
    cone: Cone = Cone()
    contact: Contact = Contact()
    hinge: Hinge = Hinge()
    latch: Latches = Latches()
    lockout: LockoutFields = LockoutFields()
    shock: Shock = Shock()
    control: Control = Control()


same_name("offset", "lateral_offset", "miss", "eccentricity")
same_word("standoff", "gap")
OF_FREE_START = ("offset", "standoff", "active_angle", "active_rate", "lateral_speed")


NOT_FACING = "; the tip must face the flank of cone.half_angle"
TURNED_AWAY = "; the probe must point towards the cone"


class Meeting(Part):
    """What scenarios of a docking share, in the plane and in space: the start in contact or free.

    - ``of_free_start``: names of the fields that belong to a free start.
    - ``offsets``: names of the fields of the tip's offset from the cone's axis.
    """

    of_free_start: ClassVar[tuple[str, ...]]
    offsets: ClassVar[tuple[str, ...]]
    start: eqx.AbstractVar[str]
    standoff: eqx.AbstractVar[Number]

    @property
    @abstractmethod
    def approach(self) -> Approach:
        """Return the start in plain numbers."""

    @abstractmethod
    def towards(self, xp: Any = jnp) -> Any:
        """Return the cosine of the angle between the probe's axis and the cone's at t = 0 [-]: positive where the probe
        points towards the cone. ``xp``: NumPy, or jax.numpy for traced numbers."""

    @property
    def without_effect(self) -> tuple[str, ...]:
        """Return the names of the fields that belong to the other kind of start."""
        return ("contact_distance",) if self.start == "free" else self.of_free_start

    def check_together(self) -> None:
        free = self.start == "free"
        usual = {field.name: field for field in dataclasses.fields(self)}
        # A number of the other kind of start would have no effect.
        for name in self.without_effect:
            value, default = concrete(getattr(self, name)), usual[name].default
            if value is not None and np.any(value != default):
                symbol = usual[name].metadata["unit"]
                raise InputError(
                    f"scenario.{name} = {float(value[value != default].flat[0]):g} {symbol} belongs to"
                    f' scenario.start = "{"contact" if free else "free"}"; here it is "{self.start}"'
                )

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.start != "free":
            # A traced number of a free start is refused as `check_together` refuses one that is known.
            for name in self.of_free_start:
                yield inside(getattr(self, name), low=0.0, high=0.0)


class MeetingFields(Meeting):
    """How the vehicles meet: the fields of `Scenario` but those of its parts."""

    approach_speed: Number = number(
        0.1, "m/s", **POSITIVE, doc="speed v0 of the active vehicle towards the passive one"
    )
    contact_distance: Number = number(
        0.0435, "m", **POSITIVE, doc="b, slant distance of the first contact from the throat's edge"
    )
    misalignment: Number = number(
        0.0,
        "rad",
        low=-math.pi / 2,
        high=math.pi / 2,
        low_open=True,
        high_open=True,
        doc="angle θ_T0 of the passive vehicle at the start",
    )
    passive_rate: Number = number(0.0, "rad/s", doc="rate θ̇_T0 of the passive vehicle's turning at the start")
    start: str = choice(
        "contact",
        "contact",
        "free",
        doc="contact: the tip touches the lower flank at the start; free: it is anywhere before the cone",
    )
    offset: Number = number(0.0, "m", doc="y of the tip from the cone's axis at a free start, below it negative")
    standoff: Number = number(0.0, "m", **NON_NEGATIVE, doc="distance of the tip from the cone's mouth at a free start")
    active_angle: Number = number(
        0.0,
        "rad",
        low=-math.pi / 2,
        high=math.pi / 2,
        low_open=True,
        high_open=True,
        doc="angle θ_S0 of the active vehicle at a free start",
    )
    active_rate: Number = number(0.0, "rad/s", doc="rate of the active vehicle's turning at a free start")
    lateral_speed: Number = number(0.0, "m/s", doc="speed of the active vehicle across its approach at a free start")

    of_free_start: ClassVar[tuple[str, ...]] = OF_FREE_START
    offsets: ClassVar[tuple[str, ...]] = ("offset",)

    @property
    def approach(self) -> Approach:
        """Return the start in plain numbers."""
        return Approach(
            speeds=np.array([float(self.approach_speed), float(self.lateral_speed), 0.0]),
            offset=(float(self.offset), 0.0),
            active=rotation_matrix(self.active_angle),
            passive=rotation_matrix(self.misalignment),
            active_spin=np.array([0.0, 0.0, float(self.active_rate)]),
            passive_spin=np.array([0.0, 0.0, float(self.passive_rate)]),
        )

    def towards(self, xp: Any = jnp) -> Any:
        return xp.cos(self.misalignment - self.active_angle)


class Scenario(ThrustFields, MeetingFields):
    """How the vehicles meet: the tip touches the lower flank at t = 0 (M62, M63), or is anywhere before the cone.

    - ``approach_speed``: v0 of S, B and P [m/s].
    - ``contact_distance``: b, slant distance of the first contact from the throat edge [m].
    - ``misalignment``: θ_T0, angle of T [rad].
    - ``passive_rate``: θ̇_T0, spin of T [rad/s].
    - ``start``: "contact", or "free": nothing touches at t = 0 (M170). The following five belong to that.
    - ``offset``: y of the tip from the cone's axis [m], below it negative.
    - ``standoff``: distance of the tip from the cone's mouth along the axis [m].
    - ``active_angle`` θ_S0 [rad], ``active_rate`` [rad/s]: of S, B and P, turned and turning as one body.
    - ``lateral_speed``: of the active vehicle across its approach [m/s].
    - ``thrust`` [N], ``thrust_time`` [s]: a force that pushes the active vehicle along its axis from t = 0 on.

    **Raises:** `InputError` where a number is out of its range.

    **Example:**

    >>> capture = jb.simulate(jb.table2(), jb.Scenario(approach_speed=0.2))
    >>> f"{float(capture.peak_force):.2f} N"
    '325.18 N'
    """

    section: ClassVar[str] = "scenario"


def check_fit(design: Design, scenario: Scenario) -> None:
    """Check that scenario and design fit (M64). Where numbers are arrays, each scenario meets its own design.

    **Raises:** `InputError` for a first contact off the flank, a tip in the other flank at the start, a tip that does
    not face the flank, and published arms (M34) at a free start.
    """
    check_type("design", design, Design, "the design first, such as jb.table2(), then the scenario")
    check_type("scenario", scenario, Scenario, "the design first, then a scenario, such as jb.Scenario()")
    # A free start touches nothing, so that M64 has nothing to rule out.
    if scenario.start == "free":
        check_towards(scenario, ("misalignment", "active_angle"))
        if design.contact.arms == "published":
            raise InputError(
                'contact.arms = "published" holds the arm where the first contact is, scenario.contact_distance, which'
                ' scenario.start = "free" has not; use contact.arms = "moving", or scenario.start = "contact"'
            )
        return
    check_contact_distance(design, scenario.contact_distance)
    cone = design.cone
    if (angle := _known("cone", cone.half_angle)) is not None:
        limit = facing_limit(angle[0], np)
        angles = scenario.misalignment
        check_entries("scenario.misalignment", angles, "rad", -limit, limit, too_low=NOT_FACING, too_high=NOT_FACING)


def check_towards(scenario: Meeting, angles: Sequence[str], least: Any = 0.0, why: str = TURNED_AWAY) -> None:
    """Check that the probe points towards the cone, by numbers that are known.

    **Arguments:** ``angles``: names of the scenario's angles between them; ``least``: cosine of the angle that is just
    too large; ``why``: ends the message. **Raises:** `InputError`.
    """
    known = [concrete(getattr(scenario, name)) for name in angles]
    if any(angle is None for angle in known):
        return
    cosine = scenario.towards(np)
    if np.any(beyond := ~(cosine > least)):
        first = [float(np.broadcast_to(it, np.shape(beyond))[beyond].flat[0]) for it in (cosine, least, *known)]
        turned, limit = np.arccos(np.clip(first[:2], -1.0, 1.0))
        of = " and ".join(f"scenario.{name} = {it:g} rad" for name, it in zip(angles, first[2:], strict=True))
        raise InputError(
            f"{of} turn the probe by {turned:g} rad from the cone's axis; allowed: [0, {limit:g}) rad{why}"
        )


def check_contact_distance(design: DockingDesign[Any], distance: Scalar) -> None:
    """Check that a first contact lies on the flank, and that the tip is not in the other one (M64). **Raises:**
    `InputError`."""
    cone, tip = design.cone, design.probe.tip_radius
    start = _known("probe.tip_radius and cone", tip, cone.throat_radius, cone.half_angle)
    # Traced numbers are checked by `valid`, in the program.
    least = 0.0 if start is None else least_contact_distance(*start)
    too_low = "; nearer to the throat the tip would be in the other flank at the start"
    sides = {"too_low": too_low, "too_high": "; the flank ends at cone.length"}
    check_entries("scenario.contact_distance", distance, "m", least, cone.length, **sides, high_open=False)


def facing_limit(half_angle: Any, xp: Any = jnp) -> Any:
    """Return how far the cone's axis may be turned away from the probe's for the tip to face the flank [rad] (M64)."""
    return xp.minimum(half_angle, math.pi / 2 - half_angle)


def valid(design: Design, scenario: Scenario) -> Bool[Array, ""]:
    """Return whether every number is in its range and they fit (M64), for numbers known only inside compiled code; NaN
    is in no range."""
    ranges = [*design.in_range(), *scenario.in_range()]
    if scenario.start == "free":
        return all_of([*ranges, scenario.towards() > 0.0])
    limit = facing_limit(design.cone.half_angle)
    fit = [
        distance_fits(design, scenario.contact_distance),
        inside(scenario.misalignment, low=-limit, high=limit, low_open=True, high_open=True),
    ]
    return all_of([*ranges, *fit])


def distance_fits(design: DockingDesign[Any], distance: Scalar) -> Bool[Array, ""]:
    """Return the same as `check_contact_distance` checks, for traced numbers."""
    cone = design.cone
    least = least_contact_distance(design.probe.tip_radius, cone.throat_radius, cone.half_angle, jnp)
    return inside(distance, low=least, high=cone.length, low_open=True)


def _known(path: str, *values: Scalar) -> list[Any] | None:
    """Return numbers as they are, or as arrays of one shape if some are arrays; None if some are traced."""
    if all(type(value) is float for value in values):
        return list(values)
    arrays = [concrete(value) for value in values]
    return None if any(array is None for array in arrays) else same_shape(path, arrays)


def least_contact_distance(tip_radius: Any, throat_radius: Any, half_angle: Any, xp: Any = np) -> Any:
    """Return how far from the throat edge the tip must touch the lower flank so as not to reach into the upper one [m]
    (M64).

    The flanks are mirror images, rims included, and the tip's centre is its radius away from the lower one: it is
    farther from the upper one exactly where it is below the axis, R cos β - R_c - b sin β < 0.

    **Arguments:** ``tip_radius`` R, ``throat_radius`` R_c [m]; ``half_angle`` β [rad]; ``xp``: NumPy, or jax.numpy for
    traced numbers.
    """
    return xp.maximum((tip_radius * xp.cos(half_angle) - throat_radius) / xp.sin(half_angle), 0.0)


def table2() -> Design:
    """Return the mechanism of the paper's Table 2 and section 7, with the assumptions its text leaves open.

    **Example:**

    >>> design = jb.table2()
    >>> print(f"{design.buffer.k_A:g} N/m, {design.buffer.c_A:g} N s/m, tip {1e3 * design.probe.tip_mass:.2f} g")
    500 N/m, 5 N s/m, tip 38.74 g
    """
    return Design()


def rigid_probe(design: Design | None = None) -> Design:
    """Return the paper's "traditional rigid probe" as a baseline: the buffer made stiff enough to act as a weld.

    1e10 N/m and 1e8 N m/rad: the first impact of Table 2 is then 1037.8 N, 0.4 % below its value for springs ten times
    stiffer (1042.0 N), while 1e8 N/m and 1e6 N m/rad, stiff as they look, still take a third of it (712.6 N). Damping
    of 1e5 N s/m and 1e3 N m s/rad keeps the stiff modes from ringing. The paper states no value ("high enough").

    **Arguments:**

    - ``design`` (default: Table 2's): whose other numbers are kept.

    **Example:**

    >>> run = jb.simulate(jb.rigid_probe(), jb.Scenario())
    >>> f"first impact {float(run.quantity('impact.1.peak_force')):.1f} N"
    'first impact 1037.8 N'
    """
    from ...fields import replace

    stiff = {"buffer.k_A": 1e10, "buffer.c_A": 1e5, "buffer.k_T": 1e8, "buffer.c_T": 1e3}
    return replace(design if design is not None else table2(), stiff)
