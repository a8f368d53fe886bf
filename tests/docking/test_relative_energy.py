"""Energy of relative motion: of two bodies by hand, and none of any motion of the whole as one rigid body."""

import equinox as eqx
import jax
import numpy as np
import pytest
from numpy.testing import assert_allclose

from docking.states import LATCH, mechanism, moving
from jaxbuffer.mechanisms.relative_energy import rigid_energy
from jaxbuffer.multibody import Body, System

SPIN, DRIFT = 0.4, np.array([0.3, -0.2])  # rad/s, m/s


@jax.jit  # once for all motions of two bodies
def energies(q, v):
    """Energy of the motion as one rigid body, and all kinetic energy, of 2 kg and 3 kg."""
    system = System((Body(2.0, 0.2), Body(3.0, 0.3)))
    kin = system.kinematics(q, v)
    return rigid_energy(system, kin), system.kinetic_energy(kin)


@eqx.filter_jit  # once for all states of a mechanism
def energies_of(assembled, state, active):
    """Energy of relative motion, and what is stored."""
    at = assembled.evaluate(state)
    return assembled.relative_energy(at, active), assembled.stored(at, active)


def test_two_bodies_by_hand():
    """2 kg at the origin and 3 kg at (1, 0), the latter moving across at 1 m/s: P²/2M = 0.9 J, H = 1.2 N m s about the
    centre of mass, J = 1.2 + 0.5 kg m²."""
    rigid, kinetic = map(float, energies(np.array([0.0, 0, 0, 1, 0, 0]), np.array([0.0, 0, 0, 0, 1, 0])))
    assert_allclose(rigid, 0.9 + 0.5 * 1.2**2 / 1.7, rtol=1e-14)
    assert_allclose(kinetic - rigid, 0.6 - 0.72 / 1.7, rtol=1e-14)


def test_where_the_origin_is_does_not_matter():
    v = np.array([0.1, 0.3, -0.5, 0.7, -0.2, 0.9])
    near, _ = energies(np.array([0.0, 0, 0, 1, 0, 0]), v)
    far, _ = energies(np.array([5.0, -7, 0, 6, -7, 0]), v)
    assert_allclose(near, far, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("free_tip", [False, True], ids=["welded tip", "free tip"])
@pytest.mark.parametrize("closed", [(), ("latch",)], ids=["open", "latched"])
def test_a_rigid_motion_of_the_whole_has_none(free_tip, closed):
    """What is left is what the springs hold."""
    assembled = mechanism(LATCH | {"probe.free_tip": free_tip})
    instant = moving(assembled, stroke=0.003, closed=closed, since_crossing=0.007)
    state = np.array(instant.state)
    q = state[:12].reshape(4, 3)
    v = np.column_stack([DRIFT[0] - SPIN * q[:, 1], DRIFT[1] + SPIN * q[:, 0], np.full(4, SPIN)])
    state[12:24] = v.ravel()
    if free_tip:
        state[24] = SPIN
    relative, stored = energies_of(assembled, state, instant.active)
    in_springs = sum(float(energy) for name, energy in stored.items() if name != "kinetic")
    assert in_springs > 1e-3
    assert_allclose(relative, in_springs, rtol=1e-12)


def test_a_tip_that_turns_by_itself_has_some():
    assembled = mechanism({"probe.free_tip": True})
    instant = moving(assembled)
    faster = np.array(instant.state)
    faster[24] += 2.0
    before, after = (float(energies_of(assembled, state, instant.active)[0]) for state in (instant.state, faster))
    inertia = float(assembled.parts.probe.tip_inertia)
    # ½ I_t ω² less its share of the rigid motion, which is of the order of I_t over the inertia of the whole.
    assert_allclose(after - before, 0.5 * inertia * (2.7**2 - 0.7**2), rtol=0.6)
    assert after > before
