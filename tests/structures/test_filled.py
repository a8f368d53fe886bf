"""Liquid without a surface, a surface that a wall comes down on, and trapped air: against closed forms."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.optimize import brentq
from test_acoustics import DENSITY, LENGTH, MASS, RIGID, SOUND, SPRING
from test_quads import grid

from jaxbuffer.structures import Elastic, FiniteElementSystem, Liquid, Plane, Quads
from jaxbuffer.structures.acoustics import Cover, element_matrices
from jaxbuffer.structures.boundary import boundary_areas
from jaxbuffer.structures.central_differences import advance
from jaxbuffer.structures.gas import EXPONENT, Gas
from jaxbuffer.structures.incidence import Incidence

TOPIC = "Finite elements, liquid and contact"


def liquid_on(positions, corners, free=(), wall=(), wet=(), structure=None, density=DENSITY, sound=SOUND, **more):
    """Of a rectangular mesh; ``wall``: the structure's nodes in the places of the liquid's ``wet``."""
    stiffness, consistent = element_matrices(positions, corners, sound)
    incidence = Incidence.of(corners, len(positions))
    wall, wet = np.asarray(wall, int), np.asarray(wet, int)
    outward = boundary_areas(structure[wall]) if len(wall) else jnp.zeros((0, 2))
    mass = incidence.to_nodes(jnp.sum(consistent, axis=2))
    open_ = jnp.ones(len(positions)).at[np.asarray(free, int)].set(0.0)
    return Liquid(incidence, stiffness, mass, open_, density, wall, wet, outward, **more)


@eqx.filter_jit
def closed_column(elements=40, mass=MASS):
    """A piston of two nodes below an upright column with a rigid end."""
    positions, corners = grid(1, elements, 1.0, LENGTH)
    structure = jnp.array([[0.0, 0.0], [1.0, 0.0]])
    wet = np.flatnonzero(positions[:, 1] == 0.0)
    liquid = liquid_on(positions, corners, (), [0, 1], wet, structure, follows=True)
    return FiniteElementSystem(structure, jnp.array([[0.0, 2.0 / mass]] * 2), liquid=liquid)


def moved(system, start, step, steps, spring=0.0, node=0):
    """A node's displacement upwards, all pressures and the energies over time."""

    def one(state, _):
        pulled = jnp.zeros_like(system.positions).at[:, 1].set(-spring * state.displacement[:, 1])
        fields = (system.elements, (), (), system.gravity, pulled, system.liquid, None, system.gas)
        after, seen = advance(FiniteElementSystem(system.positions, system.inverse_mass, *fields), state, step, ())
        spent = 0.5 * spring * jnp.sum(state.displacement[:, 1] ** 2)
        total = seen.energies.kinetic + seen.energies.stored + seen.energies.liquid + spent
        return after, (seen.displacement[node], seen.pressure, total)

    return map(np.asarray, jax.jit(lambda v: jax.lax.scan(one, system.start(v), length=steps)[1])(start))


def test_a_piston_on_a_closed_column_swings_at_its_first_frequency(evidence):
    system, step = closed_column(), 0.5 * LENGTH / 40 / SOUND
    up, _, total = moved(system, np.array([[0.0, 1e-4]] * 2), step, 12000, 0.5 * SPRING)
    time, tried = step * np.arange(len(up)), np.linspace(350.0, 378.0, 561)
    heard = np.abs(np.exp(-2j * np.pi * np.outer(tried, time)) @ (up[:, 1] * np.hanning(len(up))))
    found = tried[heard.argmax()]
    error = abs(found / RIGID[0] - 1.0)
    evidence(TOPIC, "piston on a closed column, first frequency", error, 2e-3, "root of M147's equation")
    assert np.ptp(total[1:]) < 2e-3 * total[1]


def test_a_closed_column_is_as_stiff_as_its_bulk():
    """The mean pressure is ρ c² times the share of the volume that is lost, here up to a tenth, to rounding."""
    system = closed_column(mass=1e9)
    up, pressure, _ = moved(system, np.array([[0.0, 10.0]] * 2), 5e-6, 2000)
    weight = np.asarray(system.liquid.mass) / np.sum(np.asarray(system.liquid.mass))
    assert up[-1, 1] == pytest.approx(0.1, rel=2e-3)
    np.testing.assert_allclose(pressure @ weight, DENSITY * SOUND**2 * up[:, 1] / LENGTH, rtol=1e-9, atol=1e-3)


@pytest.mark.long
def test_a_wall_on_a_closed_layer_swings_as_the_closed_form_says(evidence):
    """w = W cos kx on ends that slide: D k⁴ = ω² (m + ρ coth(κ H)/κ), κ² = k² - ω²/c²."""
    length, depth, thick, young, poisson, solid = 0.4, 0.1, 0.005, 1e9, 0.4, 950.0
    density, sound, number = 740.0, 1150.0, 3
    along, up = 48, 12
    wall, corners = grid(along, 1, length, thick)
    wall = jnp.asarray(wall + np.array([0.0, depth]))
    plate = Plane(Quads.of(wall, corners), Elastic(solid, young, poisson))
    inverse = jnp.repeat(1.0 / plate.mass()[:, None], 2, axis=1)
    ends = np.flatnonzero(np.isin(np.asarray(wall)[:, 0], (0.0, length)))
    below, cells = grid(along, up, length, depth)
    order = lambda points, height: np.flatnonzero(np.isclose(points[:, 1], height))[::-1]  # noqa: E731
    face, surface = order(np.asarray(wall), depth), order(below, depth)
    assert np.all(np.diff(below[surface, 0]) < 0.0)
    liquid = liquid_on(below, cells, (), face, surface, wall, density, sound, follows=True)
    system = FiniteElementSystem(wall, inverse.at[ends, 0].set(0.0), (plate,), liquid=liquid)
    k = number * np.pi / length
    start = jnp.zeros_like(wall).at[:, 1].set(1e-3 * jnp.cos(k * wall[:, 0]))
    rigidity = young * thick**3 / (12.0 * (1.0 - poisson**2))

    def balance(omega):
        kappa = np.sqrt(k**2 - (omega / sound) ** 2)
        return rigidity * k**4 - omega**2 * (solid * thick + density / (kappa * np.tanh(kappa * depth)))

    omega = brentq(balance, 10.0, 0.9 * k * sound)
    step = 0.8 * float(system.stable_step())
    w, _, total = moved(system, start, step, int(1.1 * np.pi / omega / step), node=int(face[-1]))
    turn = np.flatnonzero(np.diff(np.sign(w[5:, 1])))[0] + 5
    crossed = step * (turn + w[turn, 1] / (w[turn, 1] - w[turn + 1, 1]))
    error = abs(np.pi / omega / crossed - 1.0)
    evidence(TOPIC, "bending wall on a closed layer, third frequency", error, 0.01, "closed form of the strip")
    assert np.ptp(total) < 1e-3 * total[0]


@eqx.filter_jit
def column_and_lid(mass, gap, elements):
    """A column that stands on rigid ground, a lid above it, and the nodes of the surface."""
    positions, corners = grid(1, elements, 1.0, LENGTH)
    surface = np.flatnonzero(positions[:, 1] == LENGTH)
    shares = jnp.full((2, 2), 0.5)
    cover = Cover(surface, jnp.full(2, 0.5), jnp.zeros((2, 2), int), shares, jnp.full(2, gap))
    liquid = liquid_on(positions, corners, surface, cover=cover)
    lid = jnp.array([[0.0, LENGTH + gap]])
    return FiniteElementSystem(lid, jnp.array([[0.0, 1.0 / mass]]), liquid=liquid), surface


def lid_on_column(mass, speed, gap, elements=200):
    """A lid falls on the surface of a column."""
    system, surface = column_and_lid(mass, gap, elements)
    return moved(system, np.array([[0.0, -speed]]), 0.5 * LENGTH / elements / SOUND, 1200), np.asarray(surface)


def test_a_lid_on_a_surface_meets_joukowskys_pressure():
    """p = ρ c v e^(-ρ c t/m) on the lid until the wave is back, after 2 L/c; nothing before it arrives."""
    mass, speed, gap, step = 2000.0, 2.0, 4e-4, 0.5 * LENGTH / 200 / SOUND
    (down, pressure, total), surface = lid_on_column(mass, speed, gap)
    time = step * np.arange(len(down)) - gap / speed
    met = pressure[:, surface[0]]
    assert np.all(met[time < -step] == 0.0) and np.all(met >= 0.0)
    seen = (time > 0.1 * LENGTH / SOUND) & (time < 1.8 * LENGTH / SOUND)
    exact = DENSITY * SOUND * speed * np.exp(-DENSITY * SOUND * time[seen] / mass)
    assert np.sqrt(np.mean((met[seen] / exact - 1.0) ** 2)) < 0.06, "the front rings"
    assert np.mean(met[seen] / exact) == pytest.approx(1.0, abs=5e-3)
    assert np.ptp(total) < 5e-3 * total[0]


def test_trapped_air_is_a_gas_spring():
    """A box of which a third is liquid: p V^γ is constant, forces are p times areas, energy is their work."""
    box = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 1.5], [0.0, 1.5]])
    gas = Gas(np.arange(4), 0.5 * jnp.asarray(1.0), jnp.asarray(0.75), 1e5)
    lowered = box - 0.4 * np.array([[0.0, 0.0], [0.0, 0.0], [0.0, 1.0], [0.0, 1.0]])
    expected = 1e5 * ((1.0 / 0.6) ** EXPONENT - 1.0)
    energy = jax.jit(jax.value_and_grad(gas.energy))
    pressure, forces = jax.jit(lambda at: (gas.overpressure(at), gas.push(at)))(lowered)
    assert float(pressure) == pytest.approx(expected, rel=1e-12)
    assert np.sum(np.asarray(forces)[2:, 1]) == pytest.approx(0.5 * expected, rel=1e-12)
    np.testing.assert_allclose(forces, -np.asarray(energy(lowered)[1]), rtol=1e-9, atol=1e-6)
    assert float(energy(box)[0]) == 0.0
