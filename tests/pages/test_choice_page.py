"""The section of a choice: winner, limits, corners, ranking and bound, as they are made up by hand."""

import dataclasses
import json
from types import SimpleNamespace

import pytest

import jaxbuffer as jb
from jaxbuffer.output.folder import Results, load
from jaxbuffer.pages.choice import choice_check, chosen_by
from jaxbuffer.pages.designs import requirements
from jaxbuffer.pages.review import review
from jaxbuffer.tuning.report.levers import Lever
from made_up_choice import largest_force, made_up_choice, without_combination
from pages.test_report_page import Outline, section_text


def results_of(choice, place):
    jb.save(choice, place, figures=False)
    return load(place)


def badges(page):
    return {badge.text: badge.mark for badge in page.verdicts}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return results_of(made_up_choice(), tmp_path_factory.mktemp("parts"))


def test_the_winner_with_its_limits_and_corners(folder):
    page = review([folder])
    Outline(page.html())
    marks = badges(page)
    assert marks["chosen: spring S2, tip light"] == "good" and marks["all limits kept"] == "good"
    assert marks["holds in 8 of 8 corners"] == "good"
    force = largest_force(made_up_choice())
    assert marks[f"peak force, worst over the cases: {force:.4g} N"] == ""
    section, text, rows = section_text(page, "Choice")
    assert text[0] == (
        "The best of 4 combinations over 2 scenarios and 8 corners of their tolerances: spring S2, tip light, with"
        f" {force:.5g} N."
    )
    largest = "Its objective is largest at 2.4: 0.14 m/s, 0°, 1.2 buffer.c_A, probe.tip_radius +0.5 mm; of its"
    assert largest in text[1]
    assert any(line.startswith("30 runs of 40: 10 were spared") for line in text)
    assert "The first holds in 8 of 8 corners of the tolerances." in text
    (stroke,) = (row for row in rows if row[0] == "buffer stroke")
    assert stroke[1:3] == ["mm", "10"] and stroke[4:] == ["≤ 25", "60 %", "kept"]
    (price,) = (row for row in rows if row[0] == "price of all parts")
    assert price[1:] == ["EUR", "17", "–", "≤ 18", "5.56 %", "kept"]
    assert ["captured", "-", "10", "–", "of 10", "–", "kept"] in rows
    assert not section.warnings


def test_the_ranking_has_the_bound_below_it(folder):
    (section,) = (it for it in review([folder]).sections if it.title == "Choice")
    (table,) = (it for it in section.tables if it.caption == "Ranking")
    force = largest_force(made_up_choice())
    first, second, bound = table.rows
    assert first[:5] == ["1", "S2", "light", f"{force:.4g}", "–"] and first[5] == "17"
    assert second[:3] == ["2", "S2", "heavy"] and second[4] == "12 %" and second[5] == "14"  # 0.9 / 0.8
    assert bound[0] == "continuous optimum" and bound[3] == "180" and bound[4] == f"{100 * (180 / force - 1):.2g} %"
    (parts,) = (it for it in section.tables if "chosen from" in it.caption)
    assert parts.rows[0][2] == "buffer.k_A = 0.2 kN/m, price = 9 EUR"
    assert parts.folded and [row[1] for row in parts.rows] == ["S2", "S5", "light", "heavy"]


def test_levers_stand_below_the_limits(folder, tmp_path):
    levers = {"stroke": [Lever("buffer.k_A", -0.4, True), Lever("active.mass", 0.3, False)]}
    page = review([results_of(dataclasses.replace(made_up_choice(), levers=levers), tmp_path)])
    (section,) = (it for it in page.sections if it.title == "Choice")
    limits, table = section.tables[:2]
    assert "against the limits" in limits.caption and table.caption.startswith("Levers: the numbers that move")
    assert table.rows == [
        ["buffer stroke", "buffer.k_A", "-0.4", "chosen"],
        ["buffer stroke", "active.mass", "+0.3", "not chosen"],
    ]
    (without,) = (it for it in review([folder]).sections if it.title == "Choice")
    assert not any(it.caption.startswith("Levers") for it in without.tables)
    assert "--levers" not in " ".join(map(str, without.text))


def test_design_and_question_name_the_parts(folder):
    page = review([folder])
    _, _, asked = section_text(page, "What is asked")
    assert ["parts", "spring", "one of 2"] in asked and ["limit", "price of all parts", "≤ 18 EUR"] in asked
    assert ["limit", "buffer stroke", "≤ 25 mm"] in asked and any(
        row[:2] == ["tolerance", "buffer.c_A"] and "20 %" in row[2] for row in asked
    )
    _, _, design = section_text(page, "Design")
    (spring,) = (row for row in design if row[0] == "buffer.k_A")
    assert spring[2:4] == ["0.2", "kN/m"] and spring[-1] == "spring S2"


def test_corners_that_fail_are_a_warning_and_red(tmp_path):
    choice = made_up_choice(broken_corners=3)
    assert choice.holding(choice.best) == 5 and not choice.feasible
    page = review([results_of(choice, tmp_path)])
    assert badges(page)["no combination keeps every limit"] == "bad"
    section, _, rows = section_text(page, "Choice")
    assert section.warnings[0] == "It holds in 5 of 8 corners only." and "no combination keeps" in page.title
    (stroke,) = (row for row in rows if row[0] == "buffer stroke" and len(row) == 7)
    assert stroke[2] == "30" and stroke[-1] == "broken"
    assert choice_check(load(tmp_path)).keeping.count(False) == 3


def test_at_a_limit_is_not_green(tmp_path):
    page = review([results_of(made_up_choice(stroke=0.010), tmp_path)])
    assert badges(page)["at a limit"] == "unsure" and "all limits kept" not in badges(page)


def test_without_tolerances_no_corner_is_told(tmp_path):
    page = review([results_of(made_up_choice(tolerances={}, optimum=None), tmp_path)])
    assert "corner" not in page.html().partition("<h2")[2] and not any("corners" in text for text in badges(page))


def test_where_none_could_be_run_the_page_says_so(tmp_path):
    page = review([results_of(without_combination(made_up_choice()), tmp_path)])
    Outline(page.html())
    assert badges(page) == {"no combination keeps every limit": "bad"}
    assert page.abstract[0].startswith("No combination keeps the limits on price and mass")


def test_two_choices_stand_on_one_page(folder, tmp_path):
    other = results_of(made_up_choice(optimum=None), tmp_path / "other")
    titles = [section.title for section in review([folder, other]).sections]
    assert f"Choice: {folder.folder.name}" in titles and "Choice: other" in titles


def test_the_record_is_what_python_has(tmp_path):
    """Corners with the shifts of their tolerances, and which part has set what."""
    jb.save(made_up_choice(), tmp_path, figures=False)
    record = json.loads((tmp_path / "choice.json").read_text())
    best = record["ranking"][0]
    assert best["corners"] == {"holding": 8, "run": 8, "searched": False} and best["set_by"]["buffer.k_A"] == "S2"
    assert best["scenarios"][1]["shifts"] == {"probe.tip_radius": -0.0005}
    assert Results(tmp_path, records={"choice": record}).records["choice"]["tolerances"]["buffer.c_A"]["in_words"]


def test_what_is_asked_has_scenarios_without_corners_and_the_grid_s_numbers_of_the_design(tmp_path):
    jb.save(made_up_choice(), tmp_path, figures=False)
    record = json.loads((tmp_path / "choice.json").read_text())
    for k, case in enumerate(record["ranking"][0]["scenarios"]):
        case["values"] = {"buffer.k_T": 200.0 if k < 5 else 400.0}
    results = Results(tmp_path, records={"choice": record}, design=jb.table2())
    (table,) = requirements(results, [results]).tables
    rows = [row for row in table.rows if "scenarios" in row[0]]
    assert rows[0] == ["2 scenarios", "approach speed", "0.06 m/s to 0.14 m/s"]
    assert rows[-1] == ["2 scenarios", "buffer.k_T", "200 to 400 N m/rad"]


def test_parts_of_one_name_for_two_roles_are_told_apart():
    best = {"parts": {"spring": "A1", "damper": "A1"}, "set_by": {"buffer.k_A": "A1", "buffer.c_A": "A1"}}
    parts = {"spring": [{"name": "A1", "buffer.k_A": 300.0}], "damper": [{"name": "A1", "buffer.c_A": 5.0}]}
    results = SimpleNamespace(records={"choice": {"ranking": [best], "parts": parts}})
    assert chosen_by(results) == {"buffer.k_A": "spring A1", "buffer.c_A": "damper A1"}


def test_a_second_objective_stands_on_the_page_and_in_the_figure(tmp_path):
    then = jb.SecondObjective(jb.Objective({"stroke": 1.0}), tolerance=0.2)
    page = review([results_of(made_up_choice(then=then), tmp_path)]).html()
    assert "of those within 20 % of the least objective" in page and "then [mm]" in page
    assert "it orders all within 20 % of the least objective, up to" in page
    record = json.loads((tmp_path / "choice.json").read_text())
    assert [it["then"] for it in record["ranking"]] == [0.010, 0.010] and record["then_unit"] == "m"
