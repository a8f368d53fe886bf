"""The slider-crank with play in its pins: its design and its scenario."""

from typing import ClassVar

import numpy as np
from jaxtyping import Array, Bool

from ...errors import InputError, check_type, concrete, inside
from ...fields import NON_NEGATIVE, POSITIVE, Number, Part, absent, all_of, choice, chosen, mesh, number, on, whole
from ...multibody import Body
from ...multibody.flexible import Bar, FlexibleBar, free_bar
from ..run import DesignOf, Run
from . import shapes
from .pins import CrankPin, PistonPin
from .shapes import Places, PlanarBody, check_modes, length_in_mesh, rigid, shaped

RPM = 2.0 * np.pi / 60.0  # rad/s


class Crank(Part):
    """A crank on a shaft.

    ``length`` from the shaft to the crank pin; ``mass``; ``inertia`` about the shaft; ``unbalance``: mass times
    distance of its centre of mass from the shaft, positive towards the pin; a counterweight lowers it.
    """

    section: ClassVar[str] = "crank"
    length: Number = number(0.05, "m", **POSITIVE, doc="length from the shaft to the crank pin")
    mass: Number = number(0.1, "kg", **POSITIVE, doc="mass of the crank")
    inertia: Number = number(1e-4, "kg m²", **POSITIVE, doc="inertia about the shaft")
    unbalance: Number = number(
        0.0, "kg m", doc="mass times its centre's distance from the shaft, positive towards the pin"
    )


class CrankDrive(Part):
    """What turns the crank.

    ``kind``: "speed" (the crank turns steadily) or "torque", M_0 (1 - ω/ω_0) with ``torque`` M_0 and
    ``no_load_speed`` ω_0.
    """

    section: ClassVar[str] = "drive"
    kind: str = choice("speed", "speed", "torque", doc="speed: the crank turns steadily; torque: M_0 (1 - ω/ω_0)")
    torque: Number = number(
        50.0, "N m", **POSITIVE, needs=chosen("kind", "torque"), doc="torque M_0 at rest, of a drive of the kind torque"
    )
    no_load_speed: Number = number(
        5000.0 * RPM, "rad/s", **POSITIVE, needs=chosen("kind", "torque"), doc="speed ω_0 at which that torque is zero"
    )


class Rod(Part):
    """The connecting rod.

    ``length`` between its pins; ``mass``; ``inertia`` about its centre of mass, which lies at the share ``centre`` of
    the length from the crank pin. Or a uniform rectangular bar: ``depth`` of its section in the plane of motion (None:
    as above), ``width`` across it, ``density``. It bends in ``modes`` modes, none or at least 2, with ``young_modulus``
    and the ``damping_ratio`` of every mode. Or of any planar ``shape``: a mesh with the boundaries crank_pin and
    piston_pin, as large as makes its pins ``length`` apart and ``width`` thick, of 0 modes or at least 3.
    """

    section: ClassVar[str] = "rod"
    length: Number = number(0.12, "m", **POSITIVE, doc="length between its pins")
    mass: Number = number(0.21, "kg", **POSITIVE, needs=absent("depth", "shape"), doc="mass of the rod")
    inertia: Number = number(
        2.5e-4, "kg m²", **POSITIVE, needs=absent("depth", "shape"), doc="inertia about its centre of mass"
    )
    centre: Number = number(
        0.5,
        "-",
        low=0.0,
        high=1.0,
        needs=absent("depth", "shape"),
        doc="place of its centre of mass, a share of the length from the crank pin",
    )
    depth: Number = number(
        None,
        "m",
        **POSITIVE,
        doc="depth of a uniform bar's section in the plane of motion; not set: mass and inertia hold",
    )
    shape: str | None = mesh(*shapes.ROD, doc="mesh of its planar shape instead of that bar, in any unit of length")
    width: Number = number(
        0.015, "m", **POSITIVE, needs=on("depth", "shape"), doc="width of bar or shape across the plane"
    )
    density: Number = number(7850.0, "kg/m³", **POSITIVE, needs=on("depth", "shape"), doc="density of bar or shape")
    young_modulus: Number = number(
        207e9, "Pa", **POSITIVE, needs=on("modes"), doc="Young's modulus of bar or shape, for its bending"
    )
    damping_ratio: Number = number(
        0.01, "-", low=0.0, high=1.0, needs=on("modes"), doc="damping ratio of each of its modes"
    )
    modes: int = whole(0, 0, doc="how many modes bend it, none or at least 2, of a shape 3")

    def check_together(self) -> None:
        if self.shape is not None:
            if self.depth is not None:
                raise InputError("rod.depth and rod.shape: a uniform bar and a shape; keep one")
            return check_modes("rod", self.modes)
        if self.modes and self.depth is None:
            raise InputError(
                f"rod.modes = {self.modes}: a rod that bends needs its section; give rod.depth [m] or rod.shape too"
            )
        if self.modes == 1:
            raise InputError("rod.modes = 1: the rod's ends are kept, which takes 2 modes; give 0, or 2 or more")
        centre = concrete(self.centre)
        if self.depth is not None and centre is not None and np.any(centre != 0.5):
            raise InputError("rod.centre: the centre of mass of a uniform bar (rod.depth) is at 0.5 of its length")

    @property
    def bar(self) -> Bar:
        """Return the rod as a uniform bar."""
        assert self.depth is not None
        return Bar.rectangle(self.length, self.width, self.depth, self.density, self.young_modulus)

    @property
    def size(self) -> Number:
        """Return the unit of length of the rod's mesh [m]."""
        assert self.shape is not None
        return self.length / length_in_mesh(self.shape)

    @property
    def form(self) -> PlanarBody:
        """Return the rod as a planar shape."""
        return shaped(self, shapes.ROD, self.size)

    @property
    def bent(self) -> FlexibleBar | PlanarBody:
        """Return the rod in modes of a free bar or shape, whose axes keep its centre of mass and angular momentum."""
        if self.shape is not None:
            return self.form
        # Two of the modes are those of the ends; `free_bar` counts the modes beyond them.
        return free_bar(self.bar, self.modes - 2, damping_ratio=self.damping_ratio)

    @property
    def ends(self) -> Places:
        """Return the crank pin and the piston pin, from the undeformed rod's centre of mass [m]."""
        if self.shape is None:
            return (-self.centre * self.length, 0.0), ((1.0 - self.centre) * self.length, 0.0)
        return shapes.places(self, shapes.ROD, self.size)

    @property
    def body(self) -> Body:
        """Return the rod as a rigid body."""
        if self.shape is not None:
            return rigid(self, shapes.ROD, self.size)
        if self.depth is None:
            return Body(self.mass, self.inertia)
        return Body(self.bar.mass, self.bar.mass * self.length**2 / 12.0)


class Slider(Part):
    """The slider; it does not turn.

    ``mass``. Or of any planar ``shape``: a mesh with the boundaries guide, which slides and keeps its form, and
    piston_pin, in whose middle the pin sits; ``scale``: the mesh's unit of length; ``width`` across the plane,
    ``density``, ``young_modulus``. It bends in ``modes`` modes, none or at least 3, with the ``damping_ratio`` of every
    mode.
    """

    section: ClassVar[str] = "slider"
    mass: Number = number(0.14, "kg", **POSITIVE, needs=absent("shape"), doc="mass of the slider, which does not turn")
    shape: str | None = mesh(*shapes.SLIDER, doc="mesh of its planar shape, instead of that mass")
    scale: Number = number(1.0, "m", **POSITIVE, needs=on("shape"), doc="unit of length of that mesh")
    width: Number = number(0.04, "m", **POSITIVE, needs=on("shape"), doc="width of that shape across the plane")
    density: Number = number(2700.0, "kg/m³", **POSITIVE, needs=on("shape"), doc="density of that shape")
    young_modulus: Number = number(7e10, "Pa", **POSITIVE, needs=on("modes"), doc="Young's modulus of that shape")
    damping_ratio: Number = number(
        0.01, "-", low=0.0, high=1.0, needs=on("modes"), doc="damping ratio of each of its modes"
    )
    modes: int = whole(0, 0, doc="how many modes bend that shape, none or at least 3")

    def check_together(self) -> None:
        if self.modes and self.shape is None:
            raise InputError(f"slider.modes = {self.modes}: a slider that bends needs its shape; give slider.shape too")
        check_modes("slider", self.modes)

    @property
    def form(self) -> PlanarBody:
        """Return the slider as a planar shape."""
        return shaped(self, shapes.SLIDER, self.scale)

    @property
    def places(self) -> Places:
        """Return the guide's middle and the pin, from the undeformed slider's centre of mass [m]."""
        return ((0.0, 0.0),) * 2 if self.shape is None else shapes.places(self, shapes.SLIDER, self.scale)

    @property
    def body(self) -> Body:
        """Return the slider as a rigid body."""
        # The guide keeps it from turning: its inertia means nothing.
        return Body(self.mass, 1.0) if self.shape is None else rigid(self, shapes.SLIDER, self.scale)


class SliderCrank(DesignOf[Run]):
    """The whole mechanism; the defaults are a much-used set for clearance in the piston pin.

    - ``crank``, ``drive``, ``rod``, ``slider``; ``piston_pin``, ``crank_pin``: the joints at the rod's ends.

    **Raises:** `InputError` where a number is out of its range.

    **Example:**

    >>> run = jb.simulate(jb.SliderCrank(), jb.SliderCrankScenario(), duration=1e-3)
    >>> f"{float(run.quantity('impact.1.peak_force')):.1f} N"
    '45872.3 N'
    """

    crank: Crank = Crank()
    drive: CrankDrive = CrankDrive()
    rod: Rod = Rod()
    slider: Slider = Slider()
    piston_pin: PistonPin = PistonPin()
    crank_pin: CrankPin = CrankPin()


class SliderCrankScenario(Part):
    """How it starts: with the velocities of the mechanism without play, each pin in the middle of its bush.

    **Raises:** `InputError` where a number is out of its range.

    **Example:** the pin first touches its bush at the same angle of the crank, however fast that turns.

    >>> import math
    >>> run = jb.simulate(jb.SliderCrank(), jb.SliderCrankScenario(crank_speed=50.0), duration=4e-3)
    >>> f"{math.degrees(50.0 * float(run.impacts.time[0])):.4f}°"
    '6.8186°'
    """

    section: ClassVar[str] = "scenario"
    crank_speed: Number = number(
        5000.0 * RPM, "rad/s", doc="speed of the crank at the start, steady where the drive keeps it so"
    )
    crank_angle: Number = number(0.0, "rad", doc="angle of the crank from the slider's line at the start")
    gravity: Number = number(0.0, "m/s²", **NON_NEGATIVE, doc="acceleration of gravity across the slider's line")


def check_fit(design: SliderCrank, scenario: SliderCrankScenario) -> None:
    """Raise `InputError` where the rod is too short to turn round, or a drive is to keep a speed of zero."""
    check_type("design", design, SliderCrank, "the design first, such as jb.SliderCrank(), then the scenario")
    crank, rod = concrete(design.crank.length), concrete(design.rod.length)
    if crank is not None and rod is not None and not np.all(crank < rod):
        raise InputError("rod.length must be above crank.length, for the crank to turn round")
    speed = concrete(scenario.crank_speed)
    if design.drive.kind == "speed" and speed is not None and not np.all(speed != 0.0):
        raise InputError('scenario.crank_speed = 0 rad/s: drive.kind = "speed" keeps it so, and nothing moves')


def valid(design: SliderCrank, scenario: SliderCrankScenario) -> Bool[Array, ""]:
    """Return whether design and scenario fit and each number is in its range, for numbers known only inside compiled
    code."""
    fit = inside(design.crank.length, high=design.rod.length, high_open=True, **POSITIVE)
    # A motor brings a crank up from rest; a drive that keeps a speed of zero moves nothing.
    steady = inside(abs(scenario.crank_speed), low=0.0, low_open=design.drive.kind == "speed")
    return all_of([*design.in_range(), *scenario.in_range(), fit, steady])
