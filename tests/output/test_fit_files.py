"""The files of a fit hold its numbers, and are read again."""

import dataclasses
import json

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.output.fit_figure import fit_figure
from jaxbuffer.pages.review import review
from made_up_fit import made_up_fit


def test_a_fit_is_saved_and_loaded(tmp_path, no_figures):
    jb.save(made_up_fit(), tmp_path / "fitted", figures=False)
    record = json.loads((tmp_path / "fitted" / "fit.json").read_text())
    assert record["parameters"]["buffer.k_A"] == {
        "value": 655.5, "low": 655.4, "high": 655.6, "unit": "N/m", "at_bound": "", "start": 500.0,
    }  # fmt: skip
    assert record["nuisance"]["time_shift"]["value"] == 0.008 and record["residual"] == {"stroke [mm]": 0.5}
    assert record["converged"] is True
    rows = (tmp_path / "fitted" / "fit.csv").read_text().splitlines()
    assert len(rows) == 12 and float(rows[1].split(",")[-1]) == pytest.approx(-0.5)
    found = jb.load(tmp_path / "fitted")
    assert float(found.design.buffer.k_A) == 655.5 and found.records["fit"]["converged"]
    assert "fit          2 numbers from a.csv, converged" in repr(found)


def test_what_is_of_one_of_several_tests_is_named_by_it(tmp_path):
    jb.save(made_up_fit(("a.csv", "b.csv"), converged=False), tmp_path / "fitted", figures=False)
    record = json.loads((tmp_path / "fitted" / "fit.json").read_text())
    assert [*record["nuisance"]] == ["a.csv: time_shift", "b.csv: time_shift"] and record["converged"] is False
    assert "NOT converged" in repr(jb.load(tmp_path / "fitted"))


def test_a_number_at_its_bound_is_told():
    shown = str(made_up_fit())
    assert "at high bound" in shown and "655.400 to 655.600" in shown and "0.007900 to 0.008100" in shown


def test_a_fit_that_does_not_explain_its_test_calls_no_interval_sure(tmp_path):
    jb.save(made_up_fit(residual=3.1), tmp_path / "fitted", figures=False)
    assert json.loads((tmp_path / "fitted" / "fit.json").read_text())["explained"] is False
    for name in ("fit.txt", "design.toml"):
        text = (tmp_path / "fitted" / name).read_text()
        assert "NOT explained" in text and "95 %" not in text
    assert "NOT explained" in repr(jb.load(tmp_path / "fitted"))


def test_rows_that_weigh_less_or_are_left_out_are_listed_in_every_file_and_on_the_page(tmp_path):
    spikes, ends = {"a.csv": {"stroke [mm]": tuple(range(2, 32))}}, {"a.csv": {"stroke [mm]": (40, 41, 42)}}
    jb.save(made_up_fit(outliers=spikes, clipped=ends), tmp_path / "fitted", figures=False)
    record = json.loads((tmp_path / "fitted" / "fit.json").read_text())
    assert record["outliers"]["stroke [mm]"] == list(range(2, 32)) and record["clipped"]["stroke [mm]"] == [40, 41, 42]
    text = " ".join((tmp_path / "fitted" / "fit.txt").read_text().split())
    page = review([jb.load(tmp_path / "fitted")]).html()
    for said in ("30 rows stick out by more than five deviations", "20, 21 and 10 more.", "left out: 40, 41, 42."):
        assert said in text and said in page


def test_a_clipped_row_is_beside_what_the_model_gives_and_has_no_residual(tmp_path):
    fitted = made_up_fit(clips=True)
    jb.save(fitted, tmp_path / "fitted", figures=False)
    rows = [row.split(",") for row in (tmp_path / "fitted" / "fit.csv").read_text().splitlines()[1:]]
    assert [row[-1] for row in rows].count("nan") == 1 and rows[5][-1] == "nan"
    assert float(rows[5][-2]) - float(rows[5][-3]) == pytest.approx(1e-5)
    left, right = fit_figure(fitted).axes
    (marks,) = (line for line in left.lines if line.get_label() == "clipped, left out")
    np.testing.assert_allclose(marks.get_xdata(), [0.05])
    assert np.isfinite(right.lines[0].get_ydata()).sum() == 10
    assert "clipped, left out" in [text.get_text() for text in left.get_legend().get_texts()]


def test_what_sticks_out_stands_at_the_edge_of_the_residuals():
    """Of 200 rows with half a deviation one has 300: the others' scatter is seen beside it."""
    fitted = made_up_fit()
    (record,) = fitted.records.values()
    stroke = np.zeros((1, 200))
    spike = np.where(np.arange(200) == 7, 6e-3, 1e-5)[None]
    long = record._replace(times=np.arange(200.0), measured=spike, fitted=stroke, clipped=np.zeros((1, 200), bool))
    _, right = fit_figure(dataclasses.replace(fitted, records={"a.csv": long})).axes
    assert right.get_ylim() == (-5.0, 5.0)
    up, down = (line for line in right.lines if line.get_marker() in "^v")
    assert [*up.get_xdata()] == [7.0] and up.get_ydata()[0] < 5.0 and not len(down.get_xdata())
    assert len(right.lines[0].get_xdata()) == 199
