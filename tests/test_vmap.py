"""`jax.vmap(simulate)` does what a loop over its lanes does, whatever one of them comes to."""

import jax
import numpy as np

import jaxbuffer as jb

NUMBERS = ("peak_force", "peak_time", "peak_hinge_force", "stroke", "hinge_angle", "end_time", "contact_time")
COUNTS = ("code", "peak_flank", "peak_impact", "impact_count")
TOLERANCE = 1e-10  # two programs round differently, which an adaptive step size amplifies up to its tolerance
STIFFNESS = np.array([500.0, 800.0, np.nan, 500.0])  # N/m
SPEED = np.array([0.1, 0.2, 0.1, 0.15])  # m/s
MISALIGNMENT = np.array([0.0, 0.05, 0.0, -0.02])  # rad


def simulated(stiffness, speed, misalignment):
    design = jb.replace(jb.table2(), {"buffer.k_A": stiffness})
    return jb.simulate(design, jb.Scenario(approach_speed=speed, misalignment=misalignment), rtol=TOLERANCE)


def test_lanes_over_designs_and_scenarios_are_those_of_a_loop():
    batch = jax.vmap(simulated)(STIFFNESS, SPEED, MISALIGNMENT)
    assert jb.Outcome(int(batch.code[2])) == jb.Outcome.failed_input
    assert all(np.isnan(getattr(batch, name)[2]) for name in NUMBERS), "a failed lane says nothing"
    for k in (0, 1, 3):
        alone = simulated(float(STIFFNESS[k]), float(SPEED[k]), float(MISALIGNMENT[k]))
        for name in COUNTS:
            assert int(getattr(batch, name)[k]) == int(getattr(alone, name)), name
        for name in NUMBERS:
            found, expected = float(getattr(batch, name)[k]), float(getattr(alone, name))
            np.testing.assert_allclose(found, expected, rtol=1e-8, err_msg=name)
        impacts = batch.impacts.peak_force[k], alone.impacts.peak_force
        np.testing.assert_allclose(*impacts, rtol=1e-8, atol=1e-8 * float(alone.peak_force))
