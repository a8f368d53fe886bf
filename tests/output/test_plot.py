"""Figures: every axis says what it shows and in which unit, and nothing outside the figure changes."""

import dataclasses
import re
import sys

import equinox as eqx
import matplotlib
import numpy as np
import pytest

from jaxbuffer import InputError, Limits, Outcome, Scenario
from jaxbuffer.output.envelope_figure import _between_safe
from jaxbuffer.output.figures import run_figure
from jaxbuffer.output.style import png
from jaxbuffer.output.tune_figure import tune_figure
from jaxbuffer.output.tuned_files import tuned_files
from jaxbuffer.output.words import in_thousands
from jaxbuffer.study.config import Config
from made_up import PULSE, made_up_capture, made_up_tuning
from output.drawn import check_readable

UNIT = re.compile(r"\[(s|ms|N|mm|J|°|%|-)\]$")


def labelled(figure):
    """The figure's axes by title, after a check of every label and of what overlaps."""
    check_readable(figure)
    for axes in figure.axes:
        assert UNIT.search(axes.get_xlabel()), axes.get_xlabel()
        names = re.search("[a-z]", "".join(text.get_text() for text in axes.get_yticklabels()))  # these need no label
        assert names or UNIT.search(axes.get_ylabel()) or "[-]" in axes.get_ylabel(), axes.get_ylabel()
    return {axes.get_title(loc="left"): axes for axes in figure.axes}


def test_run_figure():
    figure = run_figure(made_up_capture())
    axes = labelled(figure)
    assert list(axes) == [
        "Contact force",
        "The peak, 250 N at 20 ms",
        "Gap and distance to capture",
        "Energy without that of the common motion",
        "Buffer stroke",
        "Hinge angle, from -0.229 to 0°",
    ]
    zoom = axes["The peak, 250 N at 20 ms"]
    assert zoom.get_xlim()[0] == pytest.approx(-0.75e3 * PULSE, rel=0.15), "the impact and a quarter of it either side"
    assert zoom.get_ylim()[1] > 250.0
    assert axes["Buffer stroke"].get_ylim()[1] > 7.5
    assert axes["Hinge angle, from -0.229 to 0°"].get_ylim()[0] < -0.2, "signed"
    assert png(figure).startswith(b"\x89PNG")


@pytest.mark.parametrize("at", [0.0, 0.04])
def test_a_peak_at_an_end_of_the_run_is_drawn(at):
    zoom = run_figure(made_up_capture(at=at)).axes[1]
    assert max(np.max(line.get_ydata()) for line in zoom.lines) == pytest.approx(250.0, rel=1e-2)


def test_tune_figure():
    config = Config(scenarios=tuple(Scenario(approach_speed=speed) for speed in (0.1, 0.15, 0.2, 0.25)))
    tuned = made_up_tuning(config.problem())
    figure = tune_figure(tuned)
    axes = labelled(figure)
    assert list(axes) == [
        "Peak contact force",
        "Worst over the scenarios, before → after",
        "Variables between their bounds, before → after",
        "Every design tried for:\npeak force, worst over the scenarios",
    ]
    peaks = axes["Peak contact force"]
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["before", "after", "lower bound: first impact, no buffer"]
    named = [text.get_text() for text in peaks.get_yticklabels()]
    assert named == ["1: 0.1 m/s, 0°", "2: 0.15 m/s, 0°", "3: 0.2 m/s, 0°", "4: 0.25 m/s, 0°"]
    objective = axes["Every design tried for:\npeak force, worst over the scenarios"]
    legend = objective.get_legend()
    assert legend.get_window_extent().x0 >= objective.get_window_extent().x1 - 1.0, "it hides no curve"
    labels = [text.get_text() for text in legend.get_texts()]
    assert labels == ["starts", "search", "infeasible", "best so far"]
    assert np.all(np.diff(objective.lines[-1].get_ydata()) <= 0.0), "the best so far"
    ticks = [text.get_text() for text in axes["Worst over the scenarios, before → after"].get_yticklabels()]
    assert ticks[2] == "peak contact force:\n400 → 320 N"
    assert "limit 25 mm\nroom " in ticks[0] and ticks[0].endswith(" in 1"), "the stroke's, first"
    assert png(figure).startswith(b"\x89PNG")


def test_a_lower_limit_is_held_against_the_least():
    problem = Config(scenarios=(Scenario(), Scenario(approach_speed=0.2))).problem()
    problem = dataclasses.replace(problem, limits=Limits(at_least={"peak_force": 150.0}))
    shown = labelled(tune_figure(made_up_tuning(problem)))["Worst over the scenarios, before → after"]
    assert shown.get_yticklabels()[0].get_text() == "peak contact force:\n250 → 200 N, at least 150 N\nroom 33.3 % in 1"
    before, _, after = shown.lines[:3]
    shares = [before.get_xdata()[0], after.get_xdata()[0]]
    np.testing.assert_allclose(shares, [250.0 / 1.5, 200.0 / 1.5])  # %, of the slower scenario


def test_tune_figure_with_the_worst_scenario_over_time():
    tuned = made_up_tuning(Config().problem())
    figure = tune_figure(tuned, [made_up_capture(peak=400.0), made_up_capture(peak=320.0)])
    force = figure.axes[0]
    assert force.get_title(loc="left") == "Force in the worst scenario, 0.1 m/s, 0°"
    names = [text.get_text() for text in force.get_legend().get_texts()]
    assert names == ["before, at most 400 N", "after, at most 320 N"]


def test_bounds_of_stiff_springs_need_no_exponent():
    assert in_thousands("N/m", 100.0, 2e4) == ("kN/m", 1e-3) and in_thousands("N/m", 100.0, 9e3) == ("N/m", 1.0)
    assert in_thousands("mm", 2e4) == ("mm", 1.0) and in_thousands("N s/m", 5e4) == ("kN s/m", 1e-3)


def test_only_what_lies_between_safe_runs_is_shaded():
    """By hand: one run of twelve is not safe, which leaves two of the six cells between them."""
    safe = np.ones((3, 4), bool)
    safe[1, 1] = False
    assert _between_safe(safe).tolist() == [[False, False, True], [False, False, True]]


def test_time_axes_end_soon_after_the_last_contact():
    figure = run_figure(made_up_capture(at=0.002))
    assert "nothing touches from there to 40 ms" in figure.get_suptitle()
    assert figure.axes[0].get_xlim()[1] < 5.0


def test_settings_of_matplotlib_stay_as_they_were():
    before = dict(matplotlib.rcParams)
    run_figure(made_up_capture())
    assert dict(matplotlib.rcParams) == before


def test_a_capture_without_history_is_refused():
    capture = eqx.tree_at(lambda c: c.history, made_up_capture(), None)
    with pytest.raises(InputError, match="history=True"):
        run_figure(capture)


def test_without_matplotlib_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError, match=r"pip install matplotlib"):
        run_figure(made_up_capture())


@pytest.mark.parametrize("fails", ["an outcome", "an error"])
def test_a_worst_scenario_that_fails_leaves_the_other_panels(monkeypatch, fails):
    def simulate(*given, **options):
        if fails == "an error":
            raise InputError("the design is out of its range")
        return made_up_capture(outcome=Outcome.failed_steps)

    monkeypatch.setattr("jaxbuffer.output.tuned_files.simulate", simulate)
    lines = []
    files = tuned_files(made_up_tuning(Config().problem()), None, lines.append)
    assert files["tune.png"]().startswith(b"\x89PNG") and files["tuned.json"]()
    (line,) = lines
    assert line.startswith("no force over time in tune.png, force.json")
