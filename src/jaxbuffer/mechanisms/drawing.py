"""What a mechanism looks like, as data: shapes on its bodies, springs between them, and where contact forces act."""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from ..contact import PlaneShape, Shape
from ..fields import Part
from ..multibody import Coordinates
from ..multibody.flexible import FlexibleBar
from ..programs.cache import stored
from .layout import positions

GROUND = -1  # the body that does not move
STATIONS = 25  # along a body that bends

Frames = Float[np.ndarray, "bodies 3"]  # [x, y, angle] of each [m, m, rad]
Points = Float[np.ndarray, "points 2"]
Arrows = Float[np.ndarray, "steps views contacts 4"]


class Spot(NamedTuple):
    """A point of a body (or of `GROUND`), in the body's axes [m]."""

    body: int
    x: float = 0.0
    y: float = 0.0

    def at(self, frames: Frames) -> Float[np.ndarray, "2"]:
        """Return where the spot is in inertial axes [m]."""
        return placed(np.array([[self.x, self.y]]), self.body, frames)[0]


class Outline(NamedTuple):
    """Corners (points, 2) [m] on a body, in the body's axes.

    ``filled``: a polygon, or else a line through the corners, ``dashed`` for what is no material; ``part``: what the
    legend calls it, "" for what belongs to the part before; ``endless``: so long that a picture need not show all of
    it, but where it is touched.
    """

    body: int
    corners: Points
    filled: bool = True
    part: str = ""
    dashed: bool = False
    endless: bool = False


class Disc(NamedTuple):
    """A disc of a ``radius`` [m] about a spot; ``filled``, or else its rim only; ``part``: as of `Outline`."""

    centre: Spot
    radius: float
    filled: bool = True
    part: str = ""


class RodShape(NamedTuple):
    """A bar between two spots, ``width`` [m] wide; ``part``: as of `Outline`."""

    first: Spot
    second: Spot
    width: float
    part: str = ""


class Band(NamedTuple):
    """A body that bends: a band ``width`` [m] wide along the origins of ``stations``, numbers of frames behind those of
    the bodies (`with_stations`), from one end to the other.

    ``part``: as of `Outline`; ``clamped``: whether its bending is measured from the axis of its first end, or else from
    the straight line between both ends.
    """

    stations: tuple[int, ...]
    width: float
    part: str = ""
    clamped: bool = False

    def straight(self, frames: Frames) -> Points:
        """Return where the stations would be if the band did not bend [m]."""
        at = frames[list(self.stations)]
        along = np.hypot(*np.diff(at[:, :2], axis=0).T)
        # Straight, the stations keep their distances along the band.
        way = np.concatenate([[0.0], np.cumsum(along)])
        if self.clamped:
            return at[0, :2] + way[:, None] * np.array([np.cos(at[0, 2]), np.sin(at[0, 2])])
        return at[0, :2] + way[:, None] / max(way[-1], 1e-300) * (at[-1, :2] - at[0, :2])

    def bent(self, frames: Frames, magnified: float = 1.0) -> Points:
        """Return the band's centre line, with its bending ``magnified`` [m]."""
        straight = self.straight(frames)
        return straight + magnified * (frames[list(self.stations)][:, :2] - straight)


class Spring(NamedTuple):
    """A spring between two spots, ``width`` [m] across its turns; ``part``: as of `Outline`."""

    first: Spot
    second: Spot
    width: float
    part: str = ""


class Coil(NamedTuple):
    """A spiral spring of a ``radius`` [m] about a spot, which turns with its body; ``part``: as of `Outline`."""

    centre: Spot
    radius: float
    part: str = ""


class Named(NamedTuple):
    """A point with a name, "hinge" say."""

    spot: Spot
    name: str


class Touch(NamedTuple):
    """Where a contact's force acts: a ball of a ``radius`` [m] about ``ball`` against a shape about ``carrier``;
    ``side`` of a segment: +1 where its front is to the right of its direction, else -1."""

    ball: Spot
    carrier: Spot
    shape: Shape
    side: float
    radius: float

    def at(self, frames: Frames) -> tuple[Float[np.ndarray, "2"], Float[np.ndarray, "2"], Float[np.ndarray, "2"]]:
        """Return the point of contact [m], and the unit normal and tangent there, along which the forces on the ball
        act."""
        angle = _angle(self.carrier.body, frames)
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        origin = self.carrier.at(frames)
        x, y = turn.T @ (self.ball.at(frames) - origin)
        # Shapes are fixed in the carrier's axes: the foot is found there and turned back.
        found = _foot(self.shape, float(x), float(y), self.side, self.radius)
        foot = [float(np.ravel(part)[0]) for part in found]
        normal = turn @ np.array(foot[2:4])
        return origin + turn @ np.array(foot[:2]), normal, self.side * np.array([normal[1], -normal[0]])


@functools.partial(stored, what="where a ball touches")
def _foot(shape: Shape, x: Any, y: Any, side: Any, radius: Any) -> Any:
    """Return `PlaneShape.foot`, from a program that is kept, so that a second start compiles nothing to draw."""
    assert isinstance(shape, PlaneShape), "drawings are of the plane"
    return shape.foot(x, y, side, radius)


class Detail(NamedTuple):
    """A closer look: ``title``; ``centre`` and ``half`` the width of what is seen [m].

    ``shapes``: drawn instead of the whole mechanism's, if any; ``true``: whether all is in scale; ``axes``: what is
    seen to the right and upwards; ``path``: number of a frame whose way so far is drawn, None for none; ``framed``:
    whether it is seen from where the whole is seen, whose picture then has a frame around it.
    """

    title: str
    centre: Spot
    half: float
    shapes: tuple[Any, ...] = ()
    true: bool = True
    axes: tuple[str, str] = ("x from the middle [mm]", "y [mm]")
    path: int | None = None
    framed: bool = True


def as_they_are(history: Any) -> Float[np.ndarray, "steps bodies 3"]:
    """Return the bodies' frames over a history: all that a plain drawing needs."""
    return np.asarray(history.position)


class Drawing(NamedTuple):
    """A mechanism's picture.

    - ``shapes``: `Outline`, `Disc`, `RodShape`, `Band`, `Spring` and `Coil`, from the back to the front.
    - ``touches``: one for each contact that has impacts, in their order; none in space, where ``arrows`` says it.
    - ``names``: points worth a name.
    - ``detail``: a closer look at the contact.
    - ``frames``: from a history to the frames (steps, bodies, [x, y, angle]) that the shapes are fixed to: the bodies'
      own, and behind them any others, of the end of a bending rod say.
    - ``arrows``: from a history to where the contact forces act, and the forces (steps, views, contacts, [x, y, F_x,
      F_y]) [m, m, N, N], in the picture of the whole and in the detail; None: as the touches say, in both.
    """

    shapes: tuple[Any, ...]
    touches: tuple[Touch, ...] = ()
    names: tuple[Named, ...] = ()
    detail: Detail | None = None
    frames: Callable[[Any], Float[np.ndarray, "steps frames 3"]] = as_they_are
    arrows: Callable[[Any], Arrows] | None = None


def arrows_of(drawing: Drawing, history: Any, frames: Float[np.ndarray, "steps frames 3"]) -> Arrows:
    """Return where contact forces act at the steps of a history, and their components, as `Drawing.arrows`."""
    if drawing.arrows is not None:
        return drawing.arrows(history)
    normal, friction = np.asarray(history.contact_force), np.asarray(history.friction_force)
    arrows = np.zeros((len(frames), 2, len(drawing.touches), 4))
    for k, each in enumerate(frames):
        for n, touch in enumerate(drawing.touches):
            point, outward, tangent = touch.at(each)
            arrows[k, :, n] = [*point, *(normal[k, n] * outward + friction[k, n] * tangent)]
    return arrows


def with_stations(
    frames: Float[np.ndarray, "steps frames 3"],
    history: Any,
    order: Coordinates,
    bar: FlexibleBar,
    body: int,
) -> Float[np.ndarray, "steps more 3"]:
    """Return frames, and behind them those of `STATIONS` stations along a body that bends.

    **Arguments:** ``frames``: so far; ``history``: whose states hold the modal coordinates; one without states, read
    from a file say, shows the body straight; ``order`` of the coordinates; ``bar``: the body's modes; ``body``: its
    number.
    """
    xi, length = np.linspace(0.0, 1.0, STATIONS), float(bar.bar.length)
    state = np.zeros((len(frames), order.count)) if history.state is None else np.asarray(history.state)
    modes = positions(state, order)[:, order.modal(body)]
    lateral, axial = modes[:, : bar.lateral], modes[:, bar.lateral :]
    x = length * (xi - float(bar.centre)) + axial @ bar.shapes.axial(xi, 0).T
    y, slope = (lateral @ bar.shapes.lateral(xi, order).T for order in (0, 1))
    origin, angle = frames[:, body, None, :2], frames[:, body, None, 2]
    cos, sin = np.cos(angle), np.sin(angle)
    places = origin + np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
    return np.concatenate([frames, np.concatenate([places, (angle + slope / length)[..., None]], axis=-1)], axis=1)


def stations(first: int) -> tuple[int, ...]:
    """Return the numbers of the frames that `with_stations` adds to ``first`` frames."""
    return tuple(range(first, first + STATIONS))


def plain_drawing(design: Part | None, bodies: tuple[str, ...] = (), arm: float = 5e-3) -> Drawing:
    """Return a cross, each ``arm`` [m] long, at the origin of every body that is named."""
    crosses = []
    for number, name in enumerate(bodies):
        for part, corners in ((name, [[-arm, 0.0], [arm, 0.0]]), ("", [[0.0, -arm], [0.0, arm]])):
            crosses.append(Outline(number, np.array(corners), filled=False, part=part))
    return Drawing(tuple(crosses))


def placed(points: Points, body: int, frames: Frames) -> Points:
    """Return points of a body's axes in inertial axes [m]."""
    if body == GROUND:
        return points
    x, y, angle = frames[body]
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([x + cos * points[:, 0] - sin * points[:, 1], y + sin * points[:, 0] + cos * points[:, 1]], axis=1)


def box(left: float, right: float, bottom: float, top: float) -> Points:
    """Return the corners of a rectangle [m]."""
    return np.array([[left, bottom], [right, bottom], [right, top], [left, top]])


def _angle(body: int, frames: Frames) -> float:
    return 0.0 if body == GROUND else float(frames[body][2])
