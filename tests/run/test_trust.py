"""How far a run's numbers can be trusted, against runs at tight tolerance."""

import dataclasses

import numpy as np
import pytest
from benchmarks.trust import drawn

import jaxbuffer as jb
from jaxbuffer.run.request import TOLERANCES, tenth
from jaxbuffer.run.trust import DOUBTFUL, HOPELESS, SAFETY, Trust, changes, trust
from made_up import made_up_capture

BOUNCING = {
    "buffer.k_A": 88.0, "buffer.c_A": 0.73, "buffer.k_T": 18800.0, "buffer.c_T": 0.0615, "probe.tip_mass": 0.0343,
    "contact.restitution": 0.962, "contact.friction": 0.0106,
}  # fmt: skip
MET = jb.Scenario(approach_speed=0.0346, misalignment=-0.08, passive_rate=-0.0217, contact_distance=0.0357)


def moved(run, **changes):
    result = dataclasses.replace(run)
    for name, value in changes.items():
        object.__setattr__(result, name, value)
    return result


def test_an_error_is_three_times_the_change_over_the_value():
    run = made_up_capture(peak=200.0)
    verdict = trust(run, moved(run, peak_force=np.asarray(200.0 * (1.0 + 1e-6))))
    assert verdict.errors["peak_force"] == pytest.approx(SAFETY * 1e-6, rel=1e-6)
    assert verdict.worst[0] == "peak_force" and verdict.verdict == "trusted"
    assert str(verdict) == "a tenth of the tolerance changes no number by more than 3e-06 of it (peak_force)"


@pytest.mark.parametrize(("change", "verdict"), [(2e-5, "trusted"), (5e-5, "check"), (5e-3, "ill-conditioned")])
def test_the_verdict_goes_by_the_worst(change, verdict):
    run = made_up_capture(peak=200.0)
    result = trust(run, moved(run, peak_force=np.asarray(200.0 * (1.0 - change))))
    assert result.verdict == verdict
    assert ("peak_force (by" in str(result)) == (verdict != "trusted")


def test_what_else_changes_makes_it_ill_conditioned():
    errors = {"peak_force": 2.0 * DOUBTFUL}
    assert Trust(errors, "").verdict == "check"
    assert Trust(errors, "there are 5 impacts instead of 4").verdict == "ill-conditioned"
    assert Trust({"peak_force": 0.5 * DOUBTFUL}, "there are 5 impacts instead of 4").verdict == "trusted"
    assert Trust({"peak_force": 0.0}, "the outcome is another: …").verdict == "ill-conditioned"
    assert Trust({"peak_force": 1.1 * HOPELESS}, "").verdict == "ill-conditioned"


def test_what_only_one_run_has_is_not_trusted():
    run, nan = made_up_capture(), np.asarray(np.nan)
    for one, other in ((run, moved(run, peak_force=nan)), (moved(run, peak_force=nan), run)):
        verdict = trust(one, other)
        assert verdict.worst == ("peak_force", np.inf) and verdict.verdict == "ill-conditioned"
    neither = trust(moved(run, peak_force=nan), moved(run, peak_force=nan))
    assert neither.errors["peak_force"] == 0.0 and neither.verdict == "trusted"


def test_small_numbers_are_held_against_large_ones_of_their_unit():
    """A penetration of 10 µm beside lengths of decimetres matters little, and less where the tip is at the end: that
    is a distance to either side of its seat."""
    run = made_up_capture()
    deep, ahead = float(run.penetration), float(run.throat_distance)
    largest = max(float(q.of(run)) for q in map(run.mechanism.quantities.get, run.mechanism.swept) if q.unit == "m")
    assert 0.0 < deep < 1e-3 * largest and abs(ahead) < 1e-3 * largest
    change = changes(run, moved(run, penetration=np.asarray(deep + 1e-6 * largest)))
    assert change["penetration"] == pytest.approx(1e-3, rel=1e-9)
    change = changes(run, moved(run, throat_distance=np.asarray(ahead + 1e-6 * largest)))
    assert change["throat_distance"] == pytest.approx(1e-6, rel=1e-9)


def test_what_rounding_leaves_of_zero_is_zero():
    """A free start that misses the cone loads nothing: its forces are those of rounding at any tolerance."""
    run = moved(made_up_capture(), peak_hinge_force=np.asarray(1.2e-10), peak_buffer_force=np.asarray(3e-14))
    run = moved(run, peak_force=np.asarray(0.0), peak_latch_force=np.asarray(0.0))
    result = trust(run, moved(run, peak_hinge_force=np.asarray(3e-11), peak_buffer_force=np.asarray(5e-14)))
    assert result.verdict == "trusted" and result.errors["peak_hinge_force"] < 1e-5
    assert "peak hinge force     0 N\n" in str(run) and "peak buffer force    0 N\n" in str(run)


def test_a_mechanism_without_quantities():
    assert Trust({}, "").verdict == "trusted" and str(Trust({}, "")) == "a tenth of the tolerance changes no number"


def test_runs_that_say_nothing_are_refused():
    failed = made_up_capture(outcome=jb.Outcome.failed_steps)
    with pytest.raises(jb.InputError, match="this run says nothing: failed"):
        trust(failed, failed)


def test_without_a_run_at_a_tenth_of_the_tolerance_nothing_is_known():
    run, failed = made_up_capture(), made_up_capture(outcome=jb.Outcome.failed_step_size)
    verdict = trust(run, failed)
    assert (verdict.verdict, verdict.errors) == ("unknown", {})
    reason = jb.Outcome.failed_step_size.reason
    assert str(verdict) == f"how far these numbers can be trusted is not known: at a tenth of the tolerance {reason}"


def test_a_tenth_of_the_tolerance_is_one_or_not_there():
    assert tenth(1e-6) == pytest.approx(1e-7) and tenth(1e-12) == pytest.approx(TOLERANCES["low"])
    assert tenth(1e-12) >= TOLERANCES["low"], "rounding does not lead below what is allowed"
    assert [tenth(rtol) for rtol in (9.9e-13, 2e-13, 1e-13)] == [None] * 3


@pytest.mark.long
def test_no_wide_design_is_silently_off():
    """Of the first designs of `python -m benchmarks.trust`, welded and free, and one of 120 impacts."""
    silent, marked = [], []
    for design, scenario in [*drawn(100), (jb.replace(jb.table2(), BOUNCING), MET)]:
        run, closer, tight = (jb.simulate(design, scenario, rtol=rtol) for rtol in (1e-6, 1e-7, 1e-10))
        verdict = trust(run, closer)
        marked.append(verdict.verdict)
        if verdict.verdict != "ill-conditioned":
            errors = changes(run, tight)
            silent += [(number, name) for name, error in errors.items() if error > DOUBTFUL >= verdict.errors[name]]
    assert not silent
    assert marked[-1] == "ill-conditioned"
    assert marked.count("trusted") > 50, "a verdict that always doubts says nothing"
