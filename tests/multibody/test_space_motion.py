"""Mechanisms in space integrated: a heavy top, and a chain of universal joints against minimal coordinates."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from jaxbuffer.multibody import GROUND, AppliedForce, AxialSpringDamper, Body, Prismatic, Spherical, System, Universal
from jaxbuffer.space import SPACE
from multibody.spatial import energies, integrate, momenta, rotations

GRAVITY = 9.81  # m/s²


class Top:
    """A symmetric top on a point below its centre; ``tilt`` of its axis z from the vertical."""

    mass, arm, across, along = 0.8, 0.12, 0.003, 0.0015  # kg, m, kg m² about the centre
    tilt, spin, precession = 0.6, 150.0, 2.0  # rad, rad/s about the axis, and about the vertical

    @property
    def about_point(self):
        return self.across + self.mass * self.arm**2

    def system(self):
        bodies = (Body(self.mass, (self.across, self.across, self.along)),)
        joints = (Spherical(GROUND, 0, second_point=(0.0, 0.0, -self.arm)),)
        return System(bodies, joints, (AppliedForce(0, (0.0, 0.0, -self.mass * GRAVITY)),), basis=SPACE)

    def start(self):
        turn = Rotation.from_euler("y", self.tilt)
        axis = turn.apply([0.0, 0.0, 1.0])
        spin = self.spin * axis + np.array([0.0, 0.0, self.precession])
        velocity = np.cross(spin, self.arm * axis)
        return [*(self.arm * axis), *turn.as_quat(scalar_first=True)], [*velocity, *spin]

    def euler_angles(self, times):
        """Tilt and azimuth of the axis by the two cyclic momenta (Goldstein, Classical Mechanics, 5.7), by SciPy."""
        inertia, cos = self.about_point, np.cos(self.tilt)
        own = self.along * (self.spin + self.precession * cos)
        vertical = inertia * np.sin(self.tilt) ** 2 * self.precession + own * cos

        def rates(_, y):
            c, s = np.cos(y[0]), np.sin(y[0])
            precession = (vertical - own * c) / (inertia * s**2)
            push = -precession * (own - vertical * c) / s + self.mass * GRAVITY * self.arm * s
            return [y[1], push / inertia, precession]

        start = [self.tilt, 0.0, 0.0]
        y = solve_ivp(rates, (0.0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-13).y
        return y[0], y[2]


def test_a_heavy_top_nutates_and_precesses():
    top, times = Top(), np.linspace(0.0, 2.0, 41)
    system = top.system()
    q, v = integrate(system, *top.start(), times)
    tilt, azimuth = top.euler_angles(times)
    assert np.ptp(tilt) > 0.03 and azimuth[-1] > np.pi / 2
    axis = np.stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)], axis=1)
    np.testing.assert_allclose(rotations(q, 0).apply([0.0, 0.0, 1.0]), axis, atol=1e-9)
    total = energies(system, q, v)
    np.testing.assert_allclose(total, total[0], rtol=1e-10)
    vertical = momenta(system, q, v)[1][:, 2]
    np.testing.assert_allclose(vertical, vertical[0], rtol=1e-10)
    own = np.sum(rotations(q, 0).apply([0.0, 0.0, 1.0]) * np.asarray(v)[:, 3:], axis=1)
    np.testing.assert_allclose(own, own[0], rtol=1e-10)


# Two rods that hang on each other by universal joints: masses, moments and half lengths.
MASSES, MOMENTS, HALVES = (1.1, 0.7), ((0.02, 0.11, 0.13), (0.015, 0.06, 0.07)), (0.5, 0.35)
ANGLES, RATES = (0.4, -0.3, 0.5, 0.8), (1.0, -2.0, 1.5, 3.0)


def chain(masses=MASSES):
    """Rods along their x, each on a cross with an axis y before it and an axis z behind it."""
    joints = (
        Universal(GROUND, 0, second_point=(-HALVES[0], 0.0, 0.0)),
        Universal(0, 1, (HALVES[0], 0.0, 0.0), (-HALVES[1], 0.0, 0.0)),
    )
    weights = tuple(AppliedForce(k, (0.0, 0.0, -GRAVITY * mass)) for k, mass in enumerate(masses))
    bodies = tuple(Body(mass, moments) for mass, moments in zip(masses, MOMENTS, strict=True))
    return System(bodies, joints, weights, basis=SPACE)


def about(axis, angle):
    """A rotation matrix about y or z."""
    c, s = jnp.cos(angle), jnp.sin(angle)
    if axis == "y":
        return jnp.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    return jnp.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def poses(angles):
    """Centres and rotation matrices of the rods by the angles of both crosses."""
    first = about("y", angles[0]) @ about("z", angles[1])
    second = first @ about("y", angles[2]) @ about("z", angles[3])
    middle = 2 * HALVES[0] * first[:, 0]
    return (HALVES[0] * first[:, 0], middle + HALVES[1] * second[:, 0]), (first, second)


@jax.jit
def lagrange(angles, rates):
    """The second rates of the angles: Lagrange's equations, with energies of the matrices' rates."""

    def lagrangian(angles, rates):
        (centres, _), (speeds, turnings) = jax.jvp(poses, (angles,), (rates,))
        total = 0.0
        for mass, moments, x, u, w in zip(MASSES, MOMENTS, centres, speeds, turnings, strict=True):
            # Σ m s sᵀ of the body, of which ½ tr(Ṙ S Ṙᵀ) is the energy of turning
            second = jnp.diag(jnp.sum(jnp.array(moments)) / 2 - jnp.array(moments))
            total = total + 0.5 * mass * u @ u + 0.5 * jnp.trace(w @ second @ w.T) - mass * GRAVITY * x[2]
        return total

    mass = jax.hessian(lagrangian, 1)(angles, rates)
    momentum = jax.grad(lagrangian, 1)
    moved = jax.jvp(lambda angles: momentum(angles, rates), (angles,), (rates,))[1]
    return jnp.linalg.solve(mass, jax.grad(lagrangian)(angles, rates) - moved)


def chain_start():
    """Positions and velocities of the chain at its first angles and rates."""
    (centres, turns), (speeds, turnings) = jax.jvp(poses, (jnp.array(ANGLES),), (jnp.array(RATES),))
    q, v = [], []
    for x, r, u, w in zip(centres, turns, speeds, turnings, strict=True):
        spin = np.asarray(w @ r.T)
        q += [*np.asarray(x), *Rotation.from_matrix(np.array(r)).as_quat(scalar_first=True)]
        v += [*np.asarray(u), spin[2, 1], spin[0, 2], spin[1, 0]]
    return jnp.asarray(q), jnp.asarray(v)


@pytest.mark.slow
def test_universal_joints_against_minimal_coordinates():
    times, system = np.linspace(0.0, 3.0, 31), chain()
    q, v = integrate(system, *chain_start(), times)

    def rates(_, y):
        return np.concatenate([y[4:], lagrange(y[:4], y[4:])])

    start = np.array([*ANGLES, *RATES])
    angles = solve_ivp(rates, (0.0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-13).y[:4].T
    centres, turns = jax.vmap(poses)(jnp.asarray(angles))
    for k in range(2):
        np.testing.assert_allclose(q[:, 7 * k : 7 * k + 3], centres[k], atol=1e-9)
        np.testing.assert_allclose(rotations(q, k).as_matrix(), turns[k], atol=1e-9)
    total = energies(system, q, v)
    np.testing.assert_allclose(total, total[0], atol=1e-10 * np.ptp([0.0, *total]))


@pytest.mark.slow
def test_free_bodies_on_a_slide_keep_momentum_and_energy():
    """A probe that slides in a body without turning, on a spring; nothing holds the two: both momenta as vectors."""
    joints = (Prismatic(0, 1, (0.3, 0.0, 0.0), (-0.4, 0.0, 0.0)),)
    spring = AxialSpringDamper(0, 1, (0.3, 0.0, 0.0), (-0.4, 0.0, 0.0), 60.0, 0.0, 0.0, guide=(1.0, 0.0, 0.0))
    bodies = Body(2.0, (0.05, 0.2, 0.3)), Body(0.6, (0.01, 0.08, 0.07))
    system, times = System(bodies, joints, (spring,), basis=SPACE), np.linspace(0.0, 2.0, 21)
    turn = Rotation.from_rotvec([0.3, 0.5, -0.2])
    spin, along = np.array([2.0, -1.0, 1.5]), turn.apply([1.0, 0.0, 0.0])
    speed, quaternion = np.array([0.1, 0.2, -0.3]), turn.as_quat(scalar_first=True)
    sliding = speed + np.cross(spin, 0.75 * along) + 0.4 * along
    q, v = integrate(
        system, [0.0, 0.0, 0.0, *quaternion, *(0.75 * along), *quaternion], [*speed, *spin, *sliding, *spin], times
    )
    total = energies(system, q, v)
    np.testing.assert_allclose(total, total[0], rtol=1e-10)
    for momentum in momenta(system, q, v):
        np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-10)
    stroke = np.sum(rotations(q, 0).apply([1.0, 0.0, 0.0]) * np.asarray(q[:, 7:10] - q[:, :3]), axis=1)
    assert np.ptp(stroke) > 0.05
