"""The docking in space at an instant: what it conserves, its misses and their rates, and the roll that bodies share."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import Scenario3D, docking3d, replace
from jaxbuffer.mechanisms.docking3d.assembly import assemble
from jaxbuffer.mechanisms.docking3d.bodies import assemble_system
from jaxbuffer.mechanisms.docking3d.misses import misses
from jaxbuffer.mechanisms.probe_cone.bodies import B, P, T, probe_masses
from jaxbuffer.multibody import assemble as projected

LATCH = {
    "latch.stiffness": 2e4,
    "latch.damping": 100.0,
    "latch.preload": 3.0,
    "latch.turn_stiffness": 50.0,
    "latch.turn_damping": 2.0,
}
CONTROL = {"control.stiffness": 2.0, "control.damping": 1.0, "control.limit": 0.5}
PARTS = {
    "table 2": {},
    "free tip": {"probe.free_tip": True},
    "latch": LATCH,
    "control": CONTROL,
    "everything": {**LATCH, **CONTROL, "probe.free_tip": True, "buffer.stop_stiffness": 2e4, "buffer.friction": 0.2},
}


def moving(values, seed=3):
    """The mechanism in a state on its joints in which everything turns and the tip touches the cone, all closed."""
    design = replace(docking3d(), values)
    mechanism = assemble(design, Scenario3D(azimuth=0.7, passive_pitch=0.03, passive_yaw=-0.02))
    rng = np.random.default_rng(seed)
    system = mechanism.system
    q = mechanism.q + 2e-3 * rng.normal(size=mechanism.q.shape)
    q, v = jax.jit(lambda q, v: projected(system, q, v))(q, jnp.asarray(0.05 * rng.normal(size=mechanism.v.shape)))
    state, closed = jax.jit(mechanism.start)()
    state = state.at[mechanism.places["q"]].set(q).at[mechanism.places["v"]].set(v)
    if mechanism.spins:
        state = state.at[mechanism.places["spins"]].set(jnp.asarray([0.3, -0.2, 0.4]))
    return mechanism, state, jnp.ones_like(closed)


@pytest.mark.parametrize("values", PARTS.values(), ids=PARTS)
def test_momenta_and_energy_are_kept(values):
    mechanism, state, closed = moving(values)

    def flows(state):
        rate = mechanism.rate_at(mechanism.evaluate(state), closed)
        momentum = jax.jvp(mechanism.momentum, (state,), (rate,))[1]

        def energy(state):
            return mechanism.energy_at(mechanism.evaluate(state), closed)

        return momentum, jax.jvp(energy, (state,), (rate,))[1]

    (linear, angular), energy = jax.jit(flows)(state)
    assert np.abs(linear).max() < 1e-8 and np.abs(angular).max() < 1e-8
    each = [float(flow) for flow in jax.tree.leaves(energy)]
    assert abs(sum(each)) < 1e-8 * max(map(abs, each))


def test_misses_have_the_rates_of_the_motion():
    mechanism, state, _ = moving({})

    def both(state):
        q, v = (mechanism.part(state, name) for name in "qv")
        change = jnp.zeros_like(state).at[mechanism.places["q"]].set(mechanism.system.position_rate(q).of(v))
        named = lambda state: misses(mechanism, mechanism.evaluate(state))  # noqa: E731
        return jax.jvp(named, (state,), (change,))

    values, rates = jax.jit(both)(state)
    for name in ("lateral_miss", "swing_miss", "attitude_miss"):
        assert float(values[f"{name}_rate"]) == pytest.approx(float(rates[name]), rel=1e-9)
        assert float(values[name]) > 0.0


def test_misses_by_hand():
    mechanism, state, _ = moving({})
    kin = mechanism.kinematics(state)
    matrix = [np.array([[float(x) for x in axis] for axis in kin.frame(body).axes]).T for body in (P, T)]
    relative = matrix[1].T @ matrix[0]
    values = misses(mechanism, mechanism.evaluate(state))
    assert float(values["swing_miss"]) == pytest.approx(np.arccos(relative[0, 0]), rel=1e-6)
    assert float(values["attitude_miss"]) == pytest.approx(np.arccos(0.5 * (np.trace(relative) - 1.0)), rel=1e-6)
    tip = np.array(kin.point(P, mechanism.parts.probe.tip_centre).place, float)
    _, y, z = matrix[1].T @ (tip - np.array(kin.frame(T).origin, float))
    assert float(values["lateral_miss"]) == pytest.approx(np.hypot(y, z), rel=1e-12)


@pytest.mark.parametrize("free_tip", [False, True], ids=["welded tip", "free tip"])
def test_cylinder_and_probe_have_the_probes_roll_inertia_together(free_tip):
    design = replace(docking3d(), {"probe.free_tip": free_tip})
    system = assemble_system(design, probe_masses(design), 20.0)
    roll = 0.5 * design.probe.rod_mass * 0.009**2 + (0.0 if free_tip else 0.4 * design.probe.tip_mass * 0.015**2)
    assert system.bodies[B].inertia[0] + system.bodies[P].inertia[0] == pytest.approx(roll)
