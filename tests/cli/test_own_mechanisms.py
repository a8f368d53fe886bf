"""Every command on mechanisms that have only what they declare: the documents' examples, one without a contact, and a
rig with one whose quantities have neither a time of the peak nor a penetration."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.mechanisms import mechanism_named
from own_mechanisms import PENDULUM, RIG, SLED, defined
from registration import registered

STUDY = """kind = "{kind}"
[problem.variables]
{number} = [{low}, {high}]
[problem.constraints]
{main} = 1e6
[tune]
starts = 1
iterations = 4
"""
PARTS = """kind = "{kind}"
[parts.one]
low = {{{number} = {low}}}
high = {{{number} = {high}}}
"""
FIT = """kind = "{kind}"
[fit.parameters]
{fitted} = [{least}, {most}]
[[fit.tests]]
file = "test.csv"
[fit.tests.columns]
"{measured} [m]" = {{quantity = "{quantity}", noise = "1 um"}}
"""


@pytest.fixture(scope="module", params=[SLED, PENDULUM, RIG], ids=lambda tried: tried.name)
def tried(request, tmp_path_factory):
    """A mechanism, known to these tests alone, and a folder with studies of it, in which commands are run."""
    tried, folder = request.param, tmp_path_factory.mktemp(request.param.name)
    with registered(defined(tried.name, folder)), pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        words = {"kind": tried.name, "number": tried.number, "low": tried.ends[0], "high": tried.ends[1]}
        words |= {"main": tried.main, "fitted": tried.fitted, "measured": tried.measured}
        words |= {"least": 0.8 * tried.value, "most": 1.25 * tried.value}
        words["quantity"] = tried.measured.replace(" ", "_")
        for name, text in {"study": STUDY, "parts": PARTS, "fit": FIT}.items():
            (folder / f"{name}.toml").write_text(text.format(**words))
        yield tried


def table(file):
    """The columns of a CSV file by heading."""
    with Path(file).open() as lines:
        header, *rows = csv.reader(lines)
    return {name: [row[k] for row in rows] for k, name in enumerate(header)}


def numbers(file, name):
    """A column of a CSV file, by its name without the unit."""
    (column,) = (column for heading, column in table(file).items() if heading.split(" [")[0] == name)
    return np.array(column, float)


def record(file):
    return json.loads(Path(file).read_text())


def over(tried, count):
    """Options that vary so many numbers between two values each."""
    ends = {tried.number: tried.ends, **tried.others}
    return [word for path, (low, high) in [*ends.items()][:count] for word in ("--over", f"{path}={low}:{high}:2")]


def test_a_study_is_written_and_explained(tried, capsys):
    assert run(["init", "example.toml", "--kind", tried.name]) == 0
    assert run(["check", "example.toml"]) == 0 and run(["check", "study.toml"]) == 0
    assert run(["fields", tried.name]) == 0 and run(["schema", "--kind", tried.name]) == 0
    said = capsys.readouterr().out + Path("example.toml").read_text()
    assert f"{tried.main}, worst over the cases" in said
    for foreign in {"peak_force", "peak_time", "penetration"} - set(mechanism_named(tried.name).quantities):
        # An impact of any mechanism has a peak force; a quantity of that name has the rig not.
        assert foreign not in said


@pytest.mark.long
def test_a_run_is_saved_differentiated_and_filmed(tried, capsys):
    assert run(["simulate", "study.toml", "--output", "run"]) == 0
    files = {file.name for file in Path("run").iterdir()}
    assert {"run.json", "run.png", "run.nc", "run.mat", "history.csv", "motion.png", "motion.json"} <= files
    assert run(["sensitivity", "study.toml", "--wrt", tried.number, "--output", "derived"]) == 0
    (row, *_) = record("derived/sensitivity.json")["derivatives"]
    assert row["quantity"] == tried.main
    elasticity = row["elasticity"]["value"]
    assert elasticity < 0.0 if tried.exponent is None else elasticity == pytest.approx(0.4, rel=1e-3)
    assert run(["animate", "study.toml", "--duration", "0.01", "--output", "film"]) == 0
    capsys.readouterr()
    assert run(["report", "run", "derived", "--html", "run.html"]) == 0
    said = capsys.readouterr().out
    assert tried.main.replace("_", " ") in said
    assert ("contact force" in said) == (tried is not SLED)


@pytest.mark.long
def test_pictures_show_what_happens(tried):
    known = mechanism_named(tried.name)
    drawn = jb.draw(jb.simulate(known.design(), known.scenario(), history=True))
    titles = " ".join(axes.get_title(loc="left") for axes in drawn.axes)
    happens = ("latch closed", "end stop pressed most") if tried is SLED else ("no contact", " N")
    assert all(words in titles for words in happens)
    legend = {text.get_text() for box in drawn.legends for text in box.get_texts()}
    assert legend >= ({"end stop", "plane of the latch"} if tried is SLED else {"hinge"})


@pytest.mark.long
def test_many_runs_are_drawn_and_summarised(tried, capsys):
    for count in (1, 2, 3):
        assert run(["sweep", "study.toml", *over(tried, count), "--output", f"sweep{count}"]) == 0
    low, high = numbers("sweep1/sweep.csv", tried.main)
    ratio = tried.ends[1] / tried.ends[0]
    assert high < low if tried.exponent is None else high / low == pytest.approx(ratio**tried.exponent, rel=1e-4)
    ranges = [word.removesuffix(":2") for word in over(tried, 2)]
    assert run(["sample", "study.toml", *ranges, "--count", "16", "--indices", "--surface", "--output", "sample"]) == 0
    assert set(table("sample/indices.csv")["quantity"]) == {tried.main}
    said = capsys.readouterr().out
    assert f"greatest {tried.main.replace('_', ' ')}" in said
    assert run(["report", "sweep1", "sweep2", "sweep3", "sample", "--html", "many.html"]) == 0


@pytest.mark.long
def test_the_main_quantity_is_lowered_where_nothing_is_said(tried, capsys):
    assert run(["tune", "study.toml", "--output", "tuned"]) == 0
    best = tried.ends[1] if tried.exponent is None else tried.ends[0]
    tuned = record("tuned/tuned.json")
    assert tuned["objective"] == f"{tried.main}, worst over the cases"
    assert tuned["variables"][0]["value"] == pytest.approx(best, rel=1e-6)
    assert run(["choose", "parts.toml", "--output", "choice"]) == 0
    named = "high" if tried.exponent is None else "low"
    assert record("choice/choice.json")["ranking"][0]["parts"] == {"one": named}
    assert run(["simulate", "tuned/design.toml", "--output", "again"]) == 0
    assert run(["report", "tuned", "--what-if", "--runs", "32"]) == 0
    assert run(["report", "choice", "again"]) == 0
    assert run(["compare", "tuned", "tuned"]) == 0
    front = ["pareto", "study.toml", "--points", "2", "--iterations", "1", "--output", "front", "--objectives"]
    if tried is RIG:
        assert run([*front, f"{tried.main},contact_time"]) == 0
        assert run(["report", "front"]) == 0
    else:
        assert run([*front, tried.main]) == 2  # a front needs two objectives


@pytest.mark.long
def test_a_number_is_fitted_to_a_record_of_its_own(tried):
    assert run(["simulate", "fit.toml", "--output", "truth"]) == 0
    rows = np.column_stack([numbers("truth/history.csv", name) for name in ("time", tried.measured)])
    rows = rows[np.unique(rows[:, 0], return_index=True)[1]]
    rows = rows[rows[:, 0] <= tried.until]
    np.savetxt("test.csv", rows, delimiter=",", header=f"time [s],{tried.measured} [m]", comments="")
    assert run(["fit", "fit.toml", "--output", "fit"]) in (0, 1)
    assert record("fit/fit.json")["parameters"][tried.fitted]["value"] == pytest.approx(tried.value, rel=1e-3)
    assert run(["report", "fit"]) == 0
