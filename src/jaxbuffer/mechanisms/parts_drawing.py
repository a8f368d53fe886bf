"""What a mechanism without a picture of its own looks like: its balls, flanks, holes, springs, joints, end stops and
latches, as assembled."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Float

from ..contact import Hole, Segment
from ..elements import BallContact, EndStop, Latch
from ..multibody import AxialSpringDamper, Revolute
from .assembled import Assembled
from .drawing import Detail, Disc, Drawing, Outline, Spot, Spring, Touch, plain_drawing
from .mechanism import Mechanism

SPRING_WIDTH = 0.06  # of a spring's free length
CROSS = 0.04  # of the picture's size: arm of a body's cross
LEAST = 0.1  # m, size of a picture of bodies that are all at one place
JOINT = 0.3  # of a cross's arm: radius of a hinge
CLOSE = 0.1  # of the picture's size: what is smaller is seen in a closer look only
ROOM = 2.0  # of a closer look's half, over the stroke to a stop or the way to a latch


def drawing_of(mechanism: Mechanism, design: Any, scenario: Any) -> Drawing:
    """Return the mechanism's own drawing; of one that has none, its assembled parts."""
    bodies = mechanism.view.names(design).bodies
    if mechanism.view.drawing is plain_drawing and mechanism.stepper is None:
        system = mechanism.system(design, scenario)
        if isinstance(system, Assembled):
            return assembled_drawing(system, bodies)
    return mechanism.view.drawing(design, bodies)


class Mark(NamedTuple):
    """Where a stop begins: ``distance`` [m] from the ``first`` end of its guide, along the way to the ``second``."""

    first: Spot
    second: Spot
    distance: float

    def frame(self, frames: Any) -> Float[np.ndarray, "3"]:
        """Return its place, and the angle of the way there [m, m, rad]."""
        first = self.first.at(frames)
        x, y = self.second.at(frames) - first
        along = np.array([x, y]) / max(float(np.hypot(x, y)), 1e-300)
        return np.array([*(first + self.distance * along), np.arctan2(y, x)])


def assembled_drawing(system: Assembled, bodies: tuple[str, ...] = ()) -> Drawing:
    """Return the balls, flanks, holes, springs, joints, end stops and latches of a mechanism, and a cross at each
    body's origin."""
    count = len(system.system.bodies)
    names = (*bodies, *(f"body {k + 1}" for k in range(len(bodies), count)))
    start = system.system.order.placements(np.asarray(system.q))
    size = _size(system, start)
    shapes: list[Any] = []
    balls = [ball for element in system.elements for ball in element.report.balls]
    crosses = plain_drawing(None, names, CROSS * size).shapes
    for body in range(-1, count):
        for contact in balls:
            shapes += _shapes_on(contact, body, size)
    # In front of the balls, which would hide them.
    shapes += crosses
    for force in _springs(system):
        ends = _spot(force.first, force.first_point), _spot(force.second, force.second_point)
        shapes.append(Spring(*ends, SPRING_WIDTH * float(force.free_length), part="springs"))
    shapes += _hinges(system, size)
    marks = [mark for element in system.elements if isinstance(element, EndStop) for mark in _marks(element)]
    for k, (mark, name) in enumerate(marks):
        half = SPRING_WIDTH * float(mark.distance)
        shapes.append(Outline(count + k, np.array([[0.0, -half], [0.0, half]]), filled=False, part=name))
    latches = [element for element in system.elements if isinstance(element, Latch)]
    for latch in latches:
        shapes += _latch(latch, size)
    # A picture shows the forces of those contacts that have impacts, one a segment; on bodies that bend, at their
    # origins.
    touches = [
        Touch(_spot(it.body, it.point), _spot(it.carrier, it.carrier_point), shape, side, float(it.pair.radius))
        for it in system.all_of(BallContact)
        for shape, side in _segments(it)
    ]

    def frames(history: Any) -> Float[np.ndarray, "steps frames 3"]:
        position = np.asarray(history.position)
        extra = [[mark.frame(each) for mark, _ in marks] for each in position]
        return np.concatenate([position, np.reshape(extra, (len(position), len(marks), 3))], axis=1)

    detail = _detail(system, size, count)
    return Drawing(tuple(shapes), tuple(touches), detail=detail, frames=frames)


def _size(system: Assembled, start: Float[np.ndarray, "bodies 3"]) -> float:
    """Return the size of the picture at the start [m]."""
    points = [*start[:, :2]]
    for force in _springs(system):
        points += [_spot(force.first, force.first_point).at(start), _spot(force.second, force.second_point).at(start)]
    for contact in system.all_of(BallContact):
        radius = float(contact.pair.radius)
        centre = _spot(contact.body, contact.point).at(start)
        points += [centre - radius, centre + radius]
    for joint in system.system.joints:
        if isinstance(joint, Revolute):
            points.append(_spot(joint.first, joint.first_point).at(start))
    return max(float(np.max(np.ptp(points, axis=0))), 0.0) or LEAST


def _hinges(system: Assembled, size: float) -> Iterator[Any]:
    """Yield a circle at each hinge, and a line to the origin of a body from its point of the hinge."""
    part = "hinge"
    for joint in system.system.joints:
        if not isinstance(joint, Revolute):
            continue
        for body, point in ((joint.first, joint.first_point), (joint.second, joint.second_point)):
            if body >= 0 and isinstance(point, tuple) and any(float(x) for x in point):
                yield Outline(body, np.array([[0.0, 0.0], [float(x) for x in point]]), filled=False)
        yield Disc(_spot(joint.first, joint.first_point), JOINT * CROSS * size, filled=False, part=part)
        part = ""


def _marks(stop: EndStop) -> Iterator[tuple[Mark, str]]:
    """Yield where a stop begins, and what it is called."""
    guide = stop.guide
    if isinstance(guide.first_point, tuple) and isinstance(guide.second_point, tuple):
        beyond = float(stop.place) if stop.rebound else -float(stop.place)
        ends = _spot(guide.first, guide.first_point), _spot(guide.second, guide.second_point)
        yield Mark(*ends, float(guide.free_length) + beyond), stop.report.words


def _latch(latch: Latch, size: float) -> list[Any]:
    """Return the point that a latch holds, its plane and its seat."""
    x, y = float(latch.plane), float(latch.seat[1])
    half, seat = CROSS * size, Spot(latch.second, float(latch.seat[0]), y)
    plane = np.array([[x, y - half], [x, y + half]])
    return [
        Outline(latch.second, plane, filled=False, part=f"plane of the {latch.report.words}", dashed=True),
        Disc(seat, 0.1 * half, filled=False, part=f"seat of the {latch.report.words}"),
        Disc(_spot(latch.first, latch.point), 0.05 * half, part=f"point that the {latch.report.words} holds"),
    ]


def _detail(system: Assembled, size: float, first: int) -> Detail | None:
    """Return a closer look at the first stop, or else the first latch, whose way would hardly be seen in the whole;
    None where it can be. ``first``: the number of the first stop's frame."""
    for element in system.elements:
        if isinstance(element, EndStop):
            half, centre, title = ROOM * float(element.place), Spot(first), element.report.words
        elif isinstance(element, Latch):
            seat = Spot(element.second, *(float(x) for x in element.seat))
            half, centre, title = ROOM * abs(float(element.plane) - seat.x), seat, element.report.words
        else:
            continue
        return Detail(title, centre, half) if 0.0 < half < CLOSE * size else None
    return None


def _shapes_on(contact: BallContact, body: int, size: float) -> list[Any]:
    """Return what a contact has on one body: the ball on its own, the shape on the carrier. A flank that is longer than
    the picture's ``size`` [m] is one without end."""
    shapes: list[Any] = []
    if contact.body == body and isinstance(contact.point, tuple):
        shapes.append(Disc(_spot(body, contact.point), float(contact.pair.radius)))
    if contact.carrier == body and isinstance(contact.carrier_point, tuple):
        for shape, _ in _segments(contact):
            x, y = (float(place) for place in contact.carrier_point)
            if isinstance(shape, Hole):
                centre = Spot(body, x + float(shape.x), y + float(shape.y))
                shapes.append(Disc(centre, float(shape.radius), filled=False))
            elif isinstance(shape, Segment):
                start = np.array([x + float(shape.start_x), y + float(shape.start_y)])
                way = float(shape.length) * np.array([float(shape.direction_x), float(shape.direction_y)])
                endless = float(shape.length) > size
                shapes.append(Outline(body, np.array([start, start + way]), filled=False, endless=endless))
    return shapes


def _segments(contact: BallContact) -> list[tuple[Any, float]]:
    """Return each segment of a contact's shape alone, with its side."""
    shape, side = contact.pair.shape, np.ravel(np.asarray(contact.pair.side, float))
    if contact.segments == 1:
        return [(shape, float(side[0]))]
    alone = [jax.tree.map(lambda x, k=k: np.broadcast_to(x, len(side))[k], shape) for k in range(contact.segments)]
    return list(zip(alone, map(float, side), strict=True))


def _springs(system: Assembled) -> list[AxialSpringDamper]:
    """Return the axial springs between points of bodies, of the system and of elements."""
    forces = [*system.system.forces, *(getattr(element, "force", None) for element in system.elements)]
    axial = [force for force in forces if isinstance(force, AxialSpringDamper)]
    return [force for force in axial if isinstance(force.first_point, tuple) and isinstance(force.second_point, tuple)]


def _spot(body: int, point: Any) -> Spot:
    """Return a point as a spot of a picture; a marker of a body that bends as the body's origin."""
    return Spot(body, *(float(x) for x in point)) if isinstance(point, tuple) else Spot(body)
