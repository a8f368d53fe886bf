"""The slider-crank with clearance: Exudyn's peaks at step zero against the reference's.

Exudyn samples the approach speed where a step ends, so that its peaks scatter with the step. They are extrapolated by a
straight line through ten steps; the standard error of the line is Exudyn's own error, and what a deviation is held to.
"""

import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("exudyn", reason="exudyn is not installed: pip install 'jaxbuffer[verify]'")

from benchmarks.peers.slider_crank import SliderCrank, plain
from verification.second_opinion.slider_crank import extrapolate

FILE = Path(__file__).parent.parent / "mechanisms" / "slider_crank_reference.json"
REFERENCE = json.loads(FILE.read_text())
NUMBERS = {design["name"]: design["numbers"] for design in REFERENCE["designs"]}
STEPS = np.geomspace(3e-8, 1e-7, 10)  # s
ERRORS = 4.0  # standard errors that a peak may be off; 1 in 400 by chance, were the scatter a normal one
TOPIC, SOURCE = "Slider-crank with clearance", "Exudyn, extrapolated to step zero"


def ours(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Peak forces [N] and joints of the first impacts: the independent program's."""
    record = next(design for design in REFERENCE["designs"] if design["name"] == name)
    if name == "reference":
        return np.array(REFERENCE["growth"]["peaks"][:6]), np.ones(6, int)
    impacts = record["impacts"]
    return np.array([each["peak_force"] for each in impacts]), np.array([each["contact"] for each in impacts])


def compare(evidence, name, numbers, peaks, joints, steps, duration, accurate):
    """All of Exudyn's peaks within its error of ``peaks``; the first one's error at most ``accurate``."""
    found = extrapolate(numbers, steps, duration, len(peaks))
    np.testing.assert_array_equal(found.joint, joints)
    off = np.abs(found.peak_force / peaks - 1.0)
    error = found.error / peaks
    assert error[0] < accurate
    assert np.all(error < 2e-3)
    told = ", ".join(f"{a:.1e} (±{b:.1e})" for a, b in zip(off, error, strict=True))
    claim = f"first {len(peaks)} peaks, {name}: deviation over Exudyn's standard error"
    evidence(TOPIC, claim, float(np.max(off / error)), ERRORS, SOURCE, detail=told)


@pytest.mark.parametrize(
    ("name", "duration", "coarser"),
    [
        pytest.param("reference", 1.62e-3, 1.0, marks=pytest.mark.slow),
        pytest.param("crank pin", 1.4e-3, 1.0, marks=pytest.mark.slow),
        ("both pins", 0.49e-3, 1.0),
        pytest.param("torque driven", 2.65e-3, 2.0, marks=pytest.mark.slow),
    ],
)
def test_peaks_without_friction(evidence, name, duration, coarser):
    compare(evidence, name, NUMBERS[name], *ours(name), coarser * STEPS, duration, 1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "duration"), [("rubbing under gravity", 1.9e-3), ("crank pin rubbing", 1.75e-3)])
def test_peaks_with_friction(evidence, name, duration):
    """Exudyn's friction is linear in the slip up to the slip speed, and acts midway between the two surfaces: with both
    taken over, peaks agree as closely as without friction."""
    numbers = NUMBERS[name] | {"ramp": 1.0, "overlap_share": 0.5}
    impacts = plain.simulate(SliderCrank(**numbers), duration)[:4]
    peaks, joints = np.array([i.peak_force for i in impacts]), np.array([i.joint for i in impacts])
    compare(evidence, name, numbers, peaks, joints, 2.0 * STEPS, duration, 1e-5)
