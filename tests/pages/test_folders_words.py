"""What `report` and `compare` say of folders that hold too little."""

import pytest

from jaxbuffer.cli.entry import run

DESIGN = "[buffer]\nk_A = 500.0\n"


@pytest.mark.parametrize("command", [["report", "there"], ["compare", "there", "there"]])
@pytest.mark.parametrize(
    ("files", "said"),
    [
        (
            (),
            "simulate STUDY.toml --output FOLDER makes some;"
            " so do sensitivity, sweep, tune, sample, pareto, choose and fit",
        ),
        (
            ("log.jsonl", "state.npz"),
            "there holds an unfinished tuning: the command that began it, with --resume, goes",
        ),
        (
            ("sweep.zarr/checksum/.zarray",),
            "there holds an unfinished sweep or sample: the command that began it, with --resume",
        ),
        (("least-stroke/log.jsonl",), "there holds an unfinished front: the command that began it, with --resume"),
    ],
)
def test_without_results(computed, capsys, tmp_path, command, files, said):
    (tmp_path / "there").mkdir()
    for file in files:
        (tmp_path / "there" / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "there" / file).write_text('{"shape": [3]}' if file.endswith(".zarray") else "")
    assert run(command) == 2
    message = capsys.readouterr().err
    assert said in message and message.count("\n") == 1


def test_an_interrupted_tuning_with_its_best_design_is_noted(computed, capsys, tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "log.jsonl").write_text("")
    (tmp_path / "there" / "design.toml").write_text(DESIGN)
    assert run(["report", "there"]) == 0
    assert "note: there holds an unfinished tuning" in capsys.readouterr().err


@pytest.mark.slow
def test_folders_of_different_commands(computed, no_figures, capsys, tmp_path):
    assert run(["simulate", "--output", "run"]) == 0
    assert run(["tune", "--output", "tuned"]) == 0
    capsys.readouterr()
    assert run(["compare", "run", "tuned"]) == 2
    message = capsys.readouterr().err
    assert "run holds a run, tuned holds a tuning; compare runs with runs or tunings with tunings" in message
    assert "a run is made by jaxbuffer simulate tuned/design.toml --output FOLDER\n" in message
