"""A linear map on columns against the matrix of the same map, taken column by column."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.hybrid.sensitivity.batched_map import on_columns
from jaxbuffer.hybrid.sensitivity.linear_map import Unsupported
from jaxbuffer.mechanisms.probe_cone.assembly import assemble

COLUMNS = 4


def matrix(linear, *examples):
    """One column for each number that goes in, without the function's own derivative."""
    sizes = [np.size(x) for x in examples]
    columns, linear = [], jax.jit(linear)
    for unit in np.eye(sum(sizes)):
        parts = np.split(unit, np.cumsum(sizes)[:-1])
        columns.append(np.asarray(linear(*(np.reshape(p, np.shape(x)) for p, x in zip(parts, examples, strict=True)))))
    return np.stack(columns, axis=1)


def check(linear, *examples):
    """Random vectors through both."""
    draw = np.random.default_rng(0)
    vectors = [draw.normal(size=(*np.shape(x), COLUMNS)) for x in examples]
    found = jax.jit(on_columns(linear, *examples))(*vectors)
    inputs = np.concatenate([np.reshape(vector, (-1, COLUMNS)) for vector in vectors])
    expected = matrix(linear, *examples) @ inputs
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * np.max(np.abs(expected)))


def test_every_operation():
    a = jnp.asarray([[1.5, -2.0, 0.5], [0.0, 3.0, 1.0]])
    flags = jnp.asarray([True, False, True])

    def linear(x, s):
        doubled = jnp.stack([x, -x / 4.0], axis=0)
        mixed = jnp.where(flags, x, 2.0 * s - x)
        mean = jnp.sum(a * doubled, axis=1)
        moved = jnp.transpose(doubled)[1:, :].reshape(-1)
        return jnp.concatenate([mixed, mean, moved, s[None], jnp.zeros(1)])

    check(linear, jnp.zeros(3), jnp.zeros(()))


@pytest.mark.slow
@pytest.mark.parametrize("free_tip", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_the_linearised_right_hand_side(free_tip):
    design = jax.tree.map(lambda x: jnp.asarray(x, float), jb.replace(jb.table2(), {"probe.free_tip": free_tip}))
    scenario = jax.tree.map(lambda x: jnp.asarray(x, float), jb.Scenario())

    @jax.jit  # the linear map that it returns holds the numbers of the state
    def linearised(design, scenario):
        mechanism = assemble(design, scenario)
        state, active = mechanism.start()
        state = state.at[9].add(-5e-6).at[10].add(5e-6).at[9 + 12].set(0.1)
        _, push = jax.linearize(lambda y: mechanism.derivative(jnp.zeros(()), y, active), state)
        return push, state

    check(*linearised(design, scenario))


def test_what_a_mask_switches_off_may_be_infinite():
    steep = jnp.asarray([1.0, jnp.inf])

    def linear(x):
        return jnp.where(jnp.isfinite(steep), steep * x, 0.0)

    found = jax.jit(on_columns(linear, jnp.zeros(2)))(np.ones((2, COLUMNS)))
    np.testing.assert_array_equal(found, [[1.0] * COLUMNS, [0.0] * COLUMNS])


def test_an_unknown_operation_is_said():
    with pytest.raises(Unsupported, match="cumsum"):
        on_columns(jnp.cumsum, jnp.zeros(3))


def test_a_division_by_what_is_linear_is_said():
    with pytest.raises(Unsupported, match="div"):
        on_columns(lambda x: x / (1.0 + 0.0 * x), jnp.zeros(3))
