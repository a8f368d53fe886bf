"""The picture of a mechanism that has none of its own is that of its parts."""

import jax.numpy as jnp
import numpy as np

from jaxbuffer.contact import BallPair, Hole, RegularisedCoulomb, Segment
from jaxbuffer.contact.laws import Hertz
from jaxbuffer.elements import BallContact, Buffer
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.drawing import Disc, Outline, Spot, Spring
from jaxbuffer.mechanisms.parts_drawing import assembled_drawing
from jaxbuffer.multibody import GROUND, AxialSpringDamper, Body, System

SMOOTH = RegularisedCoulomb(0.0, 1.0)


def test_balls_flanks_holes_and_springs_where_they_are():
    flanks = Segment(jnp.array([0.0, 1.0]), jnp.array([0.0, 2.0]), jnp.array([1.0, 0.0]), jnp.array([0.0, 1.0]), 0.5)
    tip = BallContact(
        0,
        1,
        BallPair(0.02, flanks, jnp.array([1.0, -1.0]), Hertz(1.0), SMOOTH),
        (0.1, 0.2),
        names=("a", "b"),
        name="tip",
    )
    pin = BallContact(
        1, GROUND, BallPair(0.01, Hole(0.3, 0.0, 0.011), 1.0, Hertz(1.0), SMOOTH), carrier_point=(1.0, 2.0)
    )
    springs = (
        AxialSpringDamper(0, 1, (0.0, 1.0), (0.0, 0.0), 1.0, 0.0, 2.0),
        AxialSpringDamper(GROUND, 1, (0.0, 0.0), (0.5, 0.0), 1.0, 0.0, 1.0),
    )
    system = System((Body(1.0, 1.0), Body(1.0, 1.0)), forces=springs[:1])
    made = Assembled(system, jnp.zeros(6), jnp.zeros(6), (tip, pin, Buffer(springs[1])))
    drawing = assembled_drawing(made, ("ball", "box"))
    discs = {(shape.centre, shape.radius, shape.filled) for shape in drawing.shapes if isinstance(shape, Disc)}
    assert discs == {(Spot(0, 0.1, 0.2), 0.02, True), (Spot(1), 0.01, True), (Spot(GROUND, 1.3, 2.0), 0.011, False)}
    lines = [shape for shape in drawing.shapes if isinstance(shape, Outline)]
    assert [(line.body, line.part) for line in lines] == [(0, "ball"), (0, ""), (1, "box"), (1, ""), (1, ""), (1, "")]
    np.testing.assert_allclose([line.corners for line in lines[-2:]], [[[0, 0], [0.5, 0]], [[1, 2], [1, 2.5]]])
    ends = [(shape.first, shape.second) for shape in drawing.shapes if isinstance(shape, Spring)]
    assert ends == [(Spot(0, 0.0, 1.0), Spot(1)), (Spot(GROUND), Spot(1, 0.5))]
    assert [touch.side for touch in drawing.touches] == [1.0, -1.0, 1.0]
