"""Whole fits where sensors are not known: a gain, and noise that several tests are left to tell."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

import jaxbuffer as jb

FOLDER = Path(__file__).with_name("measured")
BOUNDS = {
    "buffer.k_A": (100.0, 3000.0),
    "buffer.c_A": (1.0, 60.0),
    "buffer.k_T": (50.0, 2000.0),
    "buffer.c_T": (0.5, 40.0),
    "buffer.friction": (0.01, 2.0),
}
START = jb.replace(jb.table2(), dict(zip(BOUNDS, (700.0, 10.0, 300.0, 4.0, 0.3), strict=True)))
STROKE, ACTIVE, PASSIVE = "stroke [mm]", "active acceleration [m/s2]", "passive acceleration [m/s2]"
NOISE = {"stroke": 2e-5, "active_acceleration_x": 0.05, "passive_acceleration_x": 0.05}


def check(fit, truth):
    """Four of five true numbers lie in their intervals, and each is near."""
    numbers = list(fit.parameters.values())
    assert fit.converged
    assert sum(it.low <= true <= it.high for it, true in zip(numbers, truth, strict=True)) >= 4
    assert [it.value for it in numbers] == pytest.approx(truth, rel=0.01)


@pytest.mark.slow
def test_a_gain_is_found_beside_the_numbers_behind_a_measured_test(tmp_path):
    # The independent program's record, as a sensor that shows 4.3 % too much would have made it.
    gain, told = 1.043, json.loads((FOLDER / "test-00.json").read_text())
    head, *rows = (FOLDER / "test-00.csv").read_text().splitlines()
    cells = [row.split(",") for row in rows]
    file = tmp_path / "gain.csv"
    file.write_text("\n".join([head, *(f"{t},{s},{gain * float(a):.7g},{p}" for t, s, a, p in cells)]))
    channels = {
        STROKE: jb.Channel("stroke", noise="0.02 mm"),
        ACTIVE: jb.Channel("active_acceleration_x", noise=gain * told["noise"]["active"], gain=(0.9, 1.1)),
        PASSIVE: jb.Channel("passive_acceleration_x", noise=told["noise"]["passive"]),
    }
    scenario = jb.Scenario(**{key: told["known"][key] for key in ("approach_speed", "misalignment")})
    test = jb.read_recording(file, channels, scenario=scenario, units=jb.recorded_quantities(START))
    fit = jb.fit(START, None, test, BOUNDS)
    check(fit, [told["truth"][key] for key in ("k_A", "c_A", "k_T", "c_T", "buffer_friction")])
    found = fit.nuisance["gain.csv"][f"{ACTIVE}: gain"]
    # Two and a half deviations at most; a gain that is not looked for would be five away.
    assert abs(found.value - gain) < 2.5 * (found.high - found.low) / 3.92 < 0.5 * (gain - 1.0)
    rows = re.findall(r"(\S+) +(\S+) to (\S+)", repr(fit))
    assert len(rows) == 6 and all(len({len(it.partition(".")[2]) for it in row}) == 1 for row in rows)


@pytest.mark.long
def test_two_tests_at_once_tell_the_numbers_and_the_noise_that_was_left_out():
    truth, random = [520.0, 7.3, 410.0, 3.1, 0.24], np.random.default_rng(0)
    design = jb.replace(START, dict(zip(BOUNDS, truth, strict=True)))
    times, tests = np.arange(0.0, 0.12, 2e-4), []
    for name, speed, misalignment in (("slow", 0.09, 0.008), ("quick", 0.15, -0.011)):
        scenario = jb.Scenario(approach_speed=speed, misalignment=misalignment)
        seen = jb.simulate(design, scenario, 0.13, times=times, rtol=1e-10, atol=1e-10).history
        values = {
            "stroke": seen.stroke,
            "active_acceleration_x": seen.acceleration[:, 0, 0],
            "passive_acceleration_x": seen.acceleration[:, -1, 0],
        }
        noisy = {it: np.asarray(values[it]) + NOISE[it] * random.normal(size=len(times)) for it in NOISE}
        tests.append(jb.Recording(name, times, noisy, {it: jb.Channel(it) for it in NOISE}, scenario))
    fit = jb.fit(START, None, tests, BOUNDS)
    check(fit, truth)
    for noise in fit.noise.values():
        # Three deviations of an estimate from 600 rows.
        assert noise == pytest.approx(NOISE, rel=3.0 / np.sqrt(2.0 * len(times)))
