"""A probe that bends (M108): frequencies, limits, first impact, gradients and balance against closed forms and an
independent program."""

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq

import jaxbuffer as jb
from jaxbuffer import InputError, replace, table2, with_bending
from jaxbuffer.mechanisms.probe_cone.parts.bending import Bending
from verification.exact_bending import BendingModel

FIRST = 1e-3  # s, longer than a first impact
SOURCE = "Lagrange's equations in SciPy, tests/verification/exact_bending.py"
TOPIC = "A probe that bends"


def soft(frequency, modes=2, damping_ratio=0.02, **changes):
    return with_bending(replace(table2(), changes), frequency, damping_ratio, modes)


def first_peak(design, rtol=1e-9):
    return float(jb.simulate(design, duration=FIRST, rtol=rtol).peak_force)


def clamped_beam_with_a_ball(design, count):
    """Frequencies of a clamped beam with a solid ball at its end [Hz], from the characteristic equation."""
    probe = design.probe
    mass = probe.tip_mass / probe.rod_mass
    inertia = 0.4 * mass * (probe.tip_radius / probe.length) ** 2

    def condition(x):
        c, s, ch, sh = np.cos(x), np.sin(x), np.cosh(x), np.sinh(x)
        moment = [ch + c - inertia * x**3 * (sh + s), sh + s - inertia * x**3 * (ch - c)]
        force = [sh - s + mass * x * (ch - c), ch + c + mass * x * (sh - s)]
        return (moment[0] * force[1] - moment[1] * force[0]) / np.cosh(x) ** 2

    grid = np.linspace(0.3, 12.0, 2000)
    values = [condition(x) for x in grid]
    roots = [
        brentq(condition, a, b) for a, b, u, v in zip(grid, grid[1:], values, values[1:], strict=False) if u * v < 0
    ]
    scale = np.sqrt(probe.bending_stiffness / (probe.rod_mass * probe.length**3)) / (2.0 * np.pi)
    return scale * np.array(roots[:count]) ** 2


@pytest.mark.quick
def test_frequencies_of_a_clamped_beam_with_a_ball(evidence):
    design = soft(50.0, modes=6)
    expected = clamped_beam_with_a_ball(design, 3)
    error = np.max(np.abs(np.asarray(jb.bending_frequencies(design))[:3] / expected - 1.0))
    evidence(
        TOPIC, "first three frequencies, six modes", error, 1e-4, "characteristic equation of the beam", "relative"
    )


@pytest.mark.quick
@pytest.mark.parametrize("modes", [2, 4])
def test_a_frequency_is_what_was_asked_for(modes):
    design = soft(70.0, modes, damping_ratio=0.03)
    assert_allclose(float(jb.bending_frequencies(design)[0]), 70.0, rtol=1e-12)
    assert_allclose(np.pi * 70.0 * design.probe.bending_damping, 0.03, rtol=1e-12)
    assert design.probe.bending_modes == modes


@pytest.mark.long
def test_stiffer_probes_tend_to_the_rigid_one(evidence):
    """The first peak's distance from the rigid probe's goes with 1/f², as a static deflection does."""
    rigid, steps = first_peak(table2()), np.array([1e4, 3e4, 9e4])
    off = np.array([1.0 - first_peak(soft(f)) / rigid for f in steps])
    assert np.all(off > 0.0)
    orders = np.log(off[:-1] / off[1:]) / np.log(3.0)
    evidence(TOPIC, "first peak tends to the rigid probe's with 1/f²", np.max(np.abs(orders - 2.0)), 0.2, "rigid probe",
             "order", f"off by {off[0]:.1e}, {off[1]:.1e}, {off[2]:.1e} at 10, 30, 90 kHz")  # fmt: skip
    whole, bent = jb.simulate(table2()), jb.simulate(soft(1e5))
    assert bent.outcome == whole.outcome
    assert_allclose(float(bent.end_time), float(whole.end_time), rtol=1e-5)
    assert_allclose(float(bent.peak_force), float(whole.peak_force), rtol=5e-4)


def test_first_impact_of_a_soft_probe_meets_the_closed_form(evidence):
    """Without friction, and so soft that bending and buffer have no time to answer: only the masses count."""
    buffer = {"buffer.k_A": 1.0, "buffer.c_A": 0.0, "buffer.k_T": 1.0, "buffer.c_T": 0.0}
    design = soft(0.05, 2, 0.0, **{"contact.friction": 0.0}, **buffer)
    expected = float(jb.first_impact(design).predicted_peak)
    evidence(TOPIC, "first peak of a very soft probe", abs(first_peak(design) / expected - 1.0), 1e-6,
             "closed form through the modes (M79, M81)", "relative")  # fmt: skip


@pytest.mark.parametrize(
    ("frequency", "modes"), [(50.0, 2), pytest.param(200.0, 3, marks=pytest.mark.long), (2000.0, 2)]
)
def test_first_impact_of_an_independent_program(evidence, frequency, modes):
    design = soft(frequency, modes)
    model, run = BendingModel(design, jb.Scenario()), jb.simulate(design, duration=FIRST, rtol=1e-9)
    contact, hinge = model.impacts(FIRST)
    assert_allclose(jb.bending_frequencies(design), model.frequencies(), rtol=1e-6)
    evidence(TOPIC, "first impact's peak", abs(float(run.peak_force) / contact - 1.0), 1e-6, SOURCE, "relative")
    evidence(TOPIC, "hinge force in it", abs(float(run.peak_hinge_force) / hinge - 1.0), 1e-6, SOURCE, "relative")


@pytest.mark.long
def test_elasticities_of_the_first_peak(evidence):
    """By stiffness and damping of the bending and a number of the buffer, against differences of the other program."""
    design = soft(2000.0)
    paths = ["probe.bending_stiffness", "probe.bending_damping", "buffer.k_T"]
    found = jb.sensitivity(design, duration=FIRST, wrt=paths, quantities=["peak_force"], rtol=1e-9, certify="none")

    def peak(path, factor):
        changed = replace(design, {path: jb.get(design, path) * factor})
        return BendingModel(changed, jb.Scenario()).impacts(3e-4, rtol=1e-12)[0]

    for path, elasticity in zip(paths, found.elasticities[0], strict=True):
        h = 1e-2
        narrow, wide = (
            np.log(peak(path, 1.0 + s) / peak(path, 1.0 - s)) / np.log((1.0 + s) / (1.0 - s)) for s in (h, 2.0 * h)
        )
        expected = (4.0 * narrow - wide) / 3.0
        evidence(TOPIC, f"elasticity of the first peak by {path}", abs(elasticity - expected), 1e-6, SOURCE, "",
                 f"{elasticity:.6g}")  # fmt: skip


@pytest.mark.parametrize("frequency", [20.0, 200.0, 5000.0])
def test_a_whole_capture_conserves(evidence, frequency):
    run = jb.simulate(soft(frequency))
    assert run.outcome.name == "captured"
    for name, tolerance in (("energy", 1e-6), ("linear_momentum", 1e-8), ("angular_momentum", 1e-8), ("drift", 1e-8)):
        error = abs(float(getattr(run.balance, name)))
        evidence(TOPIC, f"{name} of whole captures", error, tolerance, "conservation", "m" if name == "drift" else "")


@pytest.mark.long
def test_many_stiffnesses_at_once():
    """A traced number, and a sweep's array of designs, give what single runs give."""
    design, values = soft(50.0), np.array([10.0, 40.0])
    one = [first_peak(replace(design, {"probe.bending_stiffness": v}), 1e-6) for v in values]

    def peak(value):
        return jb.simulate(replace(design, {"probe.bending_stiffness": value}), duration=FIRST).peak_force

    assert_allclose(jax.vmap(peak)(jnp.asarray(values)), one, rtol=1e-7)
    found = jb.sweep(replace(design, {"probe.bending_stiffness": values}), jb.Scenario(), FIRST)
    assert_allclose(found.peak_force, one, rtol=1e-7)


@pytest.mark.long
def test_what_a_run_shows():
    run = jb.simulate(soft(5.0), history=True)
    highest = f"{float(jb.bending_frequencies(run.design)[-1]):.4g}"
    assert_allclose(np.max(np.abs(run.history.bending)), float(run.bending), rtol=1e-3)
    text = str(run)
    assert f"2 modes, 5 to {highest} Hz, the first damped to 2 %" in text
    assert "outside the linear theory of bending" not in text
    assert f"too few modes: the highest, {highest} Hz" in text
    assert ", bending " in text
    fast = jb.simulate(soft(500.0, modes=5))
    assert "too few modes" not in str(fast)
    assert float(jb.simulate(table2()).bending) == 0.0


def test_bending_beyond_a_tenth_of_the_length_is_warned_of():
    run = jb.simulate(soft(5.0), jb.Scenario(approach_speed=0.3), 0.3)
    assert float(run.bending) > 0.02
    assert "more than a tenth of its length of 200 mm" in str(run)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"probe.bending_stiffness": 0.0}, "probe.bending_stiffness = 0 N m² is out of range; allowed: (0, inf) N m²"),
        ({"probe.bending_damping": -1.0}, "probe.bending_damping = -1 s is out of range; allowed: [0, inf) s"),
        ({"probe.bending_modes": 1}, "probe.bending_modes = 1 must be a whole number of at least 2"),
        ({"probe.bending_modes": 2.5}, "probe.bending_modes = 2.5 must be a whole number of at least 2"),
    ],
)
def test_bad_numbers_are_named(values, message):
    with pytest.raises(InputError) as caught:
        replace(table2(), values)
    assert str(caught.value) == message


def test_helpers_refuse_what_makes_no_sense():
    with pytest.raises(InputError, match=r"frequency = -5 Hz is out of range"):
        with_bending(table2(), -5.0)
    with pytest.raises(InputError, match=r"damping_ratio = -1 is out of range|damping_ratio = -1 - is out of range"):
        with_bending(table2(), 5.0, -1.0)
    with pytest.raises(InputError, match="the probe does not bend"):
        jb.bending_frequencies(table2())


@pytest.mark.parametrize(("ratio", "said"), [(0.0, True), (0.02, False)])
def test_undamped_bending_is_said_to_let_errors_grow(ratio, said):
    run = SimpleNamespace(
        design=soft(50.0, damping_ratio=ratio), bending=0.0, first_impact=SimpleNamespace(duration=1.0)
    )
    assert any("errors may grow" in line for line in Bending().report.warnings(run)) == said
