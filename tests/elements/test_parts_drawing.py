"""The picture of a mechanism that has none of its own is that of its parts."""

import types

import jax.numpy as jnp
import numpy as np

from jaxbuffer.contact import BallPair, Hole, KelvinVoigt, RegularisedCoulomb, Segment
from jaxbuffer.contact.laws import Hertz
from jaxbuffer.elements import BallContact, Buffer, EndStop, Latch
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.drawing import Disc, Outline, Spot, Spring
from jaxbuffer.mechanisms.parts_drawing import assembled_drawing
from jaxbuffer.multibody import GROUND, AxialSpringDamper, Body, Prismatic, Revolute, System
from jaxbuffer.output.sketch import bounds, fills

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
    # Crosses stand in front of the balls, which would hide them.
    assert [(line.body, line.part) for line in lines] == [(1, ""), (1, ""), (0, "ball"), (0, ""), (1, "box"), (1, "")]
    np.testing.assert_allclose([line.corners for line in lines[:2]], [[[0, 0], [0.5, 0]], [[1, 2], [1, 2.5]]])
    assert not any(line.endless for line in lines)
    ends = [(shape.first, shape.second) for shape in drawing.shapes if isinstance(shape, Spring)]
    assert ends == [(Spot(0, 0.0, 1.0), Spot(1)), (Spot(GROUND), Spot(1, 0.5))]
    assert [touch.side for touch in drawing.touches] == [1.0, -1.0, 1.0]


def test_end_stops_and_latches_where_they_begin():
    spring = AxialSpringDamper(GROUND, 0, (1.0, 0.0), (0.0, 0.0), 200.0, 0.0, free_length=1.0)
    elements = (
        Buffer(spring),
        EndStop(spring, KelvinVoigt(1e4, 0.0), place=0.03),
        EndStop(spring, KelvinVoigt(1e4, 0.0), place=0.01, rebound=True, name="rebound_stop"),
        Latch(0, GROUND, (0.0, 0.0), plane=0.031, seat=(0.028, 0.0), stiffness=5e3),
    )
    system = System((Body(2.0, 1.0),), (Prismatic(GROUND, 0),))
    drawing = assembled_drawing(Assembled(system, jnp.zeros(3), jnp.zeros(3), elements=elements))
    history = types.SimpleNamespace(position=np.array([[[0.0, 0.0, 0.0]], [[0.03, 0.0, 0.0]]]))
    frames = drawing.frames(history)
    # The body has run 30 mm in where the end stop begins, and 10 mm out where the rebound stop does, wherever it is.
    np.testing.assert_allclose(frames[:, 1:, 0], [[0.03, -0.01]] * 2, atol=1e-15)
    lines = {shape.part: shape for shape in drawing.shapes if isinstance(shape, Outline) and shape.part}
    assert [lines[name].body for name in ("body 1", "end stop", "rebound stop")] == [0, 1, 2]
    assert np.all(lines["plane of the latch"].corners[:, 0] == 0.031)
    assert [shape.centre for shape in drawing.shapes if isinstance(shape, Disc)] == [Spot(GROUND, 0.028), Spot(0)]
    # Of a metre 30 mm are hardly seen, so that there is a closer look.
    assert drawing.detail.title == "end stop" and drawing.detail.centre == Spot(1) and drawing.detail.half == 0.06


def test_a_hinge_with_the_line_to_its_body():
    swing = System((Body(1.0, 1.0),), (Revolute(GROUND, 0, second_point=(0.0, 0.5)),))
    drawing = assembled_drawing(Assembled(swing, jnp.array([0.0, -0.5, 0.0]), jnp.zeros(3)), ("rod",))
    (hinge,) = (shape for shape in drawing.shapes if isinstance(shape, Disc))
    assert hinge.centre == Spot(GROUND) and not hinge.filled
    lines = [shape for shape in drawing.shapes if isinstance(shape, Outline) and shape.body == 0]
    np.testing.assert_allclose(lines[-1].corners, [[0.0, 0.0], [0.0, 0.5]])
    assert drawing.detail is None


def test_a_picture_is_taken_when_a_latch_is_closed_and_a_stop_is_pressed_most():
    spring = AxialSpringDamper(GROUND, 0, (1.0, 0.0), (0.0, 0.0), 200.0, 0.0, free_length=1.0)
    run = types.SimpleNamespace(
        mechanism=types.SimpleNamespace(quantities={}),
        maximum_times={"stop_force": 0.15},
        switch_times={"latch": 0.1, "latch closed": 0.4},
    )
    assert EndStop(spring, KelvinVoigt(1e4, 0.0), place=0.03).report.moments(run) == {"end stop pressed most": 0.15}
    slow, fast = (Latch(0, GROUND, (0.0, 0.0), 0.031, (0.028, 0.0), 5e3, closing_time=time) for time in (0.3, 0.0))
    assert slow.report.moments(run) == {"latch closed": 0.4} and fast.report.moments(run) == {"latch closed": 0.1}
    run.switch_times = {"latch": 0.1}  # the run ends while it closes
    assert np.isnan(slow.report.moments(run)["latch closed"])


def test_a_flank_of_arrays_with_one_entry_is_drawn_as_one_of_numbers():
    numbers = (0.02, -1.0, 0.0, 1.0, 2.0)
    drawn = []
    for given in (numbers, [np.array([it]) for it in numbers], [jnp.array([it]) for it in numbers]):
        pair = BallPair(0.02, Segment(*given), -1.0, Hertz(1.0), SMOOTH)
        made = Assembled(System((Body(1.0, 1.0),)), jnp.zeros(3), jnp.zeros(3), (BallContact(0, GROUND, pair),))
        drawn.append([shape.corners for shape in assembled_drawing(made).shapes if isinstance(shape, Outline)][-1])
    assert np.array_equal(drawn[1], drawn[0]) and np.array_equal(drawn[2], drawn[0])


def test_a_flank_longer_than_the_mechanism_is_seen_where_it_is_touched():
    """A ball of 20 mm on an anvil of 2 m: the picture is as wide as the ball, and reaches down to the anvil."""
    anvil = BallPair(0.02, Segment(-1.0, 0.0, 1.0, 0.0, 2.0), -1.0, Hertz(1.0), SMOOTH)
    system = System((Body(1.0, 1.0),), (Prismatic(GROUND, 0, normal=(1.0, 0.0)),))
    made = Assembled(system, jnp.array([0.1, 0.3, 0.0]), jnp.zeros(3), (BallContact(0, GROUND, anvil),))
    drawing = assembled_drawing(made, ("ball",))
    (line,) = (shape for shape in drawing.shapes if isinstance(shape, Outline) and shape.body == GROUND)
    assert line.endless
    np.testing.assert_allclose(bounds(drawing, np.array([[0.1, 0.3, 0.0]])), [[0.08, 0.0], [0.12, 0.32]], atol=1e-12)


def test_no_two_of_seven_lines_have_one_colour():
    lines = [Outline(0, np.zeros((2, 2)), filled=False, part=str(k)) for k in range(7)]
    assert len(set(fills(lines).values())) == 7
