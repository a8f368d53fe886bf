"""The buffer's end and the flank's back over whole captures (M28 and M66 of docs/model.md)."""

import jax
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer import Outcome, Scenario, replace, simulate, table2

TOPIC, SOURCE = "The buffer's end", "an independent solution of the same model"
SOFT = replace(table2(), {"buffer.k_A": 20.0, "buffer.c_A": 1.0})
STOPPED = replace(SOFT, {"buffer.max_stroke": 0.05, "buffer.stop_stiffness": 2e4, "buffer.stop_damping": 20.0})
FAST = Scenario(approach_speed=0.35)


@pytest.mark.parametrize(("rtol", "tolerance"), [(1e-6, 1e-7), (1e-9, 1e-9)])
def test_a_run_ends_where_the_buffer_does(rtol, tolerance, evidence):
    """Without an end this run folded its stroke at 136.5 mm and ended captured with 1657.87 N."""
    capture = simulate(SOFT, FAST, rtol=rtol)
    assert capture.outcome == Outcome.bottomed
    assert int(capture.impact_count) == 17
    evidence(TOPIC, f"end time, rtol {rtol:g}", abs(capture.end_time / 0.509933655 - 1.0), tolerance * 4, SOURCE)
    evidence(TOPIC, f"peak force, rtol {rtol:g}", abs(capture.peak_force / 636.160445 - 1.0), tolerance, SOURCE)
    assert float(capture.stroke) == pytest.approx(0.1365, abs=1e-12)
    assert float(capture.capture_margin) < 0.0
    assert abs(float(capture.balance.energy)) < 1e-6


@pytest.mark.parametrize(("rtol", "tolerance"), [(1e-6, 1e-7), (1e-9, 4e-9)])
def test_an_end_stop_pushes_back(rtol, tolerance, evidence):
    capture = simulate(STOPPED, FAST, rtol=rtol)
    assert capture.outcome == Outcome.captured
    assert int(capture.impact_count) == 11
    for name, expected in (("end_time", 0.255552014), ("stroke", 0.0528788699), ("peak_hinge_force", 529.695637)):
        off = abs(float(getattr(capture, name)) / expected - 1.0)
        evidence(TOPIC, f"{name} with an end stop, rtol {rtol:g}", off, tolerance, SOURCE)
    assert float(capture.energy.stop_damper) > 1e-2
    evidence(TOPIC, "energy with an end stop", abs(float(capture.balance.energy)), 1e-6, "the start of the capture")
    assert float(capture.peak_stop_force) > 2e4 * (float(capture.stroke) - 0.05)  # spring alone where it is deepest


def numbers(design, scenario, rtol):
    """Quantities on which the buffer's end acts, as an array."""
    c = simulate(design, scenario, rtol=rtol)
    names = ("peak_hinge_force", "stroke", "end_time", "peak_stop_force", "capture_margin", "stroke_margin")
    return np.array([*(float(getattr(c, name)) for name in names), float(c.energy.stop_damper)])


STOP_PATHS = ("buffer.c_A", "buffer.max_stroke", "buffer.stop_stiffness", "buffer.stop_damping")
END_PATHS = ("buffer.c_A", "probe.tip_mass", "buffer.free_length")


@pytest.mark.long
@pytest.mark.parametrize(
    ("design", "paths"),
    [
        pytest.param(STOPPED, STOP_PATHS, id="end stop"),
        pytest.param(SOFT, END_PATHS, id="bottomed", marks=pytest.mark.slow),
    ],
)
def test_gradients_go_right_through(design, paths, evidence):
    """Against extrapolated differences of tight solves."""

    def outputs(values):
        c = simulate(replace(design, dict(zip(paths, values, strict=True))), FAST)
        peaks = [c.peak_hinge_force, c.stroke, c.end_time, c.peak_stop_force]
        return [*peaks, c.capture_margin, c.stroke_margin, c.energy.stop_damper]

    values = [float(jb.get(design, path)) for path in paths]
    found = np.array(jax.jit(jax.jacfwd(outputs))(values))
    expected = np.zeros_like(found)
    for k, (path, value) in enumerate(zip(paths, values, strict=True)):
        slopes = []
        for step in (1e-5 * value, 5e-6 * value):
            ends = [numbers(replace(design, {path: value + sign * step}), FAST, 1e-11) for sign in (1.0, -1.0)]
            slopes.append((ends[0] - ends[1]) / (2.0 * step))
        expected[:, k] = (4.0 * slopes[1] - slopes[0]) / 3.0
    sizes = np.abs(numbers(design, FAST, 1e-9))[:, None] / np.array(values)
    error = np.abs(found - expected) / np.maximum(np.abs(expected), 1e-3 * sizes + 1e-12)
    assert np.count_nonzero(np.abs(expected) > 1e-3 * sizes) > 6
    evidence(
        TOPIC,
        f"gradients, {'with' if design is STOPPED else 'without'} an end stop",
        error.max(),
        1e-3,
        "differences of tight solves",
    )


def test_the_margin_goes_on_where_the_stroke_just_reaches_the_end():
    """Table 2's stroke is 7.49727 mm: a buffer that ends just there has no margin left."""
    stroke = float(simulate(table2(), rtol=1e-9).stroke)
    margins = {}
    for part in (-1e-5, 1e-5):
        capture = simulate(replace(table2(), {"buffer.max_stroke": stroke * (1.0 + part)}), rtol=1e-9)
        margins[capture.outcome] = float(capture.capture_margin)
    assert margins[Outcome.captured] == pytest.approx(1e-5 * stroke, rel=1e-3)
    # what is missing is told from the buffer's force; that of the impact under way adds to it
    assert -2e-5 * stroke < margins[Outcome.bottomed] < 0.0


@pytest.mark.long
def test_the_flank_has_a_back():
    """The tip's centre passed the flank and the run ended captured."""
    soft = replace(table2(), {"contact.stiffness": 1e3})
    through = simulate(soft, Scenario(approach_speed=0.3))
    assert through.outcome == Outcome.failed_penetration
    assert np.isnan(float(through.peak_force))
    deep = simulate(replace(soft, {"contact.stiffness": 1e4}), Scenario(approach_speed=0.3), history=True)
    assert deep.outcome == Outcome.captured
    assert "outside the contact law's validity: the tip goes up to 10.2 mm deep" in repr(deep)
    assert "outside" not in repr(simulate(table2()))


def test_no_speed_is_too_high_for_a_word():
    """900 m/s was captured too."""
    assert simulate(table2(), Scenario(approach_speed=900.0)).outcome == Outcome.bottomed


@pytest.mark.parametrize(
    ("restitution", "law"),
    [
        (0.3, "lankarani-nikravesh"),
        pytest.param(0.3, "adams", marks=pytest.mark.long),
        pytest.param(0.3, "kelvin-voigt", marks=pytest.mark.long),
        (0.9, "lankarani-nikravesh"),
        (0.9, "adams"),
        pytest.param(0.9, "kelvin-voigt", marks=pytest.mark.long),
    ],
)
def test_no_penetration_exceeds_the_one_told(restitution, law):
    """Against every step's gap; at e = 0.9 within two per cent."""
    design = replace(table2(), {"contact.law": law, "contact.restitution": restitution})
    capture = simulate(design, history=True)
    deepest = -float(np.min(capture.history.gap))
    assert deepest <= float(capture.penetration) * (1.0 + 1e-9)
    if law == "lankarani-nikravesh" and restitution == 0.9:
        assert deepest > 0.98 * float(capture.penetration)


@pytest.mark.long
def test_a_yield_stress_is_held_against_the_pressure():
    """Aluminium of 300 MPa yields under Table 2's peak; its pressure is Hertz's 3 F/(2 π a²), a² = R δ."""
    capture = simulate(replace(table2(), {"contact.yield_stress": 300e6}))
    force, radius = float(capture.peak_force), 0.015
    depth = (force / 6.43328e9) ** (2.0 / 3.0)
    pressure = 3.0 * force / (2.0 * np.pi * radius * depth)
    assert f"the materials yield, {1e-6 * pressure:.4g} MPa" in repr(capture)
    assert "yield" not in repr(simulate(replace(table2(), {"contact.yield_stress": 600e6})))


NUMBERS = (
    *("outcome", "peak_force", "peak_time", "peak_flank", "peak_hinge_force", "peak_buffer_force", "stroke"),
    *("stroke_margin", "hinge_angle", "end_time", "contact_time", "capture_margin", "impact_count"),
)


@pytest.mark.long
def test_a_full_log_loses_nothing_but_the_list_of_impacts():
    """21 of 16 000 random captures failed with a full log: they had more impacts than it lists."""
    whole, short = (simulate(table2(), max_events=events) for events in (512, 20))
    for name in NUMBERS:
        # another program rounds otherwise, and steps elsewhere
        assert float(getattr(short, name)) == pytest.approx(float(getattr(whole, name)), rel=1e-6), name
    assert (int(short.impacts.count), int(short.impact_count), int(short.peak_impact)) == (5, 24, -1)
    for name in ("time", "contact", "approach_speed", "peak_force", "release_time"):
        ours, other = (np.asarray(getattr(c.impacts, name))[:4] for c in (short, whole))
        np.testing.assert_allclose(ours, other, rtol=1e-6, err_msg=name)
    assert "impact after the 5th of 24" in repr(short)


@pytest.mark.long
def test_derivatives_of_a_run_with_a_full_log():
    """Right as ever, but for the time in contact, whose events are not all known: NaN."""

    def outputs(stiffness):
        c = simulate(replace(table2(), {"buffer.k_A": stiffness}), max_events=20)
        return [c.peak_force, c.stroke, c.end_time, c.contact_time]

    peak, stroke, end, contact = map(float, jax.jit(jax.jacfwd(outputs))(500.0))
    assert 500.0 / 253.1315 * peak == pytest.approx(0.34139, rel=1e-3)  # the reference's elasticity
    tight = [simulate(replace(table2(), {"buffer.k_A": 500.0 + d}), rtol=1e-11) for d in (0.02, -0.02)]
    for slope, name in ((stroke, "stroke"), (end, "end_time")):
        expected = float(getattr(tight[0], name) - getattr(tight[1], name)) / 0.04
        assert slope == pytest.approx(expected, rel=1e-3)
    assert np.isnan(contact)


MANY = {  # more than 512 events: nearly elastic, a light target, a slow way in
    "buffer.k_A": 2203.4,
    "buffer.c_A": 19.237,
    "buffer.k_T": 104.24,
    "buffer.c_T": 0.63598,
    "active.mass": 106.64,
    "active.inertia": 5.3292,
    "passive.mass": 18.728,
    "passive.inertia": 0.39312,
    "probe.tip_mass": 0.21168,
    "cone.half_angle": 0.67875,
    "contact.restitution": 0.98836,
    "contact.friction": 0.19303,
}


def test_a_run_of_more_events_than_the_log_holds_does_not_fail():
    scenario = Scenario(approach_speed=0.18632, contact_distance=0.063416, misalignment=0.14814, passive_rate=0.011198)
    capture = simulate(replace(table2(), MANY), scenario)
    assert not capture.outcome.failed
    assert bool(capture.log.overflown) and int(capture.impact_count) > 100
    assert abs(float(capture.balance.energy)) < 2e-6
