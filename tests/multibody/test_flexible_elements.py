"""Bar elements and their reduction after Craig and Bampton: the eigenvalues of beams."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import csr_array

from jaxbuffer.multibody.flexible import craig_bampton as module
from jaxbuffer.multibody.flexible.bar_elements import (
    axial_matrices,
    axial_shapes,
    bending_matrices,
    bending_shapes,
    geometric_matrix,
)
from jaxbuffer.multibody.flexible.bar_shapes import clamped_wave_numbers
from jaxbuffer.multibody.flexible.craig_bampton import Reduction, craig_bampton, uncoupled

TOPIC = "Modes of bars and shapes"
TEXTBOOK = "textbook values of βL"
FREE = (4.730040745, 7.853204624, 10.995607838, 14.137165491)
BETA = {  # held unknowns of the first node and of the last one: (w, dw/dξ)
    "clamped-free": ((0, 1), (), (1.875104069, 4.694091133, 7.854757438, 10.995540735, 14.137168391, 17.278759532)),
    "free-free": ((), (), (*FREE, 17.278759657)),
    "clamped-clamped": ((0, 1), (0, 1), (*FREE, 17.278759657)),
    "clamped-pinned": ((0, 1), (0,), (3.926602312, 7.068582746, 10.210176123)),
    "pinned-free": ((0,), (), (3.926602312, 7.068582746, 10.210176123)),
    "pinned-pinned": ((0,), (0,), tuple(np.pi * np.arange(1, 6))),
}
TABLE = {  # fixed-interface modes: β of the first modes of a free beam, 60 cubic elements, as printed
    0: ("5.18004", "9.57348"),
    2: ("4.73854797", "7.87041889", "14.27380"),
    4: ("4.73101176", "7.85681347", "11.01908561"),
    6: ("4.73024514", "7.85424507", "11.00272717"),
    8: ("4.73010217", "7.85358243", "10.99816918"),
}


def rigid_motions(elements):
    """Nodal (w, dw/dξ) of a unit displacement and of a unit rotation about the start."""
    xi = np.linspace(0.0, 1.0, elements + 1)
    motions = np.zeros((2 * elements + 2, 2))
    motions[0::2, 0], motions[0::2, 1], motions[1::2, 1] = 1.0, xi, 1.0
    return motions


def wave_numbers(elements, first, last):
    """β of a beam with the given unknowns of its first and last node held; rigid-body motions left out."""
    mass, stiffness = bending_matrices(elements)
    size = 2 * elements + 2
    kept = np.setdiff1d(np.arange(size), [*first, *(size - 2 + k for k in last)])
    mass, stiffness = mass[np.ix_(kept, kept)], stiffness[np.ix_(kept, kept)]
    squared = 1.0 / eigh(mass, stiffness + mass)[0][::-1] - 1.0
    return squared[squared > 1.0] ** 0.25


@pytest.mark.quick
@pytest.mark.parametrize("ends", BETA)
def test_wave_numbers_of_beams(ends, evidence):
    """An eigenvalue β⁴ of cubic elements of the length h is too large by the share (βh)⁴/720, β by a quarter of it."""
    first, last, printed = BETA[ends]
    found = wave_numbers(60, first, last)[: len(printed)]
    share = (np.array(printed) / 60) ** 4 / 720 / 4
    off = np.abs(found / printed - 1.0 - share) / (0.01 * share + 5e-10)
    claim = "βL of beams: too large by (βh)⁴/2880, in 1 % of that and half a printed digit"
    evidence(TOPIC, claim, max(off), 1.0, TEXTBOOK, detail=ends)


def test_eigenvalues_converge_with_the_fourth_order(evidence):
    exact = 1.875104068711961
    errors = [(wave_numbers(n, (0, 1), ())[0] / exact) ** 4 - 1.0 for n in (4, 8)]
    evidence(TOPIC, "order of convergence, bending", abs(np.log2(errors[0] / errors[1]) - 4.0), 0.05, "theory: 4")
    found = [eigh(axial_matrices(n)[1], axial_matrices(n)[0])[0][1] / np.pi**2 - 1.0 for n in (4, 8)]
    evidence(TOPIC, "order of convergence, along the bar", abs(np.log2(found[0] / found[1]) - 4.0), 0.05, "theory: 4")


def test_the_consistent_matrices_of_one_element():
    """As every textbook prints them (Przemieniecki 1968)."""
    mass, stiffness = bending_matrices(1)
    rows = [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
    np.testing.assert_allclose(mass, np.array(rows) / 420, rtol=1e-13)
    rows = [[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]
    np.testing.assert_allclose(stiffness, rows, atol=1e-12)
    rows = [[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]
    np.testing.assert_allclose(geometric_matrix(1, np.ones_like), np.array(rows) / 30, atol=1e-14)
    mass, stiffness = axial_matrices(1)
    np.testing.assert_allclose(mass, np.array([[4, 2, -1], [2, 16, 2], [-1, 2, 4]]) / 30, rtol=1e-13)
    np.testing.assert_allclose(stiffness, np.array([[7, -8, 1], [-8, 16, -8], [1, -8, 7]]) / 3, rtol=1e-13)


@pytest.mark.parametrize("shapes", [bending_shapes, axial_shapes])
def test_derivatives_of_shapes(shapes):
    """Against differences, inside elements."""
    xi = np.array([0.03, 0.31, 0.52, 0.97])
    for order in (0, 1):
        slope = (shapes(5, xi + 1e-6, order) - shapes(5, xi - 1e-6, order)) / 2e-6
        np.testing.assert_allclose(shapes(5, xi, order + 1), slope, atol=1e-6)


@pytest.mark.quick
def test_the_buckling_load_by_the_geometric_matrix(evidence):
    """A cantilever under an axial load P, and a column under its own weight: P L²/EI = π²/4, q L³/EI = 7.8373."""
    _, stiffness = bending_matrices(20)
    held = slice(2, None)
    for load, tension in ((np.pi**2 / 4, np.ones_like), (7.837347, lambda xi: 1.0 - xi)):
        geometric = geometric_matrix(20, tension)
        found = 1.0 / eigh(geometric[held, held], stiffness[held, held])[0][-1]
        evidence(
            TOPIC, "buckling loads by the geometric stiffness", abs(found / load - 1.0), 1e-6, "Euler; Greenhill 1881"
        )


@pytest.mark.parametrize("interior", TABLE)
def test_the_free_beams_table(interior, evidence):
    """Craig and Bampton with both end nodes (w, θ) kept."""
    mass, stiffness = bending_matrices(60)
    reduction = craig_bampton(mass, stiffness, [0, 1, 120, 121], interior)
    found = uncoupled(reduction, mass @ rigid_motions(60)).eigenvalues ** 0.25
    assert len(found) == interior + 2
    for beta, printed in zip(found, TABLE[interior], strict=False):
        last = 0.5 * 10.0 ** -len(printed.partition(".")[2])
        evidence(
            TOPIC,
            "free beam, reduced: β in half units of the last printed digit",
            abs(beta - float(printed)) / last,
            1.0,
            "an independent program",
            detail=f"{interior} modes: {printed}",
        )


def test_the_free_beam_without_reduction(evidence):
    """The reference has 8 decimals. An eigenvalue β⁴ is known to ε λ_max, so β to that over 4 β³: 2.4e-8 or less."""
    mass, stiffness = bending_matrices(60)
    eigenvalues = uncoupled(Reduction(np.eye(122), mass, stiffness), mass @ rigid_motions(60)).eigenvalues
    found = eigenvalues[:3] ** 0.25
    known = 5e-9 + np.finfo(float).eps * eigenvalues.max() / (4.0 * found**3)
    wrong = np.max(np.abs(found - np.array([4.73004081, 7.85320542, 10.99561213])) / known)
    evidence(TOPIC, "free beam, 60 elements: β, over digits and rounding", wrong, 1.0, "an independent program")


def test_rigid_body_motion_separates(evidence):
    mass, stiffness = bending_matrices(60)
    reduction = craig_bampton(mass, stiffness, [0, 1, 120, 121], 8)
    shapes = uncoupled(reduction, mass @ rigid_motions(60)).shapes
    evidence(TOPIC, "momentum of mean-axis modes", np.abs(rigid_motions(60).T @ mass @ shapes).max(), 1e-13, "zero")
    evidence(TOPIC, "modes orthonormal in the mass", np.abs(shapes.T @ mass @ shapes - np.eye(10)).max(), 1e-11, "one")


def test_constraint_modes_move_one_interface_unknown_each():
    mass, stiffness = bending_matrices(12)
    reduction = craig_bampton(mass, stiffness, [0, 1, 24, 25], 3)
    np.testing.assert_array_equal(reduction.basis[[0, 1, 24, 25]], np.eye(4, 7))
    inner = np.setdiff1d(np.arange(26), [0, 1, 24, 25])
    np.testing.assert_allclose((stiffness @ reduction.basis[:, :4])[inner], 0.0, atol=1e-9)
    np.testing.assert_allclose(reduction.stiffness[:4, 4:], 0.0, atol=1e-8)


def test_sparse_matrices_are_reduced_alike(monkeypatch, evidence):
    mass, stiffness = bending_matrices(20)
    expected = uncoupled(craig_bampton(mass, stiffness, [0, 1], 4), None)
    monkeypatch.setattr(module, "DENSE", 10)
    found = uncoupled(craig_bampton(csr_array(mass), csr_array(stiffness), [0, 1], 4), None)
    error = np.abs(found.eigenvalues[2:] / expected.eigenvalues[2:] - 1.0).max()
    evidence(TOPIC, "sparse and dense reduction", error, 1e-9, "each other")


def test_more_modes_than_there_are():
    mass, stiffness = bending_matrices(2)
    with pytest.raises(ValueError, match="modes: 7 is not between 0 and the 2"):
        craig_bampton(mass, stiffness, [0, 1, 4, 5], 7)


def test_wave_numbers_of_clamped_beams():
    np.testing.assert_allclose(clamped_wave_numbers(4), FREE, atol=5e-10)
