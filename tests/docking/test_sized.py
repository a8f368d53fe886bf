"""A latch and a buffer that fit: each closed form against integration or algebra of its own, and against runs."""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jaxbuffer as jb
from jaxbuffer.mechanisms.probe_cone.sized.encounter import encounter, hinge_to_tip, play, turn_inertia
from jaxbuffer.mechanisms.probe_cone.sized.oscillator import SpringsInARow, at_rest_after, first_swing, largest_force
from jaxbuffer.mechanisms.probe_cone.sized.rules import closing_time, pull_stiffness, turn_stiffness

TIGHT = {"rtol": 1e-11, "atol": 1e-13, "method": "DOP853"}


@pytest.mark.parametrize("ratio", [0.02, 0.26, 0.45, 0.7, 0.95])
def test_first_swing_and_force_are_those_of_an_integrated_oscillator(ratio):
    solved = solve_ivp(
        lambda t, y: [y[1], -y[0] - 2.0 * ratio * y[1]], (0.0, 4.0), [0.0, 1.0], dense_output=True, **TIGHT
    )
    y = solved.sol(np.linspace(0.0, 4.0, 400_001))
    assert first_swing(ratio) == pytest.approx(np.max(y[0]), rel=1e-9)
    assert largest_force(ratio) == pytest.approx(np.max(np.abs(y[0] + 2.0 * ratio * y[1])), rel=1e-9)


def test_without_damping_they_are_one():
    assert first_swing(0.0) == largest_force(0.0) == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize(("ratio", "share"), list(itertools.product([0.1, 0.45, 0.9], [1e-3, 1e-2])))
def test_the_envelope_bounds_when_an_oscillator_is_at_rest_by_a_period_at_most(ratio, share):
    """From v at the spring's free length and from any other phase; half a period is what the envelope gives away."""
    damped = math.sqrt(1.0 - ratio**2)
    latest = 0.0
    for phase in np.linspace(0.0, math.pi, 13):
        x, v = math.sin(phase), math.cos(phase)
        t = np.linspace(0.0, 100.0, 100_001)
        decay = np.exp(-ratio * t)
        position = decay * (x * np.cos(damped * t) + (v + ratio * x) / damped * np.sin(damped * t))
        velocity = decay * (v * np.cos(damped * t) - (x + ratio * v) / damped * np.sin(damped * t))
        latest = max(latest, float(t[np.flatnonzero(position**2 + velocity**2 > share)[-1]]))
    bound = at_rest_after(ratio, 1.0, share)
    assert latest <= bound <= latest + math.pi / damped


def test_a_row_is_two_springs_with_a_light_mass_between_them():
    row = SpringsInARow(10.0, 160.0, 20.0, 60.0, 30.0)
    between = 1e-6

    def rates(t, y):
        z, s, u, w = y  # the mass's displacement, the first spring's, and their rates
        first, second = 160.0 * s + 20.0 * w, 60.0 * (z - s) + 30.0 * (u - w)
        return [u, w, -second / 10.0, (second - first) / between]

    # Where nothing weighs between them, the speed is shared at once, by the dampers.
    start = [0.0, 0.0, 1.0, 30.0 / 50.0]
    times = np.linspace(0.0, 3.0, 301)
    solved = solve_ivp(rates, (0.0, 3.0), start, t_eval=times, method="Radau", rtol=1e-9, atol=1e-12)
    z, speed, s = row.motion(times)
    assert np.allclose([z, speed, s], [solved.y[0], solved.y[2], solved.y[1]], atol=1e-6)


def test_a_row_with_a_stiff_second_spring_is_one_oscillator():
    ratio, share = 0.3, 1e-3
    met = SpringsInARow(10.0, 160.0, 2.0 * ratio * math.sqrt(1600.0), 1e8, 0.0).arrest(share)
    frequency = 4.0
    assert met.swing == pytest.approx(first_swing(ratio) / frequency, rel=3e-5)
    assert met.force == pytest.approx(10.0 * frequency * largest_force(ratio), rel=3e-5)
    assert 0.8 * at_rest_after(ratio, frequency, share) < met.at_rest <= at_rest_after(ratio, frequency, share)


def put_in(stiffness, mass, speed, miss, closing, damping=0.0):
    """What a latch puts in that closes around a mass with a speed along the axis and a miss across it [J]."""

    def rates(t, y):
        x = min(t / closing, 1.0)
        share, growth = x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x) / closing
        force = [-share * (stiffness * y[k] + damping * y[k + 2]) / mass for k in (0, 1)]
        return [y[2], y[3], *force, 0.5 * growth * stiffness * (y[0] ** 2 + y[1] ** 2)]

    solved = solve_ivp(rates, (0.0, closing), [0.0, miss, speed, 0.0, 0.0], **TIGHT)
    return solved.y[4, -1]


@pytest.mark.parametrize("soft", [1e-4, 1.0, 30.0])
@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_a_pull_puts_in_at_most_its_share_and_all_of_it_where_the_latch_is_soft(soft, damping):
    mass, speed, miss, closing, share = 10.0, 0.08, 0.006, 0.1, 0.05
    stiffness = soft * pull_stiffness(mass, speed, miss, closing, share)
    added = put_in(stiffness, mass, speed, miss, closing, damping * math.sqrt(stiffness * mass))
    allowed = soft * share * 0.5 * mass * speed**2
    assert added <= allowed
    if soft < 1e-3:
        assert added == pytest.approx(allowed, rel=1e-3)


def test_a_turn_puts_in_its_share_unless_the_angle_is_small():
    stiffness, rule = turn_stiffness(10.0, 0.08, 0.05, 0.05)
    assert 0.5 * stiffness * 0.05**2 == pytest.approx(0.05 * 0.5 * 10.0 * 0.08**2, rel=1e-14) and "5 %" in rule
    assert turn_stiffness(10.0, 0.08, 0.0, 0.05)[0] == pytest.approx(20.0, rel=1e-14)


def test_the_turn_s_inertia_is_that_of_two_pinned_bodies():
    """Of all motions with 1 rad/s between the bodies and no momentum it is twice the energy: the least there is."""
    design = jb.table2()
    mass = np.array(
        [
            float(design.active.mass + design.buffer.cylinder_mass + design.probe.rod_mass + design.probe.tip_mass),
            float(design.passive.mass),
        ]
    )
    a = float(design.active.hinge_offset) + hinge_to_tip(design)
    b = float(design.cone.offset) + float(design.probe.tip_radius) * math.sin(float(design.cone.half_angle))
    inertia = np.array([float(design.active.inertia), float(design.passive.inertia)])
    # y and θ of each: the tip at y₁ + a θ₁ is the seat at y₂ - b θ₂, and θ₁ - θ₂ = 1.
    energy = np.diag([mass[0], inertia[0], mass[1], inertia[1]])
    conditions = np.array([[1.0, a, -1.0, b], [0.0, 1.0, 0.0, -1.0]])
    system = np.block([[energy, conditions.T], [conditions, np.zeros((2, 2))]])
    rates = np.linalg.solve(system, [0.0] * 4 + [0.0, 1.0])[:4]
    assert turn_inertia(design) == pytest.approx(rates @ energy @ rates, rel=1e-12)


def free(speed=0.1, **given):
    return jb.Scenario(start="free", approach_speed=speed, **given)


def test_what_meets_is_the_worst_of_the_scenarios():
    design = jb.replace(jb.table2(), {"cone.throat_radius": 0.0165})
    room = 0.0165 - 0.015 * math.cos(math.pi / 4)
    assert play(design) == pytest.approx(room, rel=1e-12)
    met = encounter(design, [free(0.05, offset=0.002), free(0.15, offset=-0.003)])
    assert (met.slowest, met.fastest) == (0.05, 0.15)
    assert met.miss == pytest.approx(0.003, rel=1e-6) and met.angle == pytest.approx(0.0, abs=1e-6)
    # Farther off it slides down the flank, which turns the probe.
    wide = encounter(design, [free(offset=0.02, active_angle=0.01)])
    assert wide.miss == pytest.approx(room, rel=1e-12)
    assert wide.angle == pytest.approx(0.01 + math.asin((0.02 - room) / hinge_to_tip(design)), rel=1e-9)
    with pytest.raises(jb.InputError, match="scenarios is empty"):
        encounter(design, [])


def test_similar_dockings_are_sized_alike():
    """Twice the speed: four times the stiffness, twice the damping, half the closing time."""
    slow, fast = (jb.size_buffer(jb.table2(), [free(v, offset=0.01)]).design for v in (0.05, 0.1))
    slow, fast = (jb.size_latch(d, [free(v, offset=0.01)]).design for d, v in ((slow, 0.05), (fast, 0.1)))
    expected = {"buffer.k_A": 4.0, "buffer.c_A": 2.0, "buffer.stop_stiffness": 4.0, "buffer.max_stroke": 1.0}
    expected |= {"latch.stiffness": 4.0, "latch.damping": 2.0, "latch.turn_stiffness": 4.0, "latch.turn_damping": 2.0}
    ratio = {path: float(jb.get(fast, path)) / float(jb.get(slow, path)) for path in expected}
    assert ratio == pytest.approx(expected, rel=1e-6)
    assert float(slow.latch.closing_time) == closing_time(0.015, 0.05) == pytest.approx(0.16, rel=1e-12)


def test_wishes_soften_and_damp():
    design, meetings = jb.size_buffer(jb.table2(), [free(0.08, offset=0.01), free(0.15, offset=0.01)]).design, None
    meetings = [free(0.08, offset=0.01), free(0.15, offset=0.01)]
    usual = jb.size_latch(design, meetings)
    small = jb.size_latch(design, meetings, latch_energy_share="5 %")
    assert float(small.design.latch.stiffness) == pytest.approx(0.5 * float(usual.design.latch.stiffness), rel=1e-12)
    assert usual.estimates["latch_energy_share"].value == pytest.approx(0.1, rel=1e-12)
    weak = jb.size_latch(design, meetings, peak_latch_force="1.5 N")
    assert weak.estimates["peak_latch_force"].value == pytest.approx(0.9 * 1.5, rel=1e-9)
    time = usual.estimates["settling_time"].value
    quick = jb.size_latch(design, meetings, settling_time=0.8 * time)
    assert quick.estimates["settling_time"].value <= 0.8 * time and not quick.remarks
    late = jb.size_latch(design, meetings, settling_time=0.1 * time)
    assert "latch_energy_share keeps the latch soft" in late.remarks[0] and "rest of the vehicles" in repr(late)


def test_the_stop_takes_what_a_faster_approach_has_left():
    sized = jb.size_buffer(jb.table2(), [free(0.15)], stroke="2 cm", overspeed=2.0)
    buffer, mass = sized.design.buffer, encounter(jb.table2(), [free(0.15)]).mass
    room = 0.01
    stored = 0.5 * float(buffer.k_A) * (0.02 + room) ** 2 + 0.5 * float(buffer.stop_stiffness) * room**2
    assert stored == pytest.approx(0.5 * mass * 0.3**2, rel=1e-12)
    assert sized.estimates["stroke"].value == pytest.approx(0.02, rel=1e-12)


@pytest.mark.parametrize(
    ("wishes", "said"),
    [
        ({"stroke": "20 cm"}, "buffer.free_length"),
        ({"stroke": "2 s"}, "size.stroke"),
        ({"strok": 0.02}, "strok is unknown"),
        ({"overspeed": 0.5}, "size.overspeed"),
    ],
)
def test_bad_wishes_are_named(wishes, said):
    with pytest.raises(jb.InputError, match=said):
        jb.size_buffer(jb.table2(), [free()], **wishes)


def test_a_measured_curve_is_not_sized():
    design = jb.replace(jb.table2(), {"buffer.spring_curve": [[0.01, 4.0], [0.02, 9.0]]})
    for sizing in (jb.size_buffer, jb.size_latch):
        with pytest.raises(jb.InputError, match="leave the curve out"):
            sizing(design, [free()])
    with pytest.raises(jb.InputError, match="nothing that sizes"):
        jb.size(jb.BarDrop(), [jb.BarDropScenario()])
