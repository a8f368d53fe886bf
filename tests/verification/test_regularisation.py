"""What the numbers that no engineer chooses do to Table 2's results: the slip speed of friction, the stabilisation.

All solves are tight (rtol 1e-10), so that what differs is the model's.
"""

from functools import cache

import pytest

import jaxbuffer as jb

TOPIC = "Regularisation and stabilisation"
COULOMB = "Table 2 at a slip speed of 1e-5 m/s, indistinguishable from Coulomb's law"
BIASED = {"peak_force": 1e-5, "stroke": 1e-4, "end_time": 1e-3, "hinge_angle": 1e-3}
METRICS = (*BIASED, "peak_hinge_force", "peak_buffer_force")


@cache
def capture(slip_speed=1e-3, stabilisation=20.0):
    design = jb.replace(jb.table2(), {"contact.slip_speed": slip_speed})
    return jb.simulate(design, rtol=1e-10, stabilisation=stabilisation)


def deviation(quantity, ours, theirs):
    return abs(float(getattr(ours, quantity)) / float(getattr(theirs, quantity)) - 1.0)


@pytest.mark.parametrize("quantity", BIASED)
def test_bias_of_the_default_slip_speed(evidence, quantity):
    bias = deviation(quantity, capture(), capture(1e-5))
    evidence(TOPIC, f"slip speed 1e-3 m/s (default): {quantity}", bias, BIASED[quantity], COULOMB)


@pytest.mark.parametrize("quantity", BIASED)
def test_bias_falls_with_the_slip_speed(evidence, quantity):
    """At least as its first power; where the sticking is short, far faster."""
    coarse, middle, fine = (deviation(quantity, capture(speed), capture(1e-5)) for speed in (2e-3, 5e-4, 1.25e-4))
    told = f"{coarse:.1e}, {middle:.1e}, {fine:.1e} at 2e-3, 5e-4, 1.25e-4 m/s"
    ratio = max(4.0 * middle / coarse, 4.0 * fine / middle)
    evidence(TOPIC, f"bias over slip speed, quartered twice: {quantity}, relative", ratio, 1.15, COULOMB, detail=told)


@pytest.mark.parametrize("gain", [10.0, 40.0])
def test_stabilisation_does_not_show(evidence, gain):
    for quantity in METRICS:
        off = deviation(quantity, capture(stabilisation=gain), capture())
        claim = "stabilisation gain halved or doubled: every metric"
        evidence(TOPIC, claim, off, 1e-9, "Table 2 at the default gain", detail=quantity)
