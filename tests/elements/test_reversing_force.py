"""A force that reverses within a step, which a step that sees nothing of it leaves nearly right and its slopes wrong.

A body that a control pushes back with its whole moment, which turns over within a millionth of the angle that the body
swings through; and a slider's pin that stays in contact while its friction reverses again and again.
"""

import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from in_short import quick
from jaxbuffer.elements import AttitudeControl, Sensor
from jaxbuffer.fields import Part, number
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Mechanism
from jaxbuffer.mechanisms.quantity import Quantity
from jaxbuffer.multibody import Body, System
from registration import registered

INERTIA, ANGLE, MOMENT, STEEP = 0.4, 0.3, 0.2, 1e6  # kg m², rad, N m, times the moment a radian
NUMBERS = ("moment", "scenario.angle")


class Pushed(Part):
    moment: float = number(MOMENT, "N m")


class Start(Part):
    section = "scenario"
    angle: float = number(ANGLE, "rad")


def beyond(kin, numbers):
    """How far the body has turned beyond zero [rad]."""
    return -kin.frames[0].angle


def pushed_body(design, scenario, stabilisation=20.0):
    """A body at rest at an angle, with a control that has no damping."""
    control = AttitudeControl(0, STEEP * design.moment, 0.0, design.moment)
    q = jnp.zeros(3).at[2].set(scenario.angle)
    elements = (control, Sensor(beyond, name="beyond"))
    return Assembled(
        System((Body(2.0, INERTIA),)), q, jnp.zeros(3), elements=elements, size=(1e-2, 1.0), energy_size=1.0
    )


QUANTITIES = {"farthest": Quantity("rad", lambda run: run.maxima["beyond"], "largest angle beyond zero")}


@pytest.fixture(scope="module")
def pushed():
    with registered(Mechanism("pushed body", Pushed, Start, QUANTITIES, pushed_body)):
        yield


@pytest.mark.parametrize("rtol", quick([1e-4, 1e-5, 1e-6], 1e-6))
def test_a_body_that_is_pushed_back_swings_as_far_beyond(pushed, rtol):
    swing = 2.0 * np.sqrt(2.0 * ANGLE * INERTIA / MOMENT)  # from rest to rest, at a constant acceleration each way
    found = jb.sensitivity(Pushed(), Start(), NUMBERS, 1.2 * swing, quantities=["farthest"], rtol=rtol, certify="none")
    np.testing.assert_allclose(found.results, ANGLE, rtol=10.0 * rtol)
    # By symmetry as far as it began, with any moment.
    np.testing.assert_allclose(found.elasticities, [[0.0, 1.0]], atol=1e-3)


@pytest.mark.slow
def test_the_friction_of_a_pin_reverses_again_and_again_in_one_contact():
    """The force of its third impact, milliseconds after it has begun, against differences of tight solves."""
    design = jb.replace(
        jb.SliderCrank(),
        {
            "crank.length": 0.18846,
            "crank.inertia": 9.378e-4,
            "rod.length": 0.47406,
            "rod.mass": 1.5854,
            "slider.mass": 0.15590,
            "piston_pin.clearance": 2.8230e-4,
            "piston_pin.restitution": 0.34174,
            "piston_pin.friction": 1.4592e-3,
        },
    )
    angle, step, number = 2.2945, 1e-4, 3

    def start(angle):
        return jb.SliderCrankScenario(crank_speed=339.41, crank_angle=angle)

    def force(angle):
        run = jb.simulate(design, start(angle), 0.01, rtol=1e-10)
        assert int(run.impacts.count) == number
        return float(run.impacts.peak_force[number - 1])

    quantity = f"impact.{number}.peak_force"
    found = jb.sensitivity(design, start(angle), ["scenario.crank_angle"], 0.01, quantities=[quantity], certify="none")
    near, far = ((force(angle + h) - force(angle - h)) / (2.0 * h) for h in (step, 2.0 * step))
    np.testing.assert_allclose(found.results, force(angle), rtol=1e-6)
    np.testing.assert_allclose(found.gradients, (4.0 * near - far) / 3.0, rtol=1e-3)
