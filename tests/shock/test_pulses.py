"""Responses to pulses against printed maxima, the equation of motion, and closed forms of residuals."""

from functools import cache, partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import InputError
from jaxbuffer.shock import PULSES, largest_response, response

TOPIC = "Shock"
RATIOS = np.array([0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0])
LARGEST = {
    "half-sine": (0.396274, 0.942809, 1.570796, 1.763356, 1.732051, 1.5, 1.268075, 1.169913, 1.099802),
    "triangle": (0.311584, 0.745846, 1.273240, 1.489061, 1.508490, 1.287858, 1.0, 1.169497, 1.101698),
    "rectangle": (0.618034, 1.414214, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0),
}
FORCES = {
    "rectangle": lambda s: 1.0,
    "half-sine": lambda s: np.sin(np.pi * s),
    "triangle": lambda s: 1.0 - abs(2.0 * s - 1.0),
    "terminal-peak saw-tooth": lambda s: s,
    "initial-peak saw-tooth": lambda s: 1.0 - s,
    "versed sine": lambda s: 0.5 * (1.0 - np.cos(2.0 * np.pi * s)),
}


largest_of = jax.jit(largest_response, static_argnums=0)  # once for all ratios of a pulse


@pytest.mark.parametrize("pulse", LARGEST)
def test_largest_responses_over_the_duration(pulse, evidence):
    off = np.max(np.abs(largest_of(pulse, RATIOS) - np.array(LARGEST[pulse])))
    evidence(TOPIC, f"largest responses to a {pulse}", off, 6e-7, "closed forms, six digits")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("pulse", "ratio", "largest"),
    [
        ("half-sine", 0.809937, 1.7684577),
        ("triangle", 0.904594, 1.5171775),
        ("versed sine", 1.000, 1.7051431),
        ("terminal-peak saw-tooth", 0.650239, 1.2595905),
    ],
)
def test_the_worst_duration_of_each_pulse(pulse, ratio, largest):
    of_ratio = partial(largest_response, pulse)
    found, slope = jax.jit(jax.value_and_grad(of_ratio))(ratio)
    assert float(found) == pytest.approx(largest, abs=6e-8)
    assert abs(float(slope)) < 2e-3  # to the digits of the ratio: there the response neither rises nor falls
    around = jax.jit(of_ratio)(np.linspace(0.05, 6.0, 400))
    assert float(jnp.max(around)) <= largest + 1e-7


def test_initial_peak_saw_tooth_comes_near_two():
    """At 5: where tan(ωt/2) = ωτ, (1 - cos ωt) - (t - sin ωt/ω)/τ."""
    w = 10.0 * np.pi
    time = 2.0 * np.arctan(w) / w
    exact = 1.0 - np.cos(w * time) - (time - np.sin(w * time) / w)
    assert float(largest_of("initial-peak saw-tooth", 5.0)) == pytest.approx(exact, rel=1e-12)
    assert exact == pytest.approx(1.902026, abs=6e-7)


@cache
def motion(pulse):
    """The response by ratio and time, and its first and second derivative by time; compiled once for all ratios."""
    x = partial(response, pulse)
    rate = jax.grad(x, 1)
    return tuple(map(jax.jit, (x, rate, jax.grad(rate, 1))))


@pytest.mark.parametrize("pulse", PULSES)
@pytest.mark.parametrize("ratio", [0.3, 0.5, 1.0, 2.7])
def test_responses_solve_the_equation_of_motion(pulse, ratio, evidence):
    """ẍ/ω² + x = f, with x and ẋ zero at first, and continuous where the pulse's parts begin."""
    w, left = 2.0 * np.pi * ratio, []
    x, rate, curvature = (partial(it, ratio) for it in motion(pulse))
    for s in (0.05, 0.31, 0.62, 0.93):
        left.append(float(curvature(s)) / w**2 + float(x(s)) - FORCES[pulse](s))
    left += [float(curvature(s)) / w**2 + float(x(s)) for s in (1.2, 2.9)]
    evidence(TOPIC, "responses to six pulses", max(map(abs, left)), 1e-11, "their equation of motion")
    assert float(x(0.0)) == 0.0
    for s in (0.5, 1.0):
        assert float(x(s - 1e-9)) == pytest.approx(float(x(s + 1e-9)), abs=1e-7)
        assert float(rate(s - 1e-9)) == pytest.approx(float(rate(s + 1e-9)), abs=1e-5)


def test_short_pulses_leave_their_impulse_and_long_ones_their_force():
    """ω τ times the pulse's mean; 1 or 2 as the pulse begins slowly or at once."""
    short = {"rectangle": 1.0, "half-sine": 2.0 / np.pi, "triangle": 0.5, "versed sine": 0.5}
    for pulse, mean in short.items():
        assert float(largest_of(pulse, 1e-3)) == pytest.approx(2e-3 * np.pi * mean, rel=1e-4)
    assert float(largest_of("half-sine", 90.0)) == pytest.approx(1.0, abs=0.01)


@pytest.mark.slow
def test_a_derivative_by_the_ratio_is_that_of_the_closed_form():
    """Of the half-sine's residual, 4r |cos πr|/|1 - 4r²|."""
    residual = lambda r: 4.0 * r * jnp.cos(jnp.pi * r) / (1.0 - 4.0 * r * r)  # noqa: E731
    for r in (0.12, 0.33):
        assert float(largest_response("half-sine", r)) == pytest.approx(float(residual(r)), rel=1e-12)
        found = jax.grad(lambda r: largest_response("half-sine", r))(r)
        assert float(found) == pytest.approx(float(jax.grad(residual)(r)), rel=1e-10)


def test_an_unknown_pulse_is_refused():
    with pytest.raises(InputError, match=r"pulse = 'half-sin' is unknown.*did you mean half-sine"):
        response("half-sin", 1.0, 0.5)
