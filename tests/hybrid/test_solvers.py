"""The linearisation and the fastest rate that steppers rely on, against the exact Jacobian."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from in_short import quick
from jaxbuffer.mechanisms.probe_cone.assembly import assemble

POSITIONS = 12


@jax.jit
def _seen(design, scenario):
    """Compiled once for each kind of tip, whatever the design's numbers are."""
    mechanism = assemble(design, scenario, 0.0)
    state, active = mechanism.start()
    # Press the tip 5 µm into the flank and let it nearly stick, so that friction is steep.
    state = state.at[9].add(-5e-6).at[10].add(5e-6).at[9 + 12].set(0.1)
    part = mechanism.linearisation(0.0, state, active)
    by_position = -part.response @ part.stiffness @ part.directions[:POSITIONS].T
    by_velocity = -part.response @ part.damping @ part.directions.T
    exact = jax.jacfwd(lambda y: mechanism.derivative(0.0, y, active))(state)
    return by_position, by_velocity, part.fastest(), exact


def seen(values):
    """What the closed-form linearisation says of accelerations by positions and by velocities, and of the fastest
    rate; the exact Jacobian, of positions, velocities and a free tip's spin."""
    numbers = jax.tree.map(lambda x: jnp.asarray(x, float), (jb.replace(jb.table2(), values), jb.Scenario()))
    *found, exact = _seen(*numbers)
    moving = 2 * POSITIONS + values["probe.free_tip"]
    return *found, exact[:moving, :moving]


@pytest.mark.parametrize("free_tip", quick([False, True], False))
def test_linearisation_holds_every_stiff_force(free_tip):
    """What the closed-form linearisation leaves out of the exact Jacobian is small against what it holds."""
    stiff = {"buffer.k_A": 1e8, "buffer.c_A": 1e4, "buffer.k_T": 1e6, "buffer.c_T": 1e2}
    by_position, by_velocity, _, exact = seen({"probe.free_tip": free_tip} | stiff)
    accelerations = exact[POSITIONS:]
    for approximate, true in (
        (by_position, accelerations[:, :POSITIONS]),
        (by_velocity, accelerations[:, POSITIONS:]),
    ):
        assert float(jnp.max(jnp.abs(true))) > 1e4
        assert float(jnp.max(jnp.abs(approximate - true))) < 2e-3 * float(jnp.max(jnp.abs(true)))


@pytest.mark.parametrize("free_tip", quick([False, True], False))
@pytest.mark.parametrize("stiff", [{}, {"buffer.c_A": 1e4}, {"contact.slip_speed": 1e-5}])
def test_fastest_rate_bounds_the_eigenvalues(free_tip, stiff):
    """It may overrate them, since the forces do not all act together, within a factor 2."""
    *_, fastest, exact = seen({"probe.free_tip": free_tip} | stiff)
    largest = float(np.max(np.abs(np.linalg.eigvals(np.asarray(exact)))))
    assert largest > 1e3
    assert 0.95 * largest < float(fastest) < 2.0 * largest
