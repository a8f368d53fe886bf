"""Spectra of signals against pyyeti's values and the closed forms of pulses; the shear below a struck surface."""

import jax
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer import InputError
from jaxbuffer.shock import hertz_shear, largest_response, shock_spectrum, spectrum_of_motion

TOPIC = "Shock"


def half_sine(samples):
    return np.sin(np.pi * np.linspace(0.0, 1.0, samples))


def test_a_damped_spectrum_of_a_half_sine(evidence):
    """pyyeti.srs 1.4.7, Q = 10."""
    ratios = np.array([0.25, 0.5, 0.75, 0.8099, 1.0, 2.0])
    found = jax.jit(lambda signal: shock_spectrum(signal, 1.0 / 4000.0, ratios, 0.05))(half_sine(4001))
    off = np.max(np.abs(found - np.array([0.87808, 1.46264, 1.64490, 1.65142, 1.62379, 1.21237])))
    evidence(TOPIC, "damped spectrum of a half-sine", off, 2e-5, "pyyeti 1.4.7")


@pytest.mark.slow
def test_without_damping_it_is_the_closed_form():
    ratios = np.array([0.2, 0.5, 0.8, 1.3, 2.2])
    found = shock_spectrum(half_sine(4001), 1.0 / 4000.0, ratios, 0.0)
    np.testing.assert_allclose(found, largest_response("half-sine", ratios), atol=2e-5)


def test_it_is_differentiable_by_the_signal():
    spectrum = lambda a: shock_spectrum(a * half_sine(401), 1.0 / 400.0, np.array([0.7]), 0.05)[0]  # noqa: E731
    size = jax.jit(jax.grad(spectrum))(3.0)
    assert float(size) == pytest.approx(float(jax.jit(spectrum)(1.0)))


@pytest.mark.parametrize("frequency", [0.0, 30.0])
def test_frequencies_that_the_samples_do_not_show_are_refused(frequency):
    with pytest.raises(InputError, match=rf"{frequency:.6g} Hz; allowed: \(0, 20\] Hz"):
        shock_spectrum(half_sine(401), 1.0 / 400.0, np.array([1.0, frequency]))


def test_hertzs_shear_is_largest_half_a_radius_deep(evidence):
    """Johnson: 0.310 q0 at 0.48 a for ν = 0.3; the tank paper says about 2/((1 + ν)π)."""
    depth = np.linspace(0.0, 3.0, 30001)
    shear = np.asarray(hertz_shear(depth, 0.3))
    evidence(TOPIC, "largest shear below a Hertzian contact", abs(shear.max() - 0.310), 5e-4, "Johnson, three digits")
    assert depth[shear.argmax()] == pytest.approx(0.48, abs=5e-3)
    assert depth[shear.argmax()] == pytest.approx(2.0 / (1.3 * np.pi), rel=0.02)
    # at the surface: σz = -q0, σr = -(1 + 2ν)/2 q0
    assert shear[0] == pytest.approx(0.5 * (1.0 - 0.8), abs=1e-12)


def stopped(duration, peak):
    """Uneven instants, and the velocity of a half-sine of acceleration in between, steady before and after."""
    inside = np.random.default_rng(1).uniform(0.0, duration, 400)
    time = np.sort(np.concatenate([[-duration, 0.0, duration, 2.0 * duration], inside]))
    phase = np.pi * np.clip(time / duration, 0.0, 1.0)
    return time, 5.0 + peak * duration / np.pi * (1.0 - np.cos(phase))


@pytest.mark.slow
def test_the_spectrum_of_a_motion_is_that_of_its_pulse(evidence):
    ratios = np.array([0.1, 0.3, 0.5, 0.81, 1.3, 2.2, 5.0])
    time, velocity = stopped(0.011, 300.0)
    found = spectrum_of_motion(time, velocity, ratios / 0.011, 0.0)
    off = np.max(np.abs(found / (300.0 * largest_response("half-sine", ratios)) - 1.0))
    evidence(TOPIC, "spectrum of an uneven motion", off, 5e-4, "closed form of its pulse")


def test_the_spectrum_of_a_motion_is_differentiable_by_the_velocity():
    time, velocity = stopped(0.011, 300.0)

    @jax.jit
    @jax.value_and_grad
    def spectrum(scale):
        return spectrum_of_motion(time, scale * velocity, np.array([60.0]), 0.05)[0]

    (value, _), (_, derivative) = spectrum(1.0), spectrum(2.0)
    assert float(derivative) == pytest.approx(float(value), rel=1e-12)


@pytest.mark.long
def test_a_tanks_slider_shakes_what_it_carries_as_its_force_says():
    """Its acceleration is the force over the mass less gravity's: another way to the same spectrum."""
    run = jb.simulate(jb.TankDrop(), jb.TankDropScenario(height=0.1), 0.01, history=True)
    seen, frequencies = run.history, np.array([20.0, 50.0, 100.0])
    even = np.linspace(0.0, float(seen.time[-1]), 20001)
    force = np.interp(even, seen.time, seen.contact_force[:, 0])
    exact = shock_spectrum(force / 348.0 - 9.81, even[1], frequencies, 0.05)
    found = spectrum_of_motion(seen.time, seen.velocity[:, 0, 1], frequencies, 0.05)
    np.testing.assert_allclose(found, exact, rtol=5e-3)


@pytest.mark.parametrize(
    ("time", "velocity", "frequencies", "said"),
    [
        ([0.0, 2.0, 1.0], np.zeros(3), [1.0], "none before the one in front of it"),
        ([0.0, np.nan], np.zeros(2), [1.0], "none before the one in front of it"),
        ([0.0], np.zeros(1), [1.0], "two instants or more"),
        ([0.0, 1.0], np.zeros(3), [1.0], r"velocity has shape \(3,\), time \(2,\); both must have one"),
        (
            [0.0, 1.0],
            np.zeros(2),
            [1.0, 0.0],
            r"frequencies = \[1.0, 0.0\] Hz are out of range; allowed: \(0, inf\) Hz",
        ),
        ([0.0, 1.0], np.zeros(2), [np.inf], r"allowed: \(0, inf\) Hz"),
        ([0.0, 1.0], np.zeros(2), [], "at least one"),
    ],
)
def test_a_motion_that_is_none_is_refused(time, velocity, frequencies, said):
    with pytest.raises(InputError, match=said):
        spectrum_of_motion(np.array(time), velocity, frequencies)
