"""Coefficients of the step methods against published tables and order conditions."""

import diffrax
import jax
import numpy as np
import pytest
from scipy.integrate._ivp import dop853_coefficients as published

from jaxbuffer.hybrid.rungekutta import dop853
from jaxbuffer.hybrid.rungekutta.tableaus import diagonally_implicit, one_of

IMPLICIT = {
    "Kvaerno3": (diffrax.Kvaerno3(), 3),
    "Kvaerno5": (diffrax.Kvaerno5(), 5),
    "KenCarp5": (diffrax.KenCarp5(), 5),
}


def test_dop853_is_hairers():
    """As SciPy has copied them too."""
    method, n = dop853.METHOD, published.N_STAGES
    np.testing.assert_allclose(method.weights[:n, :n], published.A[:n, :n], rtol=1e-15)
    np.testing.assert_allclose(method.weights[n, :n], published.B, rtol=1e-15)
    np.testing.assert_allclose(method.nodes[:n], published.C[:n], rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(np.abs(method.errors), np.abs([published.E5, published.E3]), rtol=1e-14)
    assert (method.gamma, method.stages, float(method.order)) == (0.0, n + 1, 8.0)


def test_dop853_meets_the_conditions_of_order_8():
    """Σ b c^k = 1/(k+1); both estimates are of differences, so that they add up to nothing."""
    method = dop853.METHOD
    b, c = method.weights[-1], method.nodes
    np.testing.assert_allclose([b @ c**k for k in range(8)], 1.0 / np.arange(1.0, 9.0), rtol=1e-12)
    np.testing.assert_allclose(np.sum(method.errors, axis=1), 0.0, atol=1e-13)
    # of orders 5 and 3
    np.testing.assert_allclose([method.errors[0] @ c**k for k in range(5)], 0.0, atol=1e-12)
    np.testing.assert_allclose([method.errors[1] @ c**k for k in range(3)], 0.0, atol=1e-12)


@pytest.mark.parametrize("name", IMPLICIT)
def test_diagonally_implicit_methods_meet_their_conditions(name):
    """Σ b c^k = 1/(k+1), Σ b A c = 1/6; every stage but the first and the last holds itself by γ."""
    solver, order = IMPLICIT[name]
    method = diagonally_implicit(solver)
    n = len(method.nodes)
    own = np.diag([0.0, *[method.gamma] * (n - 2), 0.0])
    a, b, c = method.weights + own, method.weights[-1], method.nodes
    assert np.all(np.triu(method.weights) == 0.0)
    np.testing.assert_allclose(a.sum(axis=1), c, atol=1e-13)
    assert c[-1] == 1.0
    np.testing.assert_allclose([b @ c**k for k in range(order)], 1.0 / np.arange(1.0, order + 1.0), rtol=1e-9)
    np.testing.assert_allclose(b @ a @ c, 1.0 / 6.0, rtol=1e-9)
    np.testing.assert_allclose(np.sum(method.errors[0]), 0.0, atol=1e-12)
    assert method.errors[0, -1] == 0.0
    assert np.all(method.errors[1] == 0.0)
    assert method.stages == n


def test_a_method_picked_at_run_time_is_that_method():
    """The shorter one filled up with zeros, its rows of weights below those of the other."""
    methods = dop853.METHOD, diagonally_implicit(diffrax.Kvaerno5())
    longest = len(methods[0].nodes)
    picked = jax.jit(lambda which: one_of(methods, which))
    for which, method in enumerate(methods):
        found, n = jax.tree.map(np.asarray, picked(which)), len(method.nodes)
        first = int(found.first)
        assert (first, int(found.stages)) == (which * longest, n)
        np.testing.assert_array_equal(found.weights[first : first + n, :n], method.weights)
        assert np.all(found.weights[first : first + n, n:] == 0.0)
        np.testing.assert_array_equal(found.nodes[:n], method.nodes)
        np.testing.assert_array_equal(found.errors[:, :n], method.errors)
        assert np.all(found.nodes[n:] == 0.0)
        assert np.all(found.errors[:, n:] == 0.0)
        assert (float(found.gamma), float(found.order)) == (method.gamma, method.order)
