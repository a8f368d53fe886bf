"""The table of limits after a tuning and a run: value, bound, room, load case, and what stands in the way."""

import dataclasses
import math

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.limit import IMPACTS, Limit
from jaxbuffer.output.tune_figure import _rows
from jaxbuffer.tables import text as text_of
from jaxbuffer.tuning.report.limit_rows import LimitRow, limit_rows
from jaxbuffer.tuning.report.limits_in_the_way import limits_in_the_way
from jaxbuffer.tuning.report.message import SearchReport
from jaxbuffer.tuning.search.checks import LeastValue
from jaxbuffer.tuning.search.goal import Goal
from jaxbuffer.tuning.search.store import in_words, record_of
from made_up import made_up_evaluation, made_up_tuning

CASES = [{"stroke": 0.02, "peak_force": 90.0, IMPACTS: 3}, {"stroke": 0.03, "peak_force": 70.0, IMPACTS: 5}]
LABELS = ["slow", "fast"]


@pytest.mark.parametrize(
    ("limit", "value", "where", "room", "state"),
    [
        (Limit("stroke", 0.025), 0.03, "fast", -0.2, "broken"),
        (Limit("stroke", 0.03), 0.03, "fast", 0.0, "at the limit"),
        (Limit("peak_force", 100.0), 90.0, "slow", 0.1, "kept"),
        (Limit("peak_force", 56.0, lowest=True), 70.0, "fast", 0.25, "kept"),
        (Limit(IMPACTS, 4), 5, "fast", None, "broken"),
        (Limit("bending", 1.0), None, "", None, "not known"),
    ],
)
def test_a_row_is_of_the_worst_load_case(limit, value, where, room, state):
    row = LimitRow.of(limit, CASES, LABELS)
    assert (row.value, row.where, row.state) == (value, where, state)
    assert row.room == (None if room is None else pytest.approx(room, abs=1e-15))


@pytest.mark.parametrize("unknown", [None, math.nan])
def test_a_value_that_is_not_known_is_the_worst(unknown):
    row = LimitRow.of(Limit("stroke", 0.05), [*CASES, {"stroke": unknown}], [*LABELS, "lost"])
    assert (row.value, row.where, row.room, row.state) == (None, "lost", None, "broken")
    assert row.value_text("mm", 1e3) == "–"


def test_what_stands_in_the_way_comes_first():
    """Shares of 90, 120, 100 and 95 %."""
    limits = [
        Limit("peak_force", 100.0),
        Limit("stroke", 0.025),
        Limit("stroke", 0.03),
        Limit("peak_force", 90.0 / 0.95),
    ]
    rows = limit_rows(limits, CASES, LABELS)
    assert [row.limit for row in rows] == [limits[k] for k in (1, 2, 3, 0)]


def test_a_broken_value_that_reads_like_its_bound_has_the_digits_that_tell_it_apart():
    row = LimitRow.of(Limit("stroke", 0.025), [{"stroke": 0.0250002}], [""])
    assert row.value_text("mm", 1e3) == "25.0002 mm" and row.limit.bound_text("mm", 1e3) == "≤ 25 mm"


def tuning(**limits):
    """A made-up tuning of two scenarios and a variable on its bound, whose peaks are 200 and 240 N, 0.8 of 250 and 300;
    a lower bound of 0.4 of each."""
    scenarios = [jb.Scenario(approach_speed=speed) for speed in (0.1, 0.15)]
    variables = [jb.Variable("buffer.k_A", 100.0, 2000.0), jb.Variable("probe.tip_mass", 0.02, 0.2)]
    stated = jb.Problem(jb.table2(), scenarios, variables, limits=jb.Limits(at_most=limits))
    tuned = made_up_tuning(stated)
    scaled = np.array([tuned.after.scaled[0], 0.0])
    slopes = np.ones_like(tuned.after.rest_slope)  # both variables change something
    return dataclasses.replace(tuned, after=tuned.after._replace(scaled=scaled, rest_slope=slopes))


def rows_of(text, heading):
    """The rows of a table by their first cells."""
    lines = text[text.index(heading) :].split("\n\n")[1].splitlines()
    rows = [line.strip() for line in lines[2:]]  # below the headings and their line
    return {line[: line.index("  ")]: " ".join(line.split()) for line in rows}


def test_the_summary_of_a_tuning_has_the_table():
    tuned = tuning(peak_force=200.0, stroke=0.1)
    peak = float(tuned.after.peak_force.max())
    rows = rows_of(repr(tuned), "Limits: what stands in the way")
    assert next(iter(rows)) == "peak contact force" and rows["peak contact force"].endswith("2: 0.15 m/s, 0° broken")
    assert f"{peak:.4g} N ≤ 200 N {100 * (1 - peak / 200):.3g} %" in rows["peak contact force"]
    assert rows["buffer stroke"].endswith("kept") and "≤ 100 mm" in rows["buffer stroke"]
    assert rows["share of the stroke (always)"].endswith("kept")
    assert rows["probe.tip_mass"] == "probe.tip_mass 0.02 kg ≥ 0.02 kg 0 % – at low bound"
    assert "buffer.k_A" not in rows
    assert f"{peak:.4g} N ≥ {0.4 * peak:.4g} N 150 % 2: 0.15 m/s, 0°" in rows["first impact: peak contact force"]


ELASTICITIES = {"cone.half_angle": 0.84, "probe.rod_mass": 0.31, "probe.tip_mass": 0.12, "active.mass": 0.009}


def lower_bound(tuned, **least):
    """Its lower bound with those of some quantities, in the first load case; elasticities of a variable and others."""
    at = np.array([0.3, 0.0])
    values = {name: LeastValue(value, 0, at, np.array([0.0, 5.0]), ELASTICITIES) for name, value in least.items()}
    return dataclasses.replace(tuned.lower_bound, least=values, elasticities=ELASTICITIES)


def test_a_limit_under_the_lower_bound_says_so_and_what_would_lower_it():
    """No word of the bounds of the buffer's variables, which cannot keep it."""
    tuned = tuning(peak_hinge_force=50.0)
    bound = lower_bound(tuned, peak_hinge_force=192.0)
    tuned = dataclasses.replace(tuned, lower_bound=bound)
    message = SearchReport("", "2 searches").message(tuned.goal, tuned.after, bound)
    for text in (message, " ".join(tuned.broken_limits)):
        assert "it lies under the lower bound of peak_hinge_force, 192 N at scenario 1 (0.1 m/s, 0°)" in text
        assert "it would fall" not in text and "that would fall with probe.tip_mass below its bound of 0.02 kg" in text
        assert "cone.half_angle +0.84, probe.rod_mass +0.31" in text and "active.mass" not in text
    assert "widen" not in message
    assert message.endswith("To keep the limits, lower that bound, or relax the limit under it")
    rows = rows_of(repr(tuned), "Limits: what stands in the way")
    assert rows["first impact: peak hinge force"].endswith("above the limit")
    # No search within the bounds gets below it.
    report = SearchReport("", "2 searches", ". To search on, raise starts")
    assert report.message(tuned.goal, tuned.after, bound) == message
    assert report.message(tuned.goal, tuned.after, None).endswith(". To search on, raise starts")
    # Where no variable on its bound would lower it, other numbers alone are named.
    least = bound.least["peak_hinge_force"]._replace(slope=np.zeros(2))
    alone = dataclasses.replace(bound, least={"peak_hinge_force": least})
    fall = "; that would fall by numbers that are no variables, in per cent for 1 % more of each: cone.half_angle +0.84"
    assert fall in report.message(tuned.goal, tuned.after, alone)
    # A limit above its lower bound, or one that is not known, is spoken of as any other.
    for other in (lower_bound(tuned, peak_hinge_force=49.0), None):
        assert "lower bound" not in SearchReport("", "2 searches").message(tuned.goal, tuned.after, other)


def test_levers_of_the_first_impact_are_listed_where_the_peak_is_near_its_lower_bound():
    tuned = tuning()
    peak = tuned.after.peak_force
    for share, listed in ((1.04, True), (1.06, False)):
        bound = dataclasses.replace(lower_bound(tuned), simulated=peak / share)
        text = " ".join(repr(dataclasses.replace(tuned, lower_bound=bound)).split())
        outside = "numbers that are no variables move it, in per cent for 1 % more of each: cone.half_angle +0.84,"
        assert (outside in text) == listed and ("of the variables probe.tip_mass +0.12" in text) == listed


def test_progress_names_the_limit_and_the_load_case():
    """Peaks of 250 and 300 N: 20 % above 250 N; 0.33 % below 301 N; far below 400 N."""
    scenarios = [jb.Scenario(approach_speed=speed) for speed in (0.1, 0.15)]

    def said(limit):
        stated = jb.Problem(
            jb.table2(), scenarios, [jb.Variable("buffer.k_A", 100.0, 2000.0)],
            limits=jb.Limits(at_most={"peak_force": limit}),
        )  # fmt: skip
        goal = Goal(stated, stated.objective)
        return in_words(record_of(goal, made_up_evaluation(stated, stated.start()), 0, 0, 0, None), stated.success)

    assert said(250.0).endswith("limits broken: peak_force 300 N is above 250 N by 20 % at scenario 2 (0.15 m/s, 0°)")
    assert said(301.0).endswith("300 N, 0.33 % of room to peak_force ≤ 301 N at scenario 2 (0.15 m/s, 0°)")
    assert said(400.0).endswith("300 N")


def ending(outcome, **values):
    """A made-up tuning of two scenarios of a design with latches, all of whose runs end so, with some values."""
    design = jb.replace(jb.table2(), {"latch.stiffness": 2e3, "buffer.rebound_stiffness": 1e4})
    scenarios = [jb.Scenario(approach_speed=speed) for speed in (0.1, 0.15)]
    stated = jb.Problem(design, scenarios, [jb.Variable("buffer.k_A", 100.0, 2000.0)])
    point = made_up_evaluation(stated, stated.start())
    rest, code = point.rest.copy(), np.full(2, int(jb.Outcome[outcome]))
    for name, value in values.items():
        rest[:, stated.names.index(name) - 1] = value
    point = point._replace(rest=rest, code=code, succeeded=stated.succeeded(code))
    return dataclasses.replace(made_up_tuning(stated), before=point, after=point)


def test_what_is_left_is_listed_unless_all_runs_are_held():
    assert "What is left where the capture ends" in repr(ending("latched", relative_energy=0.02))
    assert "What is left" not in repr(ending("held", relative_energy=0.001))


def test_a_tuning_says_that_its_latch_adds_much_energy_and_where_most():
    """9 and 67 % of what the vehicles bring, against a tenth."""
    text = " ".join(repr(ending("held", latch_energy_share=[0.09, 0.67])).split())
    assert "adds more than a tenth of what the vehicles bring (latch_energy_share;" in text
    assert "in 1 of 2 scenarios, by a factor of 6.7 at scenario 2 (0.15 m/s, 0°)" in text
    assert "adds more than a tenth" not in repr(ending("held", latch_energy_share=0.0999))


def test_a_variable_that_reads_like_its_bound_is_on_it():
    """ln 1.0000176 / ln 50 is 4.5e-6 of its range, and five digits show 20; 20.002 they tell apart."""
    variable = jb.Variable("buffer.k_T", 20.0, 1000.0)
    assert variable.at_bound(20.000353) == "at low bound" and variable.at_bound(999.98) == "at high bound"
    assert variable.at_bound(20.002) == ""


def test_the_table_of_a_single_run_names_no_load_case():
    design, limits = jb.replace(jb.table2(), {}), jb.Limits(at_most={"stroke": 0.025})
    tuned = tuning(stroke=0.1)
    several = text_of(limits_in_the_way(tuned.goal, tuned.after, tuned.lower_bound))
    assert "load case" in several
    one = jb.Problem(design, [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)], limits=limits)
    made = made_up_tuning(one)
    alone = text_of(limits_in_the_way(made.goal, made.after, made.lower_bound))
    assert "load case" not in alone and "10 mm   ≤ 25 mm" in alone and "kept" in alone


def with_corners(**values):
    """A made-up tuning of a scenario with a tolerance, which has two corners, and some values of its three load
    cases."""
    stated = jb.Problem(
        jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)], tolerances={"buffer.c_A": "10 %"}
    )
    point = made_up_evaluation(stated, stated.start())
    rest = point.rest.copy()
    for name, value in values.items():
        rest[:, stated.names.index(name) - 1] = value
    point = point._replace(rest=rest)
    return dataclasses.replace(made_up_tuning(stated), before=point, after=point)


def test_corners_of_a_single_scenario_have_their_numbers_in_tables_as_in_figures():
    tuned = with_corners(arrest_stroke=[0.01, 0.03, 0.02])
    labels = [tuned.problem.label(k) for k in range(3)]
    assert labels == ["1: 0.1 m/s, 0°", "1.1: 0.1 m/s, 0°, 0.9 buffer.c_A", "1.2: 0.1 m/s, 0°, 1.1 buffer.c_A"]
    text = " ".join(repr(tuned).split())
    assert "there in scenario 1.1 30 mJ" in text and "may take up to 30 mm of stroke" in text
    assert jb.Problem(jb.table2(), [jb.Scenario()], tuned.problem.variables).label(0) == "0.1 m/s, 0°"


@pytest.mark.parametrize(("extension", "drawn"), [(2e-15, False), (2e-6, True)])
def test_a_figure_of_a_tuning_leaves_rounding_out(extension, drawn):
    """Beside strokes of 10 mm."""
    assert any("buffer extension" in row.text for row in _rows(with_corners(extension=extension))) == drawn
