"""Joints, force elements and contacts at markers of flexible bodies, against geometry and automatic differentiation."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.multibody import (
    GROUND,
    AppliedForce,
    AppliedTorque,
    AxialSpringDamper,
    Body,
    ConstantSpeed,
    DrivenAngle,
    FixedAngle,
    PointOnLine,
    Prismatic,
    Revolute,
    System,
    TorsionalSpringDamper,
    Weld,
)
from multibody.particles import random_body, random_marker

NORMAL = (np.sin(0.7), np.cos(0.7))
SIZES = (3, 0, 2)  # modes of the three bodies
MARKERS = {0: random_marker(0, 3), 2: random_marker(2, 2), 1: (0.31, -0.12), GROUND: (-0.45, 0.27)}
JOINTS = {
    "revolute": Revolute,
    "fixed angle": lambda i, j, a, b: FixedAngle(i, j, 0.4, a, b),
    "point on line": lambda i, j, a, b: PointOnLine(i, j, a, b, NORMAL),
    "prismatic": lambda i, j, a, b: Prismatic(i, j, a, b, NORMAL, 0.4),
    "weld": lambda i, j, a, b: Weld(i, j, a, b, 0.4),
    "driven angle": lambda i, j, a, b: DrivenAngle(i, j, ConstantSpeed(-0.4, 2.0), a, b),
}
PAIRS = {
    "flexible first": (0, 1),
    "flexible second": (1, 0),
    "both flexible": (0, 2),
    "both flexible, swapped": (2, 0),
    "flexible and ground": (0, GROUND),
    "ground and flexible": (GROUND, 2),
}
each_joint = pytest.mark.parametrize("joint", JOINTS)
each_pair = pytest.mark.parametrize("pair", PAIRS)


def bodies():
    return random_body(0, 3), Body(1.0, 0.1), random_body(2, 2)


def random_motion(seed):
    rng = np.random.default_rng(seed)
    return jnp.asarray(rng.normal(size=14)), jnp.asarray(rng.normal(size=14))


def jointed(joint, pair):
    i, j = PAIRS[pair]
    return System(bodies(), (JOINTS[joint](i, j, MARKERS[i], MARKERS[j]),))


def pose(q, body):
    """Place and angle of a body's point, from the coordinates alone."""
    q, point = np.asarray(q), MARKERS[body]
    if body == GROUND:
        return np.array(point), 0.0
    x, y, angle = q[3 * body : 3 * body + 3]
    local, turned = np.array(point if body == 1 else (point.x, point.y)), 0.0
    if body != 1:
        modal = q[9:12] if body == 0 else q[12:14]
        local = local + np.array([np.dot(point.displacement_x, modal), np.dot(point.displacement_y, modal)])
        turned = np.dot(point.rotation, modal)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return np.array([x, y]) + turn @ local, angle + turned


@pytest.mark.quick
@each_joint
@each_pair
def test_constraint_is_the_stated_geometry(joint, pair):
    q, v = random_motion(1)
    system = jointed(joint, pair)
    (place_i, angle_i), (place_j, angle_j) = (pose(q, body) for body in PAIRS[pair])
    apart, angle = place_i - place_j, angle_i - angle_j - 0.4
    cos, sin = np.cos(angle_i), np.sin(angle_i)
    across = -np.array([cos * NORMAL[0] - sin * NORMAL[1], sin * NORMAL[0] + cos * NORMAL[1]]) @ apart
    expected = {
        "revolute": apart,
        "fixed angle": [angle],
        "point on line": [across],
        "prismatic": [angle, across],
        "weld": [*apart, angle],
        "driven angle": [-angle],
    }[joint]
    np.testing.assert_allclose(system.errors(system.kinematics(q, v)), expected, atol=1e-14)


@each_joint
@each_pair
def test_jacobian_and_gamma_are_derivatives_of_the_constraint(joint, pair):
    """Φ_q by differentiation, and γ = -(Φ_q q̇)_q q̇ from two push-forwards of Φ."""
    q, v = random_motion(2)
    system = jointed(joint, pair)

    def phi(q):
        return system.errors(system.kinematics(q, v))

    def rate(q):
        return jax.jvp(phi, (q,), (v,))[1]

    found = system.constraints(system.kinematics(q, v))
    np.testing.assert_allclose(found.jacobian, jax.jacfwd(phi)(q), atol=1e-14)
    np.testing.assert_allclose(found.gamma, -jax.jvp(rate, (q,), (v,))[1], atol=5e-14)


@each_pair
def test_markers_move_and_turn_as_their_derivatives_say(pair):
    """Velocity, spin, acceleration at rest of all coordinates, and how speeds go with the velocities."""
    q, v = random_motion(3)
    system = jointed("weld", pair)
    body = PAIRS[pair][0]

    def place(q):
        at = system.kinematics(q, v).point(body, MARKERS[body])
        return jnp.stack([at.place.x, at.place.y, jnp.asarray(at.angle, float)])

    at = system.kinematics(q, v).point(body, MARKERS[body])
    _, moving = jax.jvp(place, (q,), (v,))
    np.testing.assert_allclose(jnp.stack([at.velocity.x, at.velocity.y, jnp.asarray(at.spin)]), moving, atol=1e-14)
    _, quadratic = jax.jvp(lambda q: jax.jvp(place, (q,), (v,))[1], (q,), (v,))
    np.testing.assert_allclose([at.quadratic.x, at.quadratic.y, 0.0], quadratic, atol=5e-14)
    np.testing.assert_allclose([at.cos, at.sin], [np.cos(at.angle), np.sin(at.angle)], atol=1e-15)


def axial(i, j, damping=0.0, guide=None):
    return AxialSpringDamper(i, j, MARKERS[i], MARKERS[j], 170.0, damping, 0.6, guide=guide)


def torsional(i, j, damping=0.0):
    return TorsionalSpringDamper(i, j, 23.0, damping, 0.7, MARKERS[i], MARKERS[j])


def flexible_of(i, j):
    return 0 if 0 in (i, j) else 2


ELEMENTS = {
    "axial": axial,
    "torsional": torsional,
    "applied force": lambda i, j: AppliedForce(k := flexible_of(i, j), (3.0, -5.0), MARKERS[k]),
    "applied torque": lambda i, j: AppliedTorque(k := flexible_of(i, j), -1.7, MARKERS[k]),
}


@pytest.mark.parametrize("kind", ELEMENTS)
@each_pair
def test_loads_are_minus_the_energys_gradient(kind, pair):
    """By all coordinates, the modal ones among them."""
    q, _ = random_motion(4)
    rest = jnp.zeros(14)
    element = ELEMENTS[kind](*PAIRS[pair])
    system, without = System(bodies(), (), (element,)), System(bodies())
    kin = system.kinematics(q, rest)
    found = system.generalised_force(kin) - without.generalised_force(kin)
    expected = -jax.grad(lambda q: jnp.asarray(element.energy(system.kinematics(q, rest))))(q)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-11)
    assert np.any(np.asarray(found)[9:] != 0.0)


@pytest.mark.parametrize("kind", [axial, torsional])
@each_pair
def test_a_damper_takes_the_power_that_it_reports(kind, pair):
    q, v = random_motion(5)
    element = kind(*PAIRS[pair], damping=8.0)
    system, without = System(bodies(), (), (element,)), System(bodies())
    kin = system.kinematics(q, v)
    power = jnp.sum((system.generalised_force(kin) - without.generalised_force(kin)) * v)
    stored = jax.jvp(lambda q: element.energy(system.kinematics(q, v)), (q,), (v,))[1]
    np.testing.assert_allclose(power, -stored - element.dissipation(kin), rtol=1e-11)


@pytest.mark.parametrize("kind", [axial, torsional])
@each_pair
def test_the_direction_of_a_spring_says_how_its_length_goes(kind, pair):
    """The second derivative of the energy by it is the stiffness, where the spring has no load."""
    q, v = random_motion(6)
    element = kind(*PAIRS[pair])
    system = System(bodies(), (), (element,))
    at = lambda q: element.energy(system.kinematics(q, v))  # noqa: E731
    (spring,) = element.springs(system.kinematics(q, v))
    along = system.direction(spring.blocks)
    gradient = jax.grad(at)(q)  # k (L - L0) b
    np.testing.assert_allclose(gradient, along * np.dot(gradient, along) / np.dot(along, along), atol=1e-11)
    length = np.sqrt(2.0 * float(at(q)) / float(spring.stiffness))
    np.testing.assert_allclose(np.linalg.norm(gradient), spring.stiffness * length * np.linalg.norm(along), rtol=1e-11)


def test_elastic_forces_are_minus_the_stored_energys_gradient():
    q, _ = random_motion(7)
    system, rest = System(bodies()), jnp.zeros(14)
    expected = -jax.grad(lambda q: system.stored_energy(system.kinematics(q, rest)))(q)
    np.testing.assert_allclose(system.generalised_force(system.kinematics(q, rest)), expected, atol=1e-12)


def test_the_weight_acts_at_the_centre_of_mass():
    """m g y of the deformed body's centre of mass, which has its linear momentum."""
    q, v = random_motion(8)
    body = bodies()[0]
    weight = AppliedForce(0, (0.0, -9.81 * float(body.mass)), body.centre_of_mass)
    system = System(bodies(), (), (weight,))
    at = system.kinematics(q, v).point(0, body.centre_of_mass)
    momentum = body.linear_momentum(system.kinematics(q, v).frame(0), *system.kinematics(q, v).modal(0))
    np.testing.assert_allclose([at.velocity.x, at.velocity.y], np.asarray(momentum) / body.mass, rtol=1e-13)


@pytest.mark.quick
def test_a_flexible_body_wants_markers():
    q, v = random_motion(9)
    system = System(bodies(), (), (AppliedForce(0, (1.0, 0.0)),))
    with pytest.raises(ValueError, match="body 0 is flexible"):
        system.motion(system.kinematics(q, v))
