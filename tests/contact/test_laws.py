"""The family of contact laws: published restitutions, closed forms, no tension, and what a design makes of a name."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq

from in_short import often
from jaxbuffer import InputError, replace, table2
from jaxbuffer.contact.laws import (
    LAWS,
    AdamsImpact,
    CarvalhoMartins,
    ContactLaw,
    ExactRestitution,
    Flores,
    Gonthier,
    HerbertMcWhannell,
    Hertz,
    HuGuo,
    HuntCrossley,
    KelvinVoigt,
    LankaraniNikravesh,
    LeeWang,
    free_impact,
    hertz_stiffness,
    socket_stiffness,
    step,
    two_spheres_stiffness,
)
from jaxbuffer.contact.laws.restitution import damping_delivering, psi, restitution_delivered
from jaxbuffer.mechanisms.probe_cone.assembly import tip_on_flanks

MASS, STIFFNESS, SPEED = 1.0, 1.4e8, 4.4294  # kg, N/m^1.5, m/s

# Restitution delivered for the one asked for, and the exact damping factor, as published to four digits.
PUBLISHED = {
    0.1: (0.5158, 0.4907, 0.6867, 0.6653, 0.1010, 0.0694, 0.0741, 9.9982),
    0.3: (0.5813, 0.5200, 0.7390, 0.6842, 0.3042, 0.2562, 0.2707, 3.0871),
    0.5: (0.6630, 0.5936, 0.7992, 0.7252, 0.4877, 0.4704, 0.4877, 1.4328),
    0.7: (0.7680, 0.7227, 0.8693, 0.7960, 0.6696, 0.6832, 0.6973, 0.6348),
    0.9: (0.9090, 0.9009, 0.9524, 0.9132, 0.8764, 0.8939, 0.8999, 0.1665),
}
FAMILY = (HuntCrossley, HerbertMcWhannell, LeeWang, LankaraniNikravesh, Gonthier, Flores, HuGuo)
EXAMPLES = {
    "hertz": Hertz(STIFFNESS),
    **{law.__name__: law(STIFFNESS, 0.6) for law in (*FAMILY, CarvalhoMartins, ExactRestitution)},
    "quadratic": HuntCrossley(1e10, 0.6, exponent=2.0),
    "linear": ExactRestitution(2e5, 0.6, exponent=1.0),
    "underdamped": KelvinVoigt(2e7, 300.0),
    "critical": KelvinVoigt(2e4, 2.0002 * np.sqrt(2e4)),
    "overdamped": KelvinVoigt(2e4, 1e3),
    "adams": AdamsImpact(STIFFNESS, 1.5, 400.0, 1e-4),
}
each_example = pytest.mark.parametrize("law", EXAMPLES.values(), ids=EXAMPLES)


@pytest.mark.parametrize("asked", PUBLISHED)
def test_delivered_restitution_as_published(asked):
    *delivered, factor = PUBLISHED[asked]
    found = [float(law(STIFFNESS, asked).delivered_restitution()) for law in FAMILY]
    assert_allclose(found, delivered, rtol=0.0, atol=5.001e-5)  # half a unit of the last digit
    exact = ExactRestitution(STIFFNESS, asked)
    assert_allclose(exact.hysteresis, factor, rtol=0.0, atol=5.001e-5)
    assert_allclose(exact.delivered_restitution(), asked, rtol=1e-14)


def test_carvalho_and_martins_deliver_as_published():
    """Five digits from e = 1/2 on; below 1/3 the law is Gonthier's, above it joins without a jump."""
    found = [CarvalhoMartins(STIFFNESS, asked).delivered_restitution() for asked in (0.5, 0.7, 0.9)]
    assert_allclose(found, [0.50017, 0.69997, 0.90000], rtol=0.0, atol=5.001e-6)
    below = [float(CarvalhoMartins(STIFFNESS, asked).delivered_restitution()) for asked in (0.1, 0.3)]
    assert_allclose(below, [PUBLISHED[asked][4] for asked in (0.1, 0.3)], rtol=0.0, atol=5.001e-5)


@pytest.mark.parametrize("asked", [0.05, 0.1, 0.5, 0.9, 0.99])
def test_exact_law_solves_the_relation_and_delivers(asked):
    d = brentq(
        lambda d: np.log((1 + d) / (1 - d * asked)) - d * (1 + asked), 1 / asked - 1 + 1e-12, (1 - 1e-15) / asked
    )
    law = ExactRestitution(STIFFNESS, asked)
    assert_allclose(law.hysteresis, d, rtol=1e-10)
    assert_allclose(free_impact(law, MASS, SPEED).restitution, asked, rtol=2e-9)


def test_exact_relation_reaches_its_limits():
    """No loss for e = 1, 3/2 (1 - e) next to it, 1/e for small e; in both directions, and finite derivatives."""
    assert float(damping_delivering(1.0)) == 0.0
    assert float(restitution_delivered(0.0)) == 1.0
    assert_allclose(damping_delivering(1 - 1e-6), 1.5e-6, rtol=1e-5)
    assert_allclose(damping_delivering(1e-3), 1e3, rtol=1e-12)
    assert_allclose(jax.grad(damping_delivering)(1.0), -1.5, rtol=1e-14)
    assert_allclose(jax.grad(restitution_delivered)(0.0), -2 / 3, rtol=1e-14)
    for e in (0.05, 0.4, 0.95):
        slope = (damping_delivering(e + 1e-4) - damping_delivering(e - 1e-4)) / 2e-4
        assert_allclose(jax.grad(damping_delivering)(e), slope, rtol=2e-5)
        assert_allclose(jax.grad(restitution_delivered)(damping_delivering(e)) * slope, 1.0, rtol=2e-5)


@pytest.mark.parametrize("x", [-0.9, -0.0501, -0.0499, 1e-3, 0.0499, 0.0501, 5.0])
def test_series_and_logarithm_meet(x):
    """ψ(x) = -∫₀¹ t/(1 + x t) dt, smooth through x = 0."""
    assert_allclose(psi(x), quad(lambda t: -t / (1 + x * t), 0.0, 1.0, epsrel=1e-13)[0], rtol=2e-13)


@each_example
def test_told_restitution_and_penetration_are_those_of_an_integrated_impact(law):
    """Closed forms against a time integration of two free bodies."""
    impact = free_impact(law, MASS, SPEED)
    assert_allclose(law.delivered_restitution(MASS, SPEED), impact.restitution, rtol=1e-9)
    assert_allclose(law.max_penetration(MASS, SPEED), impact.max_penetration, rtol=1e-9)


def test_adams_law_against_a_quadrature():
    """Without its damper it is Hertz's; with it, the kinetic energy that is gone is what the damper took."""
    assert_allclose(AdamsImpact(STIFFNESS, 1.5, 0.0, 1e-4).delivered_restitution(MASS, SPEED), 1.0, rtol=1e-9)
    law = AdamsImpact(STIFFNESS, 2.2, 400.0, 1e-4)
    impact = free_impact(law, MASS, SPEED, points=20001)
    taken = (impact.force - np.asarray(law.elastic(impact.penetration))) * impact.speed
    lost = np.trapezoid(taken, impact.time)
    assert_allclose(0.5 * MASS * SPEED**2 * (1 - impact.restitution**2), lost, rtol=1e-6)


def test_hertz_impact_as_published():
    """1.983 mm, 12.366 kN, 1.318 ms; and 2.943275 δ/v."""
    impact = free_impact(Hertz(STIFFNESS), MASS, SPEED)
    found = [impact.max_penetration, impact.peak_force, impact.duration]
    assert_allclose(found, [1.983e-3, 12.366e3, 1.318e-3], rtol=4e-4)
    assert_allclose(impact.duration, 2.943275 * impact.max_penetration / SPEED, rtol=2e-7)
    assert_allclose(impact.peak_force, STIFFNESS**0.4 * (1.25 * MASS * SPEED**2) ** 0.6, rtol=1e-9)


def test_damped_oscillator():
    """Half a period of m δ̈ + c δ̇ + k δ = 0, until the force is spent: its depth, force at touchdown and restitution."""
    law, zeta = KelvinVoigt(2e7, 300.0), 300.0 / (2 * np.sqrt(2e7))
    impact = free_impact(law, MASS, SPEED)
    natural, damped = np.sqrt(2e7), np.sqrt(2e7 * (1 - zeta**2))
    times = np.linspace(0.0, np.arccos(2 * zeta**2 - 1) / damped, 9)  # arccos(2ζ² - 1)/ω: where k δ + c δ̇ = 0
    depth = SPEED / damped * np.exp(-zeta * natural * times) * np.sin(damped * times)
    assert_allclose(np.interp(times, impact.time, impact.penetration), depth, rtol=0, atol=2e-5 * np.max(depth))
    assert_allclose(impact.force[0], 300.0 * SPEED, rtol=1e-12)


@each_example
def test_no_law_pulls_and_derivatives_are_finite(law):
    @jax.jit
    def force(*arguments):
        return law.force(*arguments)

    forces = np.asarray(force(*np.meshgrid(np.linspace(0.0, 2e-3, 41), np.linspace(-30.0, 30.0, 61)), SPEED))
    assert np.min(forces) == 0.0
    assert np.max(forces) > 0.0
    slopes_of = jax.jit(jax.grad(force, (0, 1, 2)))
    for penetration in (-1e-12, 0.0, 1e-300, 1e-12):
        slopes = slopes_of(penetration, 0.1, 0.2)
        assert np.all(np.isfinite(slopes))
        assert law.jumps or penetration > 0.0 or np.all(np.asarray(slopes) == 0.0)


@each_example
def test_stored_energy_is_the_work_of_the_elastic_force(law):
    stored, _ = quad(lambda depth: float(law.elastic(depth)), 0.0, 3e-5, epsrel=1e-12, epsabs=0.0)
    assert_allclose(law.energy(3e-5), stored, rtol=1e-9)
    assert float(law.elastic(-1e-6)) == 0.0


def test_step_of_adams():
    """STEP from 0 to 1 over 3 to 4, as its manual tabulates it; flat at both ends."""
    ramp = jax.jit(lambda x: step(x, 3.0, 0.0, 4.0, 1.0))
    assert_allclose(ramp(np.array([2.0, 3.0, 3.5, 4.0, 5.0])), [0.0, 0.0, 0.5, 1.0, 1.0], rtol=0)
    slope = jax.jit(jax.vmap(jax.grad(ramp)))(np.array([3.0, 3.5, 4.0]))
    assert_allclose(slope, [0.0, 1.5, 0.0], rtol=0, atol=1e-15)


def test_impact_of_adams_by_hand():
    """k δᵉ + c δ̇ STEP: half way up the ramp half the damper, beyond it all of it, and no pull."""
    law = AdamsImpact(1e8, 2.0, 1e3, 1e-4)
    found = [law.force(depth, speed, 1.0) for depth, speed in ((5e-5, 0.2), (2e-4, 0.2), (2e-4, -1.0), (0.0, 1.0))]
    assert_allclose(found, [0.25 + 100.0, 4.0 + 200.0, 0.0, 0.0], rtol=1e-12)


def test_stiffness_from_radii():
    """Two equal balls: the plane's over √2. A huge second ball, or socket, is a plane. A socket is stiffer."""
    plane = hertz_stiffness(0.015)
    assert_allclose(two_spheres_stiffness(0.015, 0.015), plane / np.sqrt(2), rtol=1e-14)
    assert_allclose([two_spheres_stiffness(0.015, 1e9), socket_stiffness(0.015, 1e9)], plane, rtol=1e-10)
    assert_allclose(socket_stiffness(0.015, 0.02), 2 * plane, rtol=1e-14)
    assert_allclose(
        two_spheres_stiffness(0.01, 0.03, 1e30, 0.3, 5e6, 0.5), 4 / 3 * 5e6 / 0.75 * 0.0075**0.5, rtol=1e-12
    )
    with pytest.raises(InputError, match=r"socket_radius = 0\.015 m must be above the ball's radius, 0\.02 m"):
        socket_stiffness(0.02, 0.015)


@pytest.mark.parametrize("name", LAWS)
def test_a_design_chooses_a_law_by_its_name(name):
    """Each law gets those of the design's numbers that it has."""
    values = {"contact.law": name, "contact.stiffness": 5e9, "contact.restitution": 0.7, "contact.damping": 33.0}
    law = tip_on_flanks(replace(table2(), values)).law
    assert type(law) is LAWS[name]
    wanted = {"stiffness": 5e9, "restitution": 0.7, "damping": 33.0, "linear_stiffness": 1.5e7, "ramp_depth": 1e-6}
    assert all(getattr(law, field) == value for field, value in wanted.items() if hasattr(law, field))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"contact.law": "hunt-crosley"}, "did you mean hunt-crossley"),
        (
            {"contact.law": "flores", "contact.exponent": 2.0},
            "only contact.law = 'adams' has an exponent other than 1.5",
        ),
        ({"contact.law": "adams", "contact.exponent": 2.0}, "contact.exponent = 2 needs contact.stiffness"),
        (
            {"contact.law": "adams", "contact.stiffness": 1e7, "contact.exponent": 0.5},
            r"contact.exponent = 0.5 is out of range; allowed: \[1, inf\)",
        ),
        ({"contact.law": "kelvin-voigt", "contact.memory": "smooth"}, "contact.memory must be 'event'"),
    ],
)
def test_what_does_not_fit_a_law_is_refused(values, message):
    with pytest.raises(InputError, match=message):
        replace(table2(), values)


@eqx.filter_jit  # once for all forces of a law
def depth_and_slope(way, law, force):
    return jax.value_and_grad(lambda f: jnp.asarray(way(law, f)))(force)


@eqx.filter_jit
def exerted_and_stiffness(law, depth):
    return jax.value_and_grad(law.elastic)(depth)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
@pytest.mark.parametrize("force", often([1e-3, 250.0, 1e6], 250.0))
def test_the_depth_of_a_force_and_its_slope(name, force):
    """In closed form and by bisection: there the spring alone exerts it; the slope is the inverse of the spring's."""
    law = EXAMPLES[name]
    for way in (type(law).depth, ContactLaw.depth):
        found, slope = depth_and_slope(way, law, jnp.asarray(force))
        exerted, stiffness = exerted_and_stiffness(law, found)
        assert_allclose(exerted, force, rtol=1e-12)
        assert_allclose(slope * stiffness, 1.0, rtol=1e-9)
        assert depth_and_slope(way, law, jnp.asarray(0.0))[0] == 0.0
