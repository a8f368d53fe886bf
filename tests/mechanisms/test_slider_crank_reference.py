"""The slider-crank's reference file against a second program of other coordinates, and against published numbers."""

import json
from pathlib import Path

import numpy as np
import pytest

from benchmarks.peers.slider_crank import SliderCrank, plain

RECORD = json.loads(Path(__file__).with_name("slider_crank_reference.json").read_text())
DESIGNS = {design["name"]: design for design in RECORD["designs"]}
TOPIC = "Slider-crank with clearance"
SECOND = "SciPy in absolute coordinates, rtol 1e-13"
# Best case A of the design notes: touchdown [ms], approach [m/s], peak [N], duration [µs], separation [m/s].
PUBLISHED = [
    (0.227286, 4.385783, 45872.27, 53.437, -3.911493),
    (0.637056, 2.756949, 20869.93, 53.834, -1.764880),
    (0.749700, 1.826699, 25926.15, 65.450, -2.133988),
    (1.085947, 1.101851, 6557.87, 60.758, -0.723053),
]
LATER_PEAKS = (12915.66, 1672.21, 4943.07)
OTHERS = {  # first two impacts: touchdown [ms], approach [m/s], peak [N]
    "slow": [(5.6821508, 0.175431, 891.0127), (15.1840399, 0.120155, 452.509)],
    "rubbing": [(0.227286032, 4.38578, 45825.64), (0.573371505, 2.2674, 14373.28)],
    "lossy": [(0.227286032, 4.38578, 43194.29), (0.564244239, 2.58106, 21712.35)],
}


@pytest.mark.quick
def test_published_table():
    impacts = DESIGNS["reference"]["impacts"]
    for found, (time, approach, peak, duration, separation) in zip(impacts, PUBLISHED, strict=True):
        assert 1e3 * found["time"] == pytest.approx(time, abs=6e-7)
        assert found["approach_speed"] == pytest.approx(approach, abs=6e-7)
        assert found["peak_force"] == pytest.approx(peak, abs=6e-3)
        assert 1e6 * (found["release_time"] - found["time"]) == pytest.approx(duration, abs=6e-4)
        assert found["separation"] == pytest.approx(separation, abs=6e-7)
    np.testing.assert_allclose(RECORD["growth"]["peaks"][4:7], LATER_PEAKS, rtol=0, atol=6e-3)
    assert len(RECORD["growth"]["peaks"]) == 28


@pytest.mark.parametrize("name", OTHERS)
def test_other_published_numbers(name):
    for found, (time, approach, peak) in zip(DESIGNS[name]["impacts"], OTHERS[name], strict=False):
        assert 1e3 * found["time"] == pytest.approx(time, rel=4e-9)
        assert found["approach_speed"] == pytest.approx(approach, abs=6e-6)
        assert found["peak_force"] == pytest.approx(peak, abs=6e-3)


def test_elasticities_that_are_known():
    """Before the first touchdown time scales with speed, and nothing depends on the contact or the slider's mass."""
    found = {name: values["first_time"] for name, values in RECORD["elasticities"].items()}
    assert found["speed"]["value"] == pytest.approx(-1.0, abs=1e-12)
    assert all(found[name]["value"] == 0.0 for name in ("slider_mass", "restitution", "stiffness"))


def test_elasticities_of_the_clearance_are_consistent():
    """The whole one is that at given stiffness and what the stiffness does: d ln K/d ln c = -R_B/(2 (R_B - c))."""
    found = RECORD["elasticities"]
    for name in ("first_peak", "second_peak", "third_peak"):
        whole, alone, stiff = (found[by][name]["value"] for by in ("clearance", "clearance alone", "stiffness"))
        assert whole == pytest.approx(alone - stiff * 0.01 / (2 * (0.01 - 5e-4)), abs=2e-8)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in DESIGNS if not name.startswith("slow")])
def test_a_second_program(evidence, name):
    """Multipliers instead of minimal coordinates, SciPy's events instead of steps on to them."""
    expected = DESIGNS[name]["impacts"]
    until = max(each["peak_time"] if each["peak_time"] < 5e-3 else each["time"] for each in expected) + 2e-5
    found = plain.simulate(SliderCrank(**DESIGNS[name]["numbers"]), until)
    off = {"touchdown": 0.0, "approach speed": 0.0, "peak force": 0.0}
    for one, other in zip(found, expected, strict=True):
        assert one.joint == other["contact"]
        off["touchdown"] = max(off["touchdown"], abs(one.time / other["time"] - 1.0))
        off["approach speed"] = max(off["approach speed"], abs(one.approach_speed / other["approach_speed"] - 1.0))
        if other["peak_time"] < until:
            off["peak force"] = max(off["peak force"], abs(one.peak_force / other["peak_force"] - 1.0))
    for quantity, tolerance in (("touchdown", 1e-9), ("approach speed", 1e-8), ("peak force", 1e-8)):
        claim = f"reference file, {quantity} of the first four impacts"
        evidence(TOPIC, claim, off[quantity], tolerance, SECOND, detail=name)
