"""What a whole capture must conserve: the energy balance, momenta, and the joints."""

import numpy as np
import pytest

from in_short import quick
from jaxbuffer import Scenario, replace, simulate, table2
from verification.designs import random_case

CAPTURES = {"table 2": (table2(), Scenario())} | {f"random {seed}": random_case(seed) for seed in range(1, 6)}
FREE = (replace(table2(), {"probe.free_tip": True}), Scenario())
TOPIC, SOURCE = "Conservation over whole captures", "the start of the same capture"
each_capture = pytest.mark.parametrize("name", quick(CAPTURES, "table 2", "random 1", "random 2"))


def assert_conserved(evidence, capture, energy):
    """Worst measured at the default: momentum 2e-15 linear and 1e-10 angular, drift 4e-10 m."""
    assert not capture.outcome.failed
    assert int(capture.impact_count) > 1
    assert float(capture.energy.dissipated) > 1e-2 * float(capture.energy.total)
    balance = capture.balance
    when = ", default settings" if energy == 1e-6 else ", rtol 1e-9"
    evidence(TOPIC, f"energy over a capture{when}", abs(float(balance.energy)), energy, SOURCE)
    evidence(TOPIC, f"linear momentum over m_S v0{when}", balance.linear_momentum, 1e-10, SOURCE)
    evidence(TOPIC, f"angular momentum over m_S v0 · 1 m{when}", balance.angular_momentum, 1e-7, SOURCE)
    evidence(TOPIC, f"constraint drift{when}", balance.drift, 1e-8, SOURCE, "m")


@pytest.mark.quick
@each_capture
def test_default_settings_conserve(name, evidence):
    assert_conserved(evidence, simulate(*CAPTURES[name]), 1e-6)


@each_capture
def test_a_tighter_tolerance_conserves_better(name, evidence):
    assert_conserved(evidence, simulate(*CAPTURES[name], rtol=1e-9), 1e-7)


@pytest.mark.slow
def test_a_free_tip_conserves(evidence):
    assert_conserved(evidence, simulate(*FREE), 1e-6)


@pytest.mark.parametrize(("free_tip", "count"), [(False, 120), (True, 50)])
def test_no_design_is_an_exception(evidence, free_tip, count):
    """Those that escape or hardly touch too: the worst measured 5e-7, with a free tip 8e-7."""
    worst = 0.0
    for seed in range(count):
        design, scenario = random_case(seed)
        capture = simulate(replace(design, {"probe.free_tip": free_tip}), scenario)
        assert not capture.outcome.failed
        worst = max(worst, abs(float(capture.balance.energy)))
    tip = "free" if free_tip else "welded"
    evidence(TOPIC, f"energy, worst of {count} random designs, {tip} tip, default settings", worst, 1e-6, SOURCE)


@pytest.mark.slow
def test_no_tolerance_is_an_exception_either():
    """Where a tip begins to roll within an explicit step, the estimate of its error may miss that: of a thousand such
    captures six lost up to 13 times the tolerance before steps had to keep the energy. Worst measured: 0.6 times."""
    for seed in range(50):
        design, scenario = random_case(seed, free_tip=True)
        for rtol in np.geomspace(0.8e-6, 1.25e-6, 6):
            capture = simulate(design, scenario, rtol=rtol)
            assert abs(float(capture.balance.energy)) < rtol


@each_capture
def test_energy_starts_from_the_kinetic_energy_of_the_approach(name):
    """½ (m_S + m_B + m_P) v0² + ½ I_T θ̇_T0², by hand."""
    design, scenario = CAPTURES[name]
    capture = simulate(design, scenario)
    moving = design.active.mass + design.buffer.cylinder_mass + design.probe.rod_mass + design.probe.tip_mass
    start = 0.5 * moving * scenario.approach_speed**2 + 0.5 * design.passive.inertia * scenario.passive_rate**2
    np.testing.assert_allclose(capture.energy.total, start, rtol=1e-6)


@each_capture
def test_every_loss_is_a_loss(name):
    energy = simulate(*CAPTURES[name]).energy
    losses = [energy.axial_damper, energy.torsional_damper, energy.hysteresis, energy.friction]
    assert min(map(float, losses)) > 0.0
    assert float(energy.kinetic) > 0.0
    assert float(energy.spring) >= 0.0
