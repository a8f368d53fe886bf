"""Mechanisms in space: random positions, and how tests integrate them."""

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from scipy.spatial.transform import Rotation


def integrate(system, q, v, times, tolerance=1e-13):
    """Positions and velocities at ``times``, by a method independent of jaxbuffer's own loop."""
    numbers = jax.tree.map(lambda leaf: jnp.asarray(leaf, float), (system, tolerance))
    return _integrate(numbers[0], *(jnp.asarray(row, float) for row in (q, v, times)), numbers[1])


@eqx.filter_jit
def _integrate(system, q, v, times, tolerance):
    def field(_, y, system):
        q, v = y
        return system.position_rate(q).of(v), system.motion(system.kinematics(q, v)).acceleration

    return diffrax.diffeqsolve(
        diffrax.ODETerm(field),
        diffrax.Dopri8(),
        t0=0.0,
        t1=times[-1],
        dt0=1e-3,
        y0=(q, v),
        args=system,
        saveat=diffrax.SaveAt(ts=times),
        stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
        adjoint=diffrax.ForwardMode(),
        max_steps=200_000,
    ).ys


def energies(system, q, v):
    """Kinetic and stored energy along a motion [J]."""

    return np.asarray(_along(lambda kin: system.kinetic_energy(kin) + system.stored_energy(kin), system, q, v))


def momenta(system, q, v):
    """Linear and angular momentum along a motion."""

    both = _along(lambda kin: (system.linear_momentum(kin), system.angular_momentum(kin)), system, q, v)
    return tuple(map(np.asarray, both))


def _along(of, system, q, v):
    """What is `of` a system's kinematics, along a motion."""
    return jax.jit(jax.vmap(lambda q, v: of(system.kinematics(q, v))))(q, v)


def rotations(q, body):
    """The rotations of a body, of one position or of many."""
    return Rotation.from_quat(np.array(q)[..., 7 * body + 3 : 7 * body + 7], scalar_first=True)


def random_positions(seed, bodies):
    """Places and rotations, whose quaternions have sizes of their own."""
    rng = np.random.default_rng(seed)
    turns = [1.3 * Rotation.random(rng=rng).as_quat(scalar_first=True) for _ in range(bodies)]
    return jnp.asarray(np.concatenate([[*rng.normal(size=3), *turn] for turn in turns]))


def random_velocities(seed, bodies):
    return jnp.asarray(np.random.default_rng(1000 + seed).normal(size=6 * bodies))
