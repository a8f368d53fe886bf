"""A docking for two vehicles to begin with: cone, probe, buffer and latch scaled from their masses, speeds and misses.

Two dockings are similar where lengths go with λ, masses with μ, the reduced mass, and times with λ over the speed: then
stiffnesses go with μ v²/λ², dampings with μ v/λ, and those of turning with μ v² and μ v λ. What is scaled is a docking
of two vehicles of 20 kg at 8 to 15 cm/s that is held. The materials, and with them the contact, are not scaled.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from ...errors import InputError
from ...fields import NON_NEGATIVE, POSITIVE, Number, Part, number
from ..sizing import ScaledNumber, ScaledStudy
from .sized.rules import REBOUND, REBOUND_DAMPING, closing_time, turn_stiffness

# The docking that is scaled: reduced mass [kg], slowest and fastest approach [m/s].
MASS, SLOW, FAST = 10.0, 0.08, 0.15
# Table 2's vehicles, whose arms and radii of gyration go with the cube root of the mass: kg, then m.
ACTIVE, ACTIVE_GYRATION, HINGE = 22.0, 0.142, 0.1365
PASSIVE, PASSIVE_GYRATION, CONE_OFFSET = 23.6, 0.149, 0.096
MISS = 0.03  # m: at λ = 1 what the cone is made for, a bit less than half its mouth's radius
PUT_IN = 0.05  # share of the slowest approach's energy that the latch's turning may put in
CAPTURE_ARM = 0.3  # m at λ = 1, from the hinge to the tip: what an angle of the vehicle moves it by
DURATION = 20.0  # s at λ = 1 and the slow approach
STROKE, TIP_RADIUS = 0.025, 0.015  # m at λ = 1
NONE: Mapping[str, str] = MappingProxyType({})


class VehiclesToDock(Part):
    """The vehicles, and how they meet."""

    active_mass: Number = number(20.0, "kg", **POSITIVE, doc="mass of the active vehicle, which carries the probe")
    passive_mass: Number = number(20.0, "kg", **POSITIVE, doc="mass of the passive vehicle, which carries the cone")
    slowest: Number = number(0.08, "m/s", **POSITIVE, doc="slowest approach")
    fastest: Number = number(0.15, "m/s", **POSITIVE, doc="fastest approach")
    miss: Number = number(0.01, "m", **NON_NEGATIVE, doc="largest distance of the tip from the cone's axis")
    attitude: Number = number(
        0.0, "rad", low=0.0, high=math.pi / 6.0, doc="largest angle of the active vehicle from the cone's axis"
    )

    def check_together(self) -> None:
        if float(self.slowest) > float(self.fastest):
            raise InputError(
                f"slowest = {float(self.slowest):g} m/s is above fastest = {float(self.fastest):g} m/s; give the slow"
                " speed first"
            )


class Scale(NamedTuple):
    """How much larger than the docking that is scaled another one is.

    ``mass``: its reduced mass [-]; ``length`` λ [-]; ``slow``, ``fast``: its slowest and fastest approach [-].
    """

    mass: float
    length: float
    slow: float
    fast: float


def scale_of(task: VehiclesToDock) -> Scale:
    """Return the scale of a docking: lengths that fit its misses, and grow with its masses."""
    reduced = task.active_mass * task.passive_mass / (task.active_mass + task.passive_mass)
    by_mass = (reduced / MASS) ** 0.25
    arm = HINGE * (task.active_mass / ACTIVE) ** (1.0 / 3.0) + CAPTURE_ARM * by_mass
    by_miss = (task.miss + arm * math.sin(task.attitude)) / MISS
    return Scale(reduced / MASS, max(by_mass, by_miss), task.slowest / SLOW, task.fastest / FAST)


def scaled_study(task: VehiclesToDock) -> ScaledStudy:
    """Return a study of a docking until held, scaled from its vehicles."""
    scenario: dict[str, Any] = {}
    if task.miss > 0.0:
        scenario["offset"] = float(task.miss)
    if task.attitude > 0.0:
        scenario["active_angle"] = float(task.attitude)
    # By symmetry one sign of the angle is enough with both sides of the axis.
    return study_of(task, scale_of(task), scenario, "offset")


def study_of(
    task: VehiclesToDock,
    scale: Scale,
    start: Mapping[str, Any],
    mirrored: str,
    rules: Mapping[str, str] = NONE,
    others: Iterable[ScaledNumber] = (),
) -> ScaledStudy:
    """Return the study of some vehicles.

    **Arguments:** ``task``; ``scale``; ``start``: fields of the free start beside its speed; ``mirrored``: which of
    them load cases have with either sign; ``rules`` of these fields, in words; ``others``: numbers of the design that
    the plane's has not.
    """
    stroke, duration = STROKE * scale.length, DURATION * scale.length / scale.slow
    grid = {"approach_speed": [float(task.slowest), float(task.fastest)]}
    if mirrored in start:
        grid[mirrored] = [-start[mirrored], start[mirrored]]
    return ScaledStudy(
        numbers=(*_numbers(task, scale), *others),
        scenario={"start": "free", "approach_speed": float(task.fastest), **start},
        rules=rules,
        grid={name: values for name, values in grid.items() if len(set(values)) > 1},
        duration=duration,
        objective="peak_force",
        limits={"stroke": (stroke, f"{1e3 * STROKE:g} mm × λ"), "held": (True, "every scenario, within the duration")},
        remark=f"λ = {scale.length:.3g} in lengths, reduced mass {scale.mass * MASS:.4g} kg; a docking of 20 kg is 1",
    )


def _numbers(task: VehiclesToDock, scale: Scale) -> Iterator[ScaledNumber]:
    """Yield each number of the design with its rule and the range in which it usually is."""
    yield from vehicles(task)
    for path, value, (low, high), rule in (
        ("cone.length", 0.0735, (0.7, 2.0), "with λ, which fits the misses"),
        ("cone.throat_radius", 0.0165, (1.0, 1.3), "a tenth more than the tip's radius"),
        ("probe.length", 0.2, (0.7, 2.0), "with λ"),
        ("probe.tip_radius", TIP_RADIUS, (0.7, 1.0), "with λ; it must pass the throat"),
        ("buffer.free_length", 0.1365, (0.7, 2.0), "with λ"),
        ("buffer.cylinder_length", 0.1365, (0.7, 2.0), "with λ"),
    ):
        yield ScaledNumber(path, value * scale.length, (low, high), rule)
    for path, value, (low, high), tuned in (
        ("probe.rod_mass", 0.139, (0.5, 2.0), False),
        ("probe.tip_mass", 0.0387, (0.5, 2.5), True),
        ("buffer.cylinder_mass", 1.0, (0.5, 2.0), False),
    ):
        yield ScaledNumber(path, value * scale.length**2.5, (low, high), "with λ^2.5", tuned)
    yield from _buffer(scale)
    yield from _latch(task, scale)


def vehicles(task: VehiclesToDock) -> Iterator[ScaledNumber]:
    """Yield the numbers of the vehicles."""
    given, own = (1.0, 1.0), "take your own; here with the mass to the power"
    active, passive = float(task.active_mass), float(task.passive_mass)
    large, wide = (active / ACTIVE) ** (1.0 / 3.0), (passive / PASSIVE) ** (1.0 / 3.0)
    yield ScaledNumber("active.mass", active, given, "as given")
    yield ScaledNumber("active.inertia", active * (ACTIVE_GYRATION * large) ** 2, (0.5, 3.0), f"{own} 5/3")
    yield ScaledNumber("active.hinge_offset", HINGE * large, (0.5, 3.0), f"{own} 1/3")
    yield ScaledNumber("passive.mass", passive, given, "as given")
    yield ScaledNumber("passive.inertia", passive * (PASSIVE_GYRATION * wide) ** 2, (0.5, 3.0), f"{own} 5/3")
    yield ScaledNumber("cone.offset", CONE_OFFSET * wide, (0.5, 3.0), f"{own} 1/3")


def _buffer(scale: Scale) -> Iterator[ScaledNumber]:
    mass, length, speed = scale.mass, scale.length, scale.fast
    stiffness, damping = 150.0 * mass * (speed / length) ** 2, 20.0 * mass * speed / length
    yield ScaledNumber(
        "buffer.k_A", stiffness, (0.3, 10.0), "μ v²/λ²; the fast approach takes about half the stroke", True
    )
    yield ScaledNumber("buffer.c_A", damping, (0.1, 5.0), "μ v/λ, a quarter of the critical damping", True)
    yield ScaledNumber("buffer.k_T", 150.0 * mass * speed**2, (0.2, 5.0), "μ v²", True)
    yield ScaledNumber("buffer.c_T", 6.0 * mass * speed * length, (0.1, 5.0), "μ v λ", True)
    yield ScaledNumber(
        "buffer.rebound_stiffness", REBOUND * stiffness, (0.5, 5.0), "20 k_A: the spring does not pull after capture"
    )
    yield ScaledNumber("buffer.rebound_damping", REBOUND_DAMPING * damping, (0.5, 5.0), "2 c_A")


def _latch(task: VehiclesToDock, scale: Scale) -> Iterator[ScaledNumber]:
    mass, length, speed = scale.mass, scale.length, scale.slow
    stiffness = 80.0 * mass * (speed / length) ** 2
    # ½ k φ² is what a latch that closes at once puts in.
    turning, rule = turn_stiffness(mass * MASS, float(task.slowest), float(task.attitude), PUT_IN)
    # Not less where a large angle allows a soft spring only: the swing on it has to end too.
    turn_damping = 4.0 * mass * speed * length
    yield ScaledNumber("latch.stiffness", stiffness, (0.3, 5.0), "μ v²/λ² of the slow approach", True)
    damping = 0.9 * math.sqrt(stiffness * mass * MASS)
    yield ScaledNumber("latch.damping", damping, (0.3, 3.0), "0.9 √(k μ), nearly half the critical damping", True)
    yield ScaledNumber("latch.turn_stiffness", turning, (0.2, 5.0), rule, True)
    yield ScaledNumber("latch.turn_damping", turn_damping, (0.2, 2.0), "μ v λ of the slow approach", True)
    closing = closing_time(TIP_RADIUS * length, float(task.slowest))
    yield ScaledNumber("latch.closing_time", closing, (0.3, 3.0), "the slow tip goes on by half its radius meanwhile")
    strength = 10.0 * mass * scale.fast**2 / length
    yield ScaledNumber(
        "latch.strength", strength, (0.5, 5.0), "μ v²/λ of the fast approach, some five times what it bears here"
    )
