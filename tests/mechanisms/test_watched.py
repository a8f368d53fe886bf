"""What is watched of a state for events, looked at together, against each quantity by itself and its derivatives."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from in_short import quick
from jaxbuffer.hybrid.system import HybridSystem
from mechanisms.states import PLACES, TIPS, mechanism, pressed

N = 12  # coordinates

each_place = pytest.mark.parametrize("place", quick(PLACES, *list(PLACES)[:2]))
each_tip = pytest.mark.parametrize("tip", TIPS)


def along(state):
    """The motion of the coordinates alone."""
    return jnp.zeros_like(state).at[:N].set(state[N : 2 * N])


@eqx.filter_jit  # once for all places of a mechanism
def watched_with_rates(assembled, state, active, push):
    """What is watched of a state and how it changes along the motion: together, and one by one."""
    rate = assembled.derivative(0.0, state, active)
    looks = (
        lambda y, r: assembled.watched(y, r, active),
        lambda y, r: HybridSystem.watched(assembled, y, r, active),
    )
    return [jax.jvp(look, (state, rate), (rate, push)) for look in looks]


@each_place
@each_tip
def test_together_as_one_by_one(tip, place):
    """Each from its own look at the state, with the gaps' rates by differentiation."""
    assembled = mechanism(TIPS[tip])
    state, active = pressed(assembled, place, 3)
    push = np.random.default_rng(3).normal(size=state.shape)
    (seen, moves), (seen_alone, moves_alone) = watched_with_rates(assembled, state, active, push)
    for ours, other in zip(jax.tree.leaves((seen, moves)), jax.tree.leaves((seen_alone, moves_alone)), strict=True):
        assert_allclose(ours, other, rtol=1e-9, atol=1e-12 * max(1.0, float(np.max(np.abs(other)))))
    assert np.all(np.asarray(moves.invariant) == 0.0), "nothing needs to know how it changes"


@eqx.filter_jit
def nearing_the_throat(assembled, state):
    """The rate that the mechanism gives for it [m/s], and the derivative of the distance along the motion."""

    def throat(y):
        return assembled.evaluated(assembled.evaluate(y), "throat")

    return throat(state).receding, jax.jvp(lambda y: throat(y).before, (state,), (along(state),))[1]


@pytest.mark.quick
@each_place
@each_tip
def test_how_fast_the_tip_nears_the_throat(tip, place):
    assembled = mechanism(TIPS[tip])
    state, _ = pressed(assembled, place, 4)
    assert_allclose(*nearing_the_throat(assembled, state), rtol=1e-13)
