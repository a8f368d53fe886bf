"""Joints in space: their rows by automatic differentiation of Φ alone, and the geometry that they hold."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from in_short import quick
from jaxbuffer import InputError
from jaxbuffer.multibody import (
    GROUND,
    AppliedForce,
    AxialSpringDamper,
    Body,
    ConstantSpeed,
    DrivenAngle,
    FixedAngle,
    PointOnLine,
    Prismatic,
    Revolute,
    Spherical,
    System,
    Universal,
    Weld,
    assemble,
)
from jaxbuffer.plane import PLANE
from jaxbuffer.space import SPACE
from multibody.particles import random_body
from multibody.spatial import momenta, random_positions, random_velocities, rotations

A, B = (0.31, -0.12, 0.25), (-0.45, 0.27, 0.08)
AXIS = (2 / 7, 3 / 7, -6 / 7)
NORMAL, BINORMAL = (0.6, 0.8, 0.0), (0.0, 0.0, 1.0)
TURN = (0.3, -0.5, 0.2)
# by joint, its rows and what is left of six freedoms
JOINTS = {
    "spherical": (lambda i, j: Spherical(i, j, A, B), 3),
    "revolute": (lambda i, j: Revolute(i, j, A, B, AXIS), 5),
    "revolute about z": (lambda i, j: Revolute(i, j, A, B), 5),
    "universal": (lambda i, j: Universal(i, j, A, B, (0.0, 1.0, 0.0), AXIS), 4),
    "fixed angle": (lambda i, j: FixedAngle(i, j, TURN), 3),
    "point on line": (lambda i, j: PointOnLine(i, j, A, B, NORMAL, BINORMAL), 2),
    "prismatic": (lambda i, j: Prismatic(i, j, A, B, NORMAL, 0.0, BINORMAL), 5),
    "turned prismatic": (lambda i, j: Prismatic(i, j, A, B, NORMAL, TURN, BINORMAL), 5),
    "weld": (lambda i, j: Weld(i, j, A, B, TURN), 6),
}
BODIES = {"both bodies": (0, 1), "ground second": (0, GROUND)}
PAIR = (Body(1.0, (0.1, 0.2, 0.25)), Body(2.0, (0.3, 0.25, 0.4)))

each_joint = pytest.mark.parametrize("joint", JOINTS)
each_pair = pytest.mark.parametrize("pair", quick(BODIES, "both bodies"))


def jointed(joint, pair, **others):
    return System(PAIR, (JOINTS[joint][0](*BODIES[pair]),), basis=SPACE, **others)


@each_joint
@each_pair
def test_rows_are_derivatives_of_the_constraint(joint, pair):
    """Φ_q v is the rate of Φ along q̇ = N(q) v, and γ what of its second rate is without accelerations."""
    system, q, v = jointed(joint, pair), random_positions(1, 2), random_velocities(1, 2)

    def phi(q):
        return system.errors(system.kinematics(q, v))

    def rate(q):
        return jax.jvp(phi, (q,), (system.position_rate(q).of(v),))[1]

    found = system.constraints(system.kinematics(q, v))
    assert found.phi.shape == (JOINTS[joint][1],)
    column = lambda unit: jax.jvp(phi, (q,), (system.position_rate(q).of(unit),))[1]  # noqa: E731
    np.testing.assert_allclose(found.jacobian, jax.vmap(column, out_axes=1)(jnp.eye(12)), atol=1e-14)
    np.testing.assert_allclose(found.gamma, -jax.jvp(rate, (q,), (system.position_rate(q).of(v),))[1], atol=2e-13)
    assert np.linalg.matrix_rank(found.jacobian) == JOINTS[joint][1]


def geometry(q, pair):
    """Points A and B, and the rotations of both bodies, by SciPy."""
    found = []
    for body, point in zip(BODIES[pair], (A, B), strict=True):
        still = body == GROUND
        turn = Rotation.identity() if still else rotations(q, body)
        place = np.zeros(3) if still else np.asarray(q)[7 * body : 7 * body + 3]
        found += [place + turn.apply(point), turn]
    return found


@pytest.mark.parametrize("joint", quick(JOINTS, "universal", "point on line"))
@each_pair
def test_an_assembled_joint_holds_its_geometry(joint, pair):
    """From a start that is off by some 0.1 m and 0.1 rad; the velocities fit too."""
    system = jointed(joint, pair)
    near = near_assembly(pair)
    q, v = assemble(system, near, random_velocities(2, 2))
    found = system.constraints(system.kinematics(q, v))
    np.testing.assert_allclose(found.phi, 0.0, atol=1e-14)
    np.testing.assert_allclose(found.jacobian @ v, 0.0, atol=1e-13)
    a, turn_i, b, turn_j = geometry(q, pair)
    line = np.cross(NORMAL, BINORMAL)
    relative = (turn_j.inv() * turn_i).as_rotvec()
    off = turn_i.inv().apply(b - a)
    along_line = np.cross(off, line)
    expected = {
        "spherical": [off],
        "revolute": [off, turn_i.apply(AXIS) - turn_j.apply(AXIS)],
        "revolute about z": [off, turn_i.apply([0, 0, 1]) - turn_j.apply([0, 0, 1])],
        "universal": [off, turn_i.apply([0, 1, 0]) @ turn_j.apply(AXIS)],
        "fixed angle": [relative - TURN],
        "point on line": [along_line],
        "prismatic": [relative, along_line],
        "turned prismatic": [relative - TURN, along_line],
        "weld": [off, relative - TURN],
    }[joint]
    for zero in expected:
        np.testing.assert_allclose(zero, 0.0, atol=1e-13)
    if joint in ("prismatic", "turned prismatic", "point on line"):
        assert np.linalg.norm(off) > 1e-3


def near_assembly(pair):
    """Both bodies about where a weld would hold them."""
    rng = np.random.default_rng(5)
    first, second = Rotation.from_rotvec([0.4, -0.2, 0.7]), Rotation.from_rotvec([0.4, -0.2, 0.7])
    if GROUND in BODIES[pair]:
        first = second = Rotation.identity()
    first = first * Rotation.from_rotvec(TURN) * Rotation.from_rotvec(0.1 * rng.normal(size=3))
    places = [0.1 * rng.normal(size=3), first.apply(A) - second.apply(B) + 0.1 * rng.normal(size=3)]
    parts = [[*place, *turn.as_quat(scalar_first=True)] for place, turn in zip(places, (first, second), strict=True)]
    return jnp.asarray(np.concatenate(parts))


def planar_system(basis, inertia):
    """Every joint of the plane, a spring and a weight."""
    bodies = tuple(Body(m, inertia(i)) for m, i in ((1.3, 0.2), (0.7, 0.05), (0.9, 0.3), (0.4, 0.1)))
    joints = (
        Revolute(GROUND, 0, (0.1, 0.2), (-0.3, 0.05)),
        Prismatic(0, 1, (0.2, 0.1), (0.0, -0.1), (0.6, 0.8), 0.3),
        PointOnLine(1, 2, (0.1, 0.0), (0.2, 0.3), (0.8, -0.6)),
        Weld(2, 3, (0.3, 0.1), (-0.2, 0.0), -0.4),
    )
    forces = (
        AxialSpringDamper(0, 2, (0.2, -0.1), (0.1, 0.3), 70.0, 3.0, 0.4),
        AxialSpringDamper(1, 3, (0.2, -0.1), (0.1, 0.3), 40.0, 2.0, 0.3, guide=(0.6, 0.8)),
        AppliedForce(2, (0.7, -3.0), (0.1, 0.2)),
    )
    return System(bodies, joints, forces, basis=basis)


def in_space(q, v):
    """The same motion in space."""
    parts = [
        [x, y, 0.0, np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)] for x, y, angle in np.asarray(q).reshape(-1, 3)
    ]
    velocities = [[x, y, 0.0, 0.0, 0.0, spin] for x, y, spin in np.asarray(v).reshape(-1, 3)]
    return jnp.asarray(np.concatenate(parts)), jnp.asarray(np.concatenate(velocities))


def test_a_planar_mechanism_moves_in_space_as_in_the_plane():
    """The same joints, forces and points: accelerations, energy and momenta are the plane's, and nothing leaves it."""
    rng = np.random.default_rng(3)
    plane = planar_system(PLANE, lambda i: i)
    space = planar_system(SPACE, lambda i: (0.6 * i, 0.7 * i, i))
    q, v = assemble(plane, jnp.asarray(rng.normal(size=12)), jnp.asarray(rng.normal(size=12)), iterations=20)
    here, there = plane.kinematics(q, v), space.kinematics(*in_space(q, v))
    np.testing.assert_allclose(plane.errors(here), 0.0, atol=1e-13)
    np.testing.assert_allclose(space.errors(there), 0.0, atol=1e-13)
    _, expected = in_space(q, plane.motion(here).acceleration)
    np.testing.assert_allclose(space.motion(there).acceleration, expected, rtol=1e-11, atol=1e-11)
    for energy in ("kinetic_energy", "stored_energy", "dissipation"):
        np.testing.assert_allclose(getattr(space, energy)(there), getattr(plane, energy)(here), rtol=1e-13)
    np.testing.assert_allclose(space.linear_momentum(there)[:2], plane.linear_momentum(here), rtol=1e-13)
    np.testing.assert_allclose(space.angular_momentum(there), [0, 0, plane.angular_momentum(here)], rtol=1e-13)


def test_momenta_and_energy_by_particles():
    """Of six particles on the axes of each body, which have its mass and its moments."""
    system, q, v = System(PAIR, basis=SPACE), random_positions(4, 2), random_velocities(4, 2)
    linear, angular, kinetic = np.zeros(3), np.zeros(3), 0.0
    for k, body in enumerate(PAIR):
        x, y, z = body.inertia
        # Σ m s² along each axis, by two particles of a sixth of the mass each
        spread = np.sqrt(np.array([y + z - x, z + x - y, x + y - z]) / 2 / (body.mass / 3))
        turn, velocity = rotations(q, k), np.asarray(v[6 * k : 6 * k + 6])
        for axis in np.eye(3):
            for side in (1.0, -1.0):
                arm = turn.apply(side * spread * axis)
                speed = velocity[:3] + np.cross(velocity[3:], arm)
                linear += body.mass / 6 * speed
                angular += body.mass / 6 * np.cross(np.asarray(q[7 * k : 7 * k + 3]) + arm, speed)
                kinetic += body.mass / 12 * speed @ speed
    found = momenta(system, q[None], v[None])
    np.testing.assert_allclose(found[0][0], linear, rtol=1e-13)
    np.testing.assert_allclose(found[1][0], angular, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(system.kinetic_energy(system.kinematics(q, v)), kinetic, rtol=1e-13)


@pytest.mark.parametrize(
    ("inertia", "words"),
    [
        (0.3, r"body 1: inertia = 0\.3: in space give \(x, y, z\), its principal moments"),
        ((0.0, 0.2, 0.2), r"moments must be above 0 kg m²; give a slender rod a share of that of the body"),
    ],
)
def test_what_is_no_inertia_in_space_is_said(inertia, words):
    with pytest.raises(InputError, match=words):
        System((PAIR[0], Body(1.0, inertia)), basis=SPACE)


def test_what_takes_an_angle_is_refused_in_space():
    system = System(PAIR, (DrivenAngle(0, 1, ConstantSpeed(0.0, 1.0)),), basis=SPACE)
    with pytest.raises(InputError, match=r"takes a body's angle, which is of the plane; in space use Torsional"):
        system.errors(system.kinematics(random_positions(1, 2), random_velocities(1, 2)))


def test_flexible_bodies_are_of_the_plane():
    with pytest.raises(InputError, match="body 1 is flexible: flexible bodies are of the plane"):
        System((PAIR[0], random_body(0)), basis=SPACE)
