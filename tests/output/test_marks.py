"""Every series of a figure has a mark of its own, in colour and in grey."""

import dataclasses
import itertools

import numpy as np
import pytest
from test_readable_figures import swept

import jaxbuffer as jb
from jaxbuffer.mechanisms import all_mechanisms
from jaxbuffer.mechanisms.picture import Panel, PanelCurve
from jaxbuffer.output.envelope_figure import envelope_figure
from jaxbuffer.output.figures import Window, _draw
from jaxbuffer.output.sketch import sketch
from jaxbuffer.output.style import panels
from jaxbuffer.output.sweep_figures import sweep_figure
from jaxbuffer.output.words import outcome_marks, reason_marks, success_marks
from output.marks import check_marks

SPEEDS = {"scenario.approach_speed": [0.1, 0.15, 0.2, 0.25], "scenario.contact_distance": [0.03, 0.04, 0.05]}


def test_reasons_why_runs_are_not_safe_have_marks_of_their_own():
    """Ten of them, some of them outcomes, some failures, some limits."""
    limits = ["stroke above its limit", "relative energy above its limit", "peak force above its limit"]
    sweep = swept(SPEEDS)
    found = jb.safe_rectangle(sweep, jb.Limits())
    ends = ["escaped", "bottomed", "timeout", "torn", "failed: failed_steps", "failed: failed_input", "not computed"]
    reasons = np.array([*limits, *ends, "", ""], object).reshape(found.safe.shape)
    figure = envelope_figure(dataclasses.replace(found, reasons=reasons, safe=reasons == ""))
    assert check_marks(figure) >= 11


@pytest.mark.parametrize("mechanism", all_mechanisms(), ids=lambda mechanism: mechanism.name)
def test_outcomes_and_reasons_of_a_mechanism_have_distinct_markers(mechanism):
    ended = outcome_marks(mechanism)
    reasons = reason_marks(mechanism, [*ended, *(f"limit {number}" for number in range(20))])
    assert len(set(reasons.values())) == len(reasons)
    best = success_marks(mechanism.successes)
    assert len({marker for marker, _ in [*best.values(), *ended.values()]}) == len(best) + len(ended)


@pytest.mark.parametrize("asked", [SPEEDS, {"scenario.approach_speed": [0.1, 0.12, 0.15, 0.2, 0.25, 0.3, 0.31]}])
def test_held_and_latched_are_told_apart_in_a_sweep(asked):
    outcomes = {0: jb.Outcome.latched, 1: jb.Outcome.held, 3: jb.Outcome.timeout, 4: jb.Outcome.failed_steps}
    assert check_marks(sweep_figure(swept(asked, {**outcomes, 5: jb.Outcome.torn, 6: jb.Outcome.escaped}))) >= 5


@pytest.mark.parametrize("stacked", [False, True])
def test_many_curves_of_a_panel_are_told_apart(stacked):
    figure, ((axes,),) = panels(6.0, 4.0, 1, 1)
    time = np.linspace(0.0, 1.0, 5)
    curves = tuple(PanelCurve(f"part {k}", 1.0 + k * time) for k in range(11))
    _draw(axes, time, Panel("parts", "energy [J]", curves, stacked=stacked), Window(0.0, 1.0, "s", 1.0))
    assert check_marks(figure) == 11


DESIGNS = {
    "docking": lambda: jb.replace(jb.table2(), {"latch.stiffness": 2e3, "buffer.stop_stiffness": 1e5}),
    "bar drop": jb.BarDrop,
    "slider-crank": jb.SliderCrank,
    "tank drop": jb.TankDrop,
}


@pytest.mark.parametrize("name", DESIGNS)
def test_the_parts_of_a_drawing_are_told_apart(name):
    """Both springs of a docking probe, its end stop and its latches among them."""
    design = DESIGNS[name]()
    mechanism = next(it for it in all_mechanisms() if isinstance(design, it.design))
    shapes = mechanism.view.drawing(design, mechanism.view.names(design).bodies).shapes
    figure, ((axes,),) = panels(6.0, 4.0, 1, 1)
    frames = np.array([[0.1 * k, 0.0, 0.0] for k in range(400)])
    named = sketch(axes, shapes, frames)
    axes.legend([*named.values()], [*named])
    check_marks(figure)
    if name == "docking":
        assert {"axial spring and damper", "hinge with torsional spring and damper"} <= set(named)


def test_the_check_notices_series_that_are_drawn_alike():
    figure, ((axes,),) = panels(6.0, 4.0, 1, 1)
    for colour, marker in itertools.product(["#555555"], ["D", "D"]):
        axes.scatter([0.0], [1.0], marker=marker, color=colour, label=f"{colour} {marker} {len(axes.collections)}")
    axes.legend()
    with pytest.raises(AssertionError, match="are drawn alike"):
        check_marks(figure)
