"""`jaxbuffer sample` and the envelope of `sweep`: what they ask for, write, refuse; results are made up."""

import csv
import io

import pytest

from jaxbuffer.cli.entry import run
from made_up import made_up_sweep

RANGES = ["--over", "buffer.k_A=100:2000", "--over", "scenario.approach_speed=0.1:0.3"]


def rows(path):
    return list(csv.DictReader(io.StringIO(path.read_text())))


def test_files_of_a_sample(computed, capsys, tmp_path):
    assert run(["sample", *RANGES, "--count", "64", "--surface", "--indices", "--output", "out"]) == 0
    command, asked = computed.calls[-1]
    assert command == "sweep" and asked["scenarios"].approach_speed.shape == (64 * 4,)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        *("sample.csv", "sample.png", "sample.txt", "sample.nc", "sample.json"),
        *("indices.csv", "indices.png", "surface.csv", "surface.png"),
    }
    assert len(rows(tmp_path / "out" / "sample.csv")) == 256
    indices = rows(tmp_path / "out" / "indices.csv")
    assert [row["number"] for row in indices] == ["buffer.k_A", "scenario.approach_speed"]
    assert {row["from"] for row in indices} == {"runs"}
    shown = capsys.readouterr()
    assert "Sample of 256 captures: saltelli, seed 0, 64 rows of 4 runs" in shown.out
    assert "fitting response surfaces" in shown.err
    assert run(["sample", *RANGES, "--output", "out"]) == 2
    assert "--force overwrites" in capsys.readouterr().err
    assert run(["report", "out"]) == 0
    again = capsys.readouterr().out
    assert "in a sample of 2 numbers" in again and "Response surface of" not in again


@pytest.mark.usefixtures("no_figures")
def test_runs_that_are_not_trusted_are_counted_and_marked(computed, capsys, monkeypatch, tmp_path):
    def doubtful(designs, scenarios, outcomes):
        found = made_up_sweep(designs, scenarios, outcomes)
        found.columns["trust"][:4] = [2, 1, 3, -1]
        return found

    monkeypatch.setattr("computed.made_up_sweep", doubtful)
    assert run(["sample", *RANGES, "--count", "8", "--output", "out"]) == 0
    assert computed.calls[-1][1]["trust"] is True
    words = " ".join(capsys.readouterr().out.split())
    for said in (
        "1 of 8 captures are ill-conditioned: little decides what happens",
        "1 of 8 captures have numbers that may be off by more than 1e-04 of them (see trust in sample.csv)",
        "1 of 8 captures have numbers of unknown error: a tenth of rtol is below 1e-13, the least allowed, or",
    ):
        assert said in words
    marked = [row["trust"] for row in rows(tmp_path / "out" / "sample.csv")]
    assert marked == ["ill-conditioned", "check", "unknown", "", *["trusted"] * 4]
    assert run(["sample", *RANGES, "--count", "8", "--trust", "off"]) == 0
    assert computed.calls[-1][1]["trust"] is False
    assert run(["sample", *RANGES, "--trust", "maybe"]) == 2
    assert "trust = 'maybe'" in capsys.readouterr().err


def test_a_sample_of_a_study(computed, tmp_path):
    (tmp_path / "study.toml").write_text(
        '[sample]\ncount = 10\nmethod = "latin_hypercube"\n[sample.ranges]\nbuffer.k_A = [100, 200, "log"]\n'
    )
    assert run(["sample", "study.toml", "--over", "buffer.c_A=2:4"]) == 0
    asked = computed.calls[-1][1]
    assert asked["design"].buffer.k_A.shape == (10,) and asked["design"].buffer.c_A.max() <= 4.0


def test_ctrl_c_keeps_what_was_done(computed, no_figures, capsys, tmp_path):
    computed.interrupt_after = 5
    assert run(["sample", *RANGES, "--count", "8", "--output", "out"]) == 130
    assert "interrupted, 5 of them done" in capsys.readouterr().out
    assert len(rows(tmp_path / "out" / "sample.csv")) == 5


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("--over buffer.k_A=200", "expected FIELD=LOW:HIGH"),
        ("--over buffer.k_A=200:x", "'x' is not a number"),
        ("--over buffer.k_A=200:100", "[200, 100] N/m: the low end must be below the high one"),
        ("--over buffer.k_A=-1:100", "buffer.k_A = -1 N/m is out of range; allowed: (0, inf) N/m"),
        ("--over buffer.k_B=1:100", "did you mean buffer.k_A?"),
        ("--over contact.law=1:2", "is a choice; only numbers can be sampled"),
        ("--over buffer.k_A=1:2 --count 100", "take 64 or 128, or the method latin_hypercube"),
        ("--over buffer.k_A=1:2 --count many", "--count many is not a whole number"),
        ("--over buffer.k_A=1:2 --method halton", "sobol"),
        ("--over buffer.k_A=1:2 --of peak_forse", "did you mean peak_force?"),
        ("--over buffer.k_A=1:2 --over buffer.k_A=1:3", "given more than once"),
        ("--over buffer.k_A=1:2 --buffer.k_A 3", "contradict"),
        ("--over scenario.misalignment=-0.1:0.1:log", "needs positive ends"),
    ],
)
def test_bad_input_is_told_in_a_line(computed, capsys, typed, said):
    assert run(["sample", *typed.split()]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1
    assert all(command != "sweep" for command, _ in computed.calls)


@pytest.mark.parametrize(
    ("section", "said"),
    [
        ("counts = 3", "sample.counts is unknown; did you mean count?"),
        ("ranges = 3", "write [sample.ranges]"),
        ("count = 3\n[sample.ranges]\nbuffer.k_A = [1, 2]", "not a power of two"),
        ("[sample.ranges]\nbuffer.k_A = 3", "must be low and high end in N/m"),
    ],
)
def test_a_bad_section_is_told_in_a_line(computed, capsys, tmp_path, section, said):
    (tmp_path / "study.toml").write_text(f"[sample]\n{section}\n")
    assert run(["sample", "study.toml"]) == 2
    assert said in capsys.readouterr().err


def test_a_sweep_over_two_fields_has_an_envelope(computed, capsys, tmp_path):
    (tmp_path / "study.toml").write_text("[problem.constraints]\npeak_force = 305.0\n")
    over = ["--over", "scenario.approach_speed=0.1:0.3:3", "--over", "buffer.k_A=100,1000"]
    assert run(["sweep", "study.toml", *over, "--output", "out"]) == 0
    assert (tmp_path / "out" / "envelope.png").read_bytes().startswith(b"\x89PNG")
    words = " ".join(capsys.readouterr().out.split())
    assert "Safe (captured, peak force ≤ 305 N): 4 of 6 captures" in words  # 110 200 210 300 | 310 400 N
    assert "largest rectangle of safe captures, 4 of them (2 × 2)" in words and "0.1 … 0.2 m/s" in words


def test_an_envelope_says_what_is_between_the_scenarios_of_a_grid(computed, no_figures, capsys, tmp_path):
    """Made-up forces are 110 200 210 300 310 400 N; those at 0.1 and 0.2 m/s lie within the grid's speeds."""
    grid = "[problem.grid]\napproach_speed = [0.1, 0.2]\nmisalignment = [-0.01, 0.01]\n"
    (tmp_path / "study.toml").write_text(f"[problem.constraints]\npeak_force = 205.0\n{grid}")
    over = ["--over", "scenario.approach_speed=0.1:0.3:3", "--over", "scenario.misalignment=-0.01,0.01"]
    assert run(["sweep", "study.toml", *over, "--output", "out"]) == 0
    assert "Between the study's scenarios (approach speed 0.1 … 0.2 m/s, " in " ".join(capsys.readouterr().out.split())
