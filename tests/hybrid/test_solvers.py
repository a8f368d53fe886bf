"""The linearisation and the fastest rate that steppers rely on, against the exact Jacobian."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.probe_cone.assembly import assemble


def arrays(tree):
    return jax.tree.map(lambda x: jnp.asarray(x, float), tree)


@pytest.mark.parametrize("free_tip", [False, True])
def test_linearisation_holds_every_stiff_force(free_tip):
    """What the closed-form linearisation leaves out of the exact Jacobian is small against what it holds."""
    design = jb.replace(
        jb.table2(),
        {"probe.free_tip": free_tip, "buffer.k_A": 1e8, "buffer.c_A": 1e4, "buffer.k_T": 1e6, "buffer.c_T": 1e2},
    )
    mechanism = arrays(assemble(design, jb.Scenario(), 0.0))
    state, active = mechanism.start()
    # Press the tip 5 µm into the flank and let it nearly stick, so that friction is steep.
    state = state.at[9].add(-5e-6).at[10].add(5e-6).at[9 + 12].set(0.1)
    part = mechanism.linearisation(0.0, state, active)
    exact = jax.jacfwd(lambda y: mechanism.derivative(0.0, y, active))(state)
    w = slice(12, 12 + mechanism.coordinates + mechanism.spins)
    rows = slice(12, 24 + mechanism.spins)
    by_position = -part.response @ part.stiffness @ part.directions[:12].T
    by_velocity = -part.response @ part.damping @ part.directions.T
    for approximate, true in ((by_position, exact[rows, :12]), (by_velocity, exact[rows, w])):
        assert float(jnp.max(jnp.abs(true))) > 1e4
        assert float(jnp.max(jnp.abs(approximate - true))) < 2e-3 * float(jnp.max(jnp.abs(true)))


@pytest.mark.parametrize("free_tip", [False, True])
@pytest.mark.parametrize("stiff", [{}, {"buffer.c_A": 1e4}, {"contact.slip_speed": 1e-5}])
def test_fastest_rate_bounds_the_eigenvalues(free_tip, stiff):
    """It may overrate them, since the forces do not all act together, within a factor 2."""
    design = jb.replace(jb.table2(), {"probe.free_tip": free_tip, **stiff})
    mechanism = arrays(assemble(design, jb.Scenario(), 0.0))
    state, active = mechanism.start()
    state = state.at[9].add(-5e-6).at[10].add(5e-6).at[9 + 12].set(0.1)
    moving = np.s_[: 24 + mechanism.spins]
    exact = jax.jacfwd(lambda y: mechanism.derivative(0.0, y, active))(state)[moving, moving]
    largest = float(np.max(np.abs(np.linalg.eigvals(np.asarray(exact)))))
    assert largest > 1e3
    assert 0.95 * largest < float(mechanism.linearisation(0.0, state, active).fastest()) < 2.0 * largest
