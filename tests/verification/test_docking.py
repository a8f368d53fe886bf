"""All reference runs of docking, at default settings and at a tight tolerance, and their elasticities."""

from functools import cache

import numpy as np
import pytest

from jaxbuffer import sensitivity, simulate
from jaxbuffer.run.request import DEFAULT_TOLERANCE
from verification.docking_cases import DIFFERENTIATED, DOCKING, QUANTITIES, path_of

pytestmark = pytest.mark.slow

TIGHT = 1e-9
AGREED = {DEFAULT_TOLERANCE: 1e-4, TIGHT: 1e-6}
AGREED_ENERGY = 1e-3  # of what is left of the energy of relative motion
BALANCED = {DEFAULT_TOLERANCE: 2e-6, TIGHT: 3e-9}  # of the energy at the start
TOPIC, SOURCE = "Docking until held", "runs of an independent solver at rtol 1e-10"

# Each case is a program of its own, 20 to 50 s of compiling: CI has a free start and most of a buffer's parts,
# `make test-long` the others.
TELLING = ("free start above, all rates", "real buffer")
CASES = [name if name in TELLING else pytest.param(name, marks=pytest.mark.long) for name in DOCKING]
each_case = pytest.mark.parametrize("name", CASES)
each_tolerance = pytest.mark.parametrize("rtol", AGREED, ids=["default", "tight"])


@cache
def run(name, rtol):
    case = DOCKING[name]
    return simulate(case.design, case.scenario, case.duration, rtol=rtol)


def at(rtol):
    return "default settings" if rtol == DEFAULT_TOLERANCE else f"rtol {rtol:g}"


@each_tolerance
@each_case
def test_outcome_and_impacts(name, rtol):
    values = DOCKING[name].values
    assert run(name, rtol).outcome.name == values["outcome"]
    assert int(run(name, rtol).impact_count) == values["impacts"]


@each_tolerance
@each_case
@pytest.mark.parametrize("quantity", QUANTITIES)
def test_quantities(name, quantity, rtol, evidence):
    agreed = AGREED_ENERGY if quantity == "relative_energy" else AGREED[rtol]
    claim = f"{quantity.replace('_', ' ')}, {at(rtol)}"
    evidence(TOPIC, claim, DOCKING[name].deviation(run(name, rtol), quantity), agreed, SOURCE, detail=name)


@each_tolerance
@each_case
def test_peak_time_and_force_on_the_passive_vehicle(name, rtol):
    values, found = DOCKING[name].values, run(name, rtol)
    np.testing.assert_allclose(found.peak_time, values["peak_time"], rtol=AGREED[rtol], atol=1e-7)
    np.testing.assert_allclose(found.passive_force, values["passive_force"], rtol=AGREED[rtol])


@each_tolerance
@each_case
def test_energy_and_momentum(name, rtol, evidence):
    balance = run(name, rtol).balance
    start = "the start of the same run"
    evidence(TOPIC, f"energy, {at(rtol)}", abs(float(balance.energy)), BALANCED[rtol], start, detail=name)
    evidence(TOPIC, f"linear momentum over m_S v0, {at(rtol)}", balance.linear_momentum, 1e-10, start, detail=name)
    evidence(TOPIC, f"angular momentum, {at(rtol)}", balance.angular_momentum, 1e-6, start, detail=name)


@pytest.mark.long
@each_case
def test_elasticities(name, evidence):
    """Peak force, stroke and latch force by buffer, tip and latch: 1e-3 of each, or 1e-6, or the reference's error."""
    case = DOCKING[name]
    reference = np.array(list(case.values["elasticity"].values()))  # (parameters, values and errors, quantities)
    paths = [path_of(parameter) for parameter in case.values["elasticity"]]
    found = sensitivity(
        case.design, case.scenario, paths, case.duration, quantities=DIFFERENTIATED, rtol=TIGHT, certify="none"
    )
    # A quantity that is zero has no elasticity; the reference writes zero.
    ours = np.where(found.results[:, None] < 1e-12, 0.0, found.elasticities).T
    allowed = np.maximum(np.maximum(1e-3 * np.abs(reference[:, 0]), 1e-6), reference[:, 1])
    worst = np.max(np.abs(ours - reference[:, 0]) / allowed)
    claim = "elasticities over what is agreed (1e-3 of each, 1e-6 or the reference's error)"
    evidence(TOPIC, claim, worst, 1.0, "differences of an independent solver", detail=name)
