"""`benchmarks.lanes.transform`: a function in lanes does in each lane what it does alone."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from benchmarks.lanes.transform import Lanes, Mapped, Stored
from jax import lax

COUNT = 4
X = np.linspace(-1.0, 2.0, 3 * COUNT).reshape(3, COUNT)
N = np.array([0, 2, 5, 3])


def halved_until_small(x, n):
    """A loop that lasts differently long in each lane."""
    return lax.while_loop(lambda s: s[0] < n, lambda s: (s[0] + 1, 0.5 * s[1] + jnp.max(s[1])), (0, x))[1]


def one_of_two(x, n):
    """A condition that is not the same in all lanes."""
    return lax.cond(n > 2, lambda: jnp.sort(jnp.concatenate([x, x**2]))[::2], lambda: jnp.sin(x) + jnp.argmin(x))


def entries(x, n):
    """Reading and writing at places that differ."""
    table = jnp.arange(40.0).reshape(8, 5)
    written = lax.dynamic_update_index_in_dim(jnp.zeros((6, 3)), x, n, 0)
    return written[n] + x[n % 3] + table[n][0] + jnp.sum(jnp.pad(x, (1, 2)) * jnp.arange(6.0))


@pytest.mark.parametrize("function", [halved_until_small, one_of_two, entries])
def test_a_function_in_lanes_is_the_function_in_each(function):
    traced = jax.make_jaxpr(function)(X[:, 0], N[0])
    mapped = Mapped(jnp.arange(COUNT), jnp.ones(COUNT, bool))
    (found,) = mapped.call(traced.jaxpr, traced.consts, [Lanes(jnp.asarray(X)), Lanes(jnp.asarray(N))])
    for lane in range(COUNT):
        np.testing.assert_allclose(found.array[..., lane], function(X[:, lane], N[lane]), rtol=1e-14)


def test_each_lane_writes_to_the_place_of_its_own_run():
    write = jax.make_jaxpr(lambda log, slot, entry: lax.dynamic_update_index_in_dim(log, entry, slot, 0))
    traced = write(np.zeros((6, 3)), 0, X[:, 0])
    places = np.array([4, 0, 2, 1])
    mapped = Mapped(jnp.asarray(places), jnp.ones(COUNT, bool))
    given = [Stored(jnp.zeros((5, 6, 3))), Lanes(jnp.asarray(N)), Lanes(jnp.asarray(X))]
    (found,) = mapped.call(traced.jaxpr, traced.consts, given)
    expected = np.zeros((5, 6, 3))
    expected[places, N] = X.T
    np.testing.assert_array_equal(found.array, expected)
