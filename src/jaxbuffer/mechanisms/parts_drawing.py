"""What a mechanism without a picture of its own looks like: its balls, flanks, holes and springs, as assembled."""

from typing import Any

import jax
import numpy as np

from ..contact import Hole, Segment
from ..elements import BallContact
from ..multibody import AxialSpringDamper
from .assembled import Assembled
from .drawing import Disc, Drawing, Outline, Spot, Spring, Touch, plain_drawing
from .mechanism import Mechanism

SPRING_WIDTH = 0.06  # of a spring's free length


def drawing_of(mechanism: Mechanism, design: Any, scenario: Any) -> Drawing:
    """Return the mechanism's own drawing; of one that has none, its assembled parts."""
    bodies = mechanism.view.names(design).bodies
    if mechanism.view.drawing is plain_drawing and mechanism.stepper is None:
        system = mechanism.system(design, scenario)
        if isinstance(system, Assembled):
            return assembled_drawing(system, bodies)
    return mechanism.view.drawing(design, bodies)


def assembled_drawing(system: Assembled, bodies: tuple[str, ...] = ()) -> Drawing:
    """Return the balls, flanks, holes and springs of a mechanism, and a cross at each named body's origin."""
    shapes: list[Any] = []
    balls = [ball for element in system.elements for ball in element.report.balls]
    crosses = plain_drawing(None, bodies).shapes
    for body in range(-1, len(system.system.bodies)):
        shapes += [cross for cross in crosses if cross.body == body]
        for contact in balls:
            shapes += _shapes_on(contact, body)
    shapes += [_spring(force) for force in _springs(system)]
    # A picture shows the forces of those contacts that have impacts.
    touches = [touch for contact in system.all_of(BallContact) for touch in _touches(contact)]
    return Drawing(tuple(shapes), tuple(touches))


def _shapes_on(contact: BallContact, body: int) -> list[Any]:
    """Return what a contact has on one body: the ball on its own, the shape on the carrier."""
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
                shapes.append(Outline(body, np.array([start, start + way]), filled=False))
    return shapes


def _segments(contact: BallContact) -> list[tuple[Any, float]]:
    """Return each segment of a contact's shape alone, with its side."""
    shape, side = contact.pair.shape, np.ravel(np.asarray(contact.pair.side, float))
    if contact.segments == 1:
        return [(shape, float(side[0]))]
    alone = [jax.tree.map(lambda x, k=k: np.broadcast_to(x, len(side))[k], shape) for k in range(contact.segments)]
    return list(zip(alone, map(float, side), strict=True))


def _touches(contact: BallContact) -> list[Touch]:
    """Return where a contact's forces act, one a segment; on bodies that bend, at their origins."""
    ball, carrier = _spot(contact.body, contact.point), _spot(contact.carrier, contact.carrier_point)
    return [Touch(ball, carrier, shape, side) for shape, side in _segments(contact)]


def _springs(system: Assembled) -> list[AxialSpringDamper]:
    """Return the axial springs between points of bodies, of the system and of elements."""
    forces = [*system.system.forces, *(getattr(element, "force", None) for element in system.elements)]
    axial = [force for force in forces if isinstance(force, AxialSpringDamper)]
    return [force for force in axial if isinstance(force.first_point, tuple) and isinstance(force.second_point, tuple)]


def _spring(force: AxialSpringDamper) -> Spring:
    ends = _spot(force.first, force.first_point), _spot(force.second, force.second_point)
    return Spring(*ends, SPRING_WIDTH * float(force.free_length), part="springs")


def _spot(body: int, point: Any) -> Spot:
    """Return a point as a spot of a picture; a marker of a body that bends as the body's origin."""
    return Spot(body, *(float(x) for x in point)) if isinstance(point, tuple) else Spot(body)
