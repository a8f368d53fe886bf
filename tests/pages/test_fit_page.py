"""The section of a fit: numbers with intervals, what the data cannot tell, and whether the search converged."""

import pytest

import jaxbuffer as jb
from jaxbuffer.output.folder import load
from jaxbuffer.pages.review import review
from made_up import made_up_capture
from made_up_fit import made_up_fit
from pages.test_report_page import Outline, section_text


def page_of(fitted, place):
    jb.save(fitted, place, figures=False)
    page = review([load(place)])
    Outline(page.html())
    return page


@pytest.fixture
def page(tmp_path):
    return page_of(made_up_fit(), tmp_path)


def test_the_numbers_with_their_intervals_and_units(page):
    section, text, rows = section_text(page, "Fit")
    (spring,) = (row for row in rows if row[0] == "buffer.k_A")
    assert spring == ["buffer.k_A", "N/m", "500", "655.500", "655.400 to 655.600", "the design"]
    (shift,) = (row for row in rows if row[0] == "time_shift")
    assert next(row[-1] for row in rows if row[0] == "buffer.c_A") == "at high bound"
    assert shift == ["time_shift", "s", "–", "0.008000", "0.007900 to 0.008100", "the test"]
    (stroke,) = (row for row in rows if row[0] == "stroke [mm]")
    assert stroke == ["stroke [mm]", "stroke", "0.500", "0.02", "mm"]  # 2e-5 m of noise
    assert section.warnings == [
        "buffer.c_A lies at its high bound: its given range ends there, and with it the interval."
    ]
    assert "2 numbers fitted to a.csv, 11 rows" in text[0] and "The data tell all these numbers apart." in text
    assert {badge.text: badge.mark for badge in page.verdicts} == {
        "fit converged": "good",
        "residuals at most 0.5 of the noise": "good",
    }
    assert "buffer.k_A 655.400 to 655.600 N/m" in page.abstract[0]


def test_the_design_says_which_numbers_were_fitted(page):
    _, _, rows = section_text(page, "Design")
    assert {row[0] for row in rows if row[-1] == "fitted"} == {"buffer.k_A", "buffer.c_A"}


def test_a_search_that_has_not_converged_is_said_first(tmp_path):
    page = page_of(made_up_fit(converged=False), tmp_path)
    assert page.title.endswith(": the fit has not converged")
    assert page.verdicts[0].text == "the fit has not converged" and page.verdicts[0].mark == "bad"
    assert all(badge.mark != "good" for badge in page.verdicts)
    section, _, _ = section_text(page, "Fit")
    assert section.warnings[0].startswith("The fit has not converged.") and "no result" in page.abstract[0]
    assert "655.4" not in page.abstract[0]


def test_a_test_that_is_not_explained_is_red_and_no_interval_is_sure(tmp_path):
    doubt = 'a.csv: column "stroke [cm]": unit or sign? Times 0.1 it is far nearer to what the design gives.'
    page = page_of(made_up_fit(residual=12.0, inflation=144.0, doubtful=(doubt,)), tmp_path)
    assert page.title.endswith(": the fit does not explain the test")
    assert {badge.mark for badge in page.verdicts} == {"bad"}
    section, text, _ = section_text(page, "Fit")
    assert "12 deviations" in section.warnings[0] and doubt in section.warnings
    assert "95" not in text[0] and "655.4" not in page.abstract[0] and "no result" in page.abstract[0]


def test_what_the_data_do_not_tell_and_residuals_above_the_noise_are_warnings(tmp_path):
    line = "buffer.c_A and buffer.friction: correlation +0.992; one combination of them is known far better than either"
    page = page_of(made_up_fit(told=[line], inflation=4.0), tmp_path)
    section, text, _ = section_text(page, "Fit")
    assert any("intervals are 2 times as wide" in warning for warning in section.warnings)
    assert f"{line}." in section.warnings
    assert "The data tell all these numbers apart." not in text
    assert {badge.text: badge.mark for badge in page.verdicts}["the data do not tell all numbers"] == "unsure"


def test_columns_of_several_tests_are_told_apart(tmp_path):
    _, _, rows = section_text(page_of(made_up_fit(("a.csv", "b.csv")), tmp_path), "Fit")
    assert [row[0] for row in rows if row[0].endswith("stroke [mm]")] == ["a.csv: stroke [mm]", "b.csv: stroke [mm]"]


def test_a_fit_and_a_run_stand_on_one_page(tmp_path):
    jb.save(made_up_fit(), tmp_path / "fitted", figures=False)
    jb.save(made_up_capture(), tmp_path / "run", figures=False)
    titles = [section.title for section in review([load(tmp_path / name) for name in ("fitted", "run")]).sections]
    assert "Fit" in titles and "Capture" in titles
