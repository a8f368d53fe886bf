"""Derivatives of a drop onto a tank against differences, where they mean something, and what says where not."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb

pytestmark = pytest.mark.long

VARIABLES = {"wall.top": 0.005, "wall.lower_side": 0.005, "cushion.stiffness": 4e6, "cushion.damping": 1e4, "fill": 0.8}
QUANTITIES = ("peak_force", "peak_stress", "smooth_stress", "plastic_work", "deflection")
SMALL = 1e-7  # of a variable: the static state and the steps must not change by more than they are smooth
SMALLER = 1e-8  # of the fill, by which waves in the liquid change more
DURATION = 0.008  # s
YIELDING = {"support.method": "penalty", "material.yield_stress": 2e6}  # Pa: parts of the wall yield


def quantities(values):
    """All quantities where each variable is so many times its value."""
    changed = {name: factor * value for (name, value), factor in zip(VARIABLES.items(), values, strict=True)}
    fill = changed.pop("fill")
    design = jb.replace(jb.TankDrop(), {**YIELDING, **changed})
    run = jb.simulate(design, jb.TankDropScenario(height=0.1, fill=fill), duration=DURATION)
    return jnp.stack([getattr(run, name) for name in QUANTITIES])


def test_the_smooth_stress_is_within_its_bias_of_the_largest_also_far_beyond_the_yield_stress():
    """A wall that hardens as steeply as it is stiff: its stress passes forty yield stresses."""
    design = jb.replace(jb.TankDrop(), {"material.yield_stress": 4e4, "material.hardening": 1e9})

    def smooth(thickness):
        changed = jb.replace(design, {"wall.top": thickness})
        run = jb.simulate(changed, jb.TankDropScenario(height=0.1), duration=DURATION)
        return run.smooth_stress, run

    (stress, run), slope = jax.value_and_grad(smooth, has_aux=True)(0.005)
    largest = float(run.peak_stress)
    assert largest > 40 * 4e4
    assert largest - float(run.smooth_bias) <= float(stress) <= largest
    small = 1e-9  # m
    difference = (float(smooth(0.005 + small)[0]) - float(smooth(0.005 - small)[0])) / (2.0 * small)
    assert float(slope) == pytest.approx(difference, rel=1e-3)


def test_on_a_penalty_support_derivatives_are_those_of_differences():
    """To 2e-4 of each: all quantities by thicknesses, cushion and fill."""
    compiled, ones = jax.jit(quantities), np.ones(len(VARIABLES))
    exact = np.asarray(jax.jit(jax.jacrev(quantities))(ones))
    assert np.all(np.abs(exact) > 1e-9)
    for k, name in enumerate(VARIABLES):
        small = SMALLER if name == "fill" else SMALL
        moved = small * np.eye(len(VARIABLES))[k]
        slope = np.asarray(compiled(ones + moved) - compiled(ones - moved)) / (2.0 * small)
        np.testing.assert_allclose(exact[:, k], slope, rtol=2e-4, err_msg=name)


def certified(method):
    """How far a derivative of the largest stress is trusted, by the wall's thickness."""
    design = jb.replace(jb.TankDrop(), {"support.method": method})
    scenario = jb.TankDropScenario(height=0.1)
    found = jb.sensitivity(design, scenario, ["wall.lower_side"], 2.0 * DURATION, quantities=["peak_stress"])
    return found.certificate


def test_on_defence_nodes_the_certificate_refuses():
    """Nodes that strike the baffle one by one and do not rebound make the run chaotic: derivatives grow with time."""
    assert certified("defence node").verdict.name == "refused"
