"""The drop onto a tank: its design and its scenario."""

from typing import Any, ClassVar

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from ..._types import Scalar
from ...errors import InputError, check_entries, check_type, concrete, same_shape
from ...fields import NON_NEGATIVE, POSITIVE, Number, Part, all_of, choice, chosen, number, on, whole
from ...structures.contact import METHODS
from ..run import DesignOf
from .laminate import Composite
from .tank_run import TankRun

ZONES = ("bottom", "lower_corner", "lower_side", "upper_side", "upper_corner", "top")
FILL = {"low": 0.15, "high": 1.0}
HIGHEST = 0.95  # with a surface, which needs room
WITH_LIQUID = chosen("contents.kind", "liquid", "full")
THICKNESS: dict[str, Any] = {"low": 0.0, "low_open": True, "high": 0.03}


class Wall(Part):
    """The tank's wall: its thickness in six zones, the same on the left and on the right, with tapers between them."""

    section: ClassVar[str] = "wall"
    bottom: Number = number(0.005, "m", **THICKNESS, doc="thickness of the wall at the bottom")
    lower_corner: Number = number(0.005, "m", **THICKNESS, doc="thickness of the wall at the lower corner")
    lower_side: Number = number(0.005, "m", **THICKNESS, doc="thickness of the wall at the lower side")
    upper_side: Number = number(0.005, "m", **THICKNESS, doc="thickness of the wall at the upper side")
    upper_corner: Number = number(0.005, "m", **THICKNESS, doc="thickness of the wall at the upper corner")
    top: Number = number(0.005, "m", **THICKNESS, doc="thickness of the wall at the top")


class Tank(Part):
    """The tank's outside, a rectangle with round corners, and its length along which nothing changes."""

    section: ClassVar[str] = "tank"
    width: Number = number(0.6, "m", **POSITIVE, doc="outer width")
    height: Number = number(0.3, "m", **POSITIVE, doc="outer height")
    corner_radius: Number = number(0.04, "m", **POSITIVE, doc="outer radius of the corners")
    length: Number = number(0.7, "m", **POSITIVE, doc="length along which nothing changes")

    def check_together(self) -> None:
        known = [concrete(x) for x in (self.corner_radius, self.height, self.width)]
        if any(x is None for x in known):  # traced
            return
        radius, height, width = same_shape("tank", known)
        if (bad := 2.0 * radius >= np.minimum(height, width)).any():
            given, tall, wide = (float(x[bad][0]) for x in (radius, height, width))
            allowed = f"(0, {0.5 * min(tall, wide):g}) m"
            raise InputError(
                f"tank.corner_radius = {given:g} m is out of range; allowed: {allowed}, less than half of tank.height"
                f" = {tall:g} m and of tank.width = {wide:g} m"
            )


class Plates(Part):
    """Two perforated baffle plates inside, upright from the bottom to the top, left and right alike, of the wall's
    material."""

    section: ClassVar[str] = "plates"
    kind: str = choice("none", "none", "perforated", doc="none, or two perforated baffle plates inside")
    thickness: Number = number(
        0.005,
        "m",
        **THICKNESS,
        needs=chosen("kind", "perforated"),
        doc="thickness of a plate without holes that is as stiff",
    )
    position: Number = number(
        0.15,
        "m",
        **POSITIVE,
        needs=chosen("kind", "perforated"),
        doc="distance of a plate's middle from the middle of the tank",
    )
    aperture: Number | None = number(
        None,
        "-",
        low=0.0,
        low_open=True,
        high=1.0,
        needs=(*chosen("kind", "perforated"), *WITH_LIQUID),
        doc="open share of a plate; not set: the liquid does not feel it",
    )
    hole_diameter: Number = number(
        0.02,
        "m",
        **POSITIVE,
        needs=(*chosen("kind", "perforated"), *on("aperture"), *WITH_LIQUID),
        doc="diameter of the holes, for the liquid in them",
    )


class Ribs(Part):
    """Rings inside that stiffen the wall, round the whole section and of its material, so near each other along the
    tank that they count by their share of it (M168)."""

    section: ClassVar[str] = "ribs"
    kind: str = choice("none", "none", "rings", doc="none, or rings inside that stiffen the wall")
    height: Number = number(
        0.01,
        "m",
        low=0.0,
        low_open=True,
        high=0.1,
        needs=chosen("kind", "rings"),
        doc="height of a rib, inwards from the wall",
    )
    share: Number = number(
        0.1,
        "-",
        low=0.0,
        low_open=True,
        high=1.0,
        needs=chosen("kind", "rings"),
        doc="width of a rib over the distance from one to the next",
    )


class TankMaterial(Part):
    """What the wall is made of: high-density polyethylene unless said otherwise."""

    section: ClassVar[str] = "material"
    kind: str = choice(
        "plastic", "plastic", "composite", doc="plastic: the fields below; composite: the section composite"
    )
    density: Number = number(950.0, "kg/m³", **POSITIVE, needs=chosen("kind", "plastic"), doc="density of the wall")
    young_modulus: Number = number(
        1.0e9, "Pa", **POSITIVE, needs=chosen("kind", "plastic"), doc="Young's modulus of the wall"
    )
    poisson_ratio: Number = number(
        0.4,
        "-",
        low=-1.0,
        high=0.5,
        low_open=True,
        high_open=True,
        needs=chosen("kind", "plastic"),
        doc="Poisson's ratio of the wall",
    )
    yield_stress: Number = number(
        25e6, "Pa", **POSITIVE, needs=chosen("kind", "plastic"), doc="yield stress of the wall"
    )
    hardening: Number = number(
        40e6,
        "Pa",
        **NON_NEGATIVE,
        needs=chosen("kind", "plastic"),
        doc="rise of the yield stress over equivalent plastic strain",
    )
    failure_strain: Number = number(
        0.6,
        "-",
        **POSITIVE,
        needs=chosen("kind", "plastic"),
        doc="equivalent plastic strain at which an element is deleted",
    )


class Contents(Part):
    """The liquid that the tank holds, if any, and the air above it.

    A tank that is full has no air: ``scenario.fill`` is 1 then. Open air is not felt by the wall.
    """

    section: ClassVar[str] = "contents"
    kind: str = choice(
        "liquid",
        "liquid",
        "full",
        "none",
        doc="what the tank holds: liquid with a surface, liquid up to the top, or none",
    )
    density: Number = number(740.0, "kg/m³", **POSITIVE, needs=WITH_LIQUID, doc="density of the liquid")
    sound_speed: Number = number(1150.0, "m/s", **POSITIVE, needs=WITH_LIQUID, doc="speed of sound in the liquid")
    air: str = choice(
        "open",
        "open",
        "trapped",
        needs=chosen("kind", "liquid", "none"),
        doc="the air above the liquid: open, or trapped, which is a spring",
    )
    air_pressure: Number = number(
        1.013e5,
        "Pa",
        **POSITIVE,
        needs=(*chosen("kind", "liquid", "none"), *chosen("air", "trapped")),
        doc="absolute pressure of trapped air at first",
    )


class Cushion(Part):
    """The layer under the slider: what is a buffer here.

    It is solid where less than a fifth of it is left. Without it the slider strikes the wall, as the `Support` says.
    """

    section: ClassVar[str] = "cushion"
    kind: str = choice(
        "layer", "layer", "none", doc="a layer, or none: the slider strikes the wall as the support does"
    )
    thickness: Number = number(
        0.15, "m", **POSITIVE, needs=chosen("kind", "layer"), doc="thickness of the layer under the slider"
    )
    stiffness: Number = number(4e6, "Pa/m", **POSITIVE, needs=chosen("kind", "layer"), doc="stiffness of an area of it")
    damping: Number = number(
        1e4, "Pa s/m", **NON_NEGATIVE, needs=chosen("kind", "layer"), doc="damping of an area of it"
    )


class FallingSlider(Part):
    """What falls, rigid and wider than the tank."""

    section: ClassVar[str] = "slider"
    mass: Number = number(348.0, "kg", **POSITIVE, doc="mass of what falls, which is rigid and wider than the tank")


class Support(Part):
    """The contact between the tank and the rigid baffle it rests on."""

    section: ClassVar[str] = "support"
    method: str = choice("penalty", *METHODS, doc="how the force of the support is computed")
    stiffness: Number = number(
        5e9, "Pa/m", **POSITIVE, needs=chosen("method", "penalty"), doc="stiffness of a penalty, of an area"
    )


class Mesh(Part):
    """How finely the section is divided.

    The whole section takes twice as long as half of it, and a slider at an angle needs it.
    """

    section: ClassVar[str] = "mesh"
    refinement: int = whole(
        1, 1, 8, doc="1: elements of some 20 mm and one across the wall; 2: twice as many either way; up to 8"
    )
    extent: str = choice(
        "half", "half", "whole", doc="half of the section, by symmetry; whole: as scenario.angle needs"
    )


class TankDrop(DesignOf[TankRun]):
    """The whole mechanism: plane strain in the tank's cross-section, of which half is computed, or the whole.

    *Analysis of fuel tank collision structure based on defense point method* prints no dimension and no material: the
    defaults are assumed.

    - ``tank``, ``wall``, ``ribs``, ``plates``, ``material``: the tank; ``composite``: its wall's plies, if they are its
      material.
    - ``contents``: what it holds.
    - ``cushion``, ``slider``: what falls on it.
    - ``support``: how it rests.
    - ``mesh``: how finely it is divided.

    **Raises:** `InputError` where a number is out of its range.

    **Example:**

    >>> thick = jb.replace(jb.TankDrop(), {"wall.top": "8 mm", "cushion.thickness": 0.2})
    >>> f"{1e3 * float(thick.wall.top):.0f} mm"
    '8 mm'
    """

    tank: Tank = Tank()
    wall: Wall = Wall()
    ribs: Ribs = Ribs()
    plates: Plates = Plates()
    material: TankMaterial = TankMaterial()
    composite: Composite = Composite()
    contents: Contents = Contents()
    cushion: Cushion = Cushion()
    slider: FallingSlider = FallingSlider()
    support: Support = Support()
    mesh: Mesh = Mesh()


class TankDropScenario(Part):
    """How the slider falls, from rest, onto the tank that stands still; at an angle it is guided, and does not turn.

    **Raises:** `InputError` where a number is out of its range.

    **Example:** the paper's slider arrives with 6964 J.

    >>> drop = jb.TankDropScenario()
    >>> f"{float(jb.TankDrop().slider.mass * drop.gravity * drop.height):.0f} J"
    '6964 J'
    """

    section: ClassVar[str] = "scenario"
    height: Number = number(2.04, "m", **POSITIVE, doc="height through which it falls before the cushion touches")
    fill: Number = number(0.8, "-", **FILL, needs=WITH_LIQUID, doc="height of the liquid over the inner height")
    gravity: Number = number(9.81, "m/s²", **POSITIVE, doc="acceleration of gravity")
    angle: Number = number(
        0.0, "rad", low=-0.5, high=0.5, doc="angle of the slider's underside against the top; needs mesh.extent = whole"
    )


def check_fit(design: TankDrop, scenario: TankDropScenario) -> None:
    """Raise `InputError` where a wall, with its rib, is as thick as its corner is round, a plate does not stand on the
    flat bottom, the liquid is no higher than its corner, ribs stand beside what they are not computed with, or half of
    a section is to meet a slider at an angle."""
    check_type("design", design, TankDrop, "the design first, such as jb.TankDrop(), then the scenario")
    # Where a wall is as thick as its corner's outer radius, the inner nodes of the corner meet in one point.
    for zone in ZONES:
        try:
            check_entries(f"wall.{zone}", getattr(design.wall, zone), "m", 0.0, design.tank.corner_radius)
        except InputError as error:
            raise error.between(after=", less than tank.corner_radius") from None
    _check_ribs(design)
    angle = concrete(scenario.angle)
    if design.mesh.extent != "whole" and angle is not None and (turned := np.asarray(angle) != 0.0).any():
        given = float(np.asarray(angle)[turned][0])
        raise InputError(
            f"scenario.angle = {given:g} rad ({np.degrees(given):.3g}°): an angle other than 0 needs"
            ' mesh.extent = "whole"; half of the section is symmetric'
        )
    if design.plates.kind != "none":
        try:
            check_entries("plates.position", design.plates.position, "m", *_between(design))
        except InputError as error:
            raise error.between(after=", where the whole plate stands on the flat bottom") from None
    above = "; the liquid must be higher than the lower corner, tank.corner_radius"
    if design.contents.kind == "full":
        if (fill := concrete(scenario.fill)) is not None and (np.asarray(fill) < 1.0).any():
            raise InputError(f'scenario.fill = {np.min(fill):g}: contents.kind = "full" needs 1')
        return
    try:
        check_entries("scenario.fill", scenario.fill, "-", _corner(design), HIGHEST, too_low=above, high_open=False)
    except InputError as error:
        raise error.between(after='; or 1, with contents.kind = "full"') from None


def _check_ribs(design: TankDrop) -> None:
    if design.ribs.kind == "none":
        return
    for other, given in (("plates.kind", design.plates.kind), ("material.kind", design.material.kind)):
        if given in ("perforated", "composite"):
            raise InputError(
                f'ribs.kind = "{design.ribs.kind}" and {other} = "{given}" are not computed together; take away one'
            )
    for zone in ZONES:
        try:
            check_entries("ribs.height", design.ribs.height, "m", 0.0, _room(design, zone))
        except InputError as error:
            raise error.between(after=f", less than tank.corner_radius - wall.{zone}") from None


def _room(design: TankDrop, zone: str) -> Scalar:
    """Return how high a rib can be there [m]: it ends before the middle of a corner."""
    return design.tank.corner_radius - getattr(design.wall, zone)


def _corner(design: TankDrop) -> Scalar:
    """Return how high the lower corner reaches, as a fill [-]: the mesh needs a liquid that reaches further."""
    bottom = design.wall.bottom
    return (design.tank.corner_radius - bottom) / (design.tank.height - bottom - design.wall.top)


def _between(design: TankDrop) -> tuple[Scalar, Scalar]:
    """Return where a plate can be [m]: half of its thickness from the middle, and from where the corner begins."""
    half, flat = 0.5 * design.plates.thickness, 0.5 * design.tank.width - design.tank.corner_radius
    return half, flat - half


def valid(design: TankDrop, scenario: TankDropScenario) -> Bool[Array, ""]:
    """Return whether design and scenario fit and each number is in its range, for numbers known only inside compiled
    code."""
    radius = jnp.asarray(design.tank.corner_radius, float)
    thin = [getattr(design.wall, zone) < radius for zone in ZONES]
    round_enough = [2.0 * radius < side for side in (design.tank.width, design.tank.height)]
    fill = jnp.asarray(scenario.fill, float)
    high = fill >= 1.0 if design.contents.kind == "full" else (fill > _corner(design)) & (fill <= HIGHEST)
    (left, right), at = _between(design), jnp.asarray(design.plates.position, float)
    # The default position of plates that are not there must not make a narrow tank invalid.
    beside = [] if design.plates.kind == "none" else [(left < at) & (at < right)]
    if design.ribs.kind != "none":
        beside += [jnp.asarray(design.ribs.height, float) < _room(design, zone) for zone in ZONES]
    if design.mesh.extent == "half":
        beside.append(jnp.asarray(scenario.angle, float) == 0.0)
    return all_of([*design.in_range(), *scenario.in_range(), *thin, *round_enough, *beside, high])
