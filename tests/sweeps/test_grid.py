"""Grids: what may be written for one, which captures it has, and what is refused."""

import numpy as np
import pytest

import jaxbuffer.sweeps.grid
from jaxbuffer import InputError, Scenario, table2
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.study.load import loads
from jaxbuffer.sweeps.axis import typed
from jaxbuffer.sweeps.grid import grid

SPEED, STIFFNESS = "scenario.approach_speed", "buffer.k_A"


def over(asked):
    return grid(asked, table2(), Scenario())


def test_every_combination_the_last_field_changing_fastest():
    found = over({SPEED: [0.1, 0.2], STIFFNESS: {"from": 100, "to": 400, "count": 3, "scale": "log"}})
    assert (found.shape, len(found)) == ((2, 3), 6)
    columns = found.columns()
    np.testing.assert_array_equal(columns[SPEED], [0.1, 0.1, 0.1, 0.2, 0.2, 0.2])
    np.testing.assert_allclose(columns[STIFFNESS], [100, 200, 400] * 2, rtol=1e-15)
    assert found.point(5) == "approach_speed 0.2 m/s, k_A 400 N/m"
    design, scenarios = found.applied(table2(), Scenario(misalignment=0.05))
    np.testing.assert_array_equal(scenarios.approach_speed, columns[SPEED])
    np.testing.assert_array_equal(design.buffer.k_A, columns[STIFFNESS])
    assert scenarios.misalignment == 0.05 and design.buffer.c_A == table2().buffer.c_A


def test_steps_are_even_and_reach_both_ends():
    (axis,) = over({SPEED: {"from": 0.05, "to": 0.3, "count": 6}}).axes
    np.testing.assert_allclose(axis.values, [0.05, 0.1, 0.15, 0.2, 0.25, 0.3], rtol=1e-15)
    assert over({SPEED: 0.2}).axes[0].values.tolist() == [0.2]


def test_toml_and_the_command_line_say_the_same():
    study = loads(
        b"""
        [sweep]
        scenario.approach_speed = {from = 0.05, to = 0.3, count = 20}
        scenario.misalignment = [0, 0.1]
        "buffer.k_A" = {from = 100, to = 2000, count = 4, scale = "log"}
        buffer.c_A = 5
        """,
        "study.toml",
    )
    words = (
        "scenario.approach_speed=0.05:0.3:20",
        "scenario.misalignment=0,0.1",
        "buffer.k_A=100:2000:4:log",
        "buffer.c_A=5",
    )
    assert over(study.sweep) == over(dict(map(typed, words)))
    assert over(study.sweep).shape == (20, 2, 4, 1)


def test_the_default_grid_is_valid():
    assert over(PROBE_CONE.defaults.grid).shape == (11, 11)


@pytest.mark.parametrize(
    ("path", "values", "message"),
    [
        ("scenario.aproach_speed", [0.1], "is unknown; did you mean scenario.approach_speed?"),
        ("approach_speed", [0.1], "approach_speed is unknown; did you mean scenario.approach_speed?"),
        ("buffer", [1.0], "buffer is unknown"),
        ("probe.free_tip", ["yes"], "probe.free_tip = 'yes' must be true or false"),
        ("probe.free_tip", [True, True], "sweep.probe.free_tip names true twice"),
        ("probe.bending_modes", [1.5], "probe.bending_modes = 1.5 must be a whole number of at least"),
        ("contact.law", ["hertzz"], "contact.law = 'hertzz' is unknown; choose one of .*; did you mean hertz"),
        ("contact.law", [], "sweep.contact.law is empty; list its values"),
        ("buffer.damping", {"from": 0, "to": 1, "count": 2}, "is a choice; list its values"),
        (SPEED, [], "sweep.scenario.approach_speed is empty; expected"),
        (SPEED, [0.1, -0.1], r"approach_speed = -0.1 m/s is out of range; allowed: \(0, inf\) m/s"),
        (SPEED, {"from": 0.0, "to": 0.1, "count": 3}, r"approach_speed = 0 m/s is out of range"),
        (SPEED, ["fast"], "'fast' is not a number"),
        (SPEED, [True], "True is not a number"),
        (SPEED, {"from": 0.1, "to": 0.2, "count": 0}, "count = 0 must be a whole number of at least 1"),
        (SPEED, {"from": 0.1, "to": 0.2, "count": 2.5}, "count = 2.5 must be a whole number"),
        (SPEED, {"from": 0.1, "to": 0.2, "count": "many"}, "count = 'many' must be a whole number"),
        (SPEED, {"from": 0.1, "to": 0.2, "count": float("inf")}, "count = inf must be a whole number"),
        (SPEED, {"from": 0.1, "to": 0.2, "count": 1}, "one value cannot reach"),
        (SPEED, {"from": 0.1, "to": 0.2}, "count is missing"),
        (SPEED, {"from": 0.1, "to": 0.2, "cuont": 3}, "cuont is unknown; did you mean count?"),
        (SPEED, {"from": 0.1, "to": 0.2, "count": 3, "scale": "logarithmic"}, "choose one of linear, log"),
        ("scenario.misalignment", {"from": -0.1, "to": 0.1, "count": 3, "scale": "log"}, "needs positive ends"),
    ],
)
def test_bad_axes(path, values, message):
    with pytest.raises(InputError, match=message):
        over({path: values})


@pytest.mark.parametrize("text", ["scenario.approach_speed", "x=", "x=1:2", "x=1:2:3:log:4"])
def test_bad_words(text):
    with pytest.raises(InputError, match=f"--over {text}: expected"):
        typed(text)


def test_a_grid_larger_than_memory_is_refused_before_it_is_made():
    huge = {"from": 0.1, "to": 0.2, "count": 10**9}
    with pytest.raises(InputError, match=r"1000000000 × 1000000000 = 1e\+18 runs, which need .* TiB of memory; .* are"):
        over({SPEED: huge, "scenario.misalignment": {**huge, "to": 0.3}})


def test_how_much_a_capture_counts(monkeypatch):
    monkeypatch.setattr(jaxbuffer.sweeps.grid, "_free_memory", lambda: 100 * jaxbuffer.sweeps.grid.BYTES)
    assert len(over({SPEED: {"from": 0.1, "to": 0.2, "count": 100}})) == 100
    with pytest.raises(InputError, match="101 = 101 runs, which need 197 KiB of memory; 195 KiB are free"):
        over({SPEED: {"from": 0.1, "to": 0.2, "count": 101}})


def test_a_bad_sweep_in_a_study_names_the_file():
    with pytest.raises(InputError, match=r"^study.toml: sweep: buffer.k_B is unknown; did you mean buffer.k_"):
        loads(b"[sweep]\nbuffer.k_B = [1, 2]", "study.toml")
