"""The docking in space at an instant: what it conserves, and its misses and their rates."""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from in_short import often
from jaxbuffer import Scenario3D, docking3d, replace
from jaxbuffer.hybrid.sensitivity.batched_map import on_columns
from jaxbuffer.mechanisms.docking3d.assembly import assemble
from jaxbuffer.mechanisms.docking3d.misses import misses
from jaxbuffer.mechanisms.probe_cone.bodies import P, T
from jaxbuffer.multibody import assemble as projected

pytestmark = pytest.mark.slow

LATCH = {
    "latch.stiffness": 2e4,
    "latch.damping": 100.0,
    "latch.preload": 3.0,
    "latch.turn_stiffness": 50.0,
    "latch.turn_damping": 2.0,
}
PARTS = {
    "table 2": {},
    "all parts": {**LATCH, "probe.free_tip": True, "buffer.stop_stiffness": 2e4, "buffer.friction": 0.2},
}
TIP_SPIN = (0.3, -0.2, 0.4)  # rad/s


@functools.cache
def moving(parts):
    """The mechanism in a state on its joints in which everything turns and the tip touches the cone, all closed."""
    return started(replace(docking3d(), PARTS[parts]))


@eqx.filter_jit  # one program in place of its many operations
def started(design):
    mechanism = assemble(design, Scenario3D(azimuth=0.7, passive_pitch=0.03, passive_yaw=-0.02))
    rng, system = np.random.default_rng(3), mechanism.system
    q = mechanism.q + 2e-3 * rng.normal(size=mechanism.q.shape)
    q, v = projected(system, q, jnp.asarray(0.05 * rng.normal(size=mechanism.v.shape)))
    state, closed = mechanism.start()
    state = state.at[mechanism.places["q"]].set(q).at[mechanism.places["v"]].set(v)
    if mechanism.spins:
        state = state.at[mechanism.places["spins"]].set(jnp.asarray(TIP_SPIN))
    names = [element.name for element in mechanism.elements]
    if "latch" in names:
        # Long since they began to close: at t = 0 they would exert nothing.
        state = state.at[mechanism.places[f"element {names.index('latch')}"]].set(jnp.array([0.2, 0.0]))
    return mechanism, state, jnp.ones_like(closed)


def momenta(mechanism, state):
    """Linear momentum of each body, and angular momentum about the origin of each and of a free tip's spin."""
    kin = mechanism.kinematics(state)
    linear, angular = [], []
    for number, body in enumerate(mechanism.system.bodies):
        frame = kin.frame(number)
        origin, velocity, spin = (
            jnp.stack([*map(jnp.asarray, it)]) for it in (frame.origin, frame.velocity, frame.spin)
        )
        axes = jnp.stack([jnp.stack([*map(jnp.asarray, axis)]) for axis in frame.axes])
        linear.append(body.mass * velocity)
        angular.append(jnp.cross(origin, linear[-1]) + axes.T @ (jnp.asarray(body.inertia) * (axes @ spin)))
    if mechanism.spins:
        angular.append(mechanism.parts.probe.tip_inertia * state[mechanism.places["spins"]])
    return jnp.stack(linear), jnp.stack(angular)


@pytest.mark.parametrize("parts", often(PARTS, "all parts"))
def test_momenta_and_energy_are_kept(parts):
    mechanism, state, closed = moving(parts)

    def flows(state):
        rate = mechanism.rate_at(mechanism.evaluate(state), closed)
        _, moved = jax.jvp(lambda it: momenta(mechanism, it), (state,), (rate,))
        _, energy = jax.jvp(lambda it: mechanism.energy_at(mechanism.evaluate(it), closed), (state,), (rate,))
        return moved, energy

    (linear, angular), energy = jax.jit(flows)(state)
    for each in (np.asarray(linear), np.asarray(angular)):
        largest = np.abs(each).max()
        assert largest > 0.1  # N, N m: something acts
        assert np.abs(each.sum(axis=0)).max() < 1e-10 * largest
    each = [float(flow) for flow in jax.tree.leaves(energy)]
    assert max(map(abs, each)) > 0.01  # W
    assert abs(sum(each)) < 1e-10 * max(map(abs, each))


@pytest.mark.long
@pytest.mark.parametrize("parts", PARTS)
def test_the_linearised_motion_is_read_number_by_number(parts):
    """On random columns, against the same linear map taken one by one."""
    mechanism, state, closed = moving(parts)
    vectors = np.random.default_rng(0).normal(size=(state.size, 2))

    @jax.jit
    def both(state):
        _, push = jax.linearize(lambda y: mechanism.derivative(jnp.zeros(()), y, closed), state)
        return on_columns(push, state)(vectors), jax.vmap(push, in_axes=-1, out_axes=-1)(vectors)

    found, expected = map(np.asarray, both(state))
    assert np.abs(expected).max() > 1.0
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())


def test_misses_have_the_rates_of_the_motion():
    mechanism, state, _ = moving("table 2")
    places = mechanism.places

    @jax.jit
    def shifted(time):
        """The misses a moment later, on the way that the velocities lead."""
        q, v = state[places["q"]], state[places["v"]]
        later = state.at[places["q"]].set(q + time * mechanism.system.position_rate(q).of(v))
        return misses(mechanism, mechanism.evaluate(later))

    step = 1e-6  # s; the swing, of 3 mrad at 0.26 rad/s, bends within 10 ms
    before, now, after = (shifted(time) for time in (-step, 0.0, step))
    for name in ("lateral_miss", "swing_miss", "attitude_miss"):
        difference = (float(after[name]) - float(before[name])) / (2.0 * step)
        assert float(now[f"{name}_rate"]) == pytest.approx(difference, rel=1e-6)
        assert float(now[name]) > 1e-3


def test_misses_by_hand():
    mechanism, state, _ = moving("table 2")

    @jax.jit
    def seen(state):
        """The probe's and the target's axes, the target's origin, the tip's place, and the misses."""
        kin = mechanism.kinematics(state)
        axes = [[[*axis] for axis in kin.frame(body).axes] for body in (P, T)]
        tip = kin.point(P, mechanism.parts.probe.tip_centre).place
        return axes, [*kin.frame(T).origin], [*tip], misses(mechanism, mechanism.evaluate(state))

    axes, origin, tip, values = seen(state)
    matrix = [np.array(of_body, float).T for of_body in axes]
    relative = matrix[1].T @ matrix[0]
    assert float(values["swing_miss"]) == pytest.approx(np.arccos(relative[0, 0]), rel=1e-6)
    assert float(values["attitude_miss"]) == pytest.approx(np.arccos(0.5 * (np.trace(relative) - 1.0)), rel=1e-6)
    _, y, z = matrix[1].T @ (np.array(tip, float) - np.array(origin, float))
    assert float(values["lateral_miss"]) == pytest.approx(np.hypot(y, z), rel=1e-12)
