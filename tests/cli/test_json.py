"""`--json`: the record on stdout and nothing else there."""

import json

import pytest

from jaxbuffer.cli.entry import run


@pytest.mark.parametrize(
    ("command", "key", "value"),
    [
        ("simulate", "peak_force", {"value": 250.0, "unit": "N"}),
        ("sensitivity", "peak_force", {"value": 250.0, "unit": "N"}),
        ("tune", "feasible", True),
        ("sweep", "runs", None),
    ],
)
def test_stdout_is_the_record(computed, no_figures, capsys, tmp_path, command, key, value):
    assert run([command, "--json", "--output", "out"]) == 0
    shown = capsys.readouterr()
    record = json.loads(shown.out)
    assert record[key] == value if value is not None else len(record[key]) == 121
    assert "note: wrote out" in shown.err
    name = {"simulate": "capture", "tune": "tuned"}.get(command, command)
    if command != "sweep":
        assert record == json.loads((tmp_path / "out" / f"{name}.json").read_text())


def test_a_broken_limit_leaves_the_record_on_stdout(computed, capsys, tmp_path):
    (tmp_path / "study.toml").write_text("[problem.constraints]\nstroke = '5 mm'")
    assert run(["simulate", "study.toml", "--json"]) == 1
    shown = capsys.readouterr()
    assert json.loads(shown.out)["stroke"]["value"] == 0.0075 and "not kept: stroke" in shown.err
