"""Figures and units of what is told: signs, shares, millimetres and degrees."""

import dataclasses

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.labelled.record import Record, amount
from jaxbuffer.mechanisms import all_mechanisms
from jaxbuffer.mechanisms.probe_cone.panels import panels
from jaxbuffer.output.sensitivity_figure import drawn, sensitivity_figure
from jaxbuffer.pages.abstract import _sample
from jaxbuffer.tuning.problem.cases import Case
from jaxbuffer.tuning.tolerances.corners import Corners
from made_up import made_up_capture, made_up_certificate, made_up_sensitivity
from output.drawn import check_readable

PATHS = ("buffer.k_A", "buffer.cylinder_length", "scenario.misalignment")


def test_a_curve_that_changes_sign_is_told_with_its_signs():
    """It reaches 2.33° below zero and 0.1374° above it."""
    run = made_up_capture()
    steps = len(run.history.time)
    angle = np.interp(np.arange(steps), [0, steps // 2, steps - 1], np.radians([0.1374, -2.33, 0.0]))
    history = dataclasses.replace(run.history, others={**run.history.others, "hinge_angle": angle})
    drawn_run = dataclasses.replace(run, history=history, hinge_angle=np.radians(2.33))
    (title,) = (panel.title for panel in panels(drawn_run) if panel.title.startswith("Hinge angle"))
    assert title == "Hinge angle, from -2.33 to 0.137°"


def test_sensitivities_are_told_in_millimetres_and_degrees():
    found = made_up_sensitivity(paths=PATHS)
    found = dataclasses.replace(found, values=np.array([500.0, 0.123, np.radians(2.0)]))
    said = repr(found)
    assert "123 mm" in said and "2 deg" in said and "500 N/m" in said
    assert " rad" not in said and " m " not in said
    (line,) = (it for it in said.splitlines() if "buffer.cylinder_length" in it and "123 mm" in it)
    # N per m, over a thousand, is N per mm
    assert f"{found.gradients[0, 1] / 1000.0:+.5g} N/mm" in line


def test_elasticities_are_drawn_as_bars_with_their_errors():
    found = made_up_sensitivity(paths=PATHS)
    figure = sensitivity_figure(found)
    check_readable(figure)
    assert len(figure.axes) == len(drawn(found))
    bars = sorted(float(bar.get_width()) for bar in figure.axes[0].patches)
    np.testing.assert_allclose(bars, sorted(found.elasticities[drawn(found)[0]]))


def test_a_quantity_that_is_not_trusted_is_hatched():
    found = made_up_sensitivity(paths=PATHS)
    doubtful = made_up_certificate(PATHS, found.quantities, jb.Verdict.refused)
    figure = sensitivity_figure(dataclasses.replace(found, certificate=doubtful))
    assert {bar.get_hatch() for bar in figure.axes[0].patches} == {"xxxx"}
    assert "refused" in figure.axes[0].get_title(loc="left")


class Sampled:
    """Stands in for a folder with a sample."""

    def __init__(self, trusted, source):
        rows = [("a", 0.42, 0.71), ("b", 0.29, 0.6)]
        self.mechanism = all_mechanisms()[0]
        self.design = self.mechanism.design()
        of_sample = {
            "outcomes": {"captured": 8},
            "runs": 8,
            "done": 8,
            "ranges": [{"path": "buffer.k_A"}, {"path": "buffer.c_A"}],
            "surfaces": [{"quantity": "peak_force", "trusted": trusted}],
            "indices": [
                {
                    "quantity": "peak_force",
                    "number": n,
                    "first_order": amount(s, "-"),
                    "total": amount(t, "-"),
                    "from": source,
                }
                for n, s, t in rows
            ],
        }
        self.records = {"sample": Record.of(of_sample)}


def test_the_lead_quotes_the_share_that_a_number_has_alone():
    said = _sample(Sampled(True, "response surface"), ())
    assert "scattered most by a: alone 42 % of the variance (total index 0.71" in said
    assert "71 %" not in said


def test_the_lead_quotes_nothing_of_a_surface_that_is_not_trusted():
    assert "scattered" not in _sample(Sampled(False, "response surface"), ())
    assert "scattered" in _sample(Sampled(False, "runs"), ()), "the runs themselves are no surface"


@pytest.mark.parametrize(("touches", "said"), [(False, "nothing touches there"), (True, "0 N")])
def test_a_middle_that_nothing_touches_is_no_force_of_zero(touches, said):
    cases = (Case(jb.Scenario()),)
    corners = Corners(cases, ((),), np.array([1.0]), 0, 1, True, 0.0, True, touches)
    problem = jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)])
    assert corners.lines(problem)[-1] == f"the middle of the ranges: {said}"
