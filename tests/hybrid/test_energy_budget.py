"""How much a step may change the invariant: errors of one sign add up to about the tolerance, however many they are."""

import math

import jax
import jax.numpy as jnp
import pytest

from jaxbuffer.hybrid.loop.trial import _allowed_change, _share_left
from jaxbuffer.hybrid.system import HybridSystem

SHARE = HybridSystem.invariant_change.fget(None)


def test_the_first_step_may_make_its_share_of_the_tolerance():
    assert float(_allowed_change(0.0, SHARE, 1e-6)) == pytest.approx(0.03e-6, rel=1e-12)


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_ten_thousand_steps_that_lose_all_they_may_lose_the_tolerance(sign, rtol):
    total = jax.lax.fori_loop(0, 10_000, lambda _, sum: sum + sign * _allowed_change(sum, SHARE, rtol), jnp.zeros(()))
    assert 0.5 * rtol < sign * float(total) < rtol


def test_what_newtons_method_may_leave_open_falls_with_the_share():
    """Each step's implicit stages are solved as closely as the invariant still allows: from all of it down to 1e-4."""
    assert float(_share_left(0.0, 1e-6)) == 1.0
    assert float(_share_left(0.3e-6, 1e-6)) == pytest.approx(math.exp(-1.0), rel=1e-12)
    assert float(_share_left(-2e-6, 1e-6)) == pytest.approx(1e-4, rel=1e-12)
