"""The stroke that would arrest the vehicles: the closed form of a linear spring, and SciPy's root for all others."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from docking.states import CURVES, mechanism
from jaxbuffer.mechanisms.probe_cone.docking import arrest_stroke

CURVE = PchipInterpolator([0.0, 0.005, 0.01, 0.02], [0.0, 2.0, 6.0, 20.0])
SPRING = {"buffer.spring_curve": CURVES["buffer.spring_curve"]}
PRELOAD = {"buffer.preload": 2.0}
STOP = {"buffer.max_stroke": 0.02, "buffer.stop_stiffness": 1e4}
ENERGIES = (1e-5, 0.01, 0.0999, 0.3, 2.0)  # J


def curve_energy(stroke):
    last = min(stroke, 0.02)
    beyond = stroke - last
    return CURVE.integrate(0.0, last) + beyond * (20.0 + 0.5 * CURVE.derivative()(0.02) * beyond)


def linear_energy(stroke):
    return 250.0 * stroke**2


def preload_energy(stroke):
    return 2.0 * (np.sqrt(stroke**2 + 1e-8) - 1e-4)


def stop_energy(stroke):
    return 0.5 * 1e4 * max(stroke - 0.02, 0.0) ** 2


CASES = {
    "stop": (STOP, lambda s: linear_energy(s) + stop_energy(s)),
    "preload": (PRELOAD, lambda s: linear_energy(s) + preload_energy(s)),
    "curve": (SPRING, curve_energy),
    "curve, preload, stop": (SPRING | PRELOAD | STOP, lambda s: curve_energy(s) + preload_energy(s) + stop_energy(s)),
}


@pytest.mark.parametrize("energy", ENERGIES)
def test_a_linear_spring(energy):
    assert_allclose(arrest_stroke(mechanism(), jnp.asarray(energy)), np.sqrt(2.0 * energy / 500.0), rtol=1e-14)


@pytest.mark.parametrize("name", CASES)
def test_stop_preload_and_curve(name):
    values, stored = CASES[name]
    stroke = jax.jit(jax.value_and_grad(lambda energy: arrest_stroke(mechanism(values), energy)))
    for energy in ENERGIES:
        found, slope = stroke(jnp.asarray(energy))
        reference = brentq(lambda s, energy=energy: stored(s) - energy, 0.0, 1.0, xtol=1e-15, rtol=1e-14)
        assert_allclose(found, reference, rtol=1e-9)
        force = (stored(reference + 1e-8) - stored(reference - 1e-8)) / 2e-8
        assert_allclose(slope, 1.0 / force, rtol=1e-4)
