"""What the slider-crank looks like, with the play in a pin drawn larger than it is beside it."""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Float

from ...contact import Hole
from ...multibody import Coordinates
from ..drawing import (
    GROUND,
    Band,
    Detail,
    Disc,
    Drawing,
    Named,
    Outline,
    Points,
    RodShape,
    Spot,
    Touch,
    as_they_are,
    box,
    stations,
    with_stations,
)
from . import shapes
from .assembly import flanks
from .design import SliderCrank
from .pins import PinInBush
from .sensors import CRANK, ROD, SLIDER
from .shapes import PlanarBody, outlines

BODIES = 3
Motion = Callable[[Any], Float[np.ndarray, "steps frames 3"]]  # from a history to the frames
PLAY = 0.25  # of the bush's radius: how large it is drawn
EYE = 1.7  # radius of the rod's ends, in radii of their bush; assumed, like the widths below


def drawing(design: SliderCrank, bodies: tuple[str, ...] = ()) -> Drawing:
    """Return crank, rod, slider and its guide, in the design's lengths, the rod as far as it bends; in the detail the
    first pin that has play."""
    crank, rod = design.crank, design.rod
    length, throw, off = float(rod.length), float(crank.length), float(crank.unbalance / crank.mass)
    rear, front = (Spot(ROD, float(x), float(y)) for x, y in rod.ends)
    at_crank, small, large = Spot(CRANK, throw - off), *(float(pin.bush_radius) for pin in _pins(design))
    wide, tall = 2.6 * small, 2.2 * small
    near, far = length - throw - 1.2 * wide, length + throw + 1.2 * wide
    wide_rod = float(rod.depth) if rod.depth is not None else small
    shank: RodShape | Band = RodShape(rear, front, wide_rod, "rod")
    if bends(design):
        shank = Band(stations(BODIES), wide_rod, "rod")
        # The pins of a rod that bends are where its first and its last station are.
        rear, front = Spot(shank.stations[0]), Spot(shank.stations[-1])
    rod_shapes: tuple[Any, ...] = (shank, Disc(front, EYE * small), Disc(rear, EYE * large))
    if rod.shape is not None:
        rod_shapes = lines_around(ROD, outlines(rod.shape, shapes.ROD, float(rod.size)), "rod")
    seat, slider = _seat(design), slider_shapes(design, box(-wide, wide, -tall, tall))
    low, high = (float(end) - seat.y for end in (slider[0].corners[:, 1].min(), slider[0].corners[:, 1].max()))
    drawn = (
        Outline(GROUND, np.array([[near, low], [far, low]]), False, "guide"),
        Outline(GROUND, np.array([[near, high], [far, high]]), False),
        *slider,
        RodShape(Spot(CRANK, -off), at_crank, 1.2 * large, "crank"),
        Disc(Spot(GROUND), 1.2 * large),
        *rod_shapes,
        Disc(seat, float(design.piston_pin.radius), part="pins"),
        Disc(at_crank, float(design.crank_pin.radius)),
    )
    touches = _touches(design, front, at_crank, rear)
    names = (Named(Spot(GROUND), "shaft"), Named(at_crank, "crank pin"), Named(seat, "piston pin"))
    frames = bent(design)
    if not touches:
        return Drawing(drawn, names=names, frames=frames)
    played = next(pin for pin in _pins(design) if pin.joint == "clearance")
    detail, frames = closer(played, touches[0], frames, BODIES + (len(stations(0)) if bends(design) else 0))
    return Drawing(drawn, touches, names, detail, frames)


def bent(design: SliderCrank) -> Motion:
    """Return a function of a history that gives the bodies' frames, and those of stations along a rod that bends."""
    bar = design.rod.bent if bends(design) else None
    if bar is None or isinstance(bar, PlanarBody):
        return as_they_are
    order = Coordinates(BODIES, (0, bar.modes.size, 0))
    return lambda history: with_stations(as_they_are(history), history, order, bar, ROD)


def bends(design: SliderCrank) -> bool:
    """Return whether the rod is drawn as a band that bends; a shape is drawn as if it were rigid."""
    return bool(design.rod.modes) and design.rod.shape is None


def slider_shapes(design: SliderCrank, usual: Points) -> tuple[Outline, ...]:
    """Return the slider: ``usual`` corners, or the lines around its mesh."""
    slider = design.slider
    if slider.shape is None:
        return (Outline(SLIDER, usual, part="slider"),)
    return lines_around(SLIDER, outlines(slider.shape, shapes.SLIDER, float(slider.scale)), "slider")


def lines_around(body: int, lines: list[np.ndarray], part: str) -> tuple[Outline, ...]:
    """Return a body's outlines: the longest, filled, names the ``part``; holes are lines."""
    longest_first = sorted(lines, key=lambda line: -float(np.ptp(line)))
    return tuple(Outline(body, line, filled=not k, part="" if k else part) for k, line in enumerate(longest_first))


def _seat(design: SliderCrank) -> Spot:
    """Return where the piston pin is on the slider."""
    return Spot(SLIDER, *map(float, design.slider.places[1]))


def _pins(design: SliderCrank) -> tuple[PinInBush, PinInBush]:
    return design.piston_pin, design.crank_pin


def _touches(design: SliderCrank, front: Spot, at_crank: Spot, rear: Spot) -> tuple[Touch, ...]:
    """Return where pins with play touch their bushes, the piston pin's first; ``front``, ``rear``: the rod's ends."""
    seat, touches, (small, large) = _seat(design), list[Touch](), _pins(design)
    if small.joint == "clearance":
        bush, pin = float(small.bush_radius), float(small.radius)
        if small.by_components:
            touches += [Touch(front, seat, flank, -1.0, pin) for flank in flanks(bush)]
        else:
            touches.append(Touch(seat, front, Hole(0.0, 0.0, bush), 1.0, pin))
    if large.joint == "clearance":
        touches.append(Touch(at_crank, rear, Hole(0.0, 0.0, float(large.bush_radius)), 1.0, float(large.radius)))
    return tuple(touches)


def closer(pin: PinInBush, touch: Touch, motion: Motion, magnified: int) -> tuple[Detail, Motion]:
    """Return a pin in its bush with the play drawn larger, and the frames for it: behind those of ``motion``
    (``magnified`` of them) the pin's, whose centre is as many times farther from the bush's as the play is larger."""
    bush, clearance = float(pin.bush_radius), float(pin.clearance)
    # A play that is larger than that is drawn as it is.
    times = max(PLAY * bush / clearance, 1.0)
    name = pin.section.replace("_", " ")
    hole = touch.carrier
    wall: Disc | Outline = Disc(hole, bush, filled=False, part="bush")
    if pin.by_components:
        square = box(-bush, bush, -bush, bush)
        corners = np.vstack([square, square[:1]]) + np.array([hole.x, hole.y])
        wall = Outline(hole.body, corners, filled=False, part="bush")
    journal = Disc(Spot(magnified), bush - times * clearance, part="pins")
    title = f"{name} in its bush, play × {times:.3g}" if times > 1.0 else f"{name} in its bush"

    def frames(history: Any) -> Float[np.ndarray, "steps frames 3"]:
        bodies = motion(history)
        pin_at, bush_at = (np.array([spot.at(it) for it in bodies]) for spot in (touch.ball, touch.carrier))
        larger = np.column_stack([bush_at + times * (pin_at - bush_at), bodies[:, touch.ball.body, 2]])
        return np.concatenate([bodies, larger[:, None]], axis=1)

    return Detail(title, hole, 1.6 * bush, (wall, journal), true=False), frames
