"""Stored vectors are the vectors they were, and are evaluated once."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.hybrid.rungekutta.newton import summed
from jaxbuffer.hybrid.sensitivity.stored import Store

VALUES = np.array([1.5, -0.0, 0.0, np.inf, -np.inf, np.nan, 5e-324, -1.7e308])


@pytest.mark.parametrize("example", [np.ones(2), np.array([[-3.0, 0.0], [1.0, 2.0]]), np.array([np.inf, np.nan])])
def test_a_stored_vector_has_the_same_bits(example):
    found = jax.jit(lambda vector, example: Store.of(example)(vector))(VALUES, example)
    np.testing.assert_array_equal(np.asarray(found).view(np.int64), VALUES.view(np.int64))


def products(stored):
    """How many products a compiled program holds in which one vector has three users."""

    def function(x):
        product = 3.25 * x
        product = Store.of(x)(product) if stored else product
        return [jnp.sqrt(product + shift) for shift in (1.0, 2.0, 4.0)]

    return jax.jit(function).lower(jnp.ones(8)).compile().as_text().count(" multiply(")


def test_xla_evaluates_a_stored_vector_once():
    """A product more makes the zeros."""
    assert products(stored=False) == 3
    assert products(stored=True) == 2


@pytest.mark.parametrize("count", [0, 1, 6, 7, 12, 13])
def test_sums_of_few_terms_at_a_time(count):
    terms = np.arange(10.0 * count).reshape(count, 2, 5) ** 2
    np.testing.assert_array_equal(summed(jnp.asarray(terms)), terms.sum(axis=0))
