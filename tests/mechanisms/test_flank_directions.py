"""The directions along which a flank's force acts on the capture mechanism, against rates of the gap and the slip."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mechanisms.states import TIPS, mechanism, pressed


@eqx.filter_jit
def directions_and_rates(assembled, state):
    """The force's directions on both bodies, along normal and tangent, and the rates of gap and slip [m/s]."""
    ball, element = assembled.evaluate(state).elements[0], assembled.elements[0]
    motion = jnp.zeros(state.shape).at[:12].set(state[12:24])
    growing = jax.jvp(lambda y: assembled.evaluate(y).elements[0].approach.gap, (state,), (motion,))[1]
    return *element.directions(assembled.system, ball), growing, ball.approach.slip


@pytest.mark.quick
@pytest.mark.parametrize(("place", "tip"), [("lower flank", "welded"), ("upper mouth rim", "free")])
def test_rates_of_depth_and_slip(place, tip):
    """δ̇ = b·w is minus the gap's derivative along the motion, and b·w of the tangents is the speed of slip."""
    assembled = mechanism(TIPS[tip])
    state, _ = pressed(assembled, place, 3)
    normals, tangents, growing, slip = map(np.asarray, directions_and_rates(assembled, state))
    speeds = np.asarray(state[12 : 24 + assembled.spins])
    assert np.max(np.abs(growing)) > 1e-2
    np.testing.assert_allclose(speeds @ normals, -growing, rtol=1e-9)
    np.testing.assert_allclose(speeds @ tangents, slip, rtol=1e-9)
