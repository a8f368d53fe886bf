"""A study made from masses, speeds, misses and attitude: it loads, is held in every load case, and tunes as it is."""

import math

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.study.load import load
from vehicles import VEHICLES, written


@pytest.mark.parametrize("name", VEHICLES)
def test_it_says_its_rules_and_can_be_used(name, tmp_path, capsys):
    file = written(tmp_path, *VEHICLES[name])
    problem = load(str(file)).problem()
    assert len(problem.cases) == 4 and problem.limits.held
    text = file.read_text(encoding="utf-8")
    assert "usually" in text and "μ v²/λ²" in text and "take your own" in text
    assert run(["check", str(file)]) == 0


@pytest.mark.slow
@pytest.mark.parametrize("name", VEHICLES)
def test_every_load_case_is_held(name, tmp_path):
    study = load(str(written(tmp_path, *VEHICLES[name])))
    problem = study.problem()
    for case in problem.cases:
        docking = jb.simulate(problem.design, case.scenario, duration=problem.duration)
        assert docking.outcome.name == "held"
        assert float(docking.stroke) < problem.limits.at_most["stroke"]
        assert float(docking.quantity("latch_energy_share")) < 0.2
        # Neither torn by a swing that is no worse nor so strong that the strength says nothing.
        assert 0.03 < float(docking.quantity("peak_latch_force")) / float(problem.design.latch.strength) < 0.5


def test_similar_dockings_are_similar():
    """Eight times the masses at the same speed and twice the miss, with all lengths twice as large: stiffnesses twice,
    dampings four times as large."""
    from jaxbuffer.mechanisms.probe_cone.scaled import VehiclesToDock, scaled_study

    small, large = (
        {it.path: it.value for it in scaled_study(VehiclesToDock(20.0 * m, 20.0 * m, 0.08, 0.15, miss, 0.0)).numbers}
        for m, miss in ((1.0, 0.06), (8.0, 0.12))
    )
    ratio = {path: large[path] / small[path] for path in small}
    expected = {"buffer.k_A": 2.0, "buffer.c_A": 4.0, "buffer.k_T": 8.0, "buffer.c_T": 16.0, "cone.length": 2.0}
    expected |= {"latch.stiffness": 2.0, "latch.damping": 4.0, "latch.closing_time": 2.0, "active.inertia": 32.0}
    assert {path: ratio[path] for path in expected} == pytest.approx(expected, rel=1e-12)


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


def test_without_attitude_there_is_no_angle(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(["init", "--active-mass", "100 kg"]) == 0
    problem = load("study.toml").problem()
    assert {float(case.scenario.active_angle) for case in problem.cases} == {0.0}
    assert np.isclose(float(problem.design.latch.turn_stiffness), 20.0 * (100.0 * 20.0 / 120.0) / 10.0, rtol=1e-2)
    assert math.isclose(float(problem.design.passive.mass), 20.0)
