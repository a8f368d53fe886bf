"""The directions along which a flank's force acts on the capture mechanism, against rates of the gap and the slip."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.mechanisms.probe_cone.linearisation import flank_directions
from mechanisms.states import PLACES, TIPS, mechanism, pressed


@pytest.mark.parametrize("tip", TIPS)
def test_rates_of_depth_and_slip(tip):
    """δ̇ = b·w is minus the gap's derivative along the motion, and b·w of the tangents is the speed of slip."""
    assembled = mechanism(TIPS[tip])

    @jax.jit
    def rates(state):
        motion = jnp.zeros(state.shape).at[:12].set(state[12:24])
        growing = jax.jvp(lambda y: assembled.posture(y).approach.gap, (state,), (motion,))[1]
        at = assembled.posture(state)
        normals, tangents = flank_directions(assembled, at)
        speeds = state[12 : 24 + assembled.spins]
        return speeds @ normals, -growing, speeds @ tangents, at.approach.slip

    for place in PLACES:
        deeper, expected, along, slip = (np.asarray(rate) for rate in rates(pressed(assembled, place, 3)[0]))
        assert np.max(np.abs(expected)) > 1e-2
        np.testing.assert_allclose(deeper, expected, rtol=1e-9)
        np.testing.assert_allclose(along, slip, rtol=1e-9)
