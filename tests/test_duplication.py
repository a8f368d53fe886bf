"""What is evaluated once keeps its value and its derivatives, and is compiled once."""

import jax
import jax.numpy as jnp
import numpy as np

from jaxbuffer.duplication import evaluated_once


def chain(x):
    """Cheap operations whose result is used in many places."""
    for factor in range(1, 9):
        x = (x - 0.1 * factor) * x
    return x


def many_uses(y):
    """Sums of different lengths, which are loops of their own: each would evaluate the chain anew."""
    return [jnp.sum(jnp.arange(float(n)) * y) for n in range(2, 8)]


def operations(function):
    text = jax.jit(function).lower(0.7).compile().as_text()
    return text.count(" multiply(")


def test_a_chain_is_compiled_once():
    anew, once = operations(lambda x: many_uses(chain(x))), operations(lambda x: many_uses(evaluated_once(chain(x))))
    assert anew >= 6 * 8  # in each of the six sums
    assert once <= 8 + 2 * 6


def test_numbers_and_derivatives_stay_as_they_are():
    values = {"array": jnp.asarray([0.3, -2.0, 0.0]), "number": 4.0}
    np.testing.assert_array_equal(evaluated_once(values)["array"], values["array"])
    assert evaluated_once(values)["number"] is values["number"]
    square = jax.jit(jax.grad(lambda x: evaluated_once(x) ** 2))
    assert float(square(1.5)) == 3.0


def test_what_is_linear_stays_linear():
    _, push = jax.linearize(lambda x: evaluated_once(2.0 * x), 1.5)
    (pulled,) = jax.linear_transpose(push, 1.0)(jnp.asarray(3.0))
    assert float(pulled) == 6.0
