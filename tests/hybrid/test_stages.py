"""The second derivative at a step's end, against a driven oscillator's in closed form."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import DOP853

from jaxbuffer.hybrid import Automatic, DiagonallyImplicit, ExplicitRungeKutta
from jaxbuffer.hybrid.rungekutta.stages import SecondDerivative
from jaxbuffer.hybrid.rungekutta.time_transform import TimeTransform
from jaxbuffer.hybrid.system import Linearisation

FREQUENCY, DRIVE = 40.0, 3.0  # 1/s; the rows beside the state are sensitivities to nothing


def field(time, columns):
    """Of x'' = -FREQUENCY² x + cos(DRIVE t)."""
    x, v = columns
    return jnp.stack([v, -(FREQUENCY**2) * x + jnp.cos(DRIVE * time)])


def oscillator():
    """Its stiff part: the spring."""
    one = jnp.ones((1, 1))
    return Linearisation(one, one, FREQUENCY**2 * one, 0.0 * one, 1)


def step(solver, which, length, needed):
    return _step(solver, *map(np.asarray, (which, length)), needed)


@eqx.filter_jit
def _step(solver, which, length, needed):
    """A step from t = 0.2 s, its second derivative needed or not, or where ``needed`` says so of state and rate."""
    when = needed if callable(needed) else lambda state, rate: jnp.asarray(needed)
    columns = jnp.array([[0.3, 0.0], [2.0, 1.0]])
    time, second = jnp.asarray(0.2), SecondDerivative(when, jnp.asarray(1e-5))
    rate, allowance = field(time, columns), jnp.full((2, 2), 1e-9)
    transform = TimeTransform.uniform(length)
    return solver.step(which, field, oscillator(), time, columns, rate, transform, allowance, second)


@pytest.mark.parametrize(
    ("solver", "which"), [(ExplicitRungeKutta(), 0), (DiagonallyImplicit(), 0), (Automatic(), 0), (Automatic(), 1)]
)
@pytest.mark.parametrize("length", [0.0, 5e-3])
def test_the_second_derivative_at_the_end(solver, which, length):
    """Of the state and of the rows beside it, by both methods, alone and in arrays long enough for either;
    and where no step is taken at all."""
    found = step(solver, which, length, needed=True)
    (x, v), time = np.asarray(found.end), 0.2 + length
    exact = [-(FREQUENCY**2) * x + np.cos(DRIVE * time), -(FREQUENCY**2) * v - DRIVE * np.sin(DRIVE * time)]
    np.testing.assert_allclose(found.second, exact, rtol=1e-7)


@pytest.mark.parametrize("which", [0, 1])
def test_nothing_else_changes_where_it_is_wanted(which):
    """Zeros where it is not needed; the step itself is the same."""
    with_it, without = (step(Automatic(), which, 5e-3, needed) for needed in (True, False))
    assert not np.any(without.second)
    for name in ("end", "rate", "error"):
        np.testing.assert_array_equal(getattr(with_it, name), getattr(without, name))


def high_and_falling(state, rate):
    return (state[0] > 0.1) & (rate[0] < 0.0)


def low_or_rising(state, rate):
    return (state[0] < 0.1) | (rate[0] > 0.0)


@pytest.mark.parametrize("which", [0, 1])
def test_the_state_decides_whether_it_is_needed(which):
    """Which ends at 0.3, moving at -0.4; the row beside it at 0.005, moving at 0.98."""
    of_state = step(Automatic(), which, 5e-3, high_and_falling)
    beside = step(Automatic(), which, 5e-3, low_or_rising)
    assert np.all(np.asarray(of_state.second) != 0.0) and not np.any(beside.second)


def test_the_estimated_error_is_hairers():
    """As SciPy estimates it of the same step."""
    length, start = 5e-2, np.array([0.3, 2.0])

    def rates(time, state):
        return np.array([state[1], -(FREQUENCY**2) * state[0] + np.cos(DRIVE * time)])

    theirs = DOP853(rates, 0.2, start, 1.0, first_step=length, max_step=length, rtol=1.0, atol=1e9)
    theirs.step()
    estimate = np.abs(theirs._estimate_error(theirs.K, length))
    ours = step(ExplicitRungeKutta(), 0, length, needed=False)
    assert np.min(estimate) > 1e-9
    np.testing.assert_allclose(np.abs(ours.error[:, 0]), estimate, rtol=1e-6)
