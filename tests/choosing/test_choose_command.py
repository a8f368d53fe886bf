"""`jaxbuffer choose`: files, exit codes, going on after an interrupt."""

import json
import re

import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.study.load import load

STUDY = """\
[parts.spring]
S1 = {k_A = "0.2 kN/m", price = "9 EUR"}
S2 = {k_A = "0.45 kN/m", price = "12 EUR"}
[parts.damper]
file = "dampers.csv"
[problem.grid]
approach_speed = ["6 cm/s", "14 cm/s"]
[problem.constraints]
stroke = "25 mm"
price = 40
[choose]
optimum = false
"""
DAMPERS = "name,c_A [N s/m],price [EUR]\nD14,14,26\nD45,45,31\n"
FILES = {"design.toml", "design.mat", "choice.json", "choice.csv", "choice.txt", "choice.png"}


@pytest.fixture
def study(tmp_path, monkeypatch, no_figures):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY)
    (tmp_path / "dampers.csv").write_text(DAMPERS)
    return tmp_path


@pytest.mark.slow
def test_a_choice_is_saved_and_read_again(study, capsys):
    assert run(["choose", "study.toml", "--output", "out"]) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith("The best of 4 combinations over 2 scenarios: spring S1, damper D14, with ")
    assert "4 combinations: 8 captures" in shown.err
    assert re.search(r"^ *price +[\d.]+ EUR +(≤|at most) 40 EUR", shown.out, re.MULTILINE)
    assert {path.name for path in (study / "out").iterdir() if path.is_file()} - {".lock"} == FILES
    record = json.loads((study / "out" / "choice.json").read_text())
    assert record["feasible"] and record["tally"]["priced_out"] == 1, "S2 with D45 alone costs more than 40"
    assert record["ranking"][0]["parts"] == {"spring": "S1", "damper": "D14"}
    assert record["ranking"][0]["price"]["value"] == 35.0
    assert jb.get(load(study / "out" / "design.toml").design, "buffer.k_A") == 200.0
    assert 'k_A = "0.2 kN/m"' in (study / "out" / "design.toml").read_text()
    found = jb.load(study / "out")
    assert found.records["choice"]["message"] in shown.out.replace("The best", "the best")
    assert found.design.buffer.c_A == 14.0
    # again: refused, then resumed without a run
    assert run(["choose", "study.toml", "--output", "out"]) == 2
    assert "exist" in capsys.readouterr().err
    assert run(["choose", "study.toml", "--output", "out", "--resume", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert {k: v for k, v in again.items() if k != "made"} == {k: v for k, v in record.items() if k != "made"}


@pytest.mark.slow
def test_where_none_keeps_the_limits_the_command_ends_with_1(study, capsys):
    (study / "study.toml").write_text(STUDY.replace('"25 mm"', '"1 mm"'))
    assert run(["choose", "study.toml", "--output", "out"]) == 1
    shown = capsys.readouterr()
    assert "no combination keeps all limits, of 4 combinations" in shown.err.splitlines()[-1]
    assert "broken: scenario 2 (0.14 m/s, 0°): stroke " in shown.out and (study / "out" / "choice.csv").is_file()


def test_resuming_where_nothing_was_begun_is_refused(study, capsys):
    assert run(["choose", "study.toml", "--output", "out", "--resume"]) == 2
    assert "there is no choice to resume; leave out --resume to begin one" in capsys.readouterr().err
    assert run(["choose", "study.toml", "--ranking", "0"]) == 2
    assert "--ranking = 0 must be a whole number from 1 to 1000" in capsys.readouterr().err


def test_check_says_what_is_chosen_from(study, capsys):
    assert run(["check", "study.toml"]) == 0
    shown = capsys.readouterr().out
    assert "2 × 2 = 4 combinations over 2 scenarios" in shown and "price ≤ 40 EUR of all parts" in shown
    assert "damper: 2, each with buffer.c_A, price: D14, D45" in shown


def test_check_says_that_parts_and_roundings_are_one_too_many(study, capsys):
    (study / "study.toml").write_text(STUDY + '[roundings]\nprobe.tip_mass = "E3"\n')
    assert run(["check", "study.toml"]) == 0
    assert "needs either [parts] or [roundings]; keep one" in capsys.readouterr().out


def test_check_says_the_price_that_decides_and_refuses_it_without_parts(study, capsys):
    (study / "study.toml").write_text(STUDY + "[problem.objective]\nprice = 1.0\n")
    assert run(["check", "study.toml"]) == 0
    shown = capsys.readouterr().out
    assert re.search(r"objective +price\n", shown) and "peak_force, worst" not in shown
    assert "price ≤ 40 EUR of all parts" in shown
    (study / "study.toml").write_text(STUDY + "[problem.then]\nprice = 1.0\ntolerance = 0.1\n")
    assert run(["check", "study.toml"]) == 0
    assert re.search(r"then +price, among those within 10 % of the least objective\n", capsys.readouterr().out)
    for table, name in (("objective", "price"), ("then", "price"), ("constraints", "mass")):
        (study / "study.toml").write_text(f"[problem.{table}]\n{name} = 1.0\n")
        assert run(["check", "study.toml"]) == 2
        assert f"problem.{table}.{name} is unknown" in capsys.readouterr().err
