"""What an assembled mechanism is refused for: joints that hold one motion more than once, named with their bodies."""

import jax.numpy as jnp
import pytest

import jaxbuffer as jb
from jaxbuffer.fields import POSITIVE, Part, number
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Defaults, Mechanism
from jaxbuffer.mechanisms.quantity import END_TIME
from jaxbuffer.multibody import GROUND, Body, FixedAngle, PointOnLine, Prismatic, Revolute, System, Weld
from registration import registered

# A rod on a hinge in the origin and a second one at its end, at rest at some angles.
HINGES = (Revolute(GROUND, 0, (0.0, 0.0), (-0.5, 0.0)), Revolute(0, 1, (0.5, 0.0), (-0.5, 0.0)))
GUIDE = Prismatic(GROUND, 0)
REDUNDANT = {
    "a guide twice": ((GUIDE, GUIDE), (0, 1), 2),
    "two guides in one line": ((GUIDE, Prismatic(GROUND, 0, (1.0, 0.0), (0.3, 0.0))), (0, 1), 2),
    "a hinge within a weld": (
        (Weld(GROUND, 0), FixedAngle(1, 0), Revolute(GROUND, 0, (0.2, 0.0), (0.2, 0.0))),
        (0, 2),
        2,
    ),
    "an angle in a ring": ((FixedAngle(GROUND, 0), FixedAngle(0, 1), FixedAngle(1, GROUND)), (0, 1, 2), 1),
}
ENOUGH = {
    "hinges": HINGES,
    "a guide and a point on its line": (GUIDE, PointOnLine(GROUND, 1)),
    "as many as coordinates": (Weld(GROUND, 0), Weld(GROUND, 1)),
}


def assembled(joints):
    q = jnp.array([0.5, 0.0, 0.0, 1.5, 0.0, 0.0])
    return Assembled(System((Body(1.0, 0.1), Body(2.0, 0.3)), joints), q, jnp.zeros(6))


@pytest.mark.quick
@pytest.mark.parametrize("name", REDUNDANT)
def test_joints_that_hold_one_motion_twice_are_named(name):
    joints, places, superfluous = REDUNDANT[name]
    with pytest.raises(jb.InputError) as error:
        assembled(joints)
    named = [f"{type(joint).__name__} joints[{k}]" in str(error.value) for k, joint in enumerate(joints)]
    assert named == [k in places for k in range(len(joints))]
    assert f"constraints {superfluous} can be left out" in str(error.value) and "(ground, body 0)" in str(error.value)


@pytest.mark.quick
@pytest.mark.parametrize("name", ENOUGH)
def test_joints_that_hold_each_motion_once_are_accepted(name):
    assert assembled(ENOUGH[name]).system.joints == ENOUGH[name]


class Carriage(Part):
    section = "carriage"
    mass: float = number(0.2, "kg", **POSITIVE)


class Slide(Part):
    carriage: Carriage = Carriage()


class Push(Part):
    section = "scenario"
    speed: float = number(0.3, "m/s", **POSITIVE)


def slide(design, scenario, stabilisation=20.0):
    system = System((Body(design.carriage.mass, 1e-4),), (GUIDE, GUIDE), (), stabilisation)
    return Assembled(system, jnp.zeros(3), jnp.stack([jnp.asarray(scenario.speed), *jnp.zeros(2)]))


def test_a_run_and_a_sweep_of_such_joints_say_so():
    """Inside a compiled program no number is known: failed runs are assembled from numbers."""
    with registered(Mechanism("slide", Slide, Push, {"end_time": END_TIME}, slide, defaults=Defaults(duration=0.1))):
        for call in (lambda: jb.simulate(Slide(), Push()), lambda: jb.sweep(Slide(), Push(speed=[0.1, 0.2]), 0.1)):
            with pytest.raises(
                jb.InputError, match=r"Prismatic joints\[0\] \(ground, body 0\) and Prismatic joints\[1\]"
            ):
                call()
