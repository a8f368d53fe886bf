"""A history's steps: all that were kept, then the last one again."""

import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer.run.history as module
from jaxbuffer.hybrid import Steps


@pytest.mark.parametrize(("taken", "expected"), [
    (0, [0.0, 0.0, 0.0, 0.0]), (1, [1.0, 1.0, 1.0, 1.0]), (3, [1.0, 2.0, 3.0, 3.0]), (4, [1.0, 2.0, 3.0, 4.0]),
    (6, [1.0, 2.0, 3.0, 4.0]),
])  # fmt: skip
def test_the_last_step_is_repeated(monkeypatch, taken, expected):
    monkeypatch.setattr(module, "seen_at", lambda system, time, active, state: (time, active, state))
    steps = Steps.empty(4, jnp.zeros((2, 3)), 2)
    for k in range(1, taken + 1):
        rows = jnp.stack([jnp.full(3, 10.0 * k), jnp.full(3, -1.0)])
        steps = steps.append(jnp.asarray(True), jnp.asarray(float(k)), jnp.full(2, 0.1 * k), rows)
    spare = jnp.asarray(False), jnp.asarray(99.0), jnp.full(2, 99.0), jnp.full((2, 3), 99.0)
    time, active, state = module.history(None, steps.append(*spare))
    np.testing.assert_array_equal(time, expected)
    np.testing.assert_allclose(active, 0.1 * np.outer(expected, np.ones(2)), rtol=1e-15)
    np.testing.assert_array_equal(state, 10.0 * np.outer(expected, np.ones(3)))


def test_trimmed_to_what_was_kept():
    full = {"time": jnp.arange(5.0)}
    np.testing.assert_array_equal(module.trimmed(full, 3)["time"], [0.0, 1.0, 2.0])
