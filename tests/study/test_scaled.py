"""A study made from masses, speeds, misses and attitude: it loads, is held in every load case, and tunes as it is."""

import math

import numpy as np
import pytest

import jaxbuffer as jb
from in_short import often
from jaxbuffer.cli.entry import run
from jaxbuffer.mechanisms import mechanism_named
from jaxbuffer.study.load import load
from vehicles import KINDS, VEHICLES, written

TURNS = ("active_yaw", "active_pitch", "active_rate_x", "active_rate_y", "active_rate_z")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", VEHICLES)
def test_it_says_its_rules_and_can_be_used(name, kind, tmp_path, capsys):
    file = written(tmp_path, *VEHICLES[name], kind)
    problem = load(str(file)).problem()
    assert len(problem.cases) == 4 and problem.limits.held
    text = file.read_text(encoding="utf-8")
    assert "usually" in text and "μ v²/λ²" in text and "take your own" in text
    assert run(["check", str(file)]) == 0


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", often(VEHICLES, "4 kg", "8 t", "420 t"))
def test_every_load_case_is_held(name, kind, tmp_path):
    study = load(str(written(tmp_path, *VEHICLES[name], kind)))
    problem = study.problem()
    for case in problem.cases:
        docking = jb.simulate(problem.design, case.scenario, duration=problem.duration)
        assert docking.outcome.name == "held"
        assert float(docking.stroke) < problem.limits.at_most["stroke"]
        assert float(docking.quantity("latch_energy_share")) < 0.2
        # Neither torn by a swing that is no worse nor so strong that the strength says nothing.
        assert 0.03 < float(docking.quantity("peak_latch_force")) / float(problem.design.latch.strength) < 0.5


@pytest.mark.parametrize("kind", KINDS)
def test_similar_dockings_are_similar(kind):
    """Eight times the masses at the same speed and twice the miss, with all lengths twice as large: stiffnesses twice,
    dampings four times as large."""
    task, study = mechanism_named(kind).sizing
    small, large = (
        {it.path: it.value for it in study(task(20.0 * m, 20.0 * m, 0.08, 0.15, miss, 0.0)).numbers}
        for m, miss in ((1.0, 0.06), (8.0, 0.12))
    )
    ratio = {path: large[path] / small[path] for path in small}
    expected = {"buffer.k_A": 2.0, "buffer.c_A": 4.0, "buffer.k_T": 8.0, "buffer.c_T": 16.0, "cone.length": 2.0}
    expected |= {"latch.stiffness": 2.0, "latch.damping": 4.0, "latch.closing_time": 2.0, "active.inertia": 32.0}
    if kind == "docking3d":
        expected |= {"active.roll_inertia": 32.0, "passive.roll_inertia": 32.0, "probe.rod_radius": 2.0}
    assert {path: ratio[path] for path in expected} == pytest.approx(expected, rel=1e-12)


def test_in_space_it_misses_in_two_directions_and_turns_about_two_axes(tmp_path):
    problem = load(str(written(tmp_path, "8 t", "8 t", "0.06:0.12", "5 cm", "2 deg", "docking3d"))).problem()
    directions = set()
    for case in problem.cases:
        scenario = case.scenario
        assert math.hypot(scenario.offset_y, scenario.offset_z) == pytest.approx(0.05, rel=1e-5)
        assert scenario.active_yaw == pytest.approx(math.radians(2.0), rel=1e-5)
        # Which way the tip is off, against where yaw turns it to.
        directions.add(round(math.degrees(math.atan2(scenario.offset_z, scenario.offset_y))))
        # 30 mm at λ = 1, the fourth root of 400 for these masses: on such a way by a tenth of the attitude.
        time = 0.03 * 400.0**0.25 / 0.06
        assert scenario.active_rate_x == scenario.active_rate_z == pytest.approx(math.radians(0.2) / time, rel=1e-5)
    assert directions == {45, 135}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--active-mass", "-3 kg"], "active_mass = "),
        (["--active-mass", "3 m"], "active_mass = "),
        (["--speeds", "0.15:0.05"], "slowest"),
        (["--attitude", "50 deg"], "attitude = "),
        (["--kind", "bar_drop", "--miss", "1 cm"], "bar_drop"),
        (["--own", "gripper", "--miss", "1 cm"], "--own"),
    ],
)
def test_bad_numbers_are_one_line(options, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["init", *options]) == 2
    err = capsys.readouterr().err
    assert said in err and err.count("\n") == 1 and not list(tmp_path.iterdir())


@pytest.mark.parametrize(("kind", "angles"), [("probe_cone", ["active_angle"]), ("docking3d", list(TURNS))])
def test_without_attitude_there_is_no_angle(kind, angles, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(["init", "--kind", kind, "--active-mass", "100 kg"]) == 0
    problem = load("study.toml").problem()
    assert {float(getattr(case.scenario, angle)) for case in problem.cases for angle in angles} == {0.0}
    assert np.isclose(float(problem.design.latch.turn_stiffness), 20.0 * (100.0 * 20.0 / 120.0) / 10.0, rtol=1e-2)
    assert math.isclose(float(problem.design.passive.mass), 20.0)
