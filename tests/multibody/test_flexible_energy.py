"""A flexible body's mass, momentum and velocity terms against sums over its particles and Lagrange's equations."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from in_short import often
from jaxbuffer.multibody import FlexibleBody, System
from jaxbuffer.multibody.flexible import Bar, cantilever_bar, free_bar, pinned_bar
from multibody.particles import Particles, dense_mass, positive, random_body, random_particles

TOPIC = "Equations of flexible bodies"
PARTICLES = "sums over particles"
each_seed = pytest.mark.parametrize("seed", range(4))
BAR = Bar.rectangle(0.8, 0.02, 0.01, 2700.0, 7e10)
TIP = (0.3, 4e-4)  # kg, kg m²


def random_motion(seed, size=3):
    rng = np.random.default_rng(300 + seed)
    return rng.normal(size=3 + size), rng.normal(size=3 + size)


def off(found, expected):
    """Largest difference, of the largest entry."""
    return float(np.max(np.abs(np.asarray(found) - np.asarray(expected))) / np.max(np.abs(np.asarray(expected))))


class Terms(NamedTuple):
    """Terms of the equations of one body's motion; ``force``: M q̈ without loads."""

    energy: jax.Array
    mass: jax.Array
    force: jax.Array
    linear: jax.Array
    angular: jax.Array


@eqx.filter_jit
def by_system(body, q, v):
    """The terms by the system that this body makes."""
    system = System((body,))
    kin = system.kinematics(q, v)
    return Terms(
        energy=system.kinetic_energy(kin),
        mass=dense_mass(system, kin),
        force=system.generalised_force(kin),
        linear=system.linear_momentum(kin),
        angular=system.angular_momentum(kin),
    )


@eqx.filter_jit
def by_lagrange(energy, modes, q, v):
    """Kinetic energy, mass matrix and force by this energy, of q and v, alone."""
    return energy(q, v), jax.hessian(energy, 1)(q, v), lagrange(energy, modes, q, v)


def lagrange(energy, modes, q, v):
    """∂T/∂q - (∂²T/∂q̇∂q) q̇ - K q - C q̇: what M q̈ is without loads."""
    momentum = lambda q: jax.grad(energy, 1)(q, v)  # noqa: E731
    force = jax.grad(energy)(q, v) - jax.jvp(momentum, (q,), (v,))[1]
    return force.at[3:].add(-modes.stiffness @ q[3:] - modes.damping @ v[3:])


def stiffened_energy(particles, geometric, q, v):
    """The particles' kinetic energy, less ½ ω² qᵀ G q where there is geometric stiffness."""
    stiffening = 0.0 if geometric is None else q[3:] @ geometric @ q[3:]
    return particles.kinetic_energy(q, v) - 0.5 * v[2] ** 2 * stiffening


@each_seed
def test_the_mass_matrix_is_the_kinetic_energys(seed, evidence):
    (q, v), body = random_motion(seed), random_body(seed, geometric=False)
    _, expected, _ = by_lagrange(eqx.Partial(stiffened_energy, random_particles(seed), None), body.modes, q, v)
    evidence(TOPIC, "mass matrix, relative", off(by_system(body, q, v).mass, expected), 1e-14, PARTICLES)


@eqx.filter_jit
def energy_and_momenta(system, particles, q, v):
    """Kinetic energy, linear and angular momentum: the system's, and the sums over its particles."""
    kin = system.kinematics(q, v)
    found = system.kinetic_energy(kin), system.linear_momentum(kin), system.angular_momentum(kin)
    return found, (particles.kinetic_energy(q, v), *particles.momenta(q, v))


@pytest.mark.quick
@each_seed
def test_kinetic_energy_and_momenta(seed, evidence):
    particles, (q, v) = random_particles(seed), random_motion(seed)
    system = System((random_body(seed, geometric=False),))
    for found, expected in zip(*energy_and_momenta(system, particles, q, v), strict=True):
        evidence(TOPIC, "kinetic energy and momenta, relative", off(found, expected), 1e-13, PARTICLES)


@each_seed
@pytest.mark.parametrize("stiffened", [False, True])
def test_velocity_forces_are_lagranges(seed, stiffened, evidence):
    """With every coupling there can be; geometric stiffness is -½ ω² qᵀ G q in the kinetic energy."""
    body, (q, v) = random_body(seed, geometric=stiffened), random_motion(seed)
    energy = eqx.Partial(stiffened_energy, random_particles(seed), body.modes.geometric)
    found, (energy, mass, force) = by_system(body, q, v), by_lagrange(energy, body.modes, q, v)
    claim = "velocity, elastic and damping forces, relative"
    evidence(TOPIC, claim, off(found.force, force), 1e-13, "Lagrange's equations, differentiated")
    evidence(TOPIC, "kinetic energy and momenta, relative", off(found.energy, energy), 1e-13, PARTICLES)
    evidence(TOPIC, "mass matrix, relative", off(found.mass, mass), 1e-14, PARTICLES)


@eqx.filter_jit
def acceleration(body, q, v):
    system = System((body,))
    return system.motion(system.kinematics(q, v)).acceleration


@each_seed
@pytest.mark.parametrize("left_out", ["static_moment", "translation", "rotation", "radial", "gyroscopic", "geometric"])
def test_each_term_may_be_left_out(seed, left_out):
    """None stands for zero: the same as zeros there."""
    body, (q, v) = random_body(seed), random_motion(seed)
    where = lambda body: getattr(body.modes, left_out)  # noqa: E731
    none = eqx.tree_at(where, body, None)
    zero = eqx.tree_at(where, body, np.zeros(np.shape(where(body))))
    found, expected = ([*by_system(body, q, v), acceleration(body, q, v)] for body in (none, zero))
    for a, b in zip(found, expected, strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12 * float(np.max(np.abs(b))))


def bar_particles(body, tip=0.0):
    """Gauss's points of a bar, 40 × 10 of them, and its tip's mass, as particles."""
    nodes, weights = np.polynomial.legendre.leggauss(10)
    cells = np.arange(60)[:, None]
    xi, weights = ((cells + 0.5 * (nodes + 1.0)) / 60).ravel(), np.tile(weights / 120, 60)
    bar, shapes = body.bar, body.shapes
    xi, mass = np.append(xi, 1.0), np.append(bar.mass * weights, tip)
    lateral, axial = shapes.lateral(xi, 0), shapes.axial(xi, 0)
    x = np.concatenate([np.zeros_like(lateral), axial], axis=1)
    y = np.concatenate([lateral, np.zeros_like(axial)], axis=1)
    place = np.stack([bar.length * (xi - body.centre), np.zeros_like(xi)])
    return Particles(mass, place, np.stack([x, y]))


BARS = {
    "free": lambda: free_bar(BAR, 2, 1),
    "cantilever": lambda: cantilever_bar(BAR, 1, 1),
    "cantilever with a tip": lambda: cantilever_bar(BAR, 1, 1, tip_mass=TIP[0], tip_inertia=TIP[1]),
    "pinned": lambda: pinned_bar(BAR, 2, axial_nodes=True),
    "free, bending alone": lambda: free_bar(BAR, 3),
}


@eqx.filter_jit
def built(build):
    """A builder's body, in one program in place of its many operations."""
    return build()


@eqx.filter_jit
def momenta(particles, q, v):
    return particles.momenta(q, v)


def energy_with_tip(particles, spins, turning, q, v):
    """The particles' kinetic energy, and that of an inertia that turns with the tip."""
    return particles.kinetic_energy(q, v) + 0.5 * spins * jnp.sum(turning * v) ** 2


@pytest.mark.parametrize("name", often(BARS, "free", "cantilever with a tip"))
def test_bars_against_their_velocity_field(name, evidence):
    """Kinetic energy, momenta, mass matrix and velocity forces by quadrature over the bar."""
    body = built(BARS[name])
    tip = name.endswith("tip")
    particles, size = bar_particles(body, TIP[0] if tip else 0.0), body.modes.size
    rng = np.random.default_rng(7)
    q = np.append(rng.normal(size=3), 0.05 * rng.normal(size=size))
    v = rng.normal(size=3 + size)
    turning = np.append(np.array([0.0, 0.0, 1.0]), np.asarray(body.end.rotation))
    spins = tip * TIP[1]  # kg m²: what the tip has besides its mass
    found = by_system(FlexibleBody(body.modes), q, v)
    energy, mass, force = by_lagrange(eqx.Partial(energy_with_tip, particles, spins, turning), body.modes, q, v)
    source, relative = "quadrature over the bar", 2e-11
    mass = np.asarray(mass)
    scale = np.sqrt(np.outer(np.diag(mass), np.diag(mass)))
    evidence(TOPIC, "bars, kinetic energy", off(found.energy, energy), relative, source, detail=name)
    evidence(TOPIC, "bars, mass matrix", off(found.mass / scale, mass / scale), relative, source, detail=name)
    elastic = np.append(np.zeros(3), np.asarray(body.modes.stiffness) @ q[3:])
    ours, expected = np.asarray(found.force) + elastic, np.asarray(force) + elastic
    digits = 1e-15 * np.max(np.abs(elastic)) / np.max(np.abs(expected))  # rounding of the elastic forces
    evidence(TOPIC, "bars, velocity forces", max(off(ours, expected) - 4 * digits, 0.0), relative, source, detail=name)
    linear, angular = momenta(particles, q, v)
    angular = np.asarray(angular) + spins * (turning @ v)
    evidence(TOPIC, "bars, momenta", off(found.linear, linear), relative, source, detail=name)
    evidence(TOPIC, "bars, momenta", off(found.angular, angular), relative, source, detail=name)


@eqx.filter_jit
def balance(body, q, v):
    """The rate of kinetic and elastic energy along the motion without loads, and what damping takes [W]."""
    system = System((body,))

    def energy(q, v):
        kin = system.kinematics(q, v)
        return system.kinetic_energy(kin) + system.stored_energy(kin)

    kin = system.kinematics(q, v)
    power = jax.jvp(energy, (q, v), (v, system.motion(kin).acceleration))[1]
    return power, system.dissipation(kin)


def test_power_of_the_terms_is_balanced(evidence):
    """Without loads, kinetic and elastic energy lose what damping takes."""
    power, lost = map(float, balance(random_body(5), *random_motion(5)))
    assert lost > 0.1
    evidence(TOPIC, "power of damping, relative", abs(power / lost + 1.0), 1e-11, "energy's rate")


@pytest.mark.quick
def test_positive_is_what_it_says():
    assert np.all(np.linalg.eigvalsh(positive(np.random.default_rng(1), 4)) > 0.5)
