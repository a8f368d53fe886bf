"""Own quantities in a study: a Python file beside it, which commands run that need it and no others."""

import json

import pytest

from jaxbuffer import Limits, Objective
from jaxbuffer.cli.entry import run
from jaxbuffer.study.load import load
from jaxbuffer.study.schema import study_schema

STUDY = """
[problem.variables]
buffer.k_A = [100, 2000]
[problem.quantities]
effort = {function = "objectives.py:effort", unit = "N m", description = "force times stroke"}
[problem.objective]
effort = 2.0
[problem.constraints]
stroke = 0.1
effort = "9 N m"
"""
PYTHON = """
def effort(peak_force, stroke):
    return peak_force * stroke
"""


@pytest.fixture
def study(tmp_path):
    """Writes a study and its Python file to a folder of their own."""

    def written(python=PYTHON, text=STUDY):
        folder = tmp_path / "studies"
        folder.mkdir(exist_ok=True)
        (folder / "study.toml").write_text(text)
        if python is not None:
            (folder / "objectives.py").write_text(python)
        return str(folder / "study.toml")

    return written


def test_the_problem_of_a_study(study):
    problem = load(study()).problem()
    assert problem.objective == Objective({"effort": 2.0})
    assert problem.limits == Limits(at_most={"stroke": 0.1, "effort": 9.0})
    own = problem.quantities["effort"]
    assert (own.unit, own.description, own.signature) == ("N m", "force times stroke", "effort(peak_force, stroke)")
    assert float(own.value([200.0, 0.01])) == 2.0


def test_check_says_what_it_is(computed, study, capsys):
    assert run(["check", study()]) == 0
    shown = capsys.readouterr().out
    assert "effort [N m] = effort(peak_force, stroke)" in shown and "effort ≤ 9 N m" in shown


@pytest.mark.parametrize(("limit", "code"), [("9 N m", 0), ("1 N m", 1)])
def test_a_run_is_held_against_limits_on_it(computed, study, capsys, limit, code):
    """A made-up capture of 250 N and 7.5 mm."""
    assert run(["simulate", study(text=STUDY.replace("9 N m", limit))]) == code
    said = "" if code == 0 else "error: [problem.constraints] not kept: effort 1.875 N m is above 1 N m\n"
    assert capsys.readouterr().err == f"simulating\na tenth of the tolerance changes no number\n{said}"


@pytest.mark.slow
def test_a_tuning_and_its_files(computed, study, tmp_path):
    assert run(["tune", study(), "--output", "out"]) == 0
    assert computed.asked("tune")["problem"].names[-1] == "effort"
    told = json.loads((tmp_path / "out" / "tuned.json").read_text())
    assert told["quantities"]["effort"]["function"] == "effort(peak_force, stroke)"
    assert told["limits"]["effort"] == 9.0 and told["scenarios"][0]["after"]["effort"]["unit"] == "N m"
    assert "worst effort [N m]" in (tmp_path / "out" / "history.csv").read_text()
    assert run(["report", "out"]) == 0
    assert {path.name for path in (tmp_path / "studies").iterdir()} == {"study.toml", "objectives.py"}


BAD = [
    (None, "objectives.py: no such file"),
    ("def efort(peak_force):\n    return peak_force", "has no function effort; did you mean efort?"),
    ("", "objectives.py has no function effort; it has none"),
    ("effort = 3", "custom quantity's function = 3 is not a function"),
    ("def effort(peak_force)\n    return 1", "objectives.py, line 1: expected ':'"),
    ("x = 1\ny = x / 0", "objectives.py, line 2, raises ZeroDivisionError: division by zero"),
    ("raise SystemExit(7)", "objectives.py, line 1, raises SystemExit: 7"),
    ("import no_such_module", "raises ModuleNotFoundError: No module named 'no_such_module'"),
    ("def effort(peak_forc):\n    return peak_forc", "asks for peak_forc, which is unknown; did you mean peak_force?"),
    ("def effort(stroke):\n    return {}[1]", "effort: function effort raises KeyError: 1 in line 2"),
    ("import math\ndef effort(stroke):\n    return math.sqrt(stroke)", "takes a number out of JAX in line 3"),
    ("\0", "objectives.py"),
]


@pytest.mark.parametrize("command", ["check", "tune", "simulate", "pareto"])
@pytest.mark.parametrize(("python", "said"), BAD, ids=[said for _, said in BAD])
def test_a_bad_file_is_one_line(computed, study, capsys, command, python, said):
    options = ["--objectives", "effort,stroke"] if command == "pareto" else []
    assert run([command, study(python), *options]) == 2
    shown = capsys.readouterr()
    assert shown.out == "" and shown.err.startswith("error: ") and shown.err.count("\n") == 1
    assert said in shown.err and "problem.quantities.effort" in shown.err
    assert all(name == "configure" for name, _ in computed.calls), "nothing is computed"


def test_no_file_is_run_for_commands_that_do_not_need_it(computed, study, capsys):
    text = STUDY.replace('effort = "9 N m"', "")
    assert run(["simulate", study("raise SystemExit(7)", text)]) == 0
    assert run(["sensitivity", study("raise SystemExit(7)", text)]) == 0


def test_the_schema_knows_them(study):
    jsonschema = pytest.importorskip("jsonschema")
    import tomllib

    schema = study_schema(load(study()).mechanism)
    jsonschema.validate(tomllib.loads(STUDY), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(tomllib.loads(STUDY.replace("objectives.py:effort", "effort")), schema)
