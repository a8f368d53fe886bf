"""`jaxbuffer tune`, interrupted: the best design so far is saved, and the same command goes on."""

import tomllib

import pytest

import jaxbuffer.programs.process
from jaxbuffer.cli.entry import run
from jaxbuffer.study.load import load
from jaxbuffer.tuning import tune as module
from tuning.analytic import Functions, shifted
from tuning.test_search import CB2, SHIFT

STUDY = f"""
[buffer]
k_A = {SHIFT + 1}
c_A = {SHIFT - 0.1}
[scenario]
approach_speed = 0.1
[tune]
starts = 2
searches = 1
iterations = 3
[problem.variables]
buffer.k_A = [{SHIFT - 5}, {SHIFT + 5}, "linear"]
buffer.c_A = [{SHIFT - 5}, {SHIFT + 5}, "linear"]
"""


@pytest.fixture
def tune(monkeypatch, tmp_path):
    """The command on functions instead of captures, ended after some batches by an interrupt."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text(STUDY)
    monkeypatch.setattr(jaxbuffer.programs.process, "configure", lambda **_: None)
    monkeypatch.setattr(
        "jaxbuffer.cli.commands.tune.tuned_files", lambda *_: {"design.toml": lambda: "", "tuned.json": lambda: ""}
    )
    monkeypatch.setattr("jaxbuffer.tuning.report.tuned.Tuned.__repr__", lambda tuned: tuned.message)
    monkeypatch.setattr("jaxbuffer.tuning.assessment.lower_bound", lambda *_: None)

    def call(*words, dies_after=None):
        def evaluator(problem, workers, *_):
            functions = Functions(problem, [shifted(CB2, SHIFT)])
            functions.dies_after = dies_after
            return functions

        monkeypatch.setattr(module, "Evaluator", evaluator)
        return run(["tune", "study.toml", *words])

    return call


def test_the_best_so_far_is_saved(tune, capsys, tmp_path):
    assert tune("--output", "out", dies_after=3) == 130
    shown = capsys.readouterr()
    (first, wrote) = shown.out.splitlines()
    assert first.startswith("interrupted after 4 evaluations; best so far by the objective: ")
    assert first.endswith(" N, within all limits") and wrote == "wrote out/design.toml"
    last = shown.err.splitlines()[-2:]
    assert last == ["note: the same command with --resume goes on in out", "interrupted"]
    text = (tmp_path / "out" / "design.toml").read_text()
    assert text.startswith(f"# {first}\n")
    x = [getattr(load(tmp_path / "out" / "design.toml").design.buffer, name) - SHIFT for name in ("k_A", "c_A")]
    assert max(f(x) for f in CB2) == pytest.approx(float(first.split()[-5]), rel=1e-5), "the objective it claims"
    assert tomllib.loads(text)["scenarios"] == [tomllib.loads(text)["scenarios"][0]]
    assert tune("--output", "out", "--resume") == 0
    resumed = (tmp_path / "out" / "log.jsonl").read_bytes()
    assert tune("--output", "whole") == 0 and (tmp_path / "whole" / "log.jsonl").read_bytes() == resumed


def test_the_best_so_far_says_which_limit_it_breaks(tune, capsys, tmp_path):
    study = tmp_path / "study.toml"
    study.write_text(f"{study.read_text()}[problem.constraints]\npeak_force = 0.5\n")
    assert tune("--output", "out", dies_after=3) == 130
    first, _ = capsys.readouterr().out.splitlines()
    assert "; best so far by the objective and limits: " in first
    assert ", limits broken: peak_force " in first and " is above 0.5 N by " in first


def test_before_the_first_step_there_is_nothing_to_save(tune, capsys, tmp_path):
    assert tune("--output", "out", dies_after=0) == 130
    shown = capsys.readouterr()
    assert shown.out == "" and "no step was finished; the same command with --resume goes on in out" in shown.err
    assert not (tmp_path / "out" / "design.toml").exists()
    assert tune("--output", "out", "--resume") == 0


def test_without_a_folder_it_says_what_would_have_kept_it(tune, capsys):
    assert tune(dies_after=3) == 130
    assert "nothing is kept without --output DIR" in capsys.readouterr().err


@pytest.mark.parametrize("content", [b"", b"garbage"])
def test_a_folder_that_can_not_be_resumed_is_one_line(tune, capsys, tmp_path, content):
    (tmp_path / "out").mkdir()
    for name in ("log.jsonl", "state.npz"):
        (tmp_path / "out" / name).write_bytes(content)
    assert tune("--output", "out", "--resume") == 2
    (error,) = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error")]
    assert "out: the run cannot be resumed: state.npz is damaged, state.old.npz is missing" in error
    assert {file.name: file.read_bytes() for file in (tmp_path / "out").iterdir()} == {
        "log.jsonl": content,
        "state.npz": content,
    }
