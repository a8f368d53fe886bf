"""The second derivative at a step's end, against a driven oscillator's in closed form."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.integrate import Automatic, DiagonallyImplicit, ExplicitRungeKutta
from jaxbuffer.integrate.stages import Watch
from jaxbuffer.integrate.stride import Stride
from jaxbuffer.mechanisms.hybrid import Linearisation

FREQUENCY, DRIVE = 40.0, 3.0  # 1/s; the rows beside the state are sensitivities to nothing


def field(time, columns):
    """Of x'' = -FREQUENCY² x + cos(DRIVE t)."""
    x, v = columns
    return jnp.stack([v, -(FREQUENCY**2) * x + jnp.cos(DRIVE * time)])


def oscillator():
    """Its stiff part: the spring."""
    one = jnp.ones((1, 1))
    return Linearisation(one, one, FREQUENCY**2 * one, 0.0 * one, 1)


def step(solver, which, length, near):
    """A step from t = 0.2 s, its second derivative watched or not."""
    columns = jnp.array([[0.3, 0.0], [2.0, 1.0]])
    time, watch = jnp.asarray(0.2), Watch(lambda state, rate: jnp.asarray(near), jnp.asarray(1e-5))
    rate, allowance = field(time, columns), jnp.full((2, 2), 1e-9)
    stride = Stride.even(jnp.asarray(length))
    return solver.step(jnp.asarray(which), field, oscillator(), time, columns, rate, stride, allowance, watch)


@pytest.mark.parametrize(
    ("solver", "which"), [(ExplicitRungeKutta(), 0), (DiagonallyImplicit(), 0), (Automatic(), 0), (Automatic(), 1)]
)
@pytest.mark.parametrize("length", [0.0, 5e-3])
def test_the_second_derivative_at_the_end(solver, which, length):
    """Of the state and of the rows beside it, by both methods, alone and one after the other in the longer one's room;
    and where no step is taken at all."""
    found = step(solver, which, length, near=True)
    (x, v), time = found.end, 0.2 + length
    exact = [-(FREQUENCY**2) * x + jnp.cos(DRIVE * time), -(FREQUENCY**2) * v - DRIVE * jnp.sin(DRIVE * time)]
    np.testing.assert_allclose(found.second, exact, rtol=1e-7)


@pytest.mark.parametrize("which", [0, 1])
def test_nothing_else_changes_where_it_is_watched(which):
    """Zeros where it is not wanted; the step itself is the same."""
    watched, alone = (step(Automatic(), which, 5e-3, near) for near in (True, False))
    assert not np.any(alone.second)
    for name in ("end", "rate", "error"):
        np.testing.assert_array_equal(getattr(watched, name), getattr(alone, name))
