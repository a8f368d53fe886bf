"""The files of a fit hold its numbers, and are read again."""

import json

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.fitting.fitted import Fitted, FittedNumber, RecordBesideFit


def made(tests=("a.csv",), converged=True):
    """A fit of two numbers, by hand."""
    times = np.linspace(0.0, 0.1, 11)
    stroke = np.array([0.01 * np.sin(30.0 * times)])
    record = RecordBesideFit(("stroke [mm]",), ("stroke",), ("m",), times, stroke, stroke + 1e-5)
    shift = FittedNumber(0.008, 0.0079, 0.0081, "s")
    return Fitted(
        start=jb.table2(),
        scenario=jb.Scenario(),
        parameters={
            "buffer.k_A": FittedNumber(655.5, 655.4, 655.6, "N/m"),
            "buffer.c_A": FittedNumber(60.0, 55.0, 60.0, "N s/m", "at high bound"),
        },
        nuisance={test: {"time_shift": shift} for test in tests},
        residual={test: {"stroke [mm]": 0.5} for test in tests},
        noise={test: {"stroke [mm]": 2e-5} for test in tests},
        names=("buffer.k_A", "buffer.c_A", *(f"{test}: time_shift" for test in tests)),
        correlation=np.eye(2 + len(tests)),
        not_told_apart=(),
        inflation=1.0,
        rows=dict.fromkeys(tests, 11),
        records=dict.fromkeys(tests, record),
        evaluations=12,
        converged=converged,
    )


def test_a_fit_is_saved_and_loaded(tmp_path, no_figures):
    jb.save(made(), tmp_path / "fitted", figures=False)
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
    jb.save(made(("a.csv", "b.csv"), converged=False), tmp_path / "fitted", figures=False)
    record = json.loads((tmp_path / "fitted" / "fit.json").read_text())
    assert [*record["nuisance"]] == ["a.csv: time_shift", "b.csv: time_shift"] and record["converged"] is False
    assert "NOT converged" in repr(jb.load(tmp_path / "fitted"))


def test_a_number_at_its_bound_is_told():
    shown = str(made())
    assert "at high bound" in shown and "655.4 to 655.6" in shown and "0.0079 to 0.0081" in shown
