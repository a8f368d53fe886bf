"""Where everything is, and how it moves, at a free start: section "start" of the model, in plain trigonometry."""

import equinox as eqx
import numpy as np
import pytest
from numpy.testing import assert_allclose

from docking.states import LATCH, mechanism
from jaxbuffer.elements.ball_contact import SLOWEST_TOUCHDOWN

FREE = {
    "start": "free",
    "offset": 0.02,
    "standoff": 0.01,
    "lateral_speed": 0.013,
    "active_angle": 0.05,
    "active_rate": -0.02,
    "misalignment": -0.03,
    "passive_rate": 0.005,
}


@eqx.filter_jit
def first_state(assembled):
    """The first state, which contacts are closed there, and what they remember."""
    state, active = assembled.start()
    return state, active, assembled.memory(state)


@eqx.filter_jit
def first_parts(assembled):
    """Velocities, the constraints, the buffer's state and the contacts' gaps at the start."""
    at, _ = assembled.first_evaluation()
    constraints, buffer = assembled.system.constraints(at.kin), assembled.evaluated(at, "buffer")
    return at.kin.v, constraints, buffer, at.elements[0].approach.gap


@eqx.filter_jit
def first_energies(assembled):
    """Energy of relative motion at the start, and the one in the state; masses and positions."""
    at, active = assembled.first_evaluation()
    energies = assembled.relative_energy(at, active), assembled.part(at.state, "first energy")
    return *energies, assembled.system.masses(), at.kin.q


@eqx.filter_jit  # once for all states of a mechanism
def tip_of(assembled, state):
    return tuple(assembled.evaluated(assembled.evaluate(state), "throat").tip)


@eqx.filter_jit
def terminals(assembled, state):
    return assembled.terminals_at(assembled.evaluate(state))


@pytest.mark.parametrize("free_tip", [False, True], ids=["welded tip", "free tip"])
def test_positions_and_velocities(free_tip):
    assembled = mechanism({"probe.free_tip": free_tip}, **FREE)
    state, active, memory = map(np.asarray, first_state(assembled))
    q, v = state[:12].reshape(4, 3), state[12:24].reshape(4, 3)
    # The tip's centre in the axes of T: its radius before the mouth, by the standoff before that.
    local = np.array([-0.096 - 0.0735 * np.sqrt(0.5) - 0.015 - 0.01, 0.02])
    cos, sin = np.cos(-0.03), np.sin(-0.03)
    tip = np.array([[cos, -sin], [sin, cos]]) @ local
    along, across = np.array([np.cos(0.05), np.sin(0.05)]), np.array([-np.sin(0.05), np.cos(0.05)])
    probe = tip - assembled.parts.probe.front * along
    cylinder = (
        probe - (assembled.parts.probe.rear + 0.1365 - 0.1365 / 2) * along
    )  # rear end, free spring, half the cylinder
    active_vehicle = cylinder + (0.1365 / 2 - 0.1365) * along
    assert_allclose(q[:, :2], [active_vehicle, cylinder, probe, [0.0, 0.0]], atol=1e-15)
    assert_allclose(q[:, 2], [0.05, 0.05, 0.05, -0.03])
    for body in range(3):  # turning about the centre of mass of S as one body
        arm = np.dot(q[body, :2] - active_vehicle, along)
        assert_allclose(v[body], [*(np.array([0.1, 0.013]) - 0.02 * arm * across), -0.02], atol=1e-16)
    assert_allclose(v[3], [0.0, 0.0, 0.005])
    if free_tip:
        assert state[24] == -0.02
    assert_allclose(active, 0.0)
    assert_allclose(memory, SLOWEST_TOUCHDOWN)


def test_it_is_on_the_constraints_and_the_spring_at_rest():
    assembled = mechanism(LATCH, **FREE)
    v, constraints, buffer, gap = first_parts(assembled)
    assert_allclose(constraints.phi, 0.0, atol=2e-16)
    assert_allclose(np.asarray(constraints.jacobian) @ np.asarray(v), 0.0, atol=1e-16)
    assert_allclose(buffer[1:], 0.0, atol=1e-16)
    assert np.all(np.asarray(gap) > 0.0)


def test_the_tip_stands_before_the_mouth_and_off_the_axis():
    assembled = mechanism(start="free", offset=-0.03, standoff=0.02)
    state, _, _ = first_state(assembled)
    assert_allclose(tip_of(assembled, state), [-0.096 - 0.0735 * np.sqrt(0.5) - 0.035, -0.03], rtol=1e-14)


def test_the_first_energy_of_relative_motion_is_that_of_two_bodies():
    """A straight approach off the axis: ½ m_1 m_2 v²/M less what turning as one rigid body takes, ½ H²/J."""
    assembled = mechanism(LATCH, start="free", offset=0.02)
    energy, in_state, masses, q = map(np.asarray, first_energies(assembled))
    masses, q = masses.reshape(4, 3), q.reshape(4, 3)
    front, passive = masses[:3, 0].sum(), masses[3, 0]
    whole = front + passive
    centre = masses[:, 0] @ q[:, :2] / whole
    inertia = masses[:, 2].sum() + masses[:, 0] @ np.sum((q[:, :2] - centre) ** 2, axis=1)
    turning = 0.1 * -(masses[:3, 0] @ (q[:3, 1] - centre[1]))
    expected = 0.5 * front * passive / whole * 0.1**2 - 0.5 * turning**2 / inertia
    assert_allclose(energy, expected, rtol=1e-12)
    assert_allclose(in_state, expected, rtol=1e-12)


@pytest.mark.parametrize("start", ["contact", "free"])
@pytest.mark.parametrize("side", [1.0, -1.0], ids=["upper", "lower"])
def test_a_tip_that_goes_round_the_rim_has_escaped_and_is_never_deep(start, side):
    """On a circle about the rim, from in front of the flank to behind it, where it keeps its distance from the back."""
    assembled = mechanism(start=start)
    state, _, _ = first_state(assembled)
    rim = np.array([-0.096 - 0.0735 * np.sqrt(0.5), side * (0.015 + 0.0735 * np.sqrt(0.5))])
    tip, guards = np.asarray(tip_of(assembled, state)), []
    for turn in np.radians(np.linspace(-60.0, 150.0, 106)):  # from the axis' direction back over the rim
        centre = rim + 1.3 * 0.015 * np.array([-np.cos(turn), side * np.sin(turn)])
        moved = np.array(state)
        for body in range(3):
            moved[3 * body : 3 * body + 2] += centre - tip
        guards.append(terminals(assembled, moved))
    names = assembled.end_outcomes
    escaped, deep = (np.asarray(guards)[:, names.index(name)] > 0.0 for name in ("escaped", "failed_penetration"))
    assert not escaped[0] and escaped[-1], "it goes all the way"
    assert not deep.any()
