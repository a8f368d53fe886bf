"""Runs that a caller advances step by step, against whole runs, closed forms and differences."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import jaxbuffer as jb

TOPIC = "runs in a caller's steps"
TIGHT = 1e-9
TOUCHING, FREE = jb.Scenario(approach_speed=0.1), jb.Scenario(start="free", standoff=0.2, passive_rate=0.02)
SPEEDS = {"approach_speed": 0.1, "azimuth": 0.7}


def by_hand(design):
    """Masses and moments of inertia of S, B, P and T, and of the tip that spins by itself (M6)."""
    probe, buffer = design.probe, design.buffer
    mass = probe.rod_mass + probe.tip_mass
    shift = probe.tip_mass * probe.length / 2 / mass
    of_probe = probe.rod_mass * (probe.length**2 / 12 + shift**2) + probe.tip_mass * (probe.length / 2 - shift) ** 2
    tip = probe.tip_inertia
    masses = [design.active.mass, buffer.cylinder_mass, mass, design.passive.mass]
    of_cylinder = buffer.cylinder_mass * buffer.cylinder_length**2 / 12
    own = 0.0 if probe.free_tip else tip
    return np.array(masses), np.array([design.active.inertia, of_cylinder, of_probe + own, design.passive.inertia]), tip


def momenta(design, seen):
    """Linear and angular momentum of a docking in the plane."""
    (masses, inertias, tip), q, v = by_hand(design), np.asarray(seen.position), np.asarray(seen.velocity)
    turning = inertias @ v[:, 2] + masses @ (q[:, 0] * v[:, 1] - q[:, 1] * v[:, 0])
    return masses @ v[:, :2], turning + (tip * float(seen.values["tip_spin"]) if design.probe.free_tip else 0.0)


def stepped(plant, count, length, loads=None):
    """The states observed after each step."""
    state, all_seen = plant.start(), []
    for k in range(count):
        state, seen = plant.step(state, None if loads is None else loads(k), length)
        all_seen.append(seen)
    return all_seen


def reproduces(plant, whole, counts, evidence, name):
    """Steps without loads, few or many, end as the whole run does."""
    worst = 0.0
    for count in counts:
        seen = stepped(plant, count, 1.01 * float(whole.end_time) / count)[-1]
        assert seen.outcome == whole.outcome and int(np.sum(seen.touchdowns)) == int(whole.impact_count)
        pairs = [(seen.peak_force, whole.peak_force), (seen.time, whole.end_time)]
        pairs += [(seen.largest[key], whole.maxima[key]) for key in ("hinge_force", "buffer_force", "stroke")]
        worst = max(worst, *(abs(float(a) / float(b) - 1.0) for a, b in pairs))
    evidence(TOPIC, name, worst, 1e-8, "jb.simulate at the same tolerance, relative")


@pytest.mark.slow
def test_steps_without_loads_end_as_the_whole_run(evidence):
    whole = jb.simulate(jb.table2(), TOUCHING, rtol=TIGHT)
    plant = jb.stepper(jb.table2(), TOUCHING, rtol=TIGHT)
    reproduces(plant, whole, (1, 7, 200), evidence, "a capture in 1, 7 and 200 steps")


@pytest.mark.long
def test_in_space_too(evidence):
    whole = jb.simulate(jb.docking3d(), jb.Scenario3D(**SPEEDS), rtol=TIGHT)
    plant = jb.stepper(jb.docking3d(), jb.Scenario3D(**SPEEDS), rtol=TIGHT)
    reproduces(plant, whole, (1, 40), evidence, "a capture in space in 1 and 40 steps")


@pytest.mark.slow
def test_a_free_vehicle_moves_on_parabolas():
    design, count, length, rng = jb.table2(), 6, 0.3, np.random.default_rng(5)
    plant = jb.stepper(design, FREE, rtol=TIGHT)
    forces, moments = rng.normal(size=(count, 2)), 0.01 * rng.normal(size=count)
    loads = lambda k: plant.loads({"passive": forces[k]}, {"passive": moments[k]})  # noqa: E731
    place, speed, angle, rate = np.zeros(2), np.zeros(2), 0.0, 0.02
    for k, seen in enumerate(stepped(plant, count, length, loads)):
        pull, turn = forces[k] / design.passive.mass, moments[k] / design.passive.inertia
        place, speed = place + speed * length + pull * length**2 / 2, speed + pull * length
        angle, rate = angle + rate * length + turn * length**2 / 2, rate + turn * length
        assert_allclose(seen.position[3], [*place, angle], rtol=1e-9, atol=1e-10)
        assert_allclose(seen.velocity[3], [*speed, rate], rtol=1e-9, atol=1e-10)
        assert not np.any(seen.touchdowns) and seen.outcome is None and seen.running


@pytest.mark.slow
def test_momentum_changes_by_what_was_held():
    # Through two dozen impacts: forces on both vehicles, and on the one that is still at rest a known arm.
    design, length, rng = jb.table2(), 0.05, np.random.default_rng(7)
    plant = jb.stepper(design, TOUCHING, rtol=TIGHT)
    forces, moments = rng.normal(size=(12, 2, 2)), 0.01 * rng.normal(size=(12, 2))
    forces[:, :, 1] = 0.0
    loads = lambda k: jb.Loads(jnp.asarray(forces[k]), jnp.asarray(moments[k]))  # noqa: E731
    all_seen = stepped(plant, 12, length, loads)
    masses, _, _ = by_hand(design)
    linear = np.cumsum(forces.sum(axis=1), axis=0) * length + [0.1 * masses[:3].sum(), 0.0]
    assert np.sum(all_seen[-1].touchdowns) > 5
    for k, seen in enumerate(all_seen):
        assert_allclose(momenta(design, seen)[0], linear[k], rtol=0.0, atol=1e-8)
    alone = jb.Loads(jnp.zeros((2, 2)), jnp.asarray([0.02, -0.005]))
    start = momenta(design, stepped(plant, 1, 1e-9)[0])[1]
    for k, seen in enumerate(stepped(plant, 12, length, lambda k: alone)):
        assert_allclose(momenta(design, seen)[1] - start, 0.015 * length * (k + 1), rtol=0.0, atol=1e-8)


@pytest.mark.slow
def test_in_space_a_free_vehicle_obeys_its_loads():
    design, length = jb.docking3d(), 0.4
    plant = jb.stepper(design, jb.Scenario3D(start="free", standoff=0.2), rtol=TIGHT)
    force, turn = np.array([0.3, -0.2, 0.5]), 0.02  # from rest about a principal axis
    loads = plant.loads({"passive": force}, {"passive": (0.0, turn, 0.0)})
    for k, seen in enumerate(stepped(plant, 3, length, lambda k: loads)):
        time = (k + 1) * length
        turned = [0.0, turn * time**2 / 2 / design.passive.inertia, 0.0]
        moved = force * time**2 / 2 / design.passive.mass
        assert_allclose(seen.position[3], [*moved, *turned], rtol=1e-9, atol=1e-11)


def controlled(gains, design_number, count, length, rtol):
    """A capture under a feedback on the active vehicle's angle and rate: what is observed at the end."""
    design = jb.replace(jb.table2(), {"buffer.k_A": design_number})
    plant = jb.stepper(design, TOUCHING, rtol=rtol)
    none = jnp.zeros(())

    def advance(carry, _):
        state, angle, rate = carry
        moment = -gains[0] * angle - gains[1] * rate
        loads = jb.Loads(jnp.zeros((2, 2)).at[0, 0].set(gains[2]), jnp.stack([moment, none]))
        state, seen = plant.step(state, loads, length)
        return (state, seen.position[0, 2], seen.velocity[0, 2]), seen

    (_, angle, _), seen = jax.lax.scan(advance, (plant.start(), none, none), None, length=count)
    return jnp.stack([seen.peak_force[-1], seen.time[-1], seen.largest["hinge_force"][-1], angle])


def differences(function, at, spacings):
    """Central differences of fourth order."""
    columns = []
    for k, spacing in enumerate(spacings):
        values = [np.asarray(function(at.at[k].add(step * spacing))) for step in (-2, -1, 1, 2)]
        columns.append((values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * spacing))
    return np.stack(columns, axis=1)


AT = jnp.array([0.5, 0.1, 0.05, 500.0])  # N m/rad, N m s/rad, N, N/m


@pytest.mark.long
def test_gradients_of_a_controlled_capture_are_those_of_differences(evidence):
    # Peak, hinge force and angle; and the time at which the run ends within a step.
    function = jax.jit(lambda x: controlled(x[:3], x[3], 8, 0.1, 1e-11))
    forward = np.asarray(jax.jit(jax.jacfwd(lambda x: controlled(x[:3], x[3], 8, 0.1, 1e-9)))(AT))
    by_differences = differences(function, AT, [1e-3, 1e-4, 1e-3, 0.1])
    size = np.max(np.abs(by_differences), axis=0, keepdims=True)
    error = np.abs(forward - by_differences) / (np.abs(by_differences) + 1e-4 * size)
    source = "differences of fourth order at rtol 1e-11, relative"
    evidence(TOPIC, "gradients of a capture in closed loop", float(np.max(error)), 2e-4, source)


@pytest.mark.long
def test_gradients_backwards_are_those_forwards():
    weighted = lambda x: jnp.array([1.0, 100.0, 1.0, 10.0]) @ controlled(x[:3], x[3], 4, 0.1, 1e-8)  # noqa: E731
    assert_allclose(jax.jit(jax.grad(weighted))(AT), jax.jit(jax.jacfwd(weighted))(AT), rtol=1e-6)


@pytest.mark.slow
def test_derivatives_by_held_forces_are_those_of_parabolas():
    count, length, design = 4, 0.3, jb.table2()
    plant = jb.stepper(design, FREE, rtol=1e-8)

    def reached(forces):
        def advance(state, force):
            loads = jb.Loads(jnp.stack([jnp.zeros(2), force]), jnp.zeros(2))
            state, seen = plant.step(state, loads, length)
            return state, seen.position[3, :2]

        return jax.lax.scan(advance, plant.start(), forces)[1][-1]

    slopes = jax.jit(jax.jacfwd(reached))(jnp.zeros((count, 2)))
    for k in range(count):
        wanted = length**2 / design.passive.mass * (count - k - 0.5)
        assert_allclose(slopes[:, k], wanted * np.eye(2), rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_many_loads_at_once_are_those_one_by_one():
    plant = jb.stepper(jb.table2(), TOUCHING)
    moments = jnp.array([[0.0, 0.0], [0.05, 0.0], [-0.03, 0.02]])
    peak = lambda it: plant.step(plant.start(), jb.Loads(jnp.zeros((2, 2)), it), 0.1)[1].peak_force  # noqa: E731
    assert_allclose(jax.vmap(peak)(moments), [peak(it) for it in moments], rtol=1e-8)


def message(call):
    with pytest.raises(jb.InputError) as error:
        call()
    return str(error.value)


def test_what_cannot_be_stepped_is_said():
    plant = jb.stepper(jb.table2(), TOUCHING)
    assert plant.pushed == ("active", "passive")
    assert "nothing pushes a body 'activ'" in message(lambda: plant.loads({"activ": (0.0, 1.0)}))
    assert "force of active has shape (3,); it needs (2,)" in message(lambda: plant.loads({"active": (0.0, 1.0, 0.0)}))
    assert "length = -1 s is out of range" in message(lambda: plant.step(None, None, -1.0))
    assert "plant.start()" in message(lambda: plant.step(None, None, 1.0))
    assert "pushed" in message(lambda: jb.stepper(jb.table2(), pushed=("cone",)))
    assert "axes" in message(lambda: jb.stepper(jb.table2(), axes="vehicle"))
    assert "from event to event" in message(lambda: jb.stepper(jb.TankDrop()))
    assert "from event to event" in message(lambda: jb.stepper(jb.table2(), solver=jb.Diffrax()))
