"""What a careless hand may type in a study, a command line or Python: one line says what is wrong, what allowed."""

import pytest
from bad_calls import PYTHON
from bad_docking import DOCKING
from bad_fields import CHOICES, FIELDS, of_fields
from bad_lines import LINES
from bad_studies import STUDIES
from bad_tanks import CHOICES as TANK_CHOICES
from bad_tanks import FIELDS as TANK_FIELDS
from bad_tanks import TANKS

from jaxbuffer import InputError, Scenario, TankDrop, TankDropScenario, table2
from jaxbuffer.cli.entry import run
from jaxbuffer.fields import paths, unit

BAD = [*of_fields(), *STUDIES, *LINES, *PYTHON, *TANKS, *DOCKING]


@pytest.mark.parametrize("asked", BAD, ids=lambda asked: repr(asked)[:60].replace("\n", " "))
def test_bad_input_is_one_line_that_says_what_and_what_would_do(computed, capsys, tmp_path, asked):
    if asked.call is None:
        (tmp_path / "study.toml").write_text(asked.study)
        assert run(asked.words) == 2
        shown = capsys.readouterr()
        assert shown.out == "" and shown.err.startswith("error: ") and shown.err.count("\n") == 1
        message = shown.err
        assert [path.name for path in tmp_path.rglob("*")] == ["study.toml"], "nothing is written"
    else:
        with pytest.raises(InputError) as caught:
            asked.call()
        message = str(caught.value)
        assert "\n" not in message
    assert len(message) < 500
    for part in asked.parts:
        assert part in message
    assert all(name == "configure" for name, _ in computed.calls), "nothing is computed"


@pytest.mark.parametrize(
    ("design", "scenario", "fields", "choices"),
    [(table2(), Scenario(), FIELDS, CHOICES), (TankDrop(), TankDropScenario(), TANK_FIELDS, TANK_CHOICES)],
    ids=["probe_cone", "tank_drop"],
)
def test_two_hundred_bad_inputs_and_every_field(design, scenario, fields, choices):
    assert len(BAD) >= 200
    numbers = {path: unit(design, path) for path in paths(design)}
    numbers |= {f"scenario.{path}": unit(scenario, path) for path in paths(scenario)}
    assert {path for path, symbol in numbers.items() if symbol} == set(fields)
    assert {path for path, symbol in numbers.items() if not symbol} == set(choices)
