"""`jaxbuffer init`, `check` and `schema`."""

import functools
import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest
from jsonschema import Draft7Validator

import jaxbuffer
from in_short import quick
from jaxbuffer.cli.entry import run
from jaxbuffer.fields import get, meaning, metadata, paths, replace
from jaxbuffer.fitting.quantities import recorded_quantities
from jaxbuffer.mechanisms import all_mechanisms, mechanism_named, registry
from jaxbuffer.study.example import example_toml
from jaxbuffer.study.load import load, loads
from jaxbuffer.study.schema import study_schema

SCATTER = """[problem.sample]
count = 24
[problem.sample.scenario]
approach_speed = {normal = ["10 cm/s", "1 cm/s"]}
[problem.sample.factors]
"""


@functools.cache
def example(kind: str) -> str:
    return example_toml(mechanism_named(kind))


KINDS = [mechanism.name for mechanism in all_mechanisms()]
# The longest example by far: `make test` has it once.
each_kind = pytest.mark.parametrize("kind", quick(KINDS, *(kind for kind in KINDS if kind != "docking3d")))


@pytest.mark.parametrize("kind", KINDS)
def test_an_example_loads_to_the_defaults_and_has_every_field(kind, computed, capsys):
    assert run(["init", "--kind", kind, "mine.toml"]) == 0
    study, mechanism = load("mine.toml"), mechanism_named(kind)
    design = replace(mechanism.design(), mechanism.defaults.example)
    assert (study.design, study.scenario) == (design, mechanism.scenario())
    limits = {**mechanism.defaults.limits, **mechanism.defaults.example_limits}
    assert study.problem().limits.at_most == limits and study.sweep
    text = example(kind)
    assert max(map(len, text.splitlines())) <= 120
    for part in (mechanism.design(), mechanism.scenario()):
        for path in paths(part):
            assert re.search(rf"^(# )?{path.rpartition('.')[2]} = ", text, re.MULTILINE), path
            assert metadata(part, path).get("unit", "-") in text
    assert run(["check", "mine.toml"]) == 0


@each_kind
def test_the_defaults_in_the_comments_are_the_defaults(kind):
    """Every commented field with a value, made to hold, leaves the study as it is."""
    mechanism = mechanism_named(kind)
    text = re.sub(r"^# (\w+ = [^\s].*)$", r"\1", example(kind).split("[problem")[0], flags=re.MULTILINE)
    study = loads(text.encode(), "example")
    design = replace(mechanism.design(), mechanism.defaults.example)
    for part, default in ((study.design, design), (study.scenario, mechanism.scenario())):
        for path in paths(part):
            assert get(part, path) == get(default, path)


def test_an_example_is_never_written_over_a_file(computed, capsys, tmp_path):
    (tmp_path / "study.toml").write_text("mine")
    assert run(["init"]) == 2
    assert capsys.readouterr().err == "error: study.toml exists; --force overwrites, another FILE keeps it\n"
    assert (tmp_path / "study.toml").read_text() == "mine"
    assert run(["init", "--force"]) == 0 and load("study.toml").design
    assert run(["init", "--kind", "bar_dropp", "x.toml"]) == 2
    assert "did you mean bar_drop?" in capsys.readouterr().err


def test_default_bounds_that_do_not_hold_the_start_are_said_not_refused(computed, capsys, tmp_path):
    """As of a design that was tuned within other bounds: bounds of its own are what tuning it again needs."""
    (tmp_path / "tuned.toml").write_text("[buffer]\nk_T = 10.77\n[problem.constraints]\nstroke = 0.02\n")
    assert run(["check", "tuned.toml"]) == 0
    shown = capsys.readouterr().out
    assert (
        "buffer.k_T = 10.77 N m/rad is outside the default bounds [50, 1500]: tune needs [problem.variables]" in shown
    )
    assert "stroke ≤ 20 mm" in shown and "needs [problem.variables] first" in shown
    assert run(["tune", "tuned.toml"]) == 2
    assert "default bounds [50, 1500] N m/rad; give bounds in [problem.variables]" in capsys.readouterr().err
    (tmp_path / "bounded.toml").write_text("[problem.variables]\nbuffer.k_A = [600, 2000]\n")
    assert run(["check", "bounded.toml"]) == 2
    told = capsys.readouterr().err
    assert told.endswith("[600, 2000] N/m; widen the bounds in [problem.variables] or change the start\n")


def test_a_study_is_explained(computed, capsys, tmp_path):
    (tmp_path / "study.toml").write_text(
        """
        buffer.k_A = "0.8 kN/m"
        active.mass = "42 g"
        passive.mass = 8000
        cone.half_angle = "45 deg"
        probe.length = 0.2
        latch.depth = "5 mm"
        tune.seed = 0
        tune.starts = 8
        options.duration = 4
        scenario.misalignment = "3 deg"
        [problem.variables]
        buffer.c_A = [1, 60]
        [problem.constraints]
        stroke = {min = "0.001 m", max = "25 mm"}
        [problem.grid]
        approach_speed = [0.1, 0.2]
        [problem.then]
        stroke = 1.0
        tolerance = 0.05
        [sweep]
        buffer.k_A = [100, 200]
        buffer.c_A = {from = 1, to = 9, count = 8}
        [sample]
        count = 32
        ranges.probe.tip_radius = ["14 mm", "16 mm"]
        """
    )
    assert run(["check", "study.toml"]) == 0
    shown = capsys.readouterr().out
    for line in (
        "Study study.toml: valid",
        "buffer.k_A 0.8 kN/m = 800 N/m (default 500 N/m)",
        "active.mass 42 g = 0.042 kg (1/523.1 of the default 21.9706 kg)",
        "passive.mass 8000 kg (339.4 times the default 23.5731 kg)",
        "options.duration 4 s (default 8 s)",
        "scenario.misalignment 3 deg = 0.0523599 rad (default 0 rad)",
        "tune.starts 8 (default 32)",
        "given as by default    probe.length 0.2 m",
        "cone.half_angle 45 deg = 0.785398 rad",
        "tune.seed 0",
        "latch.depth = 5 mm has no effect: it needs latch.stiffness",
        "probe.tip_radius 14 … 16 mm",
        "32 points, seed 0",
        "buffer.c_A in [1, 60] N s/m, log, from 5 N s/m",
        "stroke ≤ 25 mm",
        "stroke ≥ 1 mm",
        "every load case must end captured",
        "buffer.k_A 100, 200 N/m",
        "buffer.c_A 1 to 9 N s/m, 8 values, linear",
        "then                   stroke, worst over the cases, among those within 5 % of the least objective",
        "scenarios              1: 0.1 m/s, +3°",
        "                       2: 0.2 m/s, +3°",
        "one capture: 0.1 m/s, +3°",
        "2 × 8 = 16 captures",
        "1 variables over 2 scenarios",
    ):
        assert line in shown, line


@each_kind
def test_the_example_of_parts_roundings_and_a_fit_can_be_taken(kind):
    mechanism = mechanism_named(kind)
    text = example(kind)
    taken = re.sub(r"^# (?!#)", "", text[text.index("# [parts.") :], flags=re.MULTILINE).replace("## ", "# ")
    study = loads(f'kind = "{kind}"\n{taken}'.encode(), "example")
    (catalogue,), path = study.parts, mechanism.defaults.parameters[0]
    assert [part.name for part in catalogue.parts] == ["P1", "P2"] and catalogue.paths == (path,)
    assert study.roundings == {path: "E24"}
    if mechanism.stepper is None:
        assert [*study.fit.parameters] == [path]
        (test,) = study.fit.tests
        ((heading, channel),) = test.channels.items()
        unit = recorded_quantities(mechanism.design())[channel.quantity]
        assert heading == f"{channel.quantity} [{unit}]"


FIT = """\
buffer.k_A = "0.7 kN/m"
[fit.parameters]
buffer.k_A = ["100 N/m", "3 kN/m"]
[[fit.tests]]
file = "test.csv"
scenario.approach_speed = 0.13
time_shift = ["0 ms", "30 ms"]
[fit.tests.columns]
"stroke [mm]" = {quantity = "stroke", noise = "0.02 mm", gain = [0.9, 1.1]}
"""


def test_check_says_what_is_fitted_to_what(computed, capsys):
    Path("study.toml").write_text(FIT)
    Path("test.csv").write_text("time [s],stroke [mm]\n" + "".join(f"{0.01 * k:.2f},{k}\n" for k in range(12)))
    assert run(["check", "study.toml"]) == 0
    shown = capsys.readouterr().out
    for line in (
        "fit                    buffer.k_A in [100, 3000] N/m, log, from 700 N/m",
        "test.csv: 12 rows from 0 to 0.11 s",
        "  stroke [mm] is stroke, noise 0.02 mm",
        "  time_shift in [0, 0.03] s, unknown",
        "  stroke [mm]: gain in [0.9, 1.1], unknown",
        "jaxbuffer fit study.toml          1 numbers from 1 test",
    ):
        assert line in shown, (line, shown)
    Path("study.toml").write_text(FIT.replace('quantity = "stroke"', 'quantity = "strok"'))
    assert run(["check", "study.toml"]) == 2
    assert 'column "stroke [mm]": quantity strok is unknown; did you mean stroke?' in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[bufer]\nk_A = 1", "study.toml: [bufer] is unknown; did you mean buffer?"),
        ("[problem.variables]\nbuffer.k_A = [600, 2000]", "study.toml: the start, buffer.k_A = 500 N/m, is outside"),
        ("[problem.constraints]\nstrok = 1", "study.toml: problem.constraints.strok is unknown; did you mean stroke?"),
    ],
)
def test_what_is_wrong_with_a_study_is_one_line(computed, capsys, tmp_path, text, message):
    (tmp_path / "study.toml").write_text(text)
    assert run(["check", "study.toml"]) == 2
    shown = capsys.readouterr()
    assert shown.out == "" and shown.err.startswith(f"error: {message}") and shown.err.count("\n") == 1


@functools.cache
def validator(kind: str) -> Draft7Validator:
    """Of the schema of a mechanism's studies, which is one itself; that takes half a second to check."""
    schema = study_schema(mechanism_named(kind))
    Draft7Validator.check_schema(schema)
    return Draft7Validator(schema)


@each_kind
def test_the_schema_takes_examples_and_refuses_mistakes(kind, capsys):
    assert run(["schema", "--kind", kind]) == 0
    mechanism = mechanism_named(kind)
    schema = json.loads(capsys.readouterr().out)
    assert schema == json.loads(json.dumps(study_schema(mechanism)))
    described = validator(kind).is_valid
    assert described(tomllib.loads(example(kind)))
    field = next(path for path in paths(mechanism.design()) if "limits" in metadata(mechanism.design(), path))
    section, name = field.split(".")
    assert described({section: {name: "2 kg"}}) and described({section: {name: 2.0}})
    for wrong in ({section: {name: -1.0}}, {section: {name: True}}, {section: {f"{name}x": 1.0}}, {"fizz": {}}):
        assert not described(wrong), wrong


def test_the_schema_knows_samples_and_choices_that_are_swept():
    described = validator("probe_cone").is_valid
    for text, right in (
        ('[sample]\ncount = 64\nmethod = "sobol"\n[sample.ranges]\nbuffer.k_A = ["200 N/m", "2 kN/m", "log"]', True),
        ("[sample.ranges]\nbuffer.k_A = [200]", False),
        ('[sample]\nmethod = "random"', False),
        ('[sweep]\nbuffer.damping = ["physical", "published"]', True),
        ('[sweep]\nbuffer.damping = ["fysical"]', False),
        (f"{SCATTER}buffer.k_A = {{uniform = [0.9, 1.1]}}", True),
        (f"{SCATTER}buffer.k_A = {{uniform = [0.9]}}", False),
        (f"{SCATTER}buffer.k_B = {{uniform = [0.9, 1.1]}}", False),
        (f"{SCATTER}buffer.k_A = {{triangle = [0.9, 1.1]}}", False),
        ("[problem.sample]\ncount = 2.5", False),
        ("[problem.sample]\ncuont = 2", False),
    ):
        assert described(tomllib.loads(text)) is right, text


@each_kind
def test_the_example_shows_how_designs_scatter(kind, tmp_path):
    """The lines of [problem.sample], made to hold, are a study with so many cases, which its schema takes too."""
    text = example(kind).split("[tune]")[1].partition("\n\n")[2]
    shown = r"^# (\[problem\.sample.*\].*|count = .*|seed = .*|.* = \{uniform.*)$"
    text = re.sub(shown, r"\1", text, flags=re.MULTILINE)
    text = f'kind = "{kind}"\n{text}'
    assert len(loads(text.encode(), "example").problem().cases) == 24
    assert validator(kind).is_valid(tomllib.loads(text))


@pytest.mark.parametrize("word", ["robust", "tolerance", "monte carlo"])
def test_a_search_of_the_docs_finds_how_designs_scatter(word):
    """In a heading, which a search ranks first, of a page that shows the section; and in the example of a study."""
    found = [
        page.name
        for page in (Path(__file__).parents[2] / "docs").glob("*.md")
        if re.search(rf"^#.*{word}", text := page.read_text(encoding="utf-8"), re.MULTILINE | re.IGNORECASE)
        and "[problem.sample]" in text
    ]
    assert found == ["robust.md"]
    shown = example("bar_drop").lower()
    assert word in "".join(re.findall(r".*problem\.sample.*", shown)) and "# [tolerances]" in shown


@each_kind
def test_each_field_has_a_meaning_that_is_listed(kind, capsys):
    """One of its own: more than its name, and where two fields have the same words a section tells them apart."""
    mechanism = mechanism_named(kind)
    assert run(["fields", kind]) == 0
    listed = " ".join(capsys.readouterr().out.split())
    for part in (mechanism.design(), mechanism.scenario()):
        for path in paths(part):
            said, name = meaning(part, path), path.rpartition(".")[2]
            assert metadata(part, path)["doc"] == said and len(said.split()) > 1, path
            assert said.lower() not in (name.lower(), name.replace("_", " ").lower()), path
            assert all(word in listed for word in said.split()), path


def test_meanings_are_declared_with_the_fields():
    crank = mechanism_named("slider_crank").design()
    capture = mechanism_named("probe_cone").design()
    assert meaning(crank, "crank.length") == "length from the shaft to the crank pin"
    assert meaning(capture, "buffer.k_A") == "stiffness along the cylinder"
    assert meaning(capture, "buffer.c_T") == "damping about the hinge"
    assert meaning(capture, "probe.free_tip") == "whether the tip spins freely about its centre"
    assert meaning(capture, "active.mass") == "mass m_S of the active vehicle"


def test_a_shell_completes_commands(tmp_path):
    source = str(Path(jaxbuffer.__file__).parents[1])
    asked = {"_JAXBUFFER_COMPLETE": "complete_bash", "COMP_WORDS": "jaxbuffer si", "COMP_CWORD": "1"}
    code = "from jaxbuffer.cli import main; main([])"
    environment = {**os.environ, **asked, "PYTHONPATH": source}
    shown = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert shown.stdout.split() == ["simulate", "size"]


def test_a_mechanism_of_ones_own_to_begin_with_runs_as_it_is(computed, capsys, monkeypatch):
    assert run(["init", "--own", "soft_gripper"]) == 0
    assert capsys.readouterr().out == "wrote soft_gripper.py; 'python soft_gripper.py' runs it\n"
    assert run(["init", "--own", "soft_gripper"]) == 2
    assert "soft_gripper.py exists; --force overwrites" in capsys.readouterr().err
    monkeypatch.setattr(registry, "_BY_DESIGN", dict(registry._BY_DESIGN))
    made = ModuleType("soft_gripper")
    monkeypatch.setitem(sys.modules, made.__name__, made)
    exec(compile(Path("soft_gripper.py").read_text(), "soft_gripper.py", "exec"), vars(made))
    assert made.SOFT_GRIPPER.name == "soft_gripper"
    stroke = float(jaxbuffer.simulate(made.SoftGripper(), made.SoftGripperScenario()).quantity("stroke"))
    # Below what the thrust's energy does to the spring alone, and beyond the end stop's beginning.
    assert 0.03 < stroke < 2.0 * 8.0 / 200.0


@pytest.mark.parametrize(
    ("name", "told"),
    [("2nd", "not a name of a Python module"), ("Gripper", "take small letters"), ("bar_drop", "there is a mechanism")],
)
def test_names_that_no_mechanism_can_have_are_refused(name, told, computed, capsys):
    assert run(["init", "--own", name]) == 2
    assert told in capsys.readouterr().err
    assert run(["init", "--own", "gripper", "--kind", "bar_drop"]) == 2
    assert "give one of them" in capsys.readouterr().err
