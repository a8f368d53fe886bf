"""`jax.vmap(jb.simulate)` as on an accelerator, where all captures of a batch are stepped together."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.hybrid import lanes

SPEEDS = jnp.array([0.1, jnp.nan, 0.2])  # m/s


@pytest.mark.long
def test_lanes_are_the_runs_alone_and_one_fails_alone(monkeypatch):
    """Peak forces and their derivatives by the approach speed."""

    def peak(speed):
        return jb.simulate(jb.table2(), jb.Scenario(approach_speed=speed)).peak_force

    call = jax.value_and_grad(peak)
    alone = [jax.jit(call)(speed) for speed in SPEEDS[::2]]
    monkeypatch.setattr(lanes, "in_turn", lambda: False)
    force, slope = jax.jit(jax.vmap(call))(SPEEDS)
    assert np.isnan(force[1])
    np.testing.assert_allclose(force[::2], [one[0] for one in alone], rtol=1e-6)
    np.testing.assert_allclose(slope[::2], [one[1] for one in alone], rtol=1e-5)
