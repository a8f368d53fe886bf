"""Whole dockings in space against an independent program in minimal coordinates."""

import math

import numpy as np
import pytest

import jaxbuffer as jb
from docking3d.reference import CASES, QUANTITIES, path_of
from verification.docking_cases import DIFFERENTIATED

# One structure each is compiled, in half a minute or more: a capture, one until held, a free start, a free tip.
SLOW = (
    "table2, another azimuth",
    "two planes",
    "latched, two planes",
    "free start, all rates",
    "free tip, target rolls",
)
OF_LATCHES = ("latch_force", "latch_time")  # the reference has the capture's time where there is no latch

TIGHT = 1e-9

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    "name", [name if name in SLOW else pytest.param(name, marks=pytest.mark.long) for name in CASES]
)
def test_it_is_the_independent_programs(name):
    case = CASES[name]
    run, reference = jb.simulate(case.design, case.scenario, case.duration), case.values
    assert run.outcome.name == reference["outcome"]
    assert int(run.impact_count) == reference["impacts"]
    assert abs(float(run.balance.energy)) < 1e-6
    assert abs(float(run.balance.linear_momentum)) < 1e-10
    assert abs(float(run.balance.angular_momentum)) < 1e-7
    for quantity, named in QUANTITIES.items():
        if named not in reference or (named in OF_LATCHES and not case.design.latch.has("stiffness")):
            continue
        value, allowed = float(run.quantity(quantity)), 1e-12
        if quantity == "relative_energy":
            allowed = 1e-6  # shares of the first energy, which itself is kept to this
            if run.outcome.name == "torn":  # the reference counts nothing in latches that have torn
                value *= 1.0 - float(run.energy.stored["latch"]) / float(run.docking.energy_left)
        assert math.isfinite(value), quantity
        # A held run ends where the energy left, which falls slowly, is a thousandth.
        rel = 1e-4 if quantity == "end_time" and reference["outcome"] == "held" else 1e-5
        assert value == pytest.approx(reference[named], rel=rel, abs=allowed), quantity


@pytest.mark.long
@pytest.mark.parametrize("name", [name for name in CASES if "elasticity" in CASES[name].values])
def test_elasticities_are_the_independent_programs(name):
    """Peak force, stroke and latch force: 1e-3 of each, or 1e-6, or the reference's own error."""
    case = CASES[name]
    reference = np.array(list(case.values["elasticity"].values()))  # (parameters, values and errors, quantities)
    paths = [path_of(parameter) for parameter in case.values["elasticity"]]
    found = jb.sensitivity(
        case.design, case.scenario, paths, case.duration, quantities=DIFFERENTIATED, rtol=TIGHT, certify="none"
    )
    # A quantity that is zero has no elasticity; the reference writes zero.
    ours = np.where(found.results[:, None] < 1e-12, 0.0, found.elasticities).T
    allowed = np.maximum(np.maximum(1e-3 * np.abs(reference[:, 0]), 1e-6), reference[:, 1])
    assert np.max(np.abs(ours - reference[:, 0]) / allowed) < 1.0
