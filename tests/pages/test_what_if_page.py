"""The sliders of a page: what is shown where they begin, and that the script computes what Python does."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import jaxbuffer.pages
from jaxbuffer.cli.entry import run
from jaxbuffer.output.folder import Results, load
from jaxbuffer.output.tuned_records import tuned_record
from jaxbuffer.pages.review import review
from jaxbuffer.pages.what_if import data, deciding, number, room, what_if
from jaxbuffer.study.load import loads
from made_up import made_up_tuning
from pages.made_what_if import STUDY, made_what_if, quantity
from pages.report_folders import every_kind

SCRIPT = Path(jaxbuffer.pages.__file__).parent / "templates" / "what_if.js"


@pytest.fixture(scope="module")
def found():
    return made_what_if()


@pytest.fixture(scope="module")
def results(found, tmp_path_factory):
    tuned = made_up_tuning(loads(STUDY, "study.toml").problem())
    records = {"tuned": tuned_record(tuned), "what_if": json.loads(json.dumps(found.record()))}
    return Results(tmp_path_factory.mktemp("tuned"), records=records, design=tuned.design)


def rows(results):
    return {(it["quantity"], it["side"]): it for it in data(results.records["what_if"], results)["rows"]}


def test_the_table_at_the_tuned_design(results, found):
    """By hand: the third scenario's values are the largest of forces, strokes and the least of energies."""
    table, middle = rows(results), np.array([0.5, 0.5])
    assert float(table[0, "most"]["text"]) == pytest.approx(quantity("peak_force", 2, middle), rel=5e-3)
    assert table[0, "most"]["where"] == "3: 0.3 m/s, 0°" and table[0, "most"]["room"] == "–"
    stroke = 1e3 * quantity("stroke", 2, middle)
    assert float(table[1, "most"]["text"]) == pytest.approx(stroke, rel=5e-4) and table[1, "most"]["limit_text"] == "25"
    share = (25.0 - stroke) / 25.0
    assert table[1, "most"]["room"] == f"{25.0 - stroke:.3g} ({100.0 * share:.3g} %)"
    assert (3, "most") not in table
    assert float(table[3, "least"]["text"]) == pytest.approx(100.0 * quantity("relative_energy", 2, middle), rel=5e-4)


def test_where_no_model_is_good_there_is_no_number(results, found):
    """The hinge angle of one scenario jumps, by half of its value."""
    assert found.models[1][2].error > 0.1
    line = rows(results)[2, "most"]
    assert line["text"] == "no number: not good to 2 %" and line["where"] == "–"
    assert re.fullmatch(r"at most \d+ % in 20 runs", line["told"])
    (case,) = [it for it in data(results.records["what_if"], results)["cases"] if it["label"].startswith("2: 0.2")]
    assert case["texts"][2] == "not good to 2 %" and case["texts"][1] != "not good to 2 %"


@pytest.mark.parametrize(
    ("side", "values", "errors", "expected"),
    [
        ("most", [1.0, 3.0, 2.0], [0.01] * 3, 1),
        ("least", [1.0, 3.0, 2.0], [0.01] * 3, 0),
        ("most", [1.0, 3.0, 2.0], [0.01, 0.01, 0.2], 1),  # 2 may be 2.5
        ("most", [1.0, 3.0, 2.0], [0.01, 0.01, 0.4], None),  # 2 may be 3.33
        ("least", [1.0, 3.0, 2.0], [0.01, 0.01, 0.4], 0),
        ("most", [1.0, 3.0, 2.0], [0.01, 0.3, 0.01], None),
        ("most", [1.0, 3.0, 0.1], [0.01, 0.01, 0.6], None),
        ("most", [1.0, None, 2.0], [0.01, None, 0.01], None),
        ("most", [-1.0, -3.0, -2.0], [0.01, 0.01, 0.4], 0),
    ],
)
def test_a_scenario_without_a_good_model_is_ruled_out_only_by_its_error(side, values, errors, expected):
    assert deciding(side, values, errors, 0.02) == expected


def test_numbers_have_the_digits_that_their_error_leaves():
    assert [number(308.2417, it) for it in (0.0, 0.001, 0.015)] == ["308.2", "308.2", "308"]
    assert (number(0.00012345, 0.0), number(123456.0, 0.01), number(0.0, 0.0)) == ("0.0001234", "123000", "0")


def test_room_within_the_error_is_none(results):
    table = data(results.records["what_if"], results)["rows"]
    from jaxbuffer.pages.what_if import SliderRow

    row = SliderRow(1, "most", 25.0, 0.01, "", "")
    assert room(row, 24.8) == "within the error" and room(row, 20.0) == "5 (20 %)" and room(row, 30.0) == "-5 (-20 %)"
    assert room(row._replace(side="least"), 30.0) == "5 (20 %)" and table


def test_times_at_which_runs_end_have_no_number_and_failed_runs_none(results):
    assert "No number is shown of end time: a capture's end jumps" in what_if(results).text[2]
    record = json.loads(json.dumps(made_what_if(failing=True).record()))
    record["cases"][2]["succeeded"][0] = False  # of the tuned design itself
    folder = Results(results.folder, records=results.records | {"what_if": record}, design=results.design)
    shown = data(folder.records["what_if"], folder)
    assert {row["text"] for row in shown["rows"]} <= {"–", "no number: not good to 2 %"}
    assert set(shown["cases"][2]["texts"]) == {"–"} and "–" not in shown["cases"][0]["texts"]
    said = what_if(folder).text[3]
    assert "some were not captured" in said and " in scenario 3 (0.3 m/s, 0°)" in said


def test_models_of_another_design_are_not_shown(results):
    moved = dict(results.records["what_if"].items()) | {"variables": {"buffer.free_length": 0.1, "buffer.k_A": 300.0}}
    other = Results(results.folder, records={"tuned": dict(results.records["tuned"].items()), "what_if": moved})
    section = what_if(other)
    assert section.what_if is None and "is of another design than the tuned one" in section.warnings[0]
    assert what_if(Results(results.folder, records={"tuned": dict(results.records["tuned"].items())})) is None


def test_own_quantities_are_shown_and_what_is_held_fixed_is_said(results):
    """A quantity of the study's own, which the mechanism does not know, and a field that samples draw."""
    tuned, record = (dict(results.records[name].items()) for name in ("tuned", "what_if"))
    record["quantities"] = ["peak_force", "work", "hinge_angle", "relative_energy"]
    own = {"work": {"unit": "N m", "function": "work(peak_force, stroke)", "description": ""}}
    ranges = {"scenario.misalignment": ["uniform", -0.1, 0.1], "buffer.c_A": ["uniform", 0.9, 1.1]}
    tuned |= {"quantities": own, "sample": {"count": 3, "seed": 0, "ranges": ranges}}
    section = what_if(Results(results.folder, records={"tuned": tuned, "what_if": record}))
    assert section.what_if["quantities"][1] == {"title": "work", "unit": "N m", "factor": 1.0}
    assert section.text[1] == (
        "Held fixed: every other number of the design, and of the scenarios, each with the misalignment that its sample"
        " drew."
    )


def test_the_page_has_them_and_loads_nothing(results):
    page = review([results]).html()
    assert 'class="what-if"' in page and "class WhatIf" in page
    assert not re.search(r"(src|href)=\"(?!data:|#)", page)
    assert page.count('<input type="range"') == 2 + page.count('class="time"')


@pytest.mark.skipif(shutil.which("node") is None, reason="no node is installed")
def test_the_script_computes_what_python_does(results):
    found = made_what_if(failing=True)
    record = json.loads(json.dumps(found.record()))
    known = data(record, Results(results.folder, records=results.records | {"what_if": record}, design=results.design))
    places = [*np.random.default_rng(6).random((5, 2)).tolist(), [0.82, 0.5], [0.95, 0.5], found.shares[7].tolist()]
    source = SCRIPT.read_text()
    last = source.rindex("document.querySelectorAll")
    told = """
      const ends = WhatIf.prototype.endsWell, self = { data };
      const out = places.map(at => [
        data.cases.map(it => ends.call(self, it, at)),
        data.cases.map(it => it.models.map(model => evaluate(model, data.shares, at))),
        data.cases.map(it => it.models.map(model => number(evaluate(model, data.shares, at), model.error)))]);
      console.log(JSON.stringify(out)); }"""
    program = f"const data = {json.dumps(known)}, places = {json.dumps(places)};\n{source[:last]}{told}"
    done = subprocess.run(["node", "-e", program], capture_output=True, text=True, check=True, timeout=60)
    for place, (ended, values, texts) in zip(places, json.loads(done.stdout), strict=True):
        expected = [[model.at(np.array(place), found.shares) for model in models] for models in found.models]
        both = zip(found.endings, found.succeeded.T, strict=True)
        assert ended == [it.well(np.array(place), found.shares, of) for it, of in both]
        np.testing.assert_allclose(values, expected, rtol=1e-6)  # weights that cancel leave few digits
        errors = [[model.error for model in models] for models in found.models]
        assert texts == [
            [number(v, e) for v, e in zip(*both, strict=True)] for both in zip(expected, errors, strict=True)
        ]


def test_the_command_asks_for_a_tuned_folder_and_says_what_is_wrong(capsys, tmp_path):
    folders = every_kind(tmp_path)
    for words, said in (
        (["report", str(folders["run"]), "--what-if"], "no tuned design in"),
        (["report", str(folders["tuned"]), "--runs", "64"], "--runs are those of --what-if"),
        (["report", str(folders["tuned"]), "--what-if", "--runs", "8"], "--runs 8 must be a whole number from 32 to"),
        (["report", str(folders["tuned"]), "--what-if", "--runs", "many"], "--runs many must be a whole number"),
    ):
        capsys.readouterr()
        assert run(words) == 2
        assert said in capsys.readouterr().err
    assert not (folders["tuned"] / "what_if.json").exists()


def test_the_command_writes_models_and_a_page(monkeypatch, capsys, tmp_path):
    """What is computed is made up; the record says which command made it."""
    from jaxbuffer.cli.commands import report
    from jaxbuffer.pages import what_if as module

    folders = every_kind(tmp_path)
    study = load(folders["tuned"])
    asked = {}

    def made_up(problem, runs, *, progress):
        asked.update(runs=runs, paths=problem.paths)
        progress(5, report.most_runs(problem, runs))
        return made_what_if(("peak_force", "stroke"))

    monkeypatch.setattr(module, "fit_around", made_up)
    assert run(["report", str(folders["tuned"]), "--what-if", "--runs", "64"]) == 0
    assert asked["runs"] == 64 and set(asked["paths"]) == {it["path"] for it in study.tuned["variables"]}
    record = json.loads((folders["tuned"] / "what_if.json").read_text())
    assert record["made"]["command"].endswith("--what-if --runs 64") and record["success"] == "captured"
    # The made-up models are of another design than the made-up tuning's, which the page says.
    assert "is of another design" in (folders["tuned"] / "report.html").read_text()
