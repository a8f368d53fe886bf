"""Error norm and step sizes against their formulas, worked out by hand."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.hybrid import Controller, HybridSystem, StepTolerance
from jaxbuffer.hybrid.rungekutta.controller import StepSizes

ORDER = jnp.asarray(10.0)


class Sized(HybridSystem):
    """A system that says how large the errors in its state matter, and nothing else."""

    magnitudes: jax.Array
    limits: jax.Array | None = None

    def scales(self):
        return self.magnitudes

    def scale_limits(self):
        return self.limits


norms, allowance = eqx.filter_jit(StepTolerance.norms), eqx.filter_jit(StepTolerance.allowance)
step_factor, adapt = jax.jit(Controller().factor), jax.jit(Controller().adapt)


def factor(norm, previous=1.0):
    return float(step_factor(*map(jnp.asarray, (norm, previous, ORDER))))


def adapted(norm, accepted, method=0, length=1e-3):
    sizes = StepSizes(jnp.array([2e-3, 5e-5]), jnp.array([2.0**-20, 0.5]))
    found = adapt(sizes, *map(jnp.asarray, (method, length, norm, ORDER, accepted)))
    return np.asarray(found.steps), np.asarray(found.norms)


@pytest.mark.parametrize(
    ("norm", "previous", "expected"),
    [
        (1.0, 1.0, 0.9),
        (2.0**-10, 2.0**-10, 0.9 * 2.0**0.4),  # a steady error: the integral part alone
        (2.0**-10, 2.0**-20, 0.9 * 2.0**0.1),  # an error on the rise slows the step's growth: 0.7 - 0.6
        (2.0**-10, 1.0, 0.9 * 2.0**0.7),
    ],
)
def test_proportional_integral_control(norm, previous, expected):
    """h'/h = 0.9 ε^(-(k_I + k_P)/k) ε_before^(k_P/k) with k_I = 0.4, k_P = 0.3 (Söderlind 2003, eq. 30; Hairer and
    Wanner II, IV.2, eq. 2.43c), at k = 10."""
    assert factor(norm, previous) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("previous", [1.0, 1e-4])
def test_a_refused_step_knows_the_present_error_alone(previous):
    """h'/h = 0.9 ε^(-1/k)."""
    assert factor(2.0**10, previous) == pytest.approx(0.45, rel=1e-14)


@pytest.mark.parametrize(("norm", "expected"), [(1e30, 0.2), (0.0, 0.9 * 10.0**0.7)])
def test_limits(norm, expected):
    """A fifth at least; a norm of zero counts as 1e-10."""
    assert factor(norm) == pytest.approx(expected, rel=1e-12)
    assert float(step_factor(*map(jnp.asarray, (1e-10, 1.0, 1.0)))) == 8.0


def test_a_resting_method_recovers():
    """By a tenth at each accepted step, from half of that step at least; not at refused ones."""
    steps, norms = adapted(2.0**-10, True)
    np.testing.assert_allclose(steps, [1e-3 * 0.9 * 2.0**0.1, 5e-4], rtol=1e-14)
    np.testing.assert_allclose(norms, [2.0**-10, 0.5])
    steps, norms = adapted(0.5, True, method=1, length=5e-5)
    np.testing.assert_allclose(steps, [2.2e-3, 5e-5 * 0.9 * 2.0**0.07 * 2.0**-0.03], rtol=1e-14)
    np.testing.assert_allclose(norms, [2.0**-20, 0.5])
    steps, norms = adapted(2.0**10, False)
    np.testing.assert_allclose(steps, [0.45e-3, 5e-5], rtol=1e-14)
    np.testing.assert_allclose(norms, [2.0**-20, 0.5])


@pytest.mark.parametrize("norm", [jnp.nan, jnp.inf])
def test_without_a_finite_error_a_tenth(norm):
    steps, norms = adapted(norm, False)
    np.testing.assert_allclose(steps, [1e-4, 5e-5], rtol=1e-14)
    np.testing.assert_allclose(norms, [2.0**-20, 0.5])


def test_a_tiny_error_is_remembered_as_one_ten_thousandth():
    assert adapted(1e-9, True)[1][0] == 1e-4


def test_norms_of_rows():
    """Root mean square of error over atol · scale + rtol · |y|, where y is the larger of both ends."""
    rows, end = jnp.array([[3.0, 0.0], [1.0, 0.0]]), jnp.array([[1.0, 0.0], [-9.0, 0.0]])
    error, scales = jnp.array([[0.8, 0.6], [2.0, 0.0]]), jnp.array([1.0, 2.0])
    # allowed: 0.1 + 0.1·3 = 0.4 and 0.2; 0.1 + 0.1·9 = 1.0 and 0.2
    expected = [np.sqrt((2.0**2 + 3.0**2) / 2.0), np.sqrt(2.0**2 / 2.0)]
    found = norms(StepTolerance(0.1, 0.1), error, rows, end, Sized(scales))
    np.testing.assert_allclose(found, expected, rtol=1e-14)


def test_a_limit_of_the_scale_holds_for_the_state_alone():
    """The rows of `test_norms_of_rows`: one error of the state is relative to 1.0 at most, no tangent is."""
    larger = jnp.array([[3.0, 0.0], [9.0, 0.0]])
    system = Sized(jnp.array([1.0, 2.0]), jnp.array([jnp.inf, 1.0]))
    expected = [[0.1 + 0.1 * 3.0, 0.1], [0.1 + 0.1 * 9.0, 0.2]]
    allowed = allowance(StepTolerance(0.1, 0.1), larger, system)
    np.testing.assert_allclose(allowed, expected, rtol=1e-14)


def test_a_limit_of_the_scale_goes_no_further_than_at_1e_5():
    """1e-7 · (1 + 300) is more than 1e-5 · 1, and less than 1e-5 · 4."""
    rows = jnp.array([[300.0, 300.0]])
    system = Sized(jnp.array([1.0, 1.0]), jnp.array([1.0, 4.0]))
    np.testing.assert_allclose(allowance(StepTolerance(1e-7, 1e-7), rows, system), [[1e-5, 301e-7]], rtol=1e-14)


def test_the_first_step_of_an_impact():
    """Of what suits rtol 1e-6: error ~ length⁵, and with tangents length^2.6; between nothing and 2.5 or 1 times."""
    assert float(StepTolerance(32e-6).first_step(0)) == pytest.approx(2.0, rel=1e-12)
    assert float(StepTolerance(1e-2).first_step(0)) == 2.5
    assert float(StepTolerance(1e-6).first_step(3)) == pytest.approx(0.6, rel=1e-12)
    assert float(StepTolerance(1e-2).first_step(3)) == 1.0
