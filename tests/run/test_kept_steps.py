"""A history's steps: all that were kept, then the last one again."""

from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer.run.history as module
from jaxbuffer.hybrid import Steps
from jaxbuffer.multibody import Kinematics


@pytest.mark.parametrize(("taken", "expected"), [
    (0, [0.0, 0.0, 0.0, 0.0]), (1, [1.0, 1.0, 1.0, 1.0]), (3, [1.0, 2.0, 3.0, 3.0]), (4, [1.0, 2.0, 3.0, 4.0]),
    (6, [1.0, 2.0, 3.0, 4.0]),
])  # fmt: skip
def test_the_last_step_is_repeated(monkeypatch, taken, expected):
    monkeypatch.setattr(module, "history_at", lambda system, time, active, state: (time, active, state))
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


def test_of_bodies_that_bend_the_frames_are_shown():
    """Three numbers a body come first; what is left of the coordinates are modes."""
    q, v = jnp.arange(8.0), 10.0 + jnp.arange(8.0)
    posture = SimpleNamespace(kin=Kinematics(q, v, modes=(1, 1)))
    shown = SimpleNamespace(multipliers=jnp.zeros(3), gap=jnp.array([0.1]), approach_speed=jnp.array([0.2]),
                            slip=jnp.array([0.3]), normal=jnp.array([4.0]), friction=jnp.array([5.0]),
                            others={"own": 6.0}, acceleration=20.0 + jnp.arange(8.0))  # fmt: skip
    system = SimpleNamespace(evaluate=lambda state: posture, snapshot_at=lambda at, active: shown,
                             energy_at=lambda at, active: "energy")  # fmt: skip
    found = module.history_at(system, jnp.asarray(0.5), jnp.ones(1), jnp.zeros(16))
    np.testing.assert_array_equal(found.position, [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])
    np.testing.assert_array_equal(found.velocity, [[10.0, 11.0, 12.0], [13.0, 14.0, 15.0]])
    np.testing.assert_array_equal(found.acceleration, [[20.0, 21.0, 22.0], [23.0, 24.0, 25.0]])
    assert [float(x[0]) for x in (found.gap, found.approach_speed, found.slip)] == [0.1, 0.2, 0.3]
    assert (float(found.contact_force[0]), float(found.friction_force[0]), float(found.own)) == (4.0, 5.0, 6.0)
    assert float(found.time) == 0.5
    np.testing.assert_array_equal(found.closed, [1.0])
