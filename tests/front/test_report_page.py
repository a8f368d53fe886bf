"""The page of a design review: whole in itself, true to the records, readable by everyone."""

import json
from html.parser import HTMLParser

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run as command
from jaxbuffer.files import write
from jaxbuffer.output.folder import load
from jaxbuffer.output.results import run_files, sensitivity_files
from jaxbuffer.report.page import Cell, Table, shown
from jaxbuffer.report.review import review

VOID = {"meta", "link", "input", "img", "br", "hr"}


class Outline(HTMLParser):
    """What a page refers to, and whether its elements close as they should."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.links, self.loaded, self.pictures = [], [], [], [], []
        self.headings, self.text = [], []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attributes):
        known = dict(attributes)
        if "id" in known:
            self.ids.append(known["id"])
        if tag == "a":
            self.links.append(known["href"])
        self.loaded += [known[name] for name in ("src",) if name in known]
        if tag == "img":
            self.pictures.append(known["alt"])
        if tag == "th":
            self.headings.append(known["scope"])
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        if "id" in dict(attributes):
            self.ids.append(dict(attributes)["id"])

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of a dropped bar: a run and its sensitivities."""
    folder = tmp_path_factory.mktemp("bar")
    design, scenario = jb.BarDrop(), jb.BarDropScenario()
    run = jb.simulate(design, scenario, history=True)
    found = jb.sensitivity(design, scenario, wrt=["impact.damping"], quantities=["peak_force"])
    for name, content in {**run_files(run), **sensitivity_files(found)}.items():
        write(folder / name, content())
    return folder


@pytest.fixture
def page(folder):
    return Outline(review([load(folder)]).html())


def test_the_page_needs_nothing_else(page):
    assert all(link.removeprefix("#") in page.ids for link in page.links)
    assert all(source.startswith("data:") for source in page.loaded)
    assert len(set(page.ids)) == len(page.ids)


def test_everyone_can_read_it(page):
    assert page.pictures == [] or all(page.pictures)
    assert set(page.headings) == {"col", "row"}


def test_it_says_what_the_records_hold(page, folder):
    record = json.loads((folder / "drop.json").read_text())
    text = " ".join(page.text)
    assert f"{record['peak_force [N]']:.4g}" in text
    assert record["outcome"] in text
    assert "how far the bar falls" in text or "height" in text
    derived = json.loads((folder / "sensitivity.json").read_text())
    assert f"{derived['derivatives'][0]['elasticity [-]']:.4g}" in text
    assert derived["certificate"]["verdict"] in text


def test_a_run_moves_as_its_history_does(folder):
    """Frames at the first and the last instant are those of the history's first and last step."""
    motion = load(folder).records["motion"]
    header, *rows = (folder / "history.csv").read_text().splitlines()
    columns = header.split(",")
    wanted = [k for k, name in enumerate(columns) if " position " in name]
    for frames, row in ((motion["frames"][0], rows[0]), (motion["frames"][-1], rows[-1])):
        given = [float(row.split(",")[k]) for k in wanted]
        np.testing.assert_allclose(np.ravel(frames)[: len(given)], given, atol=1e-7)
    forces = np.array(motion["forces"])
    assert np.max(np.hypot(forces[..., 2], forces[..., 3])) == pytest.approx(motion["largest"], rel=1e-2)


def tuned_record(worst, feasible):
    case = {"outcome": "captured", "impacts": 3, "peak_force [N]": 100.0, "stroke [m]": worst}
    scenario = {
        "approach_speed [m/s]": 0.1,
        "contact_distance [m]": 0.0435,
        "misalignment [rad]": 0.05,
        "passive_rate [rad/s]": 0.0,
    }
    return {
        "kind": "probe_cone",
        "message": "converged",
        "feasible": feasible,
        "broken": [] if feasible else ["stroke"],
        "outside_validity": [],
        "objective": "peak_force",
        "objective_before [N]": 250.0,
        "objective_after [N]": 100.0,
        "first_order_residual [-]": 1e-6,
        "gradient_error [-]": 1e-5,
        "above_floor [-]": 0.01,
        "captures": 100,
        "variables": [{"path": "buffer.k_A", "low": 100.0, "high": 900.0, "before": 500.0, "value": 100.0}],
        "limits": {"stroke": 0.025},
        "scenarios": [{**scenario, "factors": {}, "before": case, "after": case}],
        "design": {"buffer.k_A [N/m]": 100.0},
        "jaxbuffer": "0.1.0",
    }


@pytest.mark.parametrize(("worst", "verdict"), [(0.02, "kept"), (0.03, "broken")])
def test_limits_are_judged(tmp_path, worst, verdict):
    (tmp_path / "tuned.json").write_text(json.dumps(tuned_record(worst, verdict == "kept")))
    page = Outline(review([load(tmp_path)]).html())
    text = " ".join(" ".join(page.text).split())
    assert f"{100 * (1 - worst / 0.025):.3g} % {verdict}" in text
    assert "at the lower" in text
    assert "stiffness" in text
    assert "0.1 m/s, 2.865°" in text or "0.1 m/s, +2.86°" in text or "°" in text


def test_designs_side_by_side(folder, tmp_path, capsys):
    other = tmp_path / "harder"
    other.mkdir()
    record = json.loads((folder / "drop.json").read_text())
    record["design"]["impact.damping [N s/m]"] = 7.5
    (other / "drop.json").write_text(json.dumps(record))
    assert command(["compare", str(folder), str(other)]) == 0
    assert "7.5" in capsys.readouterr().out
    Outline((folder / "compare.html").read_text())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["report", "nowhere"], "nowhere: no such folder"),
        (["report", "empty"], "holds no results"),
        (["report", "damaged"], "tuned.json is damaged"),
        (["compare", "empty"], "two folders at least"),
        (["report", "good", "--html", "mine.html"], "mine.html exists and is no page"),
    ],
)
def test_bad_input(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    for name in ("empty", "damaged", "good"):
        (tmp_path / name).mkdir()
    (tmp_path / "damaged" / "tuned.json").write_text("[1")
    (tmp_path / "good" / "tuned.json").write_text(json.dumps(tuned_record(0.02, True)))
    (tmp_path / "mine.html").write_text("<p>mine</p>")
    assert command(words) == 2
    assert said in " ".join(capsys.readouterr().err.split())
    assert (tmp_path / "mine.html").read_text() == "<p>mine</p>"


def test_a_page_is_made_anew_and_says_so(tmp_path, capsys):
    (tmp_path / "tuned.json").write_text(json.dumps(tuned_record(0.02, True)))
    assert command(["report", str(tmp_path)]) == 0
    assert command(["report", str(tmp_path), "--title", "Again"]) == 0
    assert "is made anew" in capsys.readouterr().err
    assert "<title>Again</title>" in (tmp_path / "report.html").read_text()


def test_numbers_stand_to_the_right():
    table = Table("", ("a", "b", "c"), [["x", "1.5e-3", Cell("–")], ["y", "-2 %", "0"]])
    assert table.numeric == [False, True, True]


@pytest.mark.parametrize(
    ("value", "text"),
    [(253.13152, "253.1"), (None, "–"), (True, "true"), (-1.4e-17, "0"), (3, "3"), ("hertz", "hertz")],
)
def test_numbers_as_they_are_shown(value, text):
    assert shown(value) == text
