"""JAX's own transformations of a docking in space: the first impact, 20 ms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb

pytestmark = [pytest.mark.slow, pytest.mark.long]

DESIGN, SCENARIO, DURATION = jb.docking3d(), jb.Scenario3D(azimuth=0.7, passive_pitch=0.01), 0.02
TIP_MASS = "probe.tip_mass"


def peak(design, scenario=SCENARIO, **options):
    return jb.simulate(design, scenario, DURATION, **options).peak_force


def test_a_batch_of_azimuths_is_each_alone():
    azimuths = jnp.array([0.0, 0.7, 2.0])
    batch = jax.jit(jax.vmap(lambda azimuth: peak(DESIGN, jb.replace(SCENARIO, {"azimuth": azimuth}))))(azimuths)
    alone = [float(peak(DESIGN, jb.replace(SCENARIO, {"azimuth": float(azimuth)}))) for azimuth in azimuths]
    np.testing.assert_allclose(batch, alone, rtol=1e-6)


def test_a_gradient_is_that_of_differences_of_tight_solves():
    """By one number: the tangents of all of a design's numbers take more than 10 GB to compile."""
    mass, step = float(jb.get(DESIGN, TIP_MASS)), 1e-4
    gradient = jax.grad(lambda mass: peak(jb.replace(DESIGN, {TIP_MASS: mass})))(mass)
    high, low = (
        float(peak(jb.replace(DESIGN, {TIP_MASS: mass * (1.0 + sign * step)}), rtol=1e-9)) for sign in (1.0, -1.0)
    )
    assert float(gradient) == pytest.approx((high - low) / (2.0 * step * mass), rel=1e-3)
