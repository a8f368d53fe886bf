"""A table of a study is declared once: reading, schema, example, suggestions and tuned files follow from it."""

import tomllib

import pytest

from jaxbuffer import InputError, Scenario
from jaxbuffer.fields import declared
from jaxbuffer.mechanisms import mechanism_named
from jaxbuffer.study.example import example_toml
from jaxbuffer.study.load import loads
from jaxbuffer.study.model import SampleTable, StudyOptions
from jaxbuffer.study.schema import study_schema
from jaxbuffer.tuning.problem.cases import Scatter
from jaxbuffer.tuning.problem.objective import Limits, Objective, SecondObjective
from jaxbuffer.tuning.problem.settings import Settings

TABLES = {
    "options": StudyOptions,
    "tune": Settings,
    "sample": SampleTable,
    "problem.sample": Scatter,
    "problem.objective": Objective,
    "problem.then": SecondObjective,
    "problem.constraints": Limits,
}
KEYS = [
    (table, name) for table, kind in TABLES.items() for name, known in declared(kind).items() if "table" not in known
]


@pytest.fixture(scope="module")
def schema_and_example():
    mechanism = mechanism_named("probe_cone")
    return study_schema(mechanism), example_toml(mechanism).splitlines()


@pytest.mark.parametrize(("table", "name"), KEYS)
def test_a_key_is_described_checked_and_suggested_wherever_it_is_declared(table, name, schema_and_example):
    known, (schema, example) = declared(TABLES[table])[name], schema_and_example
    for part in table.split("."):
        schema = schema["properties"][part]
    assert schema["properties"][name]["description"].endswith(known["doc"])
    if table != "sample":  # which the example leaves out
        assert any(line.startswith(f"# {name} = ") for line in example)
    with pytest.raises(InputError, match=rf"{table}\.{name}x is unknown; did you mean .*{name}"):
        loads(f"[{table}]\n{name}x = 1".encode(), "study.toml")
    with pytest.raises(InputError, match=rf"{table}\.{name}.* \[\]|{table}\.{name}: '\[\]'"):
        loads(f"[{table}]\n{name} = []".encode(), "study.toml")


@pytest.mark.parametrize(
    ("text", "valid"),
    [
        ("[problem.constraints]\nstroke = '25 mm'\nimpacts = 30", True),
        ("[problem.constraints]\nstrokes = '25 mm'", False),
        ("[problem.objective]\npeak_force = 1\nover = 'mean'", True),
        ("[problem.objective]\npeak_forces = 1", False),
        ("[problem.objective]\neffort = 1\n[problem.quantities]\neffort = {function = 'a.py:f', unit = 'N'}", True),
        ("[problem.then]\nstroke = 1\ntolerance = 0.1", True),
        ("[problem.then]\nstrokee = 1", False),
        ("[problem.sample]\ncount = 8\nfactors.probe.tip_radius = {uniform = [0.9, 1.1]}", True),
        ("[problem.sample]\nfactors.probe.tip_radiuss = {uniform = [0.9, 1.1]}", False),
        ("[problem.sample]\nscenario.approach_speed = {normal = ['0.1 m/s', '1 cm/s']}", True),
    ],
)
def test_an_editor_sees_which_names_there_are(text, valid):
    jsonschema = pytest.importorskip("jsonschema")
    schema = jsonschema.Draft7Validator(study_schema(mechanism_named("probe_cone")))
    assert schema.is_valid(tomllib.loads(text)) is valid


def test_listed_scenarios_begin_with_the_fields_of_scenario_and_not_with_those_of_the_first():
    listed = "[[scenarios]]\napproach_speed = 0.1\nmisalignment = 0.02\n[[scenarios]]\napproach_speed = 0.2\n"
    first, second = Scenario(approach_speed=0.1, misalignment=0.02), Scenario(approach_speed=0.2)
    study = loads(listed.encode(), "study.toml")
    assert (study.scenario, study.scenarios) == (first, (first, second))
    study = loads(f"[scenario]\npassive_rate = 0.01\n{listed}".encode(), "study.toml")
    assert study.scenario == Scenario(passive_rate=0.01)
    assert study.scenarios[1] == Scenario(approach_speed=0.2, passive_rate=0.01)
