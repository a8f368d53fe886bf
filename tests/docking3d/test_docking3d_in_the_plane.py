"""A docking in space whose vehicles move in a plane that holds the hinge's first axis is the planar mechanism's."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.registry import mechanism_of

LATCHED = {
    **{"latch.stiffness": 2e4, "latch.damping": 100.0, "latch.preload": 3.0},
    **{"latch.turn_stiffness": 50.0, "latch.turn_damping": 2.0},
    **{"buffer.max_stroke": 0.0072, "buffer.stop_stiffness": 2e4, "buffer.stop_damping": 20.0},
}
TIGHT, OF_LONG_RUNS = 1e-12, 1e-11  # rtol; of a run that is held the first is finer than rounding
FLAT = jb.Scenario(misalignment=0.02, passive_rate=0.004)


def about(azimuth):
    """The start of `FLAT` turned about the cone's axis, by an azimuth from the planar lower flank."""
    angle, rate = float(FLAT.misalignment), float(FLAT.passive_rate)
    return jb.Scenario3D(
        azimuth=azimuth,
        passive_pitch=np.arcsin(np.sin(angle) * np.sin(azimuth)),
        passive_yaw=np.arctan(np.tan(angle) * np.cos(azimuth)),
        passive_rate_y=rate * np.sin(azimuth),
        passive_rate_z=rate * np.cos(azimuth),
    )


def in_space(q, v):
    """Positions and velocities (x, y, angle) of planar bodies as those of bodies in space."""
    (x, y, angle), (u, w, spin), zero = q.reshape(-1, 3).T, v.reshape(-1, 3).T, np.zeros(len(q) // 3)
    places = [x, y, zero, np.cos(angle / 2), zero, zero, np.sin(angle / 2)]
    return np.stack(places, axis=1).ravel(), np.stack([u, w, zero, zero, zero, spin], axis=1).ravel()


@eqx.filter_jit
def started(design, scenario):
    """The mechanism of a design and its start."""
    mechanism = mechanism_of(design).system(design, scenario, 20.0)
    return mechanism, mechanism.start()[0]


@eqx.filter_jit
def rates_of(mechanism, state):
    """The rate of a state in which all contacts and switches are closed."""
    return mechanism.derivative(0.0, state, jnp.ones(mechanism.contact_count))


@pytest.mark.quick
def test_all_bodies_accelerate_as_in_the_plane():
    """The tip pressed into the lower flank and spinning, the hinge bent, the buffer at its stop, the latches closed."""
    changes = LATCHED | {"probe.free_tip": True}
    flat, planar_start = started(jb.replace(jb.table2(), changes), FLAT)
    space, spatial_start = started(jb.replace(jb.docking3d(), changes), about(0.0))
    states = [np.array(planar_start), np.array(spatial_start)]
    rng, at = np.random.default_rng(3), flat.places
    moved = states[0]
    # Along the probe towards the cylinder by more than the stroke, and the cone onto the tip by a few micrometres.
    moved[at["q"]] += [*np.zeros(6), -8e-3, 0.0, 0.0, -8e-3 - 4e-6, 0.0, 0.0]
    bent, arm = 0.1, jb.table2().active.hinge_offset  # rad, m: the active vehicle turned about the hinge
    moved[at["q"]] += [arm * (1.0 - np.cos(bent)), -arm * np.sin(bent), bent, *np.zeros(9)]
    moved[at["v"]] += 0.05 * rng.normal(size=12)
    moved[at["spins"]] = 0.7
    q, v = in_space(moved[at["q"]], moved[at["v"]])
    for name, values in (("q", q), ("v", v), ("spins", [0.0, 0.0, 0.7])):
        states[1][space.places[name]] = values
    for state, mechanism in zip(states, (flat, space), strict=True):
        latch = [element.name for element in mechanism.elements].index("latch")
        state[mechanism.places[f"element {latch}"]] = [0.2, 0.0]  # 0.2 s since the latches began to close
    rates = [np.asarray(rates_of(*each)) for each in zip((flat, space), states, strict=True)]
    _, expected = in_space(rates[0][at["q"]], rates[0][at["v"]])
    assert np.abs(expected).max() > 100.0  # m/s² or rad/s²
    np.testing.assert_allclose(rates[1][space.places["v"]], expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())
    np.testing.assert_allclose(rates[1][space.places["spins"]], [0.0, 0.0, rates[0][at["spins"]][0]], rtol=1e-10)
    np.testing.assert_allclose(rates[1][space.places["lost"]], rates[0][at["lost"]], rtol=1e-10)


def numbers(run, names):
    """All that a run has by name: quantities but for the signs of the plane's misses, energies, and its impacts."""
    count = int(run.impact_count)
    return {
        **{name: abs(float(run.quantity(name))) for name in names},
        **{f"{name}, stored": float(value) for name, value in run.energy.stored.items()},
        **{f"{name}, lost": float(value) for name, value in run.energy.lost.items()},
        **{
            f"{name} of the impacts": np.asarray(getattr(run.impacts, name))[:count]
            for name in ("time", "approach_speed", "peak_force", "release_time")
        },
    }


def farthest(run, other, but=()):
    """By how much two runs differ, relative, and in what, ``but`` for some quantities: energies relative to the largest
    of them, and so an impact's numbers. What is smaller than 1e-9 of its unit in both is zero."""
    catalogue = run.mechanism.quantities
    names = [name for name in catalogue if name in other.mechanism.quantities and name not in but]
    ours, theirs = numbers(run, names), numbers(other, names)
    # Space has neither a probe that bends nor play in the hinge.
    theirs = {name: value for name, value in theirs.items() if not name.startswith(("bending", "hinge_play"))}
    assert len(names) > 40 and set(ours) >= set(theirs)
    energies = {name for name in theirs if name not in catalogue or catalogue[name].unit == "J"}
    energies -= {name for name in theirs if name.endswith("impacts")}
    energy, apart = max(np.nan_to_num(theirs[name]) for name in energies), {}
    for name in theirs:
        assert np.array_equal(np.isnan(ours[name]), np.isnan(theirs[name])), name
        mine, value = np.nan_to_num(ours[name]), np.nan_to_num(theirs[name])
        largest = energy if name in energies else max(np.max(np.abs(value)), np.max(np.abs(mine)))
        apart[name] = np.max(np.abs(mine - value)) / largest if largest > 1e-9 else 0.0
    return max((size, name) for name, size in apart.items())


def solved(changes, scenario, duration, rtol=TIGHT):
    design = jb.table2() if isinstance(scenario, jb.Scenario) else jb.docking3d()
    run = jb.simulate(jb.replace(design, changes), scenario, duration, rtol=rtol)
    return run, (run.outcome.name, int(run.impact_count))


@pytest.mark.slow
def test_every_number_of_a_capture_is_the_planes():
    """About either axis of the hinge. Between them only the order of its axes differs: to second order in its angles,
    but for the probe's roll, which is half their product, and which the attitude miss has in it."""
    (flat, ended), *spatial = (solved({}, start, 3.0) for start in (FLAT, about(0.0), about(np.pi / 2), about(0.7)))
    assert ended == ("captured", 25) and all(each == ended for _, each in spatial)
    (about_z, _), (about_y, _), (between, _) = spatial
    assert farthest(about_z, flat) < (1e-9, "")
    assert farthest(about_y, flat) < (1e-9, "")
    apart, _ = farthest(between, flat, but=("attitude_miss", "attitude_miss_rate"))
    assert 1e-8 < apart < 5e-6  # measured: 2.5e-6
    assert float(between.quantity("swing_miss")) == pytest.approx(float(about_z.quantity("swing_miss")), rel=5e-6)
    hinge = float(between.hinge_angle)
    assert abs(between.quantity("attitude_miss") - between.quantity("swing_miss")) < hinge**2


@pytest.mark.slow
@pytest.mark.long
def test_every_number_until_the_latches_hold_is_the_planes():
    (flat, ended), (space, ours) = (solved(LATCHED, start, 20.0, OF_LONG_RUNS) for start in (FLAT, about(0.0)))
    assert ended == ours == ("held", 25)
    assert float(flat.energy.lost["stop_damper"]) > 5e-5  # J: the buffer has met its stop
    assert farthest(space, flat) < (3e-9, "")  # measured: 1.9e-9, where the latches hold the tip
