"""The page of a design review: whole in itself, true to the records, readable by everyone."""

import dataclasses
import json
import platform
from datetime import datetime, timedelta
from html.parser import HTMLParser
from pathlib import Path

import jax
import numpy as np
import pytest
from markupsafe import escape

import jaxbuffer as jb
from jaxbuffer.cli.entry import run as command
from jaxbuffer.files import write
from jaxbuffer.labelled.record import amount
from jaxbuffer.output.folder import load
from jaxbuffer.output.provenance import made
from jaxbuffer.output.run_files import run_files, sensitivity_files
from jaxbuffer.output.swept_files import swept_files
from jaxbuffer.output.tuned_records import tuned_record as tuned_record_of
from jaxbuffer.pages.compare import compared, comparison
from jaxbuffer.pages.page import Cell, Page, PageSection, Table
from jaxbuffer.pages.records import field_name
from jaxbuffer.pages.review import review
from jaxbuffer.pages.verification import lines, sources, verified
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.value_text import table_text
from made_up import END, PULSE, STEPS, made_up_sweep, made_up_tuning
from pages.report_folders import COMMANDS, STUDY, every_kind

EDGES = ([0.1, 0.2, 0.3], [10.0, 20.0, 30.0, 40.0])  # values swept
VOID = {"meta", "link", "input", "img", "br", "hr", "wbr"}


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


@pytest.mark.slow
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
    assert f"{record['peak_force']['value']:.4g}" in text
    assert record["outcome"] in text
    assert {"release time [s]", "effective energy [J]", "energy [-]", "constraint drift [m]"} <= set(page.text)
    assert "how far the bar falls" in text or "height" in text
    derived = json.loads((folder / "sensitivity.json").read_text())
    assert f"{derived['derivatives'][0]['elasticity']['value']:.4g}" in text
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
    assert np.max(np.hypot(forces[..., 2], forces[..., 3])) == pytest.approx(motion["largest"], rel=1e-3)


def tuned_record(worst, feasible):
    case = {"outcome": "captured", "impacts": 3, "peak_force": amount(100.0, "N"), "stroke": amount(worst, "m")}
    scenario = {
        "approach_speed": amount(0.1, "m/s"),
        "contact_distance": amount(0.0435, "m"),
        "misalignment": amount(0.05, "rad"),
        "passive_rate": amount(0.0, "rad/s"),
    }
    return {
        "kind": "probe_cone",
        "message": "converged",
        "feasible": feasible,
        "broken": [] if feasible else ["stroke"],
        "outside_validity": [],
        "objective": "peak_force",
        "objective_unit": "N",
        "objective_before": 250.0,
        "objective_after": 100.0,
        "first_order_residual": amount(1e-6, "-"),
        "gradient_error": amount(1e-5, "-"),
        "above_lower_bound": amount(0.01, "-"),
        "captures": 100,
        "variables": [{"path": "buffer.k_A", "low": 100.0, "high": 900.0, "before": 500.0, "value": 100.0}],
        "limits": {"stroke": 0.025},
        "scenarios": [{**scenario, "factors": {}, "before": case, "after": case}],
        "design": {"buffer.k_A": amount(100.0, "N/m")},
        "jaxbuffer": "0.1.0",
    }


def test_the_page_lists_what_moves_the_first_impact(tmp_path):
    levers = ["numbers that are no variables move it, cone.half_angle +0.77", "of the variables probe.tip_mass +0.06"]
    (tmp_path / "tuned.json").write_text(json.dumps(tuned_record(0.02, True) | {"first_impact_levers": levers}))
    text = " ".join(" ".join(Outline(review([load(tmp_path)]).html()).text).split())
    assert (
        "softens. Numbers that are no variables move it, cone.half_angle +0.77; of the variables probe.tip_mass" in text
    )


@pytest.mark.parametrize(("worst", "verdict"), [(0.02, "kept"), (0.03, "broken")])
def test_limits_are_judged(tmp_path, worst, verdict):
    (tmp_path / "tuned.json").write_text(json.dumps(tuned_record(worst, verdict == "kept")))
    page = Outline(review([load(tmp_path)]).html())
    text = " ".join(" ".join(page.text).split())
    assert f"{100 * (1 - worst / 0.025):.3g} % {verdict}" in text
    assert "at low bound" in text
    assert "stiffness" in text
    assert "0.1 m/s, 2.865°" in text or "0.1 m/s, +2.86°" in text or "°" in text


def test_designs_side_by_side(folder, tmp_path, capsys):
    other = tmp_path / "harder"
    other.mkdir()
    record = json.loads((folder / "drop.json").read_text())
    record["design"]["impact.damping"] = amount(7.5, "N s/m")
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
    assert "is overwritten" in capsys.readouterr().err
    assert "<title>Again</title>" in (tmp_path / "report.html").read_text()


@pytest.mark.parametrize(
    ("before", "stroke_before", "worst", "mark"),
    [
        (250.0, 0.02, 0.02, "good"),  # lower than before
        (96.4, 0.03, 0.02, "good"),  # higher, as the start breaks a limit
        (96.4, 0.02, 0.02, "unsure"),  # higher than a start that keeps its limits
        (96.4, 0.02, 0.03, ""),  # a broken limit has a badge of its own
        (None, 0.03, 0.02, ""),  # the start's runs failed
    ],
)
def test_an_objective_is_never_a_fault(tmp_path, before, stroke_before, worst, mark):
    """Red are broken limits, runs that did not end as they must and values that are not trusted, nothing else."""
    record = tuned_record(worst, worst <= 0.025)
    record["objective_before"] = before
    (case,) = record["scenarios"]
    case["before"] = {**case["before"], "stroke": amount(stroke_before, "m")}
    (tmp_path / "tuned.json").write_text(json.dumps(record))
    badges = {badge.text: badge.mark for badge in review([load(tmp_path)]).verdicts}
    (objective,) = (text for text in badges if "→" in text)
    assert badges[objective] == mark
    assert objective.endswith("from a start that breaks limits") == (stroke_before > 0.025 and before is not None)
    assert ("bad" in badges.values()) == (worst > 0.025)


@pytest.mark.parametrize(
    ("status", "mark", "text"),
    [
        (["front", "front"], "good", "front of 2 points"),
        (["front", "front, not converged"], "unsure", "front of 2 points, 1 not converged"),
        (["front", "dominated"], "good", "front of 1 point"),
        (["limits broken", "limits broken"], "bad", "front of 0 points"),
    ],
)
def test_a_front_is_as_sure_as_its_points(folders, tmp_path, status, mark, text):
    record = json.loads((folders["front"] / "pareto.json").read_text())
    for point, said in zip(record["points"], status, strict=True):
        point["status"] = said
    (tmp_path / "pareto.json").write_text(json.dumps(record))
    page = review([load(tmp_path)])
    assert [(badge.text, badge.mark) for badge in page.verdicts] == [(text, mark)]
    (section,) = [section for section in page.sections if section.title == "Front"]
    red = [row[-1].mark == "bad" for row in section.tables[0].rows]
    assert red == [said == "limits broken" for said in status]


@pytest.mark.parametrize(
    ("verdict", "mark"), [("trusted", None), ("check", "unsure"), ("ill-conditioned", "bad"), ("unknown", "unsure")]
)
def test_numbers_that_are_not_trusted_have_a_badge(folders, tmp_path, verdict, mark):
    record = json.loads((folders["run"] / "capture.json").read_text())
    record["trust"] = {"verdict": verdict, "reason": "made up", "errors": {}}
    (tmp_path / "capture.json").write_text(json.dumps(record))
    badges = {badge.text: badge.mark for badge in review([load(tmp_path)]).verdicts}
    assert badges.get(f"numbers: {verdict}") == mark


@pytest.mark.parametrize("scale", ["log", "linear"])
@pytest.mark.parametrize(
    ("share", "said"), [(0.0, "at low bound"), (5e-6, "at low bound"), (1e-4, ""), (0.5, ""), (1.0, "at high bound")]
)
def test_a_variable_at_its_bound_is_so_in_command_and_page(tmp_path, scale, share, said):
    """Within a hundred-thousandth of the range on the variable's own scale, in the command's table as on the page."""
    variable = jb.Variable("buffer.k_A", 1.0, 900.0, scale)
    value = variable.value(share)
    problem = jb.Problem(jb.replace(jb.table2(), {variable.path: value}), [jb.Scenario()], [variable])
    tuned = made_up_tuning(problem)
    shown = dataclasses.replace(tuned, design=problem.design, before=tuned.after)
    (line,) = (line for line in repr(shown).splitlines() if line.strip().startswith("buffer.k_A"))
    assert ("bound" in line) == bool(said) and line.rstrip().endswith(said)
    (tmp_path / "tuned.json").write_text(json.dumps(tuned_record_of(shown)))
    _, _, rows = section_text(review([load(tmp_path)]), "Tuning")
    assert rows[0][-1] == said


def made_up_envelope(highest):
    """Speeds by misalignments, of 1000 N a m/s, held against ``highest`` [N], for two scenarios of 0.1 and 0.2 m/s."""
    design, scenario = jb.table2(), jb.Scenario()
    over = grid(
        {"scenario.approach_speed": [0.05, 0.1, 0.15, 0.2], "scenario.misalignment": [0.0, 0.01]}, design, scenario
    )
    found = made_up_sweep(*over.applied(design, scenario))
    swept = dataclasses.replace(found, design=design, scenarios=scenario, grid=over)
    met = [jb.Scenario(approach_speed=speed, misalignment=turn) for speed, turn in ((0.1, 0.0), (0.2, 0.01))]
    return swept, jb.safe_rectangle(swept, jb.Limits(at_most={"peak_force": highest}), met)


@pytest.mark.parametrize(("highest", "unsafe"), [(400.0, 0), (220.0, 2), (180.0, 4)])
def test_what_breaks_a_limit_between_the_scenarios_is_said(tmp_path, highest, unsafe):
    """Peaks are 150, 200 and 250 N from 0.1 to 0.2 m/s, at two misalignments each."""
    swept, envelope = made_up_envelope(highest)
    assert (envelope.between.runs, envelope.between.unsafe) == (6, unsafe)
    said = f"{unsafe} of 6 captures are not safe: peak force above its limit ({unsafe})" if unsafe else "all 6 captures"
    assert said in envelope.between.words and said in " ".join(repr(envelope).split())
    for name, content in swept_files(swept, envelope=envelope).items():
        if name in ("sweep.nc", "sweep.json"):
            write(tmp_path / name, content())
    page = review([load(tmp_path)])
    section, _, _ = section_text(page, "Envelope")
    assert envelope.between.words in (section.warnings if unsafe else section.text)
    marks = {badge.text: badge.mark for badge in page.verdicts}
    assert marks.get(f"{unsafe} of 6 runs between the study's scenarios are not safe") == ("bad" if unsafe else None)


def test_long_names_may_break_between_their_words_only():
    rows = [["buffer.cylinder_length", "k_A of 0.05 m", Cell("mass m_S")]]
    html = Page("", "", [], [PageSection("Names", tables=[Table("", ("a", "b", "c"), rows)])]).html()
    assert "buffer.<wbr>cylinder_<wbr>length" in html
    assert "k_A of 0.05 m" in html and "mass m_S" in html
    assert "anywhere" not in html.split("@media print")[0], "nor inside one"


@pytest.mark.parametrize("part", ["active vehicle", "active vehicle, broken off"])
def test_a_part_that_is_broken_off_is_explained(folders, tmp_path, part):
    record = json.loads((folders["run"] / "motion.json").read_text())
    record["shapes"][0]["part"] = part
    (tmp_path / "motion.json").write_text(json.dumps(record))
    (tmp_path / "capture.json").write_bytes((folders["run"] / "capture.json").read_bytes())
    assert ("Zigzag edges" in review([load(tmp_path)]).html()) == ("broken off" in part)


def test_numbers_stand_to_the_right():
    table = Table("", ("a", "b", "c"), [["x", "1.5e-3", Cell("–")], ["y", "-2 %", "0"]])
    assert table.numeric == [False, True, True]


@pytest.mark.parametrize(
    ("value", "text"),
    [(253.13152, "253.1"), (None, "–"), (True, "true"), (-1.4e-17, "0"), (3, "3"), ("hertz", "hertz")],
)
def test_numbers_as_they_are_shown(value, text):
    assert table_text(value) == text


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Results of every kind, made up."""
    return every_kind(tmp_path_factory.mktemp("every"))


def section_text(page, title):
    (section,) = [section for section in page.sections if section.title == title]
    rows = [[getattr(cell, "text", cell) for cell in row] for table in section.tables for row in table.rows]
    return section, [*section.text, *section.warnings], rows


def test_a_section_for_every_kind_of_result(folders):
    page = review([load(folder) for name, folder in folders.items() if name not in ("other", "missed")])
    titles = [section.title for section in page.sections]
    first = [title for title in titles if not title.startswith("Limits")]
    assert (
        titles[0].startswith("Limits")
        and first[:2] == ["What is asked", "Design"]
        and titles[-2:] == ["Where the numbers come from", "Verification"]
    )
    assert {"Scenarios", "Capture", "Sensitivity", "Tuning", "Envelope", "Sample", "Front"} <= set(titles)
    Outline(page.html())


WHAT_WAS_FOUND = {
    "run": "the capture ends after 0.04 s: captured: the tip centre crossed the capture plane inwards. Its largest"
    " contact force is 250 N; the largest force on a vehicle is the hinge's, 375 N. It keeps every limit.",
    "missed": "escaped: the tip left the cone. Its largest contact force is 250 N; the largest force on a vehicle is"
    " the hinge's, 375 N. It does not end captured, as it must.",
    "sensitivity": "Of the 5 numbers differentiated probe.tip_mass moves the peak contact force most: 1 % more of it"
    " changes it by +0.05 % (trusted).",
    "tuned": "Tuning lowered peak force, worst over the scenarios, from 250 to 200 N (-20 %); the design keeps every"
    " limit in its scenario. It changes buffer.k_A from 500 to 300 N/m, buffer.c_A from 5 to 3 N s/m,",
    "sweep": "6 of 6 captures end captured in a sweep over approach speed and k_A. The largest contact force is 110 to"
    " 400 N. 4 of 6 keep every limit.",
    "sample": "32 of 32 captures end captured in a sample of 2 numbers. The peak contact force is scattered most by"
    " scenario.approach_speed",
    "front": "1 of 2 tuned designs are on the front of peak force and stroke. The worst peak contact force on it is"
    " 200 N. The worst buffer stroke on it is 10 mm.",
}


@pytest.mark.parametrize("name", WHAT_WAS_FOUND)
def test_a_page_begins_with_what_was_found(folders, name):
    """The first paragraph below the title, before badges and sections, in the units that tables have."""
    (paragraph,) = review([load(folders[name])]).abstract
    assert WHAT_WAS_FOUND[name] in paragraph
    page = review([load(folders[name])]).html()
    header = page[page.index("<header>") : page.index('class="verdicts"')]
    assert f'<p class="abstract">{escape(paragraph)}</p>' in header


def test_a_page_of_several_begins_with_a_paragraph_for_each(folders):
    every = [load(folder) for folder in folders.values()]
    said = review(every).abstract
    assert len(said) == len(folders)
    runs = [text for text in said if "the capture ends" in text]
    assert [text.partition(":")[0] for text in runs] == [str(folders[name]) for name in ("run", "other", "missed")]
    assert len(comparison([load(folders[name]) for name in ("run", "other")]).abstract) == 2


def test_the_safe_rectangle_in_words(folders):
    record = json.loads((folders["sweep"] / "sweep.json").read_text())["envelope"]
    section, text, _ = section_text(review([load(folders["sweep"])]), "Envelope")
    told = " ".join(text)
    assert f"{record['safe_runs']} of {record['runs']} runs are" in told
    for part in record["rectangle"]:
        assert f"{field_name(part['path'])} from {table_text(part['low'])} to {table_text(part['high'])}" in told
    assert len(section.figures) == 2


def test_an_edge_that_was_not_found_is_told(folders, tmp_path):
    """Made up: the rectangle ends at the sweep's lowest speed, and nowhere else at the sweep's edge."""
    record = json.loads((folders["sweep"] / "sweep.json").read_text())
    for name in ("sweep.nc", "sweep.json"):
        (tmp_path / name).write_bytes((folders["sweep"] / name).read_bytes())
    speed, stiffness = ({**axis, "values": values} for axis, values in zip(record["axes"], EDGES, strict=True))
    parts = [{**axis, "low": low, "high": high} for axis, (low, high) in ((speed, (0.1, 0.2)), (stiffness, (20, 30)))]
    record |= {"axes": [speed, stiffness], "envelope": record["envelope"] | {"rectangle": parts}}
    (tmp_path / "sweep.json").write_text(json.dumps(record))
    section, _, _ = section_text(review([load(tmp_path)]), "Envelope")
    assert section.warnings == [
        "The edge of what is safe was not found on the side of approach speed below 0.1 m/s: sweep wider."
    ]


def test_indices_and_surfaces_are_those_of_the_table(folders):
    _, _, rows = section_text(review([load(folders["sample"])]), "Sample")
    lines = (folders["sample"] / "indices.csv").read_text().splitlines()[1:]
    for line in lines:
        quantity, path, first, _, _, total, *_ = line.split(",")
        assert quantity == "peak_force"
        assert any(
            row[0] == path and row[1] == f"{float(first):.3f}" and row[3] == f"{float(total):.3f}" for row in rows
        )
    assert any("trusted" in row[-1] for row in rows)


def test_the_points_of_a_front(folders):
    _, text, rows = section_text(review([load(folders["front"])]), "Front")
    lines = (folders["front"] / "pareto.csv").read_text().splitlines()
    assert [row[0] for row in rows] == [line.split(",")[0] for line in lines[1:]]
    assert rows[0][1] == table_text(float(lines[1].split(",")[1]))
    assert "are on the front" in text[0]


def without_scenario(rows):
    """Rows of limits without the column that names the scenario."""
    return [[*row[:3], *row[4:]] for row in rows]


def test_a_run_is_held_against_its_studys_limits(folders):
    """Made up: 250 N and 7.5 mm of stroke, limits 300 N and 25 mm; the missed one does not end captured."""
    title = "Limits"
    _, _, rows = section_text(review([load(folders["run"])]), title)
    # What stands in the way first.
    assert without_scenario(rows)[0] == ["peak contact force", "N", "250", "≤ 300", "16.7 %", "kept"]
    assert without_scenario(rows)[1] == ["buffer stroke", "mm", "7.5", "≤ 25", "70 %", "kept"]
    _, _, rows = section_text(review([load(folders["missed"])]), title)
    assert ["captured", "-", "0", "of 1", "–", "broken"] in without_scenario(rows)


@pytest.mark.parametrize(("value", "verdict", "margin"), [(0.6, "kept", "20 %"), (0.4, "broken", "-20 %")])
def test_lower_limits_have_margins_too(tmp_path, value, verdict, margin):
    record = tuned_record(0.02, True)
    record["lower_limits"] = {"end_time": 0.5}
    record["scenarios"][0]["after"]["end_time"] = amount(value, "s")
    record["scenarios"][0]["before"]["end_time"] = amount(value, "s")
    (tmp_path / "tuned.json").write_text(json.dumps(record))
    _, _, rows = section_text(review([load(tmp_path)]), "Limits")
    assert ["end time", "s", table_text(value), "≥ 0.5", margin, verdict] in without_scenario(rows)


def test_what_held_a_run_back(folders, tmp_path):
    """The record's own words, and the advice of the sensitivities of the same run instead of the command to ask it."""
    record = json.loads((folders["missed"] / "capture.json").read_text())
    record["diagnosis"] = {"way left": "12 mm", "what to change first": "'jaxbuffer sensitivity' says it"}
    (tmp_path / "capture.json").write_text(json.dumps(record))
    _, _, rows = section_text(review([load(tmp_path)]), "Why not captured")
    assert rows == [["way left", "12 mm"], ["what to change first", "'jaxbuffer sensitivity' says it"]]
    derived = json.loads((folders["sensitivity"] / "sensitivity.json").read_text())
    derived |= {"scenario": record["scenario"], "design": record["design"], "advice": ["What, so that x:", "k_A +3 %"]}
    (tmp_path / "sensitivity.json").write_text(json.dumps(derived))
    _, _, rows = section_text(review([load(tmp_path)]), "Why not captured")
    assert rows[1][1].startswith("k_A +3 %")
    derived["scenario"]["approach_speed"]["value"] *= 1.01
    (tmp_path / "sensitivity.json").write_text(json.dumps(derived))
    _, _, rows = section_text(review([load(tmp_path)]), "Why not captured")
    assert rows[1][1] == "'jaxbuffer sensitivity' says it"
    latch = {"latch.stiffness": amount(2e4, "N/m"), "latch.damping": amount(100.0, "N s/m")}
    (tmp_path / "capture.json").write_text(json.dumps(record | {"design": record["design"] | latch}))
    assert section_text(review([load(tmp_path)]), "Why not latched")[2][0] == ["way left", "12 mm"]


def test_records_say_how_they_came_about(folders):
    files = {"run": "capture", "sensitivity": "sensitivity", "tuned": "tuned", "sweep": "sweep", "sample": "sample"}
    for name, stem in {**files, "front": "pareto"}.items():
        made = json.loads((folders[name] / f"{stem}.json").read_text())["made"]
        assert made["command"].startswith(f"jaxbuffer {COMMANDS[name][0]} ")
        assert made["study"] == STUDY and made["wall_time"]["value"] > 0.0
        assert made["settings"] == {"solver": "automatic", "rtol": amount(1e-6, "-"), "duration": amount(8.0, "s")}
        assert datetime.fromisoformat(made["finished"]).utcoffset() == timedelta(0)
        assert made["versions"]["JAX"] == jax.__version__
        assert set(made["machine"]) == {"processor", "cores", "system"}
        assert platform.node() not in json.dumps(made["machine"])


def test_no_user_is_named():
    told = made(["simulate", f"{Path.home()}/study.toml"], None, {}, 1.0)
    assert (
        told["command"] == "jaxbuffer simulate '~/study.toml'" or told["command"] == "jaxbuffer simulate ~/study.toml"
    )


def test_different_versions_are_warned_of(folders, tmp_path):
    record = json.loads((folders["run"] / "capture.json").read_text())
    record["made"]["versions"]["JAX"] = "0.0.1"
    (tmp_path / "capture.json").write_text(json.dumps(record))
    _, text, _ = section_text(review([load(tmp_path), load(folders["sweep"])]), "Where the numbers come from")
    assert any(line.startswith("Made by different versions of JAX: 0.0.1 (") for line in text)
    _, text, _ = section_text(review([load(folders["run"]), load(folders["sweep"])]), "Where the numbers come from")
    assert text == []


@pytest.mark.parametrize("text", [None, "no JSON", "[]", '{"sources": "another"}'])
def test_where_nothing_was_run_for_these_sources_the_page_says_so_and_how_to(tmp_path, text):
    file = tmp_path / "verified.json"
    if text is not None:
        file.write_text(text)
    assert verified(file) is None
    (told,) = lines(verified(file))
    assert (
        told.startswith("No checks have been run for these sources") and sources() in told and "`make verify`" in told
    )


def test_what_was_verified_for_these_sources_is_told(tmp_path):
    file = tmp_path / "verified.json"
    counted = {name: [3, 4] for name in ("claims", "tests", "breakages")}
    file.write_text(json.dumps({"jaxbuffer": "0.1.0", "date": "2026-11-23", "sources": sources(), **counted}))
    told = " ".join(lines(verified(file)))
    assert "Verified on 2026-11-23" in told and "these very equations" in told
    assert "3 of 4 measured errors" in told and "3 of 4 deliberate breakages" in told


def test_forces_of_compared_runs_are_in_one_figure(folders):
    page = comparison([load(folders["run"]), load(folders["other"])])
    (forces,) = [section for section in page.sections if section.title == "Forces"]
    (chart,) = forces.curves
    beside = 0.5 * END / (STEPS - 1)  # the made-up pulse's middle lies between two of its steps
    highest = 250.0 * np.cos(np.pi * beside / PULSE)
    assert [max(curve["values"]) for curve in chart["curves"]] == pytest.approx([highest, highest], rel=1e-5)
    _, _, rows = section_text(page, "Designs where they differ")
    assert rows == [["buffer.k_A", "N/m", "500", "750 (+50 %)"]]
    assert sum("Limits" in section.title for section in page.sections) == 2


def captured_record(folders, changes):
    """A made-up run's record, changed: 250 N and 7.5 mm of stroke."""
    return json.loads((folders["run"] / "capture.json").read_text()) | changes


def held(tmp_path, folders, first, second):
    """The page of two runs of equal design beside each other, and its folders."""
    for name, changes in (("first", first), ("second", second)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "capture.json").write_text(json.dumps(captured_record(folders, changes)))
    every = [load(tmp_path / "first"), load(tmp_path / "second")]
    page = comparison(every)
    return page, [
        table for section in page.sections for table in section.tables if "against the limits" in table.caption
    ]


def test_compared_folders_say_which_limits_they_keep(folders, tmp_path):
    """The first breaks one of two limits; the second has none of its own and is held against those."""
    first = {"limits": {"stroke": 0.005, "peak_force": 300.0}, "limited": {"stroke": 0.0075, "peak_force": 250.0}}
    page, tables = held(tmp_path, folders, first, {"limits": {}, "limited": {}, "stroke": amount(0.004, "m")})
    assert [table.caption.rpartition("/")[2] for table in tables] == [
        "first: The run against the limits of its study",
        "first",
    ]
    assert [[row[-1].text for row in table.rows[:2]] for table in tables] == [["broken", "kept"], ["kept", "kept"]]
    pills = {verdict.text.rpartition("/")[2]: verdict.mark for verdict in page.verdicts}
    larger = "the largest force on a vehicle is the hinge's, 375 N"
    assert pills[f"first: captured, 1 limit broken, peak force 250 N, {larger}"] == "bad"
    assert pills[f"second: captured, limits kept, peak force 250 N, {larger}"] == "good"


def test_badges_of_several_runs_name_their_folders(folders, tmp_path):
    first = {"limits": {"stroke": 0.005}, "limited": {"stroke": 0.0075}}
    held(
        tmp_path,
        folders,
        first,
        {"limits": {"stroke": 0.005}, "limited": {"stroke": 0.004}, "stroke": amount(0.004, "m")},
    )
    every = [load(tmp_path / "first"), load(tmp_path / "second")]
    texts = [badge.text.rpartition("/")[2] for badge in review(every).verdicts]
    assert texts[0].startswith("first: captured, 1 limit broken") and texts[1].startswith(
        "second: captured, limits kept"
    )
    assert review(every[:1]).verdicts[0].text.startswith("captured, 1 limit broken")


def test_a_value_at_its_limit_is_told(folders, tmp_path):
    """0.05 % below the limit is at it; half of it is kept."""
    changes = {"limits": {"stroke": 0.0075 / 0.9995, "peak_force": 500.0}}
    _, (table, _) = held(tmp_path, folders, changes, changes)
    assert [row[-1].text for row in table.rows[:2]] == ["at the limit", "kept"]


def test_differences_are_told_so_that_they_can_be_read(folders, tmp_path):
    """Thirty times as much is told as a multiple; a peak that comes later is no merit."""
    run = captured_record(folders, {})
    changes = {
        "stroke": amount(30 * run["stroke"]["value"], "m"),
        "peak_time": amount(2.0 * run["peak_time"]["value"], "s"),
    }
    page, _ = held(tmp_path, folders, {}, changes)
    _, _, rows = section_text(page, "Runs")
    told = {row[0]: row[-1] for row in rows}
    assert told["buffer stroke"] == "225 (× 30)"
    assert told["time of the peak"] == table_text(2.0 * run["peak_time"]["value"])


def test_runs_of_different_scenarios_are_not_compared_in_per_cent(tmp_path, folders):
    """One folder's run is at 0.1 m/s; the other's is said to be at 0.2 m/s."""
    for name, speed in (("one", 0.1), ("two", 0.2)):
        (tmp_path / name).mkdir()
        record = json.loads((folders["run"] / "capture.json").read_text())
        record["scenario"]["approach_speed"] = amount(speed, "m/s")
        record["peak_force"]["value"] *= speed
        (tmp_path / name / "capture.json").write_text(json.dumps(record))
    (runs,) = [it for it in compared([load(tmp_path / name) for name in ("one", "two")]) if "Runs" in it.caption]
    assert "of different scenarios" in runs.caption
    assert not any("%" in str(cell) for row in runs.rows for cell in row if str(cell) != "%")


def test_broken_limits_are_in_one_box_and_a_table(tmp_path):
    """Three scenarios: strokes of 20, 30 and 40 mm with a limit of 25 mm."""
    record = tuned_record(0.02, False)
    for speed, stroke in ((0.2, 0.03), (0.3, 0.04)):
        (case, *_) = record["scenarios"]
        after = {**case["after"], "stroke": amount(stroke, "m")}
        record["scenarios"].append({**case, "approach_speed": amount(speed, "m/s"), "after": after})
    record |= {"converged": False, "ended": "limit_of_steps"}
    (tmp_path / "tuned.json").write_text(json.dumps(record))
    page = review([load(tmp_path)])
    section, _, _ = section_text(page, "Limits")
    assert len(section.warnings) == 1 and "buffer stroke in 2" in section.warnings[0]
    worst, beyond = section.tables
    (stroke,) = [row for row in worst.rows if row[0] == "buffer stroke"]
    assert stroke[2:5] == ["40", "0.3 m/s, +2.865°", "≤ 25"]
    assert [row[3] for row in beyond.rows] == ["40", "30"] and [row[-1] for row in beyond.rows] == ["60 %", "20 %"]
    assert ("no feasible design found", "bad") in [(it.text, it.mark) for it in page.verdicts]


@pytest.mark.parametrize(
    ("ended", "said"),
    [("limit_of_steps", "the search stopped at its limit of steps"), ("stalled", "the search stalled")],
)
def test_a_search_that_did_not_converge_says_how_it_ended(tmp_path, ended, said):
    record = tuned_record(0.02, True) | {"converged": False, "ended": ended}
    (tmp_path / "tuned.json").write_text(json.dumps(record))
    assert (said, "unsure") in [(it.text, it.mark) for it in review([load(tmp_path)]).verdicts]


def told_of(tmp_path, record):
    """The badges of a made-up tuning by their texts, and its table of limits."""
    (tmp_path / "tuned.json").write_text(json.dumps(record))
    page = review([load(tmp_path)])
    section, _, _ = section_text(page, "Limits")
    return page, {badge.text: badge.mark for badge in page.verdicts}, section.tables[0].rows


def several(strokes, outcomes, feasible):
    """A tuning of as many scenarios as ``strokes`` [m], of rising speeds; limit 25 mm."""
    record = tuned_record(0.02, feasible)
    (case,) = record["scenarios"]
    record["scenarios"] = [
        {
            **case,
            "approach_speed": amount(0.1 * (k + 1), "m/s"),
            "after": {**case["after"], "stroke": amount(stroke, "m"), "outcome": end},
        }
        for k, (stroke, end) in enumerate(zip(strokes, outcomes, strict=True))
    ]
    return record


def test_an_infeasible_tuning_is_red_at_the_top(tmp_path):
    """Of three scenarios one breaks the stroke's limit, two are not captured; the peak force is not praised."""
    record = several((0.03, 0.02, 0.02), ("captured", "escaped", "timeout"), False)
    record["broken_limits"] = ["stroke ≤ 25 mm: broken in 1 of 3 scenarios, worst 30 mm"]
    page, badges, _ = told_of(tmp_path, record)
    assert page.title.endswith(": no feasible design")
    assert page.abstract[0] == f"No design was found that keeps every limit: {record['broken_limits'][0]}."
    assert badges["no feasible design found"] == "bad"
    assert badges["1 limit broken, 2 of 3 not captured"] == "bad"
    assert badges["peak force: 250 → 100 N (-60 %)"] == ""


def test_what_is_kept_but_not_for_certain_is_amber(tmp_path):
    """One stroke 0.04 % below its limit; the same with room, but by one search alone."""
    _, badges, _ = told_of(tmp_path, several((0.02499, 0.01), ("captured",) * 2, True))
    assert badges["all limits kept, 1 at the limit"] == "unsure"
    assert badges["peak force: 250 → 100 N (-60 %)"] == "good"
    record = several((0.02, 0.01), ("captured",) * 2, True)
    _, badges, rows = told_of(tmp_path, record | {"confirmed": False})
    assert badges["all limits kept"] == "good" and rows[0][-1].text == "kept"
    assert badges["no other search found the same: a better design may exist"] == "unsure"


def test_the_farthest_from_capture_is_named(tmp_path):
    record = several((0.02,) * 3, ("captured", "timeout", "timeout"), False)
    for case, margin in zip(record["scenarios"], (0.3, -0.1, -3.0), strict=True):
        case["after"]["capture_share"] = amount(margin, "-")
    _, _, rows = told_of(tmp_path, record)
    assert rows[0][2:5] == ["1", "0.3 m/s, +2.865°", "of 3"]


def test_what_breaks_a_limit_first(folders, tmp_path):
    """A stroke of 20 mm with a limit of 25 mm: with elasticities of -2 and 0.5, the first number needs -12.5 %."""
    record = json.loads((folders["sensitivity"] / "sensitivity.json").read_text())
    given = [row for row in record["derivatives"] if row["quantity"] in ("stroke", "peak_force")]
    elasticity = {("stroke", 0): -2.0, ("stroke", 1): 0.5}
    seen = {"stroke": 0, "peak_force": 0}
    for row in given:
        k = seen[row["quantity"]]
        row["elasticity"]["value"], seen[row["quantity"]] = elasticity.get((row["quantity"], k), 1e-6), k + 1
    record |= {"derivatives": given, "stroke": amount(0.02, "m"), "peak_force": amount(310.0, "N")}
    (tmp_path / "sensitivity.json").write_text(json.dumps(record))
    section, text, _ = section_text(review([load(tmp_path), load(folders["run"])]), "Sensitivity")
    assert text[0].startswith("At ") and text[0].endswith("; captured.")
    assert "those below 0.001 counting as 0.001" in " ".join(text)
    assert "The second largest impact is number 3 with 200 N, 20 % below the peak" in " ".join(text)
    assert "buffer.c_A -30 % would make it the peak" in " ".join(text)
    rows = {row[0]: row[2:] for row in section.tables[-1].rows}
    first = given[[row["quantity"] for row in given].index("stroke")]["parameter"]
    assert [getattr(it, "text", it) for it in rows["buffer stroke"]] == ["20", "≤ 25", f"{first} -12.5 %"]
    assert rows["peak contact force"][-1].text == "broken here"


def test_limits_come_first_then_what_is_asked(tmp_path):
    """Two scenarios, of 0.1 and 0.2 m/s; the limit in millimetres."""
    page, _, _ = told_of(tmp_path, several((0.02, 0.01), ("captured",) * 2, True))
    section, (left_out,), rows = section_text(page, "What is asked")
    assert page.sections[0].title == "Limits" and page.sections[1] is section
    assert ["objective", "peak force", "as small as possible"] in rows
    assert ["end", "each capture", "captured"] in rows and ["limit", "buffer stroke", "≤ 25 mm"] in rows
    assert ["2 scenarios", "approach speed", "0.1 m/s to 0.2 m/s"] in rows
    assert ["2 scenarios", "misalignment", "+2.865°"] in rows
    assert ["variable", "buffer.k_A", "100 to 900 N/m"] in rows
    assert "planar" in left_out and "ends at capture" in left_out and "docs/verification.md" in left_out


def test_what_the_model_of_a_bar_leaves_out(folder):
    _, (left_out,), rows = section_text(review([load(folder)]), "What is asked")
    assert "planar" in left_out and rows[0][:2] == ["scenario", "height"]


@pytest.mark.parametrize(("speed", "shown_beside"), [(0.1, False), (0.15, True)])
def test_limits_of_a_tuned_scenario_are_told_once(folders, tmp_path, speed, shown_beside):
    """A run of one of the tuning's scenarios needs no table of its own beside the tuning's."""
    run, record = captured_record(folders, {}), tuned_record(0.0075, True)
    record |= {"design": run["design"], "limits": run["limits"]}
    record["scenarios"] = [{**record["scenarios"][0], **run["scenario"]}]
    run["scenario"] |= {"approach_speed": amount(speed, "m/s")}
    for name, content in (("tuned", record), ("capture", run)):
        (tmp_path / name).mkdir()
        (tmp_path / name / f"{name}.json").write_text(json.dumps(content))
    page = review([load(tmp_path / name) for name in ("tuned", "capture")])
    assert [section.title for section in page.sections if section.title.startswith("Limits")] == (
        ["Limits: tuned", "Limits: capture"] if shown_beside else ["Limits"]
    )


def test_equal_margins_are_told_once(folders, tmp_path):
    run = captured_record(folders, {"stroke_margin": amount(0.1, "m"), "capture_margin": amount(0.1, "m")})
    (tmp_path / "capture.json").write_text(json.dumps(run))
    _, _, rows = section_text(review([load(tmp_path)]), "Capture")
    assert [row[0] for row in rows if row[0].endswith("margin")] == ["stroke margin"]


def test_tunings_under_different_limits_side_by_side(tmp_path):
    """The second folder's forces are lower, but its stroke breaks its own, smaller limit: no praise for it there."""
    first = several((0.02, 0.01), ("captured",) * 2, True)
    second = several((0.018, 0.009), ("captured",) * 2, False) | {"limits": {"stroke": 0.015, "peak_force": 500.0}}
    for case in second["scenarios"]:
        case["after"]["peak_force"] = amount(90.0, "N")
    for name, record in (("first", first), ("second", second)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "tuned.json").write_text(json.dumps(record))
    page = comparison([load(tmp_path / "first"), load(tmp_path / "second")])
    (section,) = [section for section in page.sections if "by scenario" in section.title]
    forces, strokes = section.tables
    assert [row[2].mark for row in forces.rows] == ["", "good"] and not forces.folded
    assert [[cell.text for cell in row[1:]] for row in strokes.rows] == [["20", "18"], ["10", "9"]]
    assert [[cell.mark for cell in row[1:]] for row in strokes.rows] == [["", "bad"], ["", "good"]] and strokes.folded
    (told,) = [line for section in page.sections for line in section.warnings if "different limits" in line]
    assert f"buffer stroke: {tmp_path / 'first'} ≤ 25 mm, {tmp_path / 'second'} ≤ 15 mm" in told
    assert f"peak contact force: {tmp_path / 'first'} not limited, {tmp_path / 'second'} ≤ 500 N" in told


def test_a_tunings_record_has_the_margin_of_each_scenario(folders):
    """Made up with a margin of 1 in every scenario: by it the page finds the farthest from capture."""
    record = json.loads((folders["tuned"] / "tuned.json").read_text())
    assert all(case["after"]["capture_share"]["value"] == 1.0 for case in record["scenarios"])
