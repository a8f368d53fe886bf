"""The smooth memory (M61) of a bar drop and a slider-crank against runs whose touchdowns set the memory."""

import numpy as np
import pytest

import jaxbuffer as jb

TOPIC, EVENTS = "Regularisation and stabilisation", "touchdowns located, rtol 1e-9"


def off(run, exact, impacts):
    """The largest relative difference of the first ``impacts``' peak forces."""
    return float(np.max(np.abs(run.impacts.peak_force[:impacts] / exact.impacts.peak_force[:impacts] - 1.0)))


def dropped(**changes):
    """0.22 s of a bar with Lankarani and Nikravesh's law."""
    design = jb.replace(
        jb.BarDrop(),
        {"impact.law": "lankarani-nikravesh", "impact.exponent": 1.5, "impact.stiffness": 1e10, **changes},
    )
    return jb.simulate(design, jb.BarDropScenario(height=0.1), 0.22, rtol=1e-9)


def test_a_bar_drop_in_the_loop(evidence):
    """The bias falls with the memory time."""
    exact = dropped()
    usual, short = (off(dropped(**{"impact.memory_time": time}), exact, 1) for time in (2e-4, 4e-5))
    evidence(TOPIC, "smooth memory of a bar drop: peak force", usual, 2e-4, EVENTS)
    assert short < 0.5 * usual


def test_a_slider_crank_in_the_loop(evidence):
    """The first three impacts of the piston's pin; the bias falls as the memory time."""
    exact = jb.simulate(jb.SliderCrank(), duration=1e-3, rtol=1e-9)
    assert int(exact.impact_count) >= 3

    def bias(time):
        design = jb.replace(jb.SliderCrank(), {"piston_pin.memory_time": time})
        return off(jb.simulate(design, duration=1e-3, rtol=1e-9), exact, 3)

    long, usual = bias(5e-6), bias(1e-6)
    evidence(TOPIC, "smooth memory of a slider-crank: first three peaks", usual, 4e-3, EVENTS)
    assert long / usual == pytest.approx(5.0, rel=0.2)


@pytest.mark.quick
def test_a_bar_drops_force_that_jumps_has_no_smooth_law():
    with pytest.raises(jb.InputError, match=r"impact\.law = 'kelvin-voigt': its force jumps at touchdown"):
        jb.as_diffrax(jb.replace(jb.BarDrop(), {"impact.law": "kelvin-voigt", "impact.exponent": 1.5}))
