"""The bar dropped on a plate: its design and its scenario."""

import math
from collections.abc import Iterator
from typing import ClassVar

import numpy as np
from jaxtyping import Array, Bool, Float

from ..._types import Scalar
from ...contact import hertz_stiffness, law_choice, laws_with
from ...errors import InputError, check_entries, check_type, concrete, inside
from ...fields import (
    NON_NEGATIVE,
    POSITIVE,
    Number,
    Part,
    all_of,
    choice,
    chosen_of,
    number,
    on,
    outside_runs,
    whole,
)
from ...multibody.flexible import Bar, FlexibleBar, free_bar, plate_strip
from ..run import DesignOf
from .run import BarDropRun

HERTZ_EXPONENT = 1.5  # -
MATERIALS = outside_runs("only BarDrop.hertz_stiffness reads it; the laws take impact.stiffness")
PUBLISHED_STIFFNESS = 48_049.0 * 1000.0**2.2  # N/m^2.2, the paper's 48 049 N/mm^2.2


class HingedBar(Part):
    """A round bar, hinged at one end; the other end is a ball.

    ``length`` from the hinge to the ball's centre; ``diameter``; ``density``; ``ball_radius``. ``modes``: how many of
    a free bar's modes bend it, 0 for a rigid one; ``damping_ratio`` of each; ``young_modulus``.
    """

    section: ClassVar[str] = "bar"
    length: Number = number(0.24, "m", **POSITIVE, doc="length from the hinge to the ball's centre")
    diameter: Number = number(0.004, "m", **POSITIVE, doc="diameter of the bar")
    density: Number = number(7850.0, "kg/m³", **POSITIVE, doc="density of the bar and its ball")
    ball_radius: Number = number(0.002, "m", **POSITIVE, doc="radius of the ball at its end")
    modes: int = whole(0, 0, doc="how many modes bend the bar, 0 for a rigid one")
    damping_ratio: Number = number(
        0.01, "-", low=0.0, high=1.0, needs=on("modes"), doc="damping ratio of each of its modes"
    )
    young_modulus: Number = number(
        2.07e11, "Pa", **POSITIVE, needs=on("modes"), doc="Young's modulus of the bar, for its bending"
    )

    def check_together(self) -> None:
        if self.modes == 1:
            raise InputError("bar.modes = 1: both ends move and turn, which takes 2 modes at least; 0 is a rigid bar")

    @property
    def mass(self) -> Scalar:
        """Return the mass of the bar [kg]; the ball's own is part of it."""
        return self.density * math.pi / 4.0 * self.diameter**2 * self.length

    @property
    def rod(self) -> Bar:
        """Return the bar as a uniform one of circular section."""
        return Bar.circle(self.length, self.diameter, self.density, self.young_modulus)

    @property
    def bent(self) -> FlexibleBar:
        """Return the bar in modes of a free one, whose axes keep its centre of mass and angular momentum."""
        return free_bar(self.rod, self.modes - 2, damping_ratio=self.damping_ratio)

    @property
    def middle_off_ends(self) -> Float[np.ndarray, " modes"]:
        """Return how far the bar's middle is off the line through its ends, per unit of each modal coordinate [-]."""
        # The mode shapes of a free uniform bar do not depend on its dimensions.
        shapes = free_bar(Bar.circle(1.0, 1.0, 1.0, 1.0), self.modes - 2).shapes
        start, middle, end = shapes.lateral(np.array([0.0, 0.5, 1.0]), 0)
        return middle - 0.5 * (start + end)


class Impact(Part):
    """The ball against the plate.

    ``law``: a name in `contact.laws.LAWS`, each of which takes those fields that it has. "adams" is IMPACT: k δ^e and a
    damper c that sets in over ``ramp_depth`` d; ``stiffness`` k is in N/m^exponent. Other laws have the exponent 1.5.
    ``young_modulus``, ``poisson_ratio`` of ball and plate: what Hertz's stiffness is computed from.
    """

    section: ClassVar[str] = "impact"
    law: str = law_choice("adams")
    stiffness: Number = number(
        PUBLISHED_STIFFNESS,
        "N/m^e",
        **POSITIVE,
        needs=chosen_of("law", laws_with("stiffness")),
        doc="stiffness k of the law adams",
    )
    exponent: Number = number(2.2, "-", low=1.0, doc="exponent e of the law adams")
    damping: Number = number(
        1000.0,
        "N s/m",
        **NON_NEGATIVE,
        needs=chosen_of("law", laws_with("damping")),
        doc="damping c of the laws adams and kelvin-voigt",
    )
    ramp_depth: Number = number(
        1e-5,
        "m",
        **POSITIVE,
        needs=chosen_of("law", laws_with("ramp_depth")),
        doc="depth over which the damping of adams sets in",
    )
    restitution: Number = number(
        0.9,
        "-",
        low=0.0,
        high=1.0,
        low_open=True,
        needs=chosen_of("law", laws_with("restitution")),
        doc="restitution that is asked of laws with hysteresis",
    )
    linear_stiffness: Number = number(
        1e7,
        "N/m",
        **POSITIVE,
        needs=chosen_of("law", laws_with("linear_stiffness")),
        doc="stiffness of the law kelvin-voigt",
    )
    memory_time: Number = number(
        None,
        "s",
        **POSITIVE,
        doc="time in which a smooth contact's memory follows the approach speed; not set: events set it",
    )
    friction: Number = number(0.0, "-", **NON_NEGATIVE, doc="coefficient of friction between ball and plate")
    slip_speed: Number = number(
        1e-3, "m/s", **POSITIVE, needs=on("friction"), doc="slip speed below which friction falls to zero"
    )
    young_modulus: Number = number(
        2.07e11, "Pa", **POSITIVE, needs=MATERIALS, doc="Young's modulus of ball and plate, for Hertz's stiffness"
    )
    poisson_ratio: Number = number(
        0.3,
        "-",
        low=-1.0,
        high=0.5,
        low_open=True,
        needs=MATERIALS,
        doc="Poisson's ratio of ball and plate, for Hertz's stiffness",
    )

    def check_together(self) -> None:
        exponent = concrete(self.exponent)
        if self.law != "adams" and exponent is not None and np.any(exponent != HERTZ_EXPONENT):
            raise InputError(
                f"impact.exponent = {float(exponent.flat[0]):g}: impact.law = {self.law!r} has the exponent"
                f" {HERTZ_EXPONENT}; give impact.exponent = {HERTZ_EXPONENT} and impact.stiffness in N/m^1.5"
            )

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        yield from super().in_range()
        if self.law != "adams":
            yield inside(self.exponent, low=HERTZ_EXPONENT, high=HERTZ_EXPONENT)


class Plate(Part):
    """The plate, struck in the middle between two supports.

    ``modes``: how many of its natural modes bend it, 0 for a rigid plate; every second one rests where it is struck and
    is left out. ``length`` between the supports, ``width``, ``thickness``; ``support``: "supported" (free to turn
    there) or "clamped"; ``damping_ratio`` of every mode; ``density``, ``young_modulus``.
    """

    section: ClassVar[str] = "plate"
    modes: int = whole(0, 0, doc="how many modes bend the plate, 0 for a rigid one")
    length: Number = number(0.3, "m", **POSITIVE, needs=on("modes"), doc="length between the supports")
    width: Number = number(0.1, "m", **POSITIVE, needs=on("modes"), doc="width along the supports")
    thickness: Number = number(0.006, "m", **POSITIVE, needs=on("modes"), doc="thickness of the plate")
    support: str = choice(
        "supported",
        "supported",
        "clamped",
        needs=on("modes"),
        doc="supported: free to turn at the supports; or clamped",
    )
    damping_ratio: Number = number(
        0.01, "-", low=0.0, high=1.0, needs=on("modes"), doc="damping ratio of each of its modes"
    )
    density: Number = number(7850.0, "kg/m³", **POSITIVE, needs=on("modes"), doc="density of the plate")
    young_modulus: Number = number(
        2.07e11, "Pa", **POSITIVE, needs=on("modes"), doc="Young's modulus of the plate, for its bending"
    )

    @property
    def strip(self) -> Bar:
        """Return the plate as a uniform bar of rectangular section."""
        return Bar.rectangle(self.length, self.width, self.thickness, self.density, self.young_modulus)

    @property
    def moving_modes(self) -> tuple[int, ...]:
        """Return which of its modes move its middle, counted from 1: every other one."""
        return tuple(range(1, self.modes + 1, 2))

    @property
    def bent(self) -> FlexibleBar:
        """Return the plate in those of its modes that move where it is struck."""
        return plate_strip(self.strip, self.moving_modes, support=self.support, damping_ratio=self.damping_ratio)


class BarDrop(DesignOf[BarDropRun]):
    """The whole mechanism.

    The defaults are those of *Impact Dynamics Analysis of Mobile Mechanical Systems* (2021), section 2; the density is
    assumed.

    - ``bar``: the bar and its ball end; rigid, unless it has modes.
    - ``impact``: the ball against the plate.
    - ``plate``: rigid, unless it has modes.

    **Raises:** `InputError` where a number is out of its range.

    **Example:**

    >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario())
    >>> print(f"{float(run.peak_force):.1f} N, {1e6 * float(run.quantity('penetration')):.2f} µm deep")
    1831.5 N, 23.46 µm deep
    """

    bar: HingedBar = HingedBar()
    impact: Impact = Impact()
    plate: Plate = Plate()

    @property
    def hertz_stiffness(self) -> Scalar:
        """Return Hertz's stiffness of the ball on the flat plate [N/m^1.5], from the materials."""
        modulus, ratio = self.impact.young_modulus, self.impact.poisson_ratio
        return hertz_stiffness(self.bar.ball_radius, modulus, ratio, modulus, ratio)


class BarDropScenario(Part):
    """How the bar is dropped, at rest.

    **Raises:** `InputError` where a number is out of its range.

    **Example:** the ball end comes down at √(3 g_0 H).

    >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.1))
    >>> f"{float(run.impacts.approach_speed[0]):.4f} m/s"
    '1.7155 m/s'
    """

    section: ClassVar[str] = "scenario"
    height: Number = number(0.194, "m", **POSITIVE, doc="height H of the ball end above where it touches the plate")
    gravity: Number = number(9.81, "m/s²", **POSITIVE, doc="acceleration of gravity g_0")


def check_fit(design: BarDrop, scenario: BarDropScenario) -> None:
    """Raise `InputError` where the ball end would start higher than the bar is long."""
    check_type("design", design, BarDrop, "the design first, such as jb.BarDrop(), then the scenario")
    above = "; the ball end hangs on a bar of bar.length"
    check_entries("scenario.height", scenario.height, "m", 0.0, design.bar.length, too_high=above)


def valid(design: BarDrop, scenario: BarDropScenario) -> Bool[Array, ""]:
    """Return whether design and scenario fit and each number is in its range, for numbers known only inside compiled
    code."""
    fit = inside(scenario.height, high=design.bar.length, high_open=True, **POSITIVE)
    return all_of([*design.in_range(), *scenario.in_range(), fit])
