"""Plane elements: patch test, bending, no locking, no hourglasses, large rotations."""

import re

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import eigh

from jaxbuffer.errors import InputError
from jaxbuffer.structures import Elastic, Orthotropic, Plane, Quads

TOPIC = "Finite elements, liquid and contact"
SQUARE = np.array([[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]])


def grid(along, across, length, height):
    """Positions and corners of a rectangle."""
    x, y = np.meshgrid(np.linspace(0.0, length, along + 1), np.linspace(0.0, height, across + 1), indexing="ij")
    node = np.arange(x.size).reshape(x.shape)
    cells = [node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]]
    return np.stack([x.ravel(), y.ravel()], axis=1), np.stack(cells, axis=-1).reshape(-1, 4)


@eqx.filter_jit
def forces_of(group, displacement):
    return group.resist(jnp.asarray(displacement), group.start())


def elements(positions, corners, material):
    """Of elements and a material, in one program: a tenth of the time that its operations take one by one."""
    return eqx.filter_jit(lambda: Plane(Quads.of(jnp.asarray(positions), corners), material))()


def stiffness_of(group, nodes):
    matrix = jax.jit(jax.jacfwd(lambda u: forces_of(group, u.reshape(-1, 2)).forces.ravel()))
    return np.asarray(matrix(np.zeros(2 * nodes)))


@pytest.mark.slow
@pytest.mark.parametrize("plane", ["strain", "stress"])
def test_a_distorted_patch_keeps_a_constant_strain(plane):
    """All elements have the same stress, by Hooke, and the inner node is in equilibrium."""
    positions, _ = grid(2, 2, 2.0, 2.0)
    positions = positions.reshape(3, 3, 2).swapaxes(0, 1).reshape(9, 2)
    positions[4] += [0.23, -0.31]
    positions[1] += [0.2, 0.0]
    material = Elastic(1.0, 100.0, 0.3, plane)
    group = elements(positions, SQUARE, material)
    gradient = 1e-7 * np.array([[1.0, 0.4], [-0.2, 0.7]])
    found = forces_of(group, positions @ gradient.T)
    stress = np.asarray(eqx.filter_jit(group.quads.in_own_axes)(np.asarray(found.stress)[..., :3]))
    e = 0.5 * (gradient + gradient.T)
    lame, twice = float(material.lame), 2.0 * float(material.shear_modulus)
    exact = [lame * np.trace(e) + twice * e[0, 0], lame * np.trace(e) + twice * e[1, 1], twice * e[0, 1]]
    np.testing.assert_allclose(stress, np.broadcast_to(exact, stress.shape), rtol=3e-6)
    assert np.abs(np.asarray(found.forces)[4]).max() < 1e-13


@pytest.mark.parametrize("poisson", [0.0, 0.4, 0.4999])
def test_one_element_across_bends_as_the_closed_form_says(poisson, evidence):
    """A strip under a pure moment: E t³/12/(1 - ν²) under plane strain, with any Poisson's ratio and no locking."""
    young, length, height = 1e6, 1.0, 0.1
    positions, corners = grid(5, 1, length, height)
    group = elements(positions, corners, Elastic(1.0, young, poisson))
    n = len(positions)
    matrix = stiffness_of(group, n)
    load = np.zeros((n, 2))
    load[-2:, 0] = [1.0, -1.0]  # N, a couple of 0.1 N m
    held = np.zeros((n, 2), bool)
    held[:2, 0] = True
    held[0, 1] = True
    free = np.flatnonzero(~held.ravel())
    moved = np.zeros(2 * n)
    moved[free] = np.linalg.solve(matrix[np.ix_(free, free)], load.ravel()[free])
    turned = (moved.reshape(n, 2)[-2, 0] - moved.reshape(n, 2)[-1, 0]) / height
    exact = height * length / (young * height**3 / 12.0 / (1.0 - poisson**2))
    off = abs(turned / exact - 1.0)
    evidence(TOPIC, "one element across a bent strip, any Poisson's ratio", off, 1e-9, "plate theory")


@pytest.mark.slow
def test_elements_turn_rigidly_without_stress_and_resist_every_hourglass():
    positions, corners = grid(1, 1, 0.3, 0.2)
    group = elements(positions, corners, Elastic(1.0, 1e6, 0.3))
    c, s = np.cos(1.1), np.sin(1.1)
    turned = positions @ np.array([[c, s], [-s, c]]) - positions + [0.7, -0.2]
    found = forces_of(group, turned)
    assert np.abs(np.asarray(found.forces)).max() < 1e-9 and float(found.stored) < 1e-20
    values = np.linalg.eigvalsh(stiffness_of(group, 4))
    assert np.count_nonzero(values < 1e-8 * values[-1]) == 3, "the rigid motions alone"


def test_a_cantilevers_frequencies(evidence):
    """Plane stress, 1 × 0.06 m aluminium: Euler-Bernoulli with Timoshenko's correction for the slender first modes."""
    young, density, length, height = 70e9, 2700.0, 1.0, 0.03
    positions, corners = grid(60, 2, length, height)
    group = elements(positions, corners, Elastic(density, young, 0.3, "stress"))
    n = len(positions)
    free = np.flatnonzero(positions.repeat(2, axis=0)[:, 0] > 0.0)
    matrix = stiffness_of(group, n)[np.ix_(free, free)]
    mass = np.repeat(np.asarray(group.mass()), 2)[free]
    found = np.sqrt(eigh(matrix, np.diag(mass), eigvals_only=True, subset_by_index=[0, 2])) / (2.0 * np.pi)
    beam = np.sqrt(young * height**2 / 12.0 / density) / (2.0 * np.pi * length**2)
    exact = beam * np.array([1.875104, 4.694091, 7.854757]) ** 2
    off = np.max(np.abs(found / (exact * [1.0, 0.997, 0.992]) - 1.0))
    evidence(TOPIC, "three frequencies of a cantilever", off, 4e-3, "Euler-Bernoulli and Timoshenko")


@pytest.mark.slow
def test_forces_are_the_slope_of_the_energy():
    """Of an elastic element far from its rest, by differences."""
    rng = np.random.default_rng(1)
    positions, corners = grid(2, 1, 1.0, 0.4)
    group = elements(positions, corners, Elastic(1.0, 10.0, 0.35))
    here, way = (0.1 * rng.standard_normal(positions.shape) for _ in range(2))
    energy = lambda h: float(forces_of(group, here + h * way).stored)  # noqa: E731
    slope = (energy(1e-5) - energy(-1e-5)) / 2e-5
    assert np.sum(np.asarray(forces_of(group, here).forces) * way) == pytest.approx(slope, rel=1e-8)


def test_orthotropic_moduli_come_out_as_they_went_in():
    """Stretched along either axis with the other free, under plane strain: E_i/(1 - ν_i3 ν_3i)."""
    young, poisson = np.array([40e9, 10e9, 20e9]), np.array([0.28, 0.3, 0.1])
    material = Orthotropic(1800.0, jnp.asarray(young), jnp.asarray(poisson), 4e9)
    first, second = map(float, material.coupling())
    stress = np.asarray(material.answer(jnp.array([1e-3, -first * 1e-3, 0.0]), None).stress)
    assert abs(stress[1]) < 1e-6 * stress[0]
    v13, v31 = poisson[1], poisson[1] * young[2] / young[0]
    assert stress[0] == pytest.approx(1e-3 * young[0] / (1.0 - v13 * v31), rel=1e-12)
    stress = np.asarray(material.answer(jnp.array([-second * 1e-3, 1e-3, 0.0]), None).stress)
    v23, v32 = poisson[2], poisson[2] * young[2] / young[1]
    assert stress[1] == pytest.approx(1e-3 * young[1] / (1.0 - v23 * v32), rel=1e-12)
    same = Orthotropic(1.0, jnp.full(3, 5.0), jnp.full(3, 0.3), 5.0 / 2.6)
    strain = jnp.array([0.01, -0.03, 0.02])
    np.testing.assert_allclose(same.answer(strain, None).stress, Elastic(1.0, 5.0, 0.3).answer(strain, None).stress)


@pytest.mark.long
def test_the_element_bounds_the_frequency_of_the_assembly():
    positions, corners = grid(6, 3, 1.0, 0.5)
    positions = positions + 0.02 * np.sin(7.0 * positions[:, ::-1])
    group = elements(positions, corners, Elastic(3.0, 50.0, 0.3))
    mass = np.repeat(np.asarray(group.mass()), 2)
    highest = np.sqrt(eigh(stiffness_of(group, len(positions)), np.diag(mass), eigvals_only=True)[-1])
    assert highest <= float(group.fastest().max()) * (1.0 + 1e-12)
    assert highest > 0.7 * float(group.fastest().max())


def test_clockwise_corners_are_refused():
    corners = np.array([[0, 1, 2, 3], [0, 3, 2, 1]])
    square = jnp.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    with pytest.raises(InputError, match="corners of element 1 are not counter-clockwise"):
        Quads.of(square, corners)


def test_eigenvalues_of_elements_are_sizes_one_by_one():
    """Many at once share XLA's threads, for which programs that run side by side, as in a sweep, wait forever."""
    positions, corners = grid(20, 4, 1.0, 0.1)
    wall = elements(positions, corners, Elastic(1.0, 100.0, 0.3, "strain"))
    sizes = re.findall(r"f64\[([\d,]+)\] \w+:f64\[[\d,]+\] = eigh", str(jax.make_jaxpr(wall.fastest)()))
    assert sizes == ["8,8"]
