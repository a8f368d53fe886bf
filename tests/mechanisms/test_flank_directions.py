"""The directions along which a flank's force acts on the capture mechanism, against rates of the gap and the slip."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mechanisms.states import TIPS, mechanism, pressed


@pytest.mark.quick
@pytest.mark.parametrize(("place", "tip"), [("lower flank", "welded"), ("upper mouth rim", "free")])
def test_rates_of_depth_and_slip(place, tip):
    """δ̇ = b·w is minus the gap's derivative along the motion, and b·w of the tangents is the speed of slip."""
    assembled = mechanism(TIPS[tip])
    state, _ = pressed(assembled, place, 3)
    at = assembled.evaluate(state)
    motion = jnp.zeros(state.shape).at[:12].set(state[12:24])
    growing = jax.jvp(lambda y: assembled.evaluate(y).elements[0].approach.gap, (state,), (motion,))[1]
    normals, tangents = assembled.elements[0].directions(assembled.system, at.elements[0])
    speeds = np.asarray(state[12 : 24 + assembled.spins])
    assert np.max(np.abs(growing)) > 1e-2
    np.testing.assert_allclose(speeds @ np.asarray(normals), -growing, rtol=1e-9)
    np.testing.assert_allclose(speeds @ np.asarray(tangents), at.elements[0].approach.slip, rtol=1e-9)
