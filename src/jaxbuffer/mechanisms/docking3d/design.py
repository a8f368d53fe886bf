"""The docking in space: its design, made of the plane's parts and roll inertias, and its scenario."""

import math
from collections.abc import Iterator
from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from ..._types import Scalar
from ...errors import InputError, check_entries, check_type, concrete, inside
from ...fields import POSITIVE, Number, all_of, choice, like, number
from ...space import Quaternion, Vector
from ..probe_cone.approach import Approach, rotation_matrix
from ..probe_cone.contact import Contact
from ..probe_cone.design import (
    NOT_FACING,
    DockingDesign,
    Meeting,
    Scenario,
    check_contact_distance,
    check_towards,
    distance_fits,
    facing_limit,
)
from ..probe_cone.parts import (
    ROD_RADIUS,
    Active,
    Cone,
    Control,
    Latches,
    Passive,
    ProbeBuffer,
    RodFields,
    Shock,
    ThrustFields,
)
from .capture import Capture3D

MOST_ROLL = 2.0  # of the transverse inertia: that of a flat disc; no body has more


class Active3D(Active):
    """The active vehicle S, axisymmetric about its x axis."""

    inertia: Number = number(0.445, "kg m²", **POSITIVE, doc="inertia I_S about y and z through its centre of mass")
    roll_inertia: Number = number(0.2, "kg m²", **POSITIVE, doc="inertia I_x about the vehicle's axis; assumed")

    def check_together(self) -> None:
        _check_roll("active", self.roll_inertia, self.inertia)

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        yield inside(self.roll_inertia, high=MOST_ROLL * self.inertia, **POSITIVE)


class Passive3D(Passive):
    """The passive vehicle T, axisymmetric about its x axis."""

    inertia: Number = number(0.5206, "kg m²", **POSITIVE, doc="inertia I_T about y and z through its centre of mass")
    roll_inertia: Number = number(0.25, "kg m²", **POSITIVE, doc="inertia I_x about the vehicle's axis; assumed")

    def check_together(self) -> None:
        _check_roll("passive", self.roll_inertia, self.inertia)

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        yield inside(self.roll_inertia, high=MOST_ROLL * self.inertia, **POSITIVE)


def _check_roll(section: str, roll: Scalar, inertia: Scalar) -> None:
    """Raise `InputError` for a roll inertia that no body can have."""
    above = f"; no body has more than twice its {section}.inertia about another axis"
    check_entries(f"{section}.roll_inertia", roll, "kg m²", 0.0, MOST_ROLL * inertia, too_high=above, high_open=False)


class Probe3D(RodFields):
    """The rod and its ball tip."""

    section: ClassVar[str] = "probe"

    rod_radius: Number = number(
        ROD_RADIUS, "m", **POSITIVE, doc="radius r_p of the rod, on which its inertia about its axis depends"
    )


class Design3D(DockingDesign[Capture3D]):
    """The docking in space: every planar design with roll inertias; the defaults are the paper's Table 2.

    - ``active``, ``passive``: the vehicles, with ``roll_inertia``.
    - ``buffer``, ``probe``, ``cone``, ``contact``, ``latch``, ``shock``, ``control``: as of `Design`; the rod does not
      bend, and the hinge, a universal joint, has no play.

    **Raises:** `InputError` where a number is out of its range, for a tip that does not pass the cone's mouth, and for
    a roll inertia above twice the other one, which no body has.

    **Example:**

    >>> design = jb.replace(jb.docking3d(), {"active.roll_inertia": 0.3})
    >>> design.active.roll_inertia, design.buffer.k_A
    (0.3, 500.0)
    """

    active: Active3D = Active3D()
    passive: Passive3D = Passive3D()
    buffer: ProbeBuffer = ProbeBuffer()
    probe: Probe3D = Probe3D()
    cone: Cone = Cone()
    contact: Contact = Contact()
    latch: Latches = Latches()
    shock: Shock = Shock()
    control: Control = Control()

    def check_together(self) -> None:
        super().check_together()
        if self.contact.arms == "published":
            raise InputError(
                'contact.arms = "published" is of the plane: it freezes an arm in one of two flanks; use "moving"'
            )


def _angle(doc: str) -> Any:
    """Declare an angle of less than a quarter of a turn."""
    half = math.pi / 2
    return number(0.0, "rad", low=-half, high=half, low_open=True, high_open=True, doc=doc)


AT_FREE_START = "at a free start"
PASSIVE_ANGLES, ACTIVE_ANGLES = ("passive_yaw", "passive_pitch"), ("active_yaw", "active_pitch")


class Approach3D(Meeting):
    """The fields of `Scenario3D` but those of its parts."""

    approach_speed: Number = like(Scenario, "approach_speed")
    contact_distance: Number = like(Scenario, "contact_distance")
    azimuth: Number = number(0.0, "rad", doc="ψ, where about the cone's axis the tip first touches")
    passive_yaw: Number = _angle("yaw of the passive vehicle at the start")
    passive_pitch: Number = _angle("pitch of the passive vehicle at the start")
    passive_rate_x: Number = number(0.0, "rad/s", doc="roll rate of the passive vehicle at the start")
    passive_rate_y: Number = number(0.0, "rad/s", doc="pitch rate of the passive vehicle at the start")
    passive_rate_z: Number = number(0.0, "rad/s", doc="yaw rate of the passive vehicle at the start")
    active_rate_x: Number = number(0.0, "rad/s", doc="roll rate of the active vehicle at the start")
    start: str = choice(
        "contact",
        "contact",
        "free",
        doc="contact: the tip touches the cone at the start, at the azimuth; free: it is anywhere before the cone",
    )
    offset_y: Number = number(0.0, "m", doc=f"y of the tip from the cone's axis {AT_FREE_START}")
    offset_z: Number = number(0.0, "m", doc=f"z of the tip from the cone's axis {AT_FREE_START}")
    standoff: Number = like(Scenario, "standoff")
    active_yaw: Number = _angle(f"yaw of the active vehicle {AT_FREE_START}")
    active_pitch: Number = _angle(f"pitch of the active vehicle {AT_FREE_START}")
    active_rate_y: Number = number(0.0, "rad/s", doc=f"pitch rate of the active vehicle {AT_FREE_START}")
    active_rate_z: Number = number(0.0, "rad/s", doc=f"yaw rate of the active vehicle {AT_FREE_START}")
    lateral_speed_y: Number = number(0.0, "m/s", doc=f"speed of the active vehicle along y {AT_FREE_START}")
    lateral_speed_z: Number = number(0.0, "m/s", doc=f"speed of the active vehicle along z {AT_FREE_START}")

    of_free_start: ClassVar[tuple[str, ...]] = (
        *("offset_y", "offset_z", "standoff", "active_yaw", "active_pitch", "active_rate_y", "active_rate_z"),
        *("lateral_speed_y", "lateral_speed_z"),
    )
    offsets: ClassVar[tuple[str, ...]] = ("offset_y", "offset_z")

    @property
    def approach(self) -> Approach:
        """Return the start in plain numbers."""
        lateral = float(self.lateral_speed_y), float(self.lateral_speed_z)
        return Approach(
            speeds=np.array([float(self.approach_speed), *lateral]),
            offset=(float(self.offset_y), float(self.offset_z)),
            active=rotation_matrix(self.active_yaw, self.active_pitch),
            passive=rotation_matrix(self.passive_yaw, self.passive_pitch),
            active_spin=np.array([float(rate) for rate in self.active_spin]),
            passive_spin=np.array([float(rate) for rate in self.passive_spin]),
        )

    def towards(self, xp: Any = jnp) -> Any:
        # Of either axis: (cos yaw cos pitch, sin yaw cos pitch, -sin pitch).
        between = xp.cos(self.passive_yaw - self.active_yaw)
        level = xp.cos(self.passive_pitch) * xp.cos(self.active_pitch) * between
        return level + xp.sin(self.passive_pitch) * xp.sin(self.active_pitch)

    @property
    def without_effect(self) -> tuple[str, ...]:
        """Return the names of the fields that belong to the other kind of start."""
        return ("contact_distance", "azimuth") if self.start == "free" else self.of_free_start

    @property
    def active_rotation(self) -> Quaternion:
        """Return the rotation of S, B and P at t = 0."""
        return rotation(self.active_yaw, self.active_pitch)

    @property
    def passive_rotation(self) -> Quaternion:
        """Return the rotation of T at t = 0."""
        return rotation(self.passive_yaw, self.passive_pitch)

    @property
    def active_spin(self) -> Vector:
        """Return the angular velocity of S, B and P at t = 0 [rad/s]."""
        return Vector(self.active_rate_x, self.active_rate_y, self.active_rate_z)

    @property
    def passive_spin(self) -> Vector:
        """Return the angular velocity of T at t = 0 [rad/s]."""
        return Vector(self.passive_rate_x, self.passive_rate_y, self.passive_rate_z)


class Scenario3D(ThrustFields, Approach3D):
    """How the vehicles meet in space: the tip touches the cone at t = 0, or is anywhere before it.

    Yaw turns about the inertial z, then pitch about the turned y; roll angles do not matter but through the hinge's
    axes. In the plane z = 0 ``passive_yaw`` is `Scenario`'s misalignment, ``active_yaw`` its active_angle, ``offset_y``
    its offset, and so on.

    - ``approach_speed``, ``contact_distance``, ``start``, ``standoff``, ``thrust``, ``thrust_time``: as of `Scenario`.
    - ``azimuth``: ψ, where about the axis the tip first touches, from the planar lower flank [rad].
    - ``passive_yaw``, ``passive_pitch`` [rad]; ``passive_rate_x``, ``_y``, ``_z``: of T, in inertial axes [rad/s].
    - ``active_rate_x``: roll rate of S with all that it carries [rad/s]. What follows belongs to a free start.
    - ``offset_y``, ``offset_z``: of the tip from the cone's axis [m].
    - ``active_yaw``, ``active_pitch`` [rad]; ``active_rate_y``, ``active_rate_z`` [rad/s]: of S, B and P, turned and
      turning as one body.
    - ``lateral_speed_y``, ``lateral_speed_z``: of the active vehicle across its approach [m/s].

    **Raises:** `InputError` where a number is out of its range.

    **Example:**

    >>> scenario = jb.Scenario3D(azimuth="40 deg", passive_pitch=0.03)
    >>> f"{scenario.azimuth:.4f} rad"
    '0.6981 rad'
    """

    section: ClassVar[str] = "scenario"


def rotation(yaw: Scalar, pitch: Scalar) -> Quaternion:
    """Return the rotation by a pitch about y, and after it a yaw about z [rad]."""
    zero = jnp.zeros(())
    about_z = Quaternion.of_rotation_vector(Vector(zero, zero, yaw))
    return about_z.after(Quaternion.of_rotation_vector(Vector(zero, pitch, zero)))


def check_fit(design: Design3D, scenario: Scenario3D) -> None:
    """Check that scenario and design fit (M64).

    **Raises:** `InputError` for a first contact off the cone, a tip that does not face it, and of a free start a probe
    that points away from it.
    """
    check_type("design", design, Design3D, "the design first, such as jb.docking3d(), then the scenario")
    check_type("scenario", scenario, Scenario3D, "the design first, then a scenario, such as jb.Scenario3D()")
    if scenario.start == "free":
        check_towards(scenario, (*PASSIVE_ANGLES, *ACTIVE_ANGLES))
        return
    check_contact_distance(design, scenario.contact_distance)
    if (half_angle := concrete(design.cone.half_angle)) is not None:
        check_towards(scenario, PASSIVE_ANGLES, np.cos(facing_limit(half_angle, np)), NOT_FACING)


def valid(design: Design3D, scenario: Scenario3D) -> Bool[Array, ""]:
    """Return whether every number is in its range and they fit (M64), for numbers known only inside compiled code."""
    ranges = [*design.in_range(), *scenario.in_range()]
    if scenario.start == "free":
        return all_of([*ranges, scenario.towards() > 0.0])
    # The angle between the axes compares as its cosine does, which has a slope everywhere.
    fit = [
        distance_fits(design, scenario.contact_distance),
        scenario.towards() > jnp.cos(facing_limit(design.cone.half_angle)),
    ]
    return all_of([*ranges, *fit])


def docking3d() -> Design3D:
    """Return the mechanism of the paper's Table 2 in space, with roll inertias that its text leaves open.

    **Example:**

    >>> design = jb.docking3d()
    >>> print(f"{design.active.roll_inertia:g} and {design.passive.roll_inertia:g} kg m²")
    0.2 and 0.25 kg m²
    """
    return Design3D()
