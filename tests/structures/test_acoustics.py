"""A liquid column on a piston, waves in it, and sloshing: against transcendental equations and tables."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import eig, eigh
from test_quads import grid

from jaxbuffer.structures import FiniteElementSystem, Liquid
from jaxbuffer.structures.acoustics import element_matrices
from jaxbuffer.structures.boundary import boundary_areas
from jaxbuffer.structures.central_differences import advance
from jaxbuffer.structures.incidence import Incidence
from jaxbuffer.structures.sloshing import in_cylinder, in_rectangle

TOPIC = "Finite elements, liquid and contact"
MASS, SPRING, LENGTH, DENSITY, SOUND = 50.0, 1e8, 1.0, 1000.0, 1500.0
RIGID = (363.782193, 1074.408383, 1790.588262, 2510.238439)  # Hz, roots of k - mω² + ρcω cot(ωL/c) = 0
FREE = (48.788451, 717.833145, 1432.061209, 2149.974915)  # Hz, of k - mω² - ρcω tan(ωL/c) = 0


@jax.jit
def matrices_of(positions, corners):
    """K_f and M_f of each element."""
    return element_matrices(positions, corners, SOUND)


def assembled(positions, corners, matrices):
    total = np.zeros((len(positions), len(positions)))
    for nodes, matrix in zip(corners, np.asarray(matrices), strict=True):
        total[np.ix_(nodes, nodes)] += matrix
    return total


def column_frequencies(elements, free_end):
    """Of the unsymmetric (u, p) system with a piston at x = 0 [Hz]."""
    positions, corners = grid(elements, 1, LENGTH, 1.0)
    stiffness, mass = (assembled(positions, corners, m) for m in matrices_of(positions, corners))
    wet = np.flatnonzero(positions[:, 0] == 0.0)[::-1]  # downwards, so that the liquid is on the left
    areas = np.asarray(boundary_areas(jnp.asarray(positions[wet])))
    np.testing.assert_allclose(areas, [[-0.5, 0.0], [-0.5, 0.0]])
    coupling = np.zeros(len(positions))
    coupling[wet] = -areas[:, 0]  # the piston moves along +x, out of its own side
    kept = positions[:, 0] < LENGTH if free_end else np.ones(len(positions), bool)
    n = np.count_nonzero(kept)
    m, k = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))
    m[0, 0], k[0, 0] = MASS, SPRING
    m[1:, 1:], k[1:, 1:] = mass[np.ix_(kept, kept)], stiffness[np.ix_(kept, kept)]
    m[1:, 0], k[0, 1:] = -DENSITY * coupling[kept], coupling[kept]
    scale = 1.0 / np.sqrt(np.diagonal(k))  # metres beside pascals would cost half of the digits
    squared = np.sort(eig(scale[:, None] * k * scale, scale[:, None] * m * scale, right=False).real)
    return np.sqrt(np.maximum(squared, 0.0)) / (2.0 * np.pi)


@pytest.mark.parametrize(("elements", "first"), [(10, 364.1217), (40, 363.8034), (160, 363.7835)])
def test_a_column_before_a_rigid_end(elements, first):
    found = column_frequencies(elements, free_end=False)
    assert found[0] < 1e-2, "constant pressure costs nothing"
    lateral = found[(found > 1.0) & (found < 700.0)]
    assert lateral[0] == pytest.approx(first, abs=6e-5)
    if elements == 160:
        for exact in RIGID[:3]:
            assert np.abs(found - exact).min() < 3e-4 * exact


@pytest.mark.parametrize(("elements", "first"), [(10, 48.78846), (40, 48.78845), (160, 48.78845)])
def test_a_column_with_a_free_surface(elements, first):
    found = column_frequencies(elements, free_end=True)
    assert found[0] == pytest.approx(first, abs=6e-6)
    if elements == 160:
        for exact in FREE[:3]:
            assert np.abs(found - exact).min() < 3e-4 * exact


def piston_and_column(elements, spring=0.0, mass=MASS, free_end=True):
    """The same in time, upright: the piston is one node, held sideways, that the two lower liquid nodes share."""
    positions, corners = grid(1, elements, 1.0, LENGTH)
    stiffness, consistent = element_matrices(positions, corners, SOUND)
    incidence = Incidence.of(corners, len(positions))
    wet = np.flatnonzero(positions[:, 1] == 0.0)
    free = np.where((positions[:, 1] == LENGTH) & free_end, 0.0, 1.0)
    liquid = Liquid(
        incidence,
        stiffness,
        incidence.to_nodes(jnp.sum(consistent, axis=2)),
        jnp.asarray(free),
        DENSITY,
        np.zeros(2, int),
        wet,
        boundary_areas(jnp.asarray(positions[wet])),
    )
    inverse = jnp.array([[0.0, 1.0 / mass]])
    return FiniteElementSystem(jnp.zeros((1, 2)), inverse, liquid=liquid), spring


def followed(system, spring, speed, step, steps):
    state = system.start(jnp.array([[0.0, speed]]))

    def one(state, _):
        pulled = jnp.zeros((1, 2)).at[0, 1].set(-spring * state.displacement[0, 1])
        with_spring = FiniteElementSystem(system.positions, system.inverse_mass, load=pulled, liquid=system.liquid)
        after, seen = advance(with_spring, state, step, ())
        spent = 0.5 * spring * state.displacement[0, 1] ** 2
        return after, (
            seen.displacement[0, 1],
            seen.pressure[system.liquid.wet[0]],
            seen.energies.kinetic,
            seen.energies.liquid,
            spent,
        )

    return map(np.asarray, jax.jit(lambda s: jax.lax.scan(one, s, length=steps)[1])(state))


@pytest.mark.slow
def test_a_piston_on_a_column_swings_at_its_first_frequency_and_keeps_its_energy(evidence):
    system, spring = piston_and_column(40, SPRING)
    step = 0.5 * LENGTH / 40 / SOUND
    moved, _, kinetic, liquid, spent = followed(system, spring, 0.01, step, 20000)
    time, tried = step * np.arange(len(moved)), np.linspace(45.0, 53.0, 801)
    heard = np.abs(np.exp(-2j * np.pi * np.outer(tried, time)) @ (moved * np.hanning(len(moved))))
    off = abs(tried[heard.argmax()] / FREE[0] - 1.0)
    evidence(TOPIC, "piston on an open column, first frequency", off, 4e-3, "root of M147's equation")
    total = kinetic + liquid + spent
    assert np.ptp(total[1:]) < 2e-3 * total[1]


@pytest.mark.slow
def test_a_heavy_piston_sends_joukowskys_pressure_up_a_long_column(evidence):
    """p = ρ c v = 1.5 MPa per m/s, behind a front that moves at c."""
    system, _ = piston_and_column(200, mass=1e12, free_end=True)
    step = 0.5 * LENGTH / 200 / SOUND
    _, pressure, *_ = followed(system, 0.0, 1.0, step, 600)
    off = abs(pressure[300:600].mean() / (DENSITY * SOUND) - 1.0)
    evidence(TOPIC, "pressure before a piston in a long column", off, 5e-3, "Joukowsky")


@pytest.mark.parametrize(
    ("depth", "frequency", "mass", "length"),
    [
        (0.125, 1.083497, 0.771322, 0.851814),
        (0.25, 1.435353, 0.676812, 0.485381),
        (0.5, 1.697445, 0.473273, 0.347063),
        (1.0, 1.769147, 0.257050, 0.319501),
    ],
)
def test_sloshing_in_a_rectangle(depth, frequency, mass, length):
    found = in_rectangle(1.0, depth, gravity=1.0)
    np.testing.assert_allclose([found.frequency, found.mass, found.length], [frequency, mass, length], atol=6e-7)
    masses = jax.jit(jax.vmap(lambda mode: in_rectangle(1.0, depth, mode, 1.0).mass))(np.arange(1, 4001))
    assert np.sum(np.asarray(masses)) < 1.0, "what is left moves with the tank"
    assert float(found.length) * float(found.frequency) ** 2 == pytest.approx(1.0, rel=1e-12)


def test_sloshing_in_a_cylinder():
    found = in_cylinder(0.5, 0.5, gravity=1.0)
    np.testing.assert_allclose([found.frequency, found.mass, found.length], [1.871255, 0.432197, 0.285584], atol=6e-7)
    half_depth = 0.25 * (1.0 - 4.0 / 1.8411838 * np.tanh(1.8411838 / 2.0))
    assert float(found.depth) == pytest.approx(0.25 - half_depth, rel=1e-6)


@pytest.mark.parametrize("depth", [0.25, 0.5, 1.0])
def test_the_liquids_elements_slosh_at_those_frequencies(depth, evidence):
    """K_f p = ω² ∫ N N p/g on the surface, by 40 elements along the tank."""
    positions, corners = grid(40, 20, 1.0, depth)
    stiffness = assembled(positions, corners, matrices_of(positions, corners)[0])
    surface = np.flatnonzero(positions[:, 1] == depth)
    rest = np.setdiff1d(np.arange(len(positions)), surface)
    inner = np.linalg.solve(stiffness[np.ix_(rest, rest)], stiffness[np.ix_(rest, surface)])
    schur = stiffness[np.ix_(surface, surface)] - stiffness[np.ix_(surface, rest)] @ inner
    h = 1.0 / 40
    mass = np.zeros(schur.shape)
    for k in range(40):
        mass[k : k + 2, k : k + 2] += h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    squared = eigh(schur, mass, eigvals_only=True)
    exact = [float(in_rectangle(1.0, depth, mode, 1.0).frequency) for mode in (1, 2)]
    off = abs(np.sqrt(squared[1]) / exact[0] - 1.0)
    evidence(TOPIC, "first sloshing frequency of a rectangle", off, 2e-3, "Abramson, NASA SP-106")
    np.testing.assert_allclose(np.sqrt(squared[3]), exact[1], rtol=6e-3)
