"""The command line: what it computes, prints and writes, and how it fails."""

import csv
import io
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from rich.console import Console

import jaxbuffer
from jaxbuffer import Design, InputError, Outcome, Scenario, table2
from jaxbuffer.cli.commands.names import all_names
from jaxbuffer.cli.entry import main, run
from jaxbuffer.cli.overrides import fields_text, quantities_text, split
from jaxbuffer.cli.quick import prepare
from jaxbuffer.fields import paths, unit
from jaxbuffer.labelled.record import amount
from jaxbuffer.mechanisms import all_mechanisms
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.mechanisms.probe_cone.quantities import QUANTITIES as CATALOGUE
from jaxbuffer.mechanisms.quantity import OF_IMPACT
from jaxbuffer.mechanisms.registry import registered
from jaxbuffer.sensitivities.certificate import Verdict
from jaxbuffer.study.load import load

SIMULATED = ("capture.json", "force.json", "history.csv", "motion.json", "capture.txt", "capture.nc", "capture.mat")
SIMULATED += ("capture.png", "motion.png")
DIFFERENTIATED = ("sensitivity.json", "sensitivity.csv", "sensitivity.txt", "sensitivity.png")
TUNED = ("design.toml", "tuned.json", "history.csv", "force.json", "tune.png", "tune.txt", "design.mat")
PNG = b"\x89PNG"


def refused(capsys, tmp_path, *arguments) -> str:
    """The one line on stderr of a command that must exit with 2 and write nothing."""
    before = sorted(tmp_path.rglob("*"))
    assert run(arguments) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err.startswith("error: ") and shown.err.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before
    return shown.err


def test_simulate_prints_a_summary_and_writes_nothing(computed, capsys, tmp_path):
    assert run(["simulate"]) == 0
    shown = capsys.readouterr()
    assert "peak contact force   250 N at 0.02 s, upper flank, impact 1 of 1" in shown.out
    assert shown.err == "simulating\na tenth of the tolerance changes no number\n"
    (configured, _), (command, arguments), (again, closer) = computed.calls
    assert (configured, command, again) == ("configure", "simulate", "simulate"), "JAX is set up first"
    assert closer == arguments | {"rtol": 1e-7}
    assert (arguments["design"], arguments["scenario"], arguments["duration"]) == (table2(), Scenario(), 8.0)
    assert (arguments["rtol"], arguments["history"]) == (1e-6, False)
    assert list(tmp_path.iterdir()) == []


def test_without_a_tenth_of_the_tolerance_trust_is_unknown(computed, no_figures, capsys, tmp_path):
    assert run(["simulate", "--rtol", "9e-13", "--output", "out"]) == 0
    assert [arguments["rtol"] for name, arguments in computed.calls if name == "simulate"] == [9e-13]
    reason = "how far these numbers can be trusted is not known: a tenth of rtol is below 1e-13, the least allowed"
    assert f"note: {reason}\n" in capsys.readouterr().err
    stored = json.loads((tmp_path / "out" / "capture.json").read_text())
    assert stored["trust"] == {"verdict": "unknown", "reason": reason, "errors": {}}


def test_options_and_fields_override_the_study(computed, tmp_path):
    (tmp_path / "study.toml").write_text("[buffer]\nk_A = 600\nc_A = 7\n[options]\nduration = 3\nrtol = 1e-6")
    words = "--buffer.k_A 800 --scenario.misalignment=-0.1 --rtol 1e-9 --solver explicit"
    assert run(["simulate", "study.toml", *words.split(), "--trust", "off"]) == 0
    _, (_, arguments) = computed.calls
    assert (arguments["design"].buffer.k_A, arguments["design"].buffer.c_A) == (800.0, 7.0)
    assert arguments["scenario"].misalignment == -0.1
    assert (arguments["duration"], arguments["rtol"]) == (3.0, 1e-9)
    assert type(arguments["solver"]).__name__ == "ExplicitRungeKutta"


@pytest.mark.parametrize(("first", "second"), [("--buffer.k_A 800", ""), ("", "--buffer.k_A=800")])
def test_fields_may_stand_anywhere(computed, tmp_path, first, second):
    (tmp_path / "study.toml").write_text("[buffer]\nc_A = 7")
    assert run(["simulate", *first.split(), "study.toml", *second.split()]) == 0
    buffer = computed.calls[-1][1]["design"].buffer
    assert (buffer.k_A, buffer.c_A) == (800.0, 7.0)


def test_splitting_dotted_options():
    words = ["a.toml", "--buffer.k_A", "-1", "--rtol", "1e-3"]
    assert split(words) == (["a.toml", "--rtol", "1e-3"], {"buffer.k_A": "-1"})
    assert split(["--output=a.b", "--", "--c.d"]) == (["--output=a.b", "--", "--c.d"], {})
    for words in (["--buffer.k_A"], ["--buffer.k_A", "--rtol", "1e-3"]):
        with pytest.raises(InputError, match=r"buffer\.k_A needs a value: --buffer\.k_A VALUE"):
            split(words)


def test_simulate_writes_numbers_history_and_figure(computed, capsys, tmp_path):
    assert run(["simulate", "--output", "a/b", "--buffer.damping", "published"]) == 0
    folder = tmp_path / "a" / "b"
    assert {path.name for path in folder.iterdir()} == set(SIMULATED)
    assert [line for line in capsys.readouterr().out.splitlines() if line.startswith("wrote")] == [
        f"wrote {os.path.join('a', 'b', name)}" for name in SIMULATED
    ]
    record = json.loads((folder / "capture.json").read_text())
    assert (record["outcome"], record["peak_force"]["value"], record["peak_flank"]) == ("captured", 250.0, "upper")
    assert record["design"]["buffer.k_A"]["value"] == 500.0 and record["design"]["buffer.damping"] == "published"
    assert record["design"]["contact.stiffness"]["value"] is None
    (impact,) = record["impacts"]
    assert (impact["number"], impact["peak_force"]["value"], impact["release_time"]["value"]) == (1, 250.0, None)
    rows = list(csv.DictReader(io.StringIO((folder / "history.csv").read_text())))
    assert len(rows) == 400 and all(re.search(r" \[[^]]+\]$", name) for name in rows[0])
    assert max(float(row["contact_force upper [N]"]) for row in rows) == pytest.approx(250.0, rel=1e-2)
    assert float(rows[-1]["time [s]"]) == 0.04
    assert (folder / "capture.png").read_bytes().startswith(PNG)


def test_sensitivity_prints_tables_and_writes_files(computed, no_figures, capsys, tmp_path):
    assert run(["sensitivity", "--output", "out", "--wrt", "buffer.k_A", "--wrt", "scenario.approach_speed"]) == 0
    shown = capsys.readouterr().out
    for part in ("peak_force", "buffer.k_A", "1 N/m", "+1 N/(N/m)", "1.0e-05", "+0.0100"):
        assert part in shown
    for part in (
        "Certificate: TRUSTED: made up in a test",
        "250 N at 0.02 s, upper flank, impact 1",
        "200 N, impact 3, 20 % below; -30 % of buffer.c_A would make it the peak",
        "First impact: 250 N; closed form 143 N, 150 N without loss (effective energy T_c 0.0005 J)",
    ):
        assert part in shown
    arguments = computed.calls[-1][1]
    assert arguments["wrt"] == ("buffer.k_A", "scenario.approach_speed")
    assert (arguments["quantities"], arguments["certify"]) == (PROBE_CONE.defaults.differentiated, "quick")
    record = json.loads((tmp_path / "out" / "sensitivity.json").read_text())
    assert record["peak_force"]["value"] == 250.0
    rows = list(csv.DictReader(io.StringIO((tmp_path / "out" / "sensitivity.csv").read_text())))
    assert len(rows) == len(record["derivatives"]) == 10
    assert rows[1]["gradient_unit"] == "N/(m/s)"
    assert rows[0]["estimated_error [-]"] == "1e-05" and rows[0]["verdict"] == "trusted"
    stored = record["certificate"]
    assert (stored["verdict"], stored["reason"]) == ("trusted", "made up in a test")
    assert stored["estimated_error"]["stroke"]["buffer.k_A"] == 1e-5
    assert stored["active_peak"] == {
        "force": amount(250.0, "N"),
        "time": amount(0.02, "s"),
        "flank": "upper",
        "impact": 1,
    }
    assert stored["runner_up"]["impact"] == 3 and stored["runner_up"]["swapped_by"] == "buffer.c_A"


def test_quantities_and_certificate_are_chosen_by_name(computed, capsys, tmp_path):
    words = ["--of", "stroke", "--of", "impact.2.approach_speed", "--certify", "thorough", "--wrt", "buffer.c_A"]
    computed.verdict = Verdict.check
    assert run(["sensitivity", *words]) == 0
    arguments = computed.calls[-1][1]
    assert arguments["quantities"] == ("stroke", "impact.2.approach_speed") and arguments["certify"] == "thorough"
    shown = capsys.readouterr().out
    assert "CHECK: made up in a test" in shown and "stroke check; the others are" in shown
    assert "did you mean stroke?" in refused(capsys, tmp_path, "sensitivity", "--of", "strok")
    assert "did you mean approach_speed?" in refused(capsys, tmp_path, "sensitivity", "--of", "impact.1.aproach_speed")
    assert "they count from 1" in refused(capsys, tmp_path, "sensitivity", "--of", "impact.0.time")
    assert "certify = 'ful' is unknown" in refused(capsys, tmp_path, "sensitivity", "--certify", "ful")


def test_the_quantities_in_the_help_are_those_there_are():
    listed = dict(re.findall(r"(\S+) \[(.+?)\]", quantities_text(all_names()[PROBE_CONE.name])))
    assert listed == {name: q.unit for name, q in CATALOGUE.items()} | {
        f"impact.N.{field}": symbol for field, symbol in OF_IMPACT.items()
    }


def test_tune_prints_before_and_after_and_writes_files(computed, capsys, tmp_path, request):
    study = str(request.config.rootpath / "optimise" / "table2.toml")
    words = ["--iterations", "9", "--starts", "3", "--seed", "5", "--output", "out"]
    assert run(["tune", study, *words]) == 0
    shown = capsys.readouterr()
    for part in (
        "peak_force, worst over the cases [N]",
        "250 → 200",
        "-20.0 %",
        "0.15 m/s",
        "350 → 280",
        "converged: in a test",
        "0.0015 % of the objective left to gain",
        "+150.000 % above it",
        "none gets below 90 N",
    ):
        assert part in shown.out
    assert ", 1 of at most 276, start: 350 N, 2 % left to gain" in shown.err
    assert ", 3 of at most 276, search 1, step 2: 315 N, 0 of 3 captured, limits broken" in shown.err
    arguments = computed.asked("tune")
    assert {name: arguments[name] for name in ("iterations", "starts", "searches", "seed", "resume")} == {
        **{"iterations": 9, "starts": 3, "searches": 2, "seed": 5, "resume": False}
    }
    assert arguments["problem"].limits.at_most == {"stroke": 0.025} and str(arguments["folder"]) == "out"
    written = load(tmp_path / "out" / "design.toml")
    assert written.design.buffer.k_A == pytest.approx(300.0)
    assert [s.approach_speed for s in written.scenarios] == [0.1, 0.15, 0.2]  # in the study's order
    assert written.scenario.approach_speed == 0.2  # the one with the largest peak
    rows = list(csv.DictReader(io.StringIO((tmp_path / "out" / "history.csv").read_text())))
    assert len(rows) == 5 and float(rows[-1]["buffer.k_A [N/m]"]) == pytest.approx(300.0)
    assert rows[0]["worst peak_force [N]"] == "350.0"
    record = json.loads((tmp_path / "out" / "tuned.json").read_text())
    assert record["objective_after"] == 280.0 and record["scenarios"][1]["after"]["peak_force"]["value"] == 240.0
    assert (tmp_path / "out" / "tune.png").read_bytes().startswith(PNG)


@pytest.mark.usefixtures("no_figures")
def test_resuming_takes_the_folder_as_it_is(computed, tmp_path):
    (tmp_path / "out").mkdir()
    for name in ("log.jsonl", "state.npz"):
        (tmp_path / "out" / name).write_text("")
    assert run(["tune", "--output", "out"]) == 2
    assert run(["tune", "--output", "out", "--resume"]) == 0 and computed.asked("tune")["resume"] is True


def test_on_a_terminal_progress_is_drawn_and_removed(computed, capsys, monkeypatch):
    drawn = io.StringIO()
    terminal = Console(file=drawn, force_terminal=True, width=100)
    monkeypatch.setattr("jaxbuffer.cli.commands.progress.Console", lambda **_: terminal)
    assert run(["tune"]) == 0 and run(["simulate"]) == 0
    assert "tuning" in drawn.getvalue() and "simulating" in drawn.getvalue()
    assert "compiling" not in drawn.getvalue(), "nothing was compiled"
    assert capsys.readouterr().err == "a tenth of the tolerance changes no number\n"


BAD_FIELDS = [
    ("--active.mass=-1", "active.mass = -1 kg is out of range; allowed: (0, inf) kg"),
    ("--probe.tip_mass=0", "probe.tip_mass = 0 kg is out of range; allowed: (0, inf) kg"),
    ("--buffer.k_A=0", "buffer.k_A = 0 N/m is out of range; allowed: (0, inf) N/m"),
    ("--probe.tip_radius=-1", "probe.tip_radius = -1 m is out of range; allowed: (0, inf) m"),
    ("--probe.tip_radius=0.07", "probe.tip_radius = 0.07 m is out of range; allowed: (0, 0.0669723) m"),
    ("--contact.restitution=0", "contact.restitution = 0"),
    ("--contact.restitution=1.2", "contact.restitution = 1.2"),
    ("--contact.friction=-0.1", "contact.friction = -0.1"),
    ("--scenario.contact_distance=0.08", "scenario.contact_distance = 0.08 m is out of range; allowed: (0, 0.0735] m"),
    ("--buffer.c_T=nan", "buffer.c_T = nan N m s/rad is out of range; allowed: [0, inf) N m s/rad"),
    ("--buffer.c_T=inf", "buffer.c_T = inf N m s/rad is out of range; allowed: [0, inf) N m s/rad"),
    ("--buffer.k_A=stiff", "buffer.k_A: 'stiff' is not a number; expected (0, inf) N/m"),
    ("--bufer.k_A=1", "bufer.k_A is unknown; did you mean buffer.k_A?"),
    ("--buffer.k_A", "buffer.k_A needs a value"),
    ("--outptu=x", "No such option: --outptu"),
    ("--rtol=1", "--rtol = 1 is out of range; allowed: [1e-13, 0.01]"),
    ("--rtol=tiny", "--rtol: 'tiny' is not a number; expected [1e-13, 0.01]"),
    ("--duration=-2", "--duration = -2 s is out of range; allowed: (0, inf) s"),
]


@pytest.mark.parametrize("command", ["simulate", "sensitivity", "tune", "sweep"])
@pytest.mark.parametrize(("word", "message"), BAD_FIELDS)
def test_bad_options_are_one_line_and_exit_code_2(computed, capsys, tmp_path, command, word, message):
    assert message in refused(capsys, tmp_path, command, "--output", "out", word)
    assert all(name == "configure" for name, _ in computed.calls), "nothing was computed"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[buffer]\nk_A = -1", "study.toml: buffer.k_A = -1 N/m is out of range; allowed: (0, inf) N/m"),
        ("[bufer]\nk_A = 1", "study.toml: [bufer] is unknown; did you mean buffer?"),
        ("[buffer]\nk_A = '1'", "study.toml: buffer.k_A = '1': a text needs a unit; write 1 without quotes"),
        ("[buffer", "study.toml is not valid TOML"),
        ('["a\\nb"]', "is unknown"),
    ],
)
def test_a_bad_study_is_one_line_and_exit_code_2(computed, capsys, tmp_path, text, message):
    (tmp_path / "study.toml").write_text(text)
    assert message in refused(capsys, tmp_path, "simulate", "study.toml", "--output", "out")


def test_a_missing_study_and_a_second_one(computed, capsys, tmp_path):
    assert "missing.toml: no such file" in refused(capsys, tmp_path, "tune", "missing.toml")
    assert "unexpected extra argument" in refused(capsys, tmp_path, "tune", "a.toml", "b.toml")
    assert "--iterations = 0 must be a whole number of at least 1" in refused(
        capsys, tmp_path, "tune", "--iterations", "0"
    )
    assert "the start, buffer.k_A = 5000 N/m, is outside the default bounds [100, 2000] N/m; give bounds in" in refused(
        capsys, tmp_path, "tune", "--buffer.k_A", "5000"
    )


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    ("command", "names"), [("simulate", SIMULATED), ("sensitivity", DIFFERENTIATED), ("tune", TUNED)]
)
def test_existing_files_stay_unless_forced(computed, capsys, tmp_path, command, names):
    (tmp_path / "out").mkdir()
    mine = tmp_path / "out" / names[1]
    mine.write_text("mine")
    message = refused(capsys, tmp_path, command, "--output", "out")
    assert f"{os.path.join('out', names[1])} exists; --force overwrites, another --output keeps it" in message
    assert computed.calls[-1][0] == "configure" and mine.read_text() == "mine"
    assert run([command, "--output", "out", "--force"]) == 0
    assert mine.read_text() != "mine" and {path.name for path in (tmp_path / "out").iterdir()} == set(names)


def test_output_that_is_a_file_is_refused(computed, capsys, tmp_path):
    (tmp_path / "out").write_text("")
    for folder in ("out", "out/below"):
        assert "out is a file; --output needs a folder" in refused(capsys, tmp_path, "simulate", "--output", folder)


def test_figures_without_matplotlib_are_refused_before_computing(computed, capsys, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert "pip install matplotlib" in refused(capsys, tmp_path, "simulate", "--output", "out")
    assert "pip install matplotlib" in refused(capsys, tmp_path, "sweep", "--output", "out")
    assert "pip install matplotlib" in refused(capsys, tmp_path, "sensitivity", "--output", "out")
    assert run(["simulate"]) == 0 and run(["sensitivity"]) == 0


@pytest.mark.parametrize("command", ["simulate", "sensitivity"])
def test_a_failed_capture_exits_with_3_and_writes_nothing(computed, capsys, tmp_path, command):
    computed.outcome = Outcome.failed_step_size
    assert run([command, "--output", "out"]) == 3
    shown = capsys.readouterr()
    assert shown.out == "" and shown.err.splitlines()[-1] == f"error: {Outcome.failed_step_size.reason}"
    assert not (tmp_path / "out").exists()


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize("command", ["simulate", "sensitivity"])
def test_a_run_outside_the_studys_limits_exits_with_1_and_says_which(computed, capsys, tmp_path, command):
    """A made-up capture has 7.5 mm of stroke, takes 0.04 s and has one impact."""
    limits = "stroke = '5 mm'\nend_time = {min = '50 ms', max = '1 s'}\nimpacts = 1\n"
    (tmp_path / "study.toml").write_text(f"[problem.constraints]\n{limits}")
    assert run([command, "study.toml", "--output", "out"]) == 1
    shown = capsys.readouterr()
    kept = "error: [problem.constraints] not kept: stroke 7.5 mm is above 5 mm; end_time 0.04 s is below 0.05 s"
    assert shown.err.splitlines()[-1] == kept
    assert shown.out and any((tmp_path / "out").iterdir()), "the result is saved and shown all the same"
    if command == "simulate":
        table = shown.out[shown.out.index("Limits: what stands in the way") :].splitlines()
        rows = [" ".join(line.split()) for line in table[4:10]]
        # The one that is farthest broken stands first.
        assert rows[0].startswith("buffer stroke 7.5 mm ≤ 5 mm -50 % ") and rows[0].endswith("broken")
        assert rows[1].startswith("end time 0.04 s ≥ 0.05 s -20 % ") and rows[1].endswith("broken")
        assert {row.split(" ", 2)[0] for row in rows[2:]} == {"end", "share", "impacts", "captured"}
        assert table[4] in (tmp_path / "out" / "capture.txt").read_text()
    computed.outcome = Outcome.timeout
    (tmp_path / "study.toml").write_text("[problem.constraints]\nstroke = 0.02\n")
    assert run([command, "study.toml"]) == 1
    assert "not kept: not captured (timeout: neither captured nor escaped" in capsys.readouterr().err
    (tmp_path / "study.toml").write_text("[problem.constraints]\nrequire_success = false\n")
    assert run([command, "study.toml"]) == 0


def test_a_bug_exits_with_3(monkeypatch, capsys):
    def broken(arguments):
        raise ZeroDivisionError("of a bug")

    monkeypatch.setattr("jaxbuffer.cli.entry.run", broken)
    with pytest.raises(SystemExit) as ended:
        main(["simulate"])
    assert ended.value.code == 3 and "ZeroDivisionError: of a bug" in capsys.readouterr().err


def test_an_escape_is_a_result(computed, capsys):
    computed.outcome = Outcome.escaped
    assert run(["simulate"]) == 0
    assert "escaped" in capsys.readouterr().out


def test_input_errors_of_the_computation_exit_with_2(computed, capsys):
    computed.error = InputError("the design to start from is not captured")
    assert run(["tune"]) == 2
    assert capsys.readouterr().err.endswith("error: the design to start from is not captured\n")


def test_an_interrupt_is_one_line_and_exit_code_130(computed, capsys):
    computed.error = KeyboardInterrupt()
    assert run(["simulate"]) == 130
    assert capsys.readouterr().err.splitlines()[1:] == ["interrupted"]


def test_bugs_keep_their_traceback(computed):
    computed.error = ZeroDivisionError()
    with pytest.raises(ZeroDivisionError):
        run(["simulate"])


@pytest.mark.parametrize(
    ("environment", "folder"),
    [
        ({"JAXBUFFER_CACHE": "here", "XDG_CACHE_HOME": "there"}, "here"),
        ({"XDG_CACHE_HOME": "/there"}, os.path.join("/there", "jaxbuffer")),
        ({"HOME": "home"}, os.path.join("home", ".cache", "jaxbuffer")),
        ({"HOME": "/home/me", "XDG_CACHE_HOME": "there"}, "/home/me/.cache/jaxbuffer"),
        ({"HOME": "/home/me", "XDG_CACHE_HOME": "~/kept"}, "/home/me/kept/jaxbuffer"),
        ({"HOME": "/home/me", "JAXBUFFER_CACHE": "~/programs"}, "/home/me/programs"),
    ],
)
def test_where_compiled_programs_are_kept(computed, monkeypatch, environment, folder):
    for name in ("JAXBUFFER_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    run(["simulate"])
    assert str(computed.calls[0][1]["cache"]) == folder


def test_help_shows_examples_and_every_field_with_its_unit(computed, capsys):
    assert run(["--help"]) == 0 and run([]) == 0
    shown = capsys.readouterr().out
    assert shown.count("jaxbuffer tune optimise/table2.toml --output results/table2") == 2
    for command, names in (("simulate", SIMULATED), ("sensitivity", DIFFERENTIATED), ("tune", TUNED)):
        assert run([command, "--help"]) == 0
        shown = capsys.readouterr().out
        assert all(name in shown for name in (*names, "--force", "k_A [N/m]"))


def test_the_fields_in_the_help_are_those_of_design_and_scenario():
    text = fields_text(all_names()[PROBE_CONE.name])
    blocks = dict(re.findall(r"^  (\w+) +(.*(?:\n {12}.*)*)", text, flags=re.MULTILINE))
    listed = {
        f"{section}.{name}": symbol
        for section, block in blocks.items()
        for name, symbol in re.findall(r"(\w+)\s(?:\[(.+?)\]|\([^)]*\))", block)
    }
    design, scenario = Design(), Scenario()
    expected = {path: unit(design, path) for path in paths(design)}
    assert listed == expected | {f"scenario.{path}": unit(scenario, path) for path in paths(scenario)}


def test_version(capsys):
    assert run(["--version"]) == 0
    assert re.fullmatch(r"jaxbuffer \S.*\n", capsys.readouterr().out)


@pytest.mark.long
def test_a_real_capture_from_another_process(tmp_path):
    words = ["simulate", "--output", "out", "--scenario.approach_speed", "0.2"]
    with _started(tmp_path, *words) as process:
        shown, errors = process.communicate(timeout=300)
    assert process.returncode == 0 and "captured" in shown
    assert re.fullmatch(
        r"simulating\ncompiling a run, which usually takes about \d+ s \(first run only\)…\n"
        r"(compiling .*…\n)*a tenth of the tolerance changes .*\n",
        errors,
    )
    record = json.loads((tmp_path / "out" / "capture.json").read_text())
    assert record["outcome"] == "captured" and record["scenario"]["approach_speed"]["value"] == 0.2
    with _started(tmp_path, *words, "--force", JAX_LOG_COMPILES="1") as process:
        again, errors = process.communicate(timeout=300)
    assert process.returncode == 0 and again == shown
    # Every program is found compiled: nothing is traced, however small.
    for step in (r"Finished tracing (\w+)", r"Compiling jit\((\w+)\)"):
        assert re.findall(step, errors) == []
    assert "compiling" not in errors
    with _started(tmp_path, *words) as process:
        shown, errors = process.communicate(timeout=60)
    assert (process.returncode, shown) == (2, "") and "--force overwrites" in errors


@pytest.mark.slow
def test_ctrl_c_ends_a_compilation_at_once(tmp_path):
    # what a shell without job control runs in the background ignores Ctrl-C, and so would what it starts
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    process = _started(tmp_path, "simulate")
    signal.signal(signal.SIGINT, before)
    with process:
        assert process.stderr.readline() == "simulating\n"
        assert process.stderr.readline().startswith("compiling a run, which usually takes about ")
        time.sleep(2.0)  # s, into the compilation, which takes four at the least
        process.send_signal(signal.SIGINT)
        sent = time.monotonic()
        _, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (130, "interrupted\n")
    assert time.monotonic() - sent < 3.0


def test_a_process_ends_with_its_code_and_exit_functions_but_frees_nothing():
    """What Python frees at its end takes as long as a third of a command."""
    code = """if True:
        import atexit, sys
        from jaxbuffer import cli
        from jaxbuffer.cli import entry

        class Freed:
            def __del__(self):
                print("freed")

        def command(arguments):
            atexit.register(print, "exit function")
            print("command", *arguments)
            sys.exit(3)

        kept, entry.main = Freed(), command
        cli.main(["simulate"])
    """
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (3, "command simulate\nexit function\n", "")


def _started(folder, *arguments, **environment) -> subprocess.Popen:
    source = Path(jaxbuffer.__file__).resolve().parents[1]
    return subprocess.Popen(
        [sys.executable, "-c", "from jaxbuffer.cli import main; main()", *arguments],
        cwd=folder,
        env={**os.environ, "JAXBUFFER_CACHE": str(folder / "cache"), "PYTHONPATH": str(source), **environment},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def test_fields_of_every_mechanism(computed, capsys):
    assert run(["fields"]) == 0
    kinds = re.findall(r'^kind = "(\w+)"', capsys.readouterr().out, flags=re.MULTILINE)
    assert set(kinds) == {mechanism.name for mechanism in all_mechanisms()}
    for mechanism in map(registered, kinds):
        assert run(["fields", mechanism.name]) == 0
        shown = capsys.readouterr().out
        fields = [*paths(mechanism.design()), *(f"scenario.{path}" for path in paths(mechanism.scenario()))]
        assert all(f" {name} " in shown for name in (*fields, *mechanism.quantities))


def test_fields_of_no_mechanism(computed, capsys):
    assert run(["fields", "prob_cone"]) == 2
    assert "kind = 'prob_cone' is unknown" in (said := capsys.readouterr().err) and "did you mean probe_cone?" in said


def test_a_tuned_design_is_run_as_long_as_it_was_tuned_and_says_its_objectives_unit(computed, tmp_path):
    (tmp_path / "study.toml").write_text("[options]\nduration = 2\nrtol = 1e-5\n[problem.objective]\nstroke = 1.0\n")
    assert run(["tune", "study.toml", "--output", "out"]) == 0
    written = load(tmp_path / "out" / "design.toml")
    assert (written.options.duration, written.options.rtol) == (2.0, 1e-5)
    assert "# stroke, worst over the cases, before and after: " in (text := (tmp_path / "out/design.toml").read_text())
    assert re.search(r"before and after: \S+ mm, \S+ mm\.\n", text)
    assert run(["simulate", "out/design.toml"]) == 0
    assert computed.asked("simulate")["duration"] == 2.0


def test_an_alarm_about_long_compilations_is_not_printed_unless_asked_for(monkeypatch):
    """XLA logs it as an error, below what is fatal; a choice of the user's stays."""
    for given, expected in ((None, "3"), ("0", "0")):
        monkeypatch.delenv("TF_CPP_MIN_LOG_LEVEL", raising=False)
        if given is not None:
            monkeypatch.setenv("TF_CPP_MIN_LOG_LEVEL", given)
        prepare()
        assert os.environ["TF_CPP_MIN_LOG_LEVEL"] == expected
