"""JAX's own transformations of a docking in space: the first impact, 20 ms."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb

pytestmark = [pytest.mark.slow, pytest.mark.long]

DESIGN, SCENARIO, DURATION = jb.docking3d(), jb.Scenario3D(azimuth=0.7, passive_pitch=0.01), 0.02


def peak(design, scenario=SCENARIO, **options):
    return jb.simulate(design, scenario, DURATION, **options).peak_force


def test_a_batch_of_azimuths_is_each_alone():
    azimuths = jnp.array([0.0, 0.7, 2.0])
    batch = jax.jit(jax.vmap(lambda azimuth: peak(DESIGN, jb.replace(SCENARIO, {"azimuth": azimuth}))))(azimuths)
    alone = [float(peak(DESIGN, jb.replace(SCENARIO, {"azimuth": float(azimuth)}))) for azimuth in azimuths]
    np.testing.assert_allclose(batch, alone, rtol=1e-6)


def test_a_gradient_by_all_numbers_is_that_of_differences_of_tight_solves():
    """To 1e-3, or 1e-6 of the force for as large a part of the number."""
    gradient, step = jax.grad(peak)(DESIGN), 1e-4
    for path in ("probe.tip_mass", "buffer.k_A", "contact.young_modulus"):
        value = float(jb.get(DESIGN, path))
        high, low = (
            float(peak(jb.replace(DESIGN, {path: value * (1.0 + sign * step)}), rtol=1e-9)) for sign in (1.0, -1.0)
        )
        elasticity = float(jb.get(gradient, path)) * value / low
        assert elasticity == pytest.approx((high / low - 1.0) / (2.0 * step), rel=1e-3, abs=1e-6), path
