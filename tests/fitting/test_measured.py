"""Three tests made by an independent program: the numbers that they were made with are found, in honest intervals."""

import json
from pathlib import Path

import pytest

import jaxbuffer as jb

FOLDER = Path(__file__).with_name("measured")
PATHS = {
    "k_A": ("buffer.k_A", (100.0, 3000.0)),
    "c_A": ("buffer.c_A", (1.0, 60.0)),
    "k_T": ("buffer.k_T", (50.0, 2000.0)),
    "c_T": ("buffer.c_T", (0.5, 40.0)),
    "buffer_friction": ("buffer.friction", (0.01, 2.0)),
}
SOURCE = "tests/fitting/measured, an independent program"
STROKE, ACTIVE, PASSIVE = "stroke [mm]", "active acceleration [m/s2]", "passive acceleration [m/s2]"


def fitted(name):
    told = json.loads((FOLDER / f"{name}.json").read_text())
    design = jb.replace(jb.table2(), {path: told["start"][key] for key, (path, _) in PATHS.items()})
    known = told["known"]
    scenario = jb.Scenario(approach_speed=known["approach_speed"], misalignment=known["misalignment"])
    lag = ("0 s", "0.5 ms") if told["kind"] == "filter" else 0.0
    channels = {
        STROKE: jb.Channel("stroke", noise=f"{told['noise']['stroke']} m"),
        ACTIVE: jb.Channel("active_acceleration_x", noise=told["noise"]["active"], filter=lag),
        PASSIVE: jb.Channel("passive_acceleration_x", noise=told["noise"]["passive"], filter=lag),
    }
    shift = ("0 ms", "30 ms") if told["kind"] == "late trigger" else 0.0
    units = jb.recorded_quantities(design)
    test = jb.read_recording(FOLDER / f"{name}.csv", channels, scenario=scenario, time_shift=shift, units=units)
    return told, jb.fit(design, None, test, dict(PATHS.values()))


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("test-00", marks=pytest.mark.slow),
        pytest.param("test-01", marks=pytest.mark.long),
        pytest.param("test-03", marks=pytest.mark.long),
    ],
)
def test_the_numbers_behind_a_measured_test_are_found_in_their_intervals(name, evidence):
    told, fit = fitted(name)
    assert fit.converged and all(0.95 < figure < 1.05 for figure in fit.residual[f"{name}.csv"].values())
    inside, worst = 0, 0.0
    for key, (path, _) in PATHS.items():
        it, truth, bound = fit.parameters[path], told["truth"][key], told["cramer_rao_percent"][key]
        inside += it.low <= truth <= it.high
        error = 100.0 * abs(it.value / truth - 1.0)
        worst = max(worst, error / max(1.0, 4.0 * bound))
        # Neither narrower than noise allows, nor wide for safety; a shift or a delay that is unknown costs some.
        assert 0.85 * bound < 100.0 * (it.high - it.low) / (2.0 * 1.96) / truth < 1.35 * bound
    assert inside >= 4
    evidence("fit to a test", f"{name}: numbers outside their 95 % intervals, of five", 5 - inside, 1.0, SOURCE)
    claim = f"{name}: error of the worst number over 1 % or four Cramér-Rao deviations"
    evidence("fit to a test", claim, worst, 1.0, SOURCE)
