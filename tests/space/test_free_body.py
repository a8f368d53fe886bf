"""A free asymmetric body: Euler's equations, and their solution by Jacobi's elliptic functions."""

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.spatial.transform import Rotation
from scipy.special import ellipj, ellipk

from jaxbuffer.plane import ldl_solve
from jaxbuffer.space import SPACE, Vector

MOMENTS = (0.8, 1.3, 1.9)  # kg m², in ascending order
TIMES = np.linspace(0.0, 20.0, 41)
NEAR_LARGEST, NEAR_SMALLEST = (0.3, 0.1, 1.4), (1.5, 0.1, 0.2)  # rad/s, in the body's axes


@jax.jit
def motion(q, v, times, moments=MOMENTS):
    """Position and velocity at ``times``; the rotation is kept by nothing but its rate."""

    def field(_, y, __):
        q, v = y
        (frame,) = SPACE.frames(q, v, 1)
        turned = ldl_solve(SPACE.inertia_block(frame, moments), SPACE.gyroscopic_moment(frame, moments))
        return SPACE.position_rate(q, 1).of(v), jnp.concatenate([jnp.zeros(3), turned])

    return diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        diffrax.Dopri8(),
        t0=0.0,
        t1=times[-1],
        dt0=1e-3,
        y0=(q, v),
        saveat=diffrax.SaveAt(ts=times),
        stepsize_controller=diffrax.PIDController(rtol=1e-13, atol=1e-13),
        adjoint=diffrax.ForwardMode(),
        max_steps=100_000,
    ).ys


def thrown(spin, seed=0):
    """Turned in some way, with a ``spin`` in the body's axes."""
    turn = Rotation.random(rng=np.random.default_rng(seed))
    q = jnp.asarray([0.3, -0.2, 0.5, *turn.as_quat(scalar_first=True)])
    return q, jnp.asarray([0.1, 0.4, -0.3, *turn.apply(spin)])


def rotations(q):
    return Rotation.from_quat(np.array(q)[:, 3:], scalar_first=True)


def local_spins(q, v):
    """The spins in the body's axes."""
    return rotations(q).inv().apply(np.array(v)[:, 3:])


def momenta(q, v):
    """The angular momentum about the centre of mass, in inertial axes."""
    return rotations(q).apply(local_spins(q, v) * MOMENTS)


@pytest.mark.parametrize("spin", [NEAR_LARGEST, NEAR_SMALLEST, (0.01, 1.2, 0.02)])
def test_the_spin_follows_eulers_equations(spin):
    """I ω̇ = I ω × ω in the body's axes, by SciPy: also about the middle axis, which tumbles."""
    q, v = motion(*thrown(spin), jnp.asarray(TIMES))
    moments = np.array(MOMENTS)

    def euler(_, w):
        return np.cross(moments * w, w) / moments

    expected = solve_ivp(euler, (0.0, TIMES[-1]), spin, "DOP853", TIMES, rtol=1e-13, atol=1e-14).y.T
    np.testing.assert_allclose(local_spins(q, v), expected, atol=1e-10)
    start = np.asarray(thrown(spin)[0][:3])
    np.testing.assert_allclose(q[:, :3], start + np.outer(TIMES, [0.1, 0.4, -0.3]), atol=1e-12)


@pytest.mark.parametrize("spin", [NEAR_LARGEST, (0.01, 1.2, 0.02)])
def test_momentum_and_energy_stay(spin):
    """The angular momentum as a vector, the energy, and the size of the quaternion."""
    q, v = motion(*thrown(spin), jnp.asarray(TIMES))
    momentum = momenta(q, v)
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=1e-10)
    energy = 0.5 * np.sum(local_spins(q, v) ** 2 * MOMENTS, axis=1)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-10)
    np.testing.assert_allclose(np.linalg.norm(q[:, 3:], axis=1), 1.0, atol=1e-10)


def jacobi(amplitude):
    """Moving about its axis of largest inertia (Landau and Lifshitz, Mechanics, § 37), with the spins of t = 0,
    (amplitude, 0, 1): the spin over time, its period, and the rate of precession about the angular momentum."""
    a, b, c = MOMENTS
    first = np.array([amplitude, 0.0, 1.0])
    twice, momentum = np.sum(MOMENTS * first**2), np.linalg.norm(MOMENTS * first)
    rate = np.sqrt((c - b) * (momentum**2 - twice * a) / (a * b * c))
    m = (b - a) * (twice * c - momentum**2) / ((c - b) * (momentum**2 - twice * a))
    sizes = np.sqrt(
        [
            (twice * c - momentum**2) / (a * (c - a)),
            (twice * c - momentum**2) / (b * (c - b)),
            (momentum**2 - twice * a) / (c * (c - a)),
        ]
    )

    def spin(t):
        sn, cn, dn, _ = ellipj(rate * t, m)
        return np.array([sizes[0] * cn, sizes[1] * sn, sizes[2] * dn])

    def precession(t):
        w = spin(t)
        return momentum * (a * w[0] ** 2 + b * w[1] ** 2) / ((a * w[0]) ** 2 + (b * w[1]) ** 2)

    return spin, 4.0 * ellipk(m) / rate, precession


@pytest.mark.parametrize("amplitude", [0.2, 1.0])
def test_the_motion_is_jacobis(amplitude):
    """The spin at all times; after its period the body has turned about the angular momentum by the precession's
    integral, and stands as at first but for that."""
    spin, period, precession = jacobi(amplitude)
    times = period * np.linspace(0.0, 1.0, 41)
    q, v = motion(*thrown([amplitude, 0.0, 1.0], seed=1), jnp.asarray(times))
    np.testing.assert_allclose(local_spins(q, v), np.array([spin(t) for t in times]), atol=1e-10)
    turned = (rotations(q)[-1] * rotations(q)[0].inv()).as_matrix()
    axis = momenta(q, v)[0] / np.linalg.norm(momenta(q, v)[0])
    angle = quad(precession, 0.0, period, epsabs=1e-13, epsrel=1e-13)[0]
    np.testing.assert_allclose(turned, Rotation.from_rotvec(angle * axis).as_matrix(), atol=1e-10)


@pytest.mark.slow
def test_derivatives_are_those_of_differences():
    """The end by the first spin and by the inertias, against central differences."""
    spin, moments, times = jnp.asarray(NEAR_LARGEST), jnp.asarray(MOMENTS), jnp.asarray(TIMES[:11])
    q, _ = thrown(NEAR_LARGEST)
    (frame,) = SPACE.frames(q, jnp.zeros(6), 1)

    def end(x):
        v = jnp.concatenate([jnp.zeros(3), jnp.stack(frame.turn(Vector(*x[:3])))])
        q_end, v_end = motion(q, v, times, tuple(x[3:]))
        return jnp.concatenate([q_end[-1], v_end[-1]])

    x, step = jnp.concatenate([spin, moments]), 1e-4
    slopes = [(end(x + step * unit) - end(x - step * unit)) / (2 * step) for unit in jnp.eye(6)]
    np.testing.assert_allclose(jax.jacfwd(end)(x).T, slopes, atol=2e-6)
