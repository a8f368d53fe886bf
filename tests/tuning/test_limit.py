"""One decision for limits: what keeps one, how it is said, what an end that is asked for adds."""

import dataclasses
import itertools
import math
import pickle
import types

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.limit import ROUNDING, Limit
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.study.load import loads
from jaxbuffer.study.tuned_toml import tuned_toml
from jaxbuffer.tuning.search.goal import Goal
from jaxbuffer.tuning.search.measurement import Margin, margin_of_end
from jaxbuffer.tuning.search.store import in_words, record_of
from jaxbuffer.value_text import before_and_after, change_text, relative_change
from made_up import made_up_evaluation, made_up_tuning

LATCH = {"latch.stiffness": 2e3, "latch.damping": 50.0}  # N/m, N s/m
QUIET = 1e-3  # the default of latch.quiet
RELATIVE_ENERGY = PROBE_CONE.quantities["relative_energy"]


def problem(cases=2, **fields):
    design = jb.replace(jb.table2(), LATCH)
    scenarios = [jb.Scenario(approach_speed=0.1 + 0.05 * k) for k in range(cases)]
    return jb.Problem(design, scenarios, [jb.Variable("buffer.k_A", 100.0, 2000.0)], **fields)


def evaluated(stated, outcome, **values):
    """A made-up evaluation of which every run ends with an outcome, and has some values of quantities."""
    point = made_up_evaluation(stated, stated.start())
    rest = point.rest.copy()
    for name, value in values.items():
        rest[:, stated.names.index(name) - 1] = value
    code = np.full(len(point.code), int(outcome))
    return point._replace(rest=rest, code=code, succeeded=stated.succeeded(code))


@pytest.mark.parametrize("lowest", [False, True])
def test_a_value_on_its_limit_keeps_it_and_an_unknown_one_does_not(lowest):
    limit, sign = Limit("stroke", 0.025, lowest), -1.0 if lowest else 1.0
    near = [0.025, 0.025 * (1.0 + sign * 1e-13), 0.025 * (1.0 + sign * 1e-7), math.nan, None]
    assert limit.keeps(near).tolist() == [True, True, False, False, False]
    assert limit.excess(0.025 * (1.0 + sign * 0.1)) == pytest.approx(0.1)
    assert limit.margin(None) is None and limit.margin(math.nan) is None
    assert limit.worst([0.025, math.nan]) is None and np.isinf(limit.share(math.nan))


@pytest.mark.parametrize("share", [1.0 + 2e-4, 1.0 + 3e-7, 1.0 + 1e-8])
def test_a_sentence_has_as_many_digits_as_tell_the_value_from_its_bound(share):
    said = Limit("relative_energy", QUIET).sentence(share * QUIET, RELATIVE_ENERGY)
    value, bound = said.removeprefix("relative_energy ").removesuffix(" %").split(" % is above ")
    assert float(bound) == 0.1 and float(value) > float(bound)
    assert Limit("relative_energy", QUIET).sentence(0.0123456, RELATIVE_ENERGY) == (
        "relative_energy 1.235 % is above 0.1 %"
    )


def test_a_change_has_a_meaning_unless_it_begins_at_zero_or_turns_its_sign():
    assert relative_change(2.0, 3.0) == 0.5 and relative_change(0.0, 0.0) == 0.0
    assert relative_change(-2.0, -3.0) == -0.5, "a fall by half of its size"
    for before, after in ((0.0, 1.0), (1.0, -1.0), (math.nan, 1.0), (1.0, math.inf), (None, 1.0), (5e-324, 1e10)):
        assert relative_change(before, after) is None and change_text(before, after) == "–"
    assert change_text(4.0, 3.0) == "-25.0 %" and change_text(1.0, 0.0) == "-100.0 %"


def test_a_run_that_ends_where_its_energy_is_quiet_keeps_a_limit_of_that_share():
    """Location leaves 1e-14 of the share: the limit is kept, and the tuning is feasible."""
    stated = problem(limits=jb.Limits(at_most={"relative_energy": QUIET}))
    goal = Goal(stated, stated.objective)
    for rounding, kept in ((2e-14, True), (2.0 * ROUNDING, False)):
        point = evaluated(stated, jb.Outcome.held, relative_energy=QUIET * (1.0 + rounding))
        assert goal.feasible(point) == kept and bool(goal.broken(point)) != kept


def test_held_is_asked_for_by_name_in_python_and_in_a_study():
    limits = jb.Limits(held=True, at_most={"stroke": 0.025})
    assert limits.held and not limits.latched and limits == pickle.loads(pickle.dumps(limits))
    assert dataclasses.replace(limits, at_most={}).held and "held=True" in repr(limits)
    text = "[latch]\nstiffness = 2e3\ndamping = 50\n[problem.constraints]\nheld = true\nstroke = '25 mm'"
    read = loads(text.encode(), "study.toml").problem()
    assert read.limits == limits and read.success == "held"
    again = loads(tuned_toml(read.design, read, "").encode(), "design.toml")
    assert again.problem().limits == limits


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: jb.Limits(hold=True), "constraints.hold is unknown; did you mean held?"),
        (lambda: jb.Limits(held=1), "constraints.held = 1 must be true or false"),
        (lambda: jb.Limits(require_success=False, held=True), "require_success = false and held = true contradict"),
        (
            lambda: jb.Problem(
                jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 1e2, 2e3)], limits=jb.Limits(held=True)
            ),
            "constraints.held needs latch.stiffness, which the design has not",
        ),
        (
            lambda: jb.Problem(
                jb.BarDrop(), [jb.BarDropScenario()], [jb.Variable("impact.stiffness", 1e10, 1e12)],
                limits=jb.Limits(held=True),
            ),
            "constraints.held is unknown",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_asked_for_is_refused(call, words):
    with pytest.raises(jb.InputError) as caught:
        call()
    assert words in str(caught.value)


@pytest.mark.parametrize("limits", [jb.Limits(held=True), jb.Limits(at_most={"settling_time": 30.0})])
def test_a_run_that_is_latched_and_not_held_breaks_what_waits_for_held(limits):
    """Even where the time to wait for is longer than the run."""
    stated = problem(limits=limits)
    goal = Goal(stated, stated.objective)
    held = evaluated(stated, jb.Outcome.held, relative_energy=QUIET, settling_time=2.0)
    assert goal.feasible(held) and goal.broken(held) == []
    latched = evaluated(stated, jb.Outcome.latched, relative_energy=0.02, settling_time=20.0)
    latched = latched._replace(margin=np.full(2, -math.log(0.02 / QUIET)))
    assert not goal.feasible(latched)
    assert all("not held (relative_energy 2 % is above 0.1 %)" in line for line in goal.broken(latched)[::2])
    assert goal.obstacle(latched) == "not held (relative_energy 2 % is above 0.1 %) at scenario 1 (0.1 m/s, 0°)"
    assert not stated.known(latched.code)[:, stated.names.index("settling_time")].any()


@pytest.mark.parametrize("duration", [4.0, 12.0])
def test_the_margin_of_held_is_that_of_an_exponential(duration):
    """The share exp(-γ t) is quiet at t = ln(1/q)/γ: the margin is the logarithm of the duration over that, or γ T less
    ln(1/q), both zero where it just happens; slopes by γ are those of differences."""
    (_, end), design = PROBE_CONE.tuning.ends, jb.replace(jb.table2(), LATCH)

    def margin(gamma):
        time, own = math.log(1.0 / QUIET) / gamma, Margin(1.0, np.zeros(1))
        held = time <= duration
        left = QUIET if held else math.exp(-gamma * duration)
        by_gamma = 0.0 if held else -duration * left
        numbers = {
            "end_time": Margin(time if held else duration, np.array([-time / gamma if held else 0.0])),
            "relative_energy": Margin(left, np.array([by_gamma])),
        }
        outcome = jb.Outcome.held if held else jb.Outcome.latched
        run = types.SimpleNamespace(mechanism=PROBE_CONE, outcome=outcome, design=design)
        return margin_of_end(end, run, own, numbers, duration)

    just = math.log(1.0 / QUIET) / duration
    for gamma in (0.5 * just, 0.99 * just, 1.01 * just, 2.0 * just):
        found = margin(gamma)
        expected = math.log(gamma / just) if gamma > just else (gamma - just) * duration
        assert found.value == pytest.approx(expected, rel=1e-12)
        difference = (margin(gamma * 1.0001).value - margin(gamma * 0.9999).value) / (2e-4 * gamma)
        assert found.slope[0] == pytest.approx(difference, rel=1e-4)


def test_a_run_that_is_not_even_latched_is_farther_from_held_and_led_by_the_margin_of_capture():
    _, end = PROBE_CONE.tuning.ends
    run = types.SimpleNamespace(mechanism=PROBE_CONE, outcome=jb.Outcome.timeout, design=jb.replace(jb.table2(), LATCH))
    own = Margin(-0.3, np.array([2.0]))
    found = margin_of_end(end, run, own, {}, 8.0)
    assert found.value == pytest.approx(math.log(QUIET) - 0.3) and found.slope[0] == 2.0


@pytest.mark.parametrize(("outcome", "said"), [("latched", "held is not asked for: 0 of 2 are held"), ("held", "")])
def test_a_summary_says_that_held_is_not_asked_for(outcome, said):
    stated = problem()
    tuned = made_up_tuning(stated)
    after = evaluated(stated, jb.Outcome[outcome])
    tuned = dataclasses.replace(tuned, after=after, before=evaluated(stated, jb.Outcome.held))
    text = " ".join(repr(tuned).split())
    assert ("held is not asked for" in text) == bool(said) and said in text
    assert f"cases held 2 of 2 {'0' if said else '2'} of 2" in text
    assert str(tuned.end_count(tuned.before)) == "held in 2 of 2"


@pytest.mark.parametrize(("before", "after"), [(0.0, 250.0), (250.0, 0.0), (0.0, 0.0), (math.nan, 250.0)])
def test_a_scenario_that_touches_nothing_is_a_row_of_the_summary(before, after):
    stated = problem()
    tuned = made_up_tuning(stated)
    sides = {}
    for name, peak in (("before", before), ("after", after)):
        point = getattr(tuned, name)
        peaks = point.peaks.copy()
        peaks[0, 0] = peak
        sides[name] = point._replace(peaks=peaks)
    text = repr(dataclasses.replace(tuned, lower_bound=None, **sides))
    change = "+0.0 %" if before == after else "-100.0 %" if after == 0.0 else "–"
    (row,) = (line for line in text.splitlines() if "0.1 m/s" in line and "→" in line and "captured" in line)
    assert before_and_after(before, after, 5) in row and change in row


def test_progress_names_the_limit_in_the_way_and_the_first_impact_beneath_it():
    """Peaks of 250 and 300 N, first impacts of half of that, over 60 N."""
    stated = problem(limits=jb.Limits(at_most={"peak_force": 60.0}))
    goal = Goal(stated, stated.objective)
    record = record_of(goal, made_up_evaluation(stated, stated.start()), 0, 0, 0, None)
    said = in_words(record, stated.success)
    assert "limits broken: peak_force 300 N is above 60 N" in said
    assert "the first impact, which no buffer softens, has 150 N" in said


@pytest.mark.parametrize("values", [*itertools.product([0.0, 250.0], repeat=2)])
def test_a_limit_on_nothing_that_is_known_is_broken_by_a_failed_run(values):
    """Whatever numbers stand in a failed evaluation."""
    stated = problem(limits=jb.Limits(require_success=False, at_most={"stroke": 0.1}))
    goal, point = Goal(stated, stated.objective), made_up_evaluation(stated, stated.start())
    peaks = point.peaks.copy()
    peaks[:, 0] = values
    failed = point._replace(peaks=peaks, solved=np.zeros(2, bool), succeeded=np.zeros(2, bool))
    assert not goal.feasible(failed) and goal.broken(failed)[0].endswith("the simulation failed")
