"""Flexible bodies made of particles: each integral over the mass is a plain sum, and so is the kinetic energy."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from jaxbuffer.multibody import FlexibleBody
from jaxbuffer.multibody.flexible import ComponentModes, Marker


class Particles(NamedTuple):
    """Masses (p,) [kg], their places (2, p) on the undeformed body [m] and mode shapes (2, p, n) there [-]."""

    mass: np.ndarray
    place: np.ndarray
    shapes: np.ndarray

    def modes(self, stiffness, damping, geometric=None, **fields) -> ComponentModes:
        """All integrals, none taken for zero."""
        m, (x, y), (a, b) = self.mass, self.place, self.shapes
        turned = np.einsum("p,pi,pj->ij", m, a, b)
        return ComponentModes(
            mass=m.sum(),
            inertia=m @ (x * x + y * y),
            mass_matrix=jnp.asarray(np.einsum("p,pi,pj->ij", m, a, a) + np.einsum("p,pi,pj->ij", m, b, b)),
            stiffness=jnp.asarray(stiffness),
            damping=jnp.asarray(damping),
            static_moment=jnp.asarray([m @ x, m @ y]),
            translation=jnp.asarray([m @ a, m @ b]),
            rotation=jnp.asarray((m * x) @ b - (m * y) @ a),
            radial=jnp.asarray((m * x) @ a + (m * y) @ b),
            gyroscopic=jnp.asarray(turned - turned.T),
            geometric=None if geometric is None else jnp.asarray(geometric),
            **fields,
        )

    def motion(self, q, v):
        """Places and velocities (2, p) in inertial axes of coordinates and velocities (u, v, θ, modal)."""

        def places(q):
            cos, sin = jnp.cos(q[2]), jnp.sin(q[2])
            turn = jnp.stack([jnp.stack([cos, -sin]), jnp.stack([sin, cos])])
            return q[:2, None] + turn @ (self.place + self.shapes @ q[3:])

        return jax.jvp(places, (q,), (v,))

    def kinetic_energy(self, q, v):
        """½ Σ m |ṙ|² [J]."""
        return 0.5 * jnp.sum(self.mass[None, :] * self.motion(q, v)[1] ** 2)

    def momenta(self, q, v):
        """Σ m ṙ and Σ r × m ṙ."""
        place, velocity = self.motion(q, v)
        return jnp.sum(self.mass[None, :] * velocity, axis=1), jnp.sum(
            self.mass * (place[0] * velocity[1] - place[1] * velocity[0])
        )


def positive(rng, size):
    """A random symmetric positive definite matrix."""
    half = rng.normal(size=(size, size))
    return half @ half.T + np.eye(size)


def random_particles(seed, size=3, count=7):
    """Particles anywhere with any shapes."""
    rng = np.random.default_rng(seed)
    shapes = rng.normal(size=(2, count, size))
    return Particles(rng.uniform(0.2, 1.0, count), rng.normal(size=(2, count)), shapes)


def random_body(seed, size=3, damped=True, geometric=True) -> FlexibleBody:
    """A body of them, with any stiffness, damping and geometric stiffness."""
    rng = np.random.default_rng(100 + seed)
    stiffness, damping, stiffening = (positive(rng, size) for _ in range(3))
    particles = random_particles(seed, size)
    return FlexibleBody(particles.modes(10.0 * stiffness, damped * damping, 0.1 * stiffening if geometric else None))


def random_marker(seed, size=3) -> Marker:
    """Anywhere on a body, with any shape."""
    rng = np.random.default_rng(200 + seed)
    x, y = rng.normal(size=2)
    return Marker(x, y, *(jnp.asarray(rng.normal(size=size)) for _ in range(3)))


def dense_mass(system, kin):
    """M as one matrix, also in a compiled function."""
    matrix = jnp.diag(system.masses())
    for columns, rows in system.mass_matrix(kin).blocks():
        lower = np.tril_indices(len(columns))
        entries = jnp.stack([jnp.asarray(rows[i][j], float) for i, j in zip(*lower, strict=True)])
        at, beside = (np.array(columns)[side] for side in lower)
        matrix = matrix.at[at, beside].set(entries).at[beside, at].set(entries)
    return matrix
