"""Cliffs between the start and the best design: further rounds find it, end, and are resumed like all else."""

import json

import numpy as np
import pytest

from jaxbuffer import Objective, Outcome, Problem, Scenario, SecondObjective, Variable, table2
from jaxbuffer.tuning import tune as module
from jaxbuffer.tuning.problem.settings import Settings
from jaxbuffer.tuning.report.message import agreement_in_words
from jaxbuffer.tuning.report.tuned import tuned_table
from jaxbuffer.tuning.rounds import anywhere, around
from jaxbuffer.tuning.search import checks
from jaxbuffer.tuning.search.checks import lower_bound
from jaxbuffer.tuning.search.evaluation import Evaluator
from jaxbuffer.tuning.search.measurement import Measurement
from jaxbuffer.tuning.search.store import Progress
from jaxbuffer.tuning.tune import tune
from tuning.analytic import Functions, problem

SHIFT = 10.0
HIGHEST = 3.0


def island(from_):
    """Captured up to x = 1 and from ``from_`` on, with nothing to tell of it in between."""
    return lambda x: 1.0 + 0.0 * x[0] if not SHIFT + 1.0 < x[0].real < SHIFT + from_ else -1.0 + 0.0 * x[0]


def falling(x):
    """29 at x = 1, 27 at x = 3, and least where y = 0."""
    return 30.0 - (x[0] - SHIFT) + (x[1] - SHIFT) ** 2


def stated(**fields):
    return problem([SHIFT, SHIFT - 2.0], [SHIFT + HIGHEST, SHIFT + 2.0], [SHIFT + 0.2, SHIFT + 0.5], **fields)


@pytest.fixture
def solve(monkeypatch):
    """`tune` at its defaults, on functions instead of captures; ``dies_after`` so many batches."""
    monkeypatch.setattr("jaxbuffer.tuning.assessment.lower_bound", lambda *_: None)

    def run(margin, dies_after=None, fields=None, **settings):
        functions = Functions(stated(**(fields or {})), [[falling]], {"peak_hinge_force": lambda x: x[0]}, margin)
        functions.dies_after = dies_after
        monkeypatch.setattr(module, "Evaluator", lambda *_: functions)
        return tune(functions.problem, **settings), functions

    return run


@pytest.mark.parametrize(("from_", "seed"), [(2.6, 0), (2.85, 0), (2.85, 2)])
def test_the_far_side_of_a_cliff_is_found(solve, from_, seed):
    """The best design is at x = 3, y = 0, beyond a gap without a slope; on the near side none gets below 29."""
    tuned, _ = solve(island(from_), seed=seed)
    assert tuned.feasible and tuned.objective[1] == pytest.approx(27.0, abs=1e-2)


def test_where_searches_end_apart_the_message_says_so(solve):
    """What lies beyond the gap is a thousandth of the range: no search gets there, and none may claim agreement with a
    design that it did not find; allowed one round only, the run says that there is a discontinuity and what to do."""
    tuned, _ = solve(island(2.997), rounds=1, starts=3, searches=1)
    assert tuned.feasible and tuned.objective[1] > 28.9
    assert "stopped at a discontinuity" in tuned.message
    assert "raise starts (now 3) or rounds (now 1), or change seed, in [tune] of the study" in tuned.message


@pytest.mark.parametrize(
    ("apart", "said"),
    [
        (0.004, "Of 4 searches the best two that began apart agree within 0.4 %"),
        (0.05, "Of 4 searches the best two that began apart differ by 5 %; a better design may exist: raise"),
        (
            np.inf,
            "Of 4 searches no other that began apart ended feasible within 1 % of it; a better design may exist: raise",
        ),
    ],
)
def test_the_message_claims_no_more_than_the_searches_show(apart, said):
    progress = Progress(0, 1, 1.0, np.nan, 4, apart, None, ())
    assert agreement_in_words(progress, "raise …").startswith(said)


def test_searches_that_agree_end_the_rounds(solve):
    """Without a discontinuity one round is enough, and the best two agree."""
    tuned, _ = solve(None)
    assert tuned.objective[1] == pytest.approx(27.0, abs=1e-2)
    searches = {record["search"] for record in tuned.records if record["status"] != "start"}
    assert searches == {0, 1}
    assert "Of 2 searches the best two that began apart agree within" in tuned.message


def test_what_was_spent_is_counted(solve):
    tuned, functions = solve(island(2.6))
    screened = sum(record["status"] == "start" for record in tuned.records)
    assert tuned.screened == screened >= 32
    assert tuned.captures == functions.captures == len(tuned.records) + 2, "start and result are solved once more"
    assert tuned.records[-1]["captures"] == len(tuned.records)


@pytest.mark.slow
@pytest.mark.parametrize(
    "then", [None, SecondObjective(Objective({"peak_hinge_force": 1.0}), tolerance=0.1)], ids=["", "then"]
)
def test_a_run_killed_in_any_batch_of_any_round_ends_the_same(solve, tmp_path, then):
    """Killed again and again, each time a few batches after it was resumed."""
    fields, folder = {"then": then}, tmp_path / "killed"
    whole, functions = solve(island(2.85), fields=fields, folder=tmp_path / "whole", starts=6)
    assert functions.batches > 20
    for kills in range(functions.batches):
        try:
            resumed, _ = solve(island(2.85), 3, fields, folder=folder, starts=6, resume=kills > 0)
        except KeyboardInterrupt:
            continue
        break
    assert kills == functions.batches // 3, "what was computed before a kill is not computed again"
    assert resumed.records == whole.records and resumed.design == whole.design
    assert resumed.message == whole.message and resumed.captures == whole.captures
    assert (folder / "log.jsonl").read_bytes() == (tmp_path / "whole" / "log.jsonl").read_bytes()


def test_samples_fill_the_bounds_and_the_surroundings():
    settings, best = Settings(seed=2), np.array([0.9, 0.5])
    wide = np.array(anywhere(settings, 1, 2, 16))
    assert np.all(np.sort(np.floor(16 * wide), axis=0) == np.arange(16)[:, None]), "a Latin hypercube"
    assert not np.any(wide == np.array(anywhere(settings, 2, 2, 16)))
    near = np.array(around(best, settings, 1, 16))
    away = np.max(np.abs(near - best), axis=1)
    assert np.all((near >= 0.0) & (near <= 1.0)) and np.all(away <= np.geomspace(0.5, 0.01, 16) + 1e-12)
    assert away[-1] <= 0.01 and np.max(away) > 0.1


# --- designs that do not fit their scenarios --------------------------------------------------------------------------

ANGLE = Variable("cone.half_angle", 0.1, 1.5, "linear")


def askew(**fields):
    """The misalignment of 0.5 rad must stay below the half-angle and below its complement to 90°: 0.5 to 1.07 fit."""
    return Problem(table2(), [Scenario(misalignment=0.5)], [ANGLE], **fields)


def test_a_design_that_does_not_fit_is_a_lost_case():
    """One does not fit its scenario; of the other the mouth is narrower than the tip, which no design may be."""
    narrow = Problem(table2(), [Scenario()], [ANGLE, Variable("probe.tip_radius", 0.005, 0.05)])
    for stated_, scaled in ((askew(), [0.0]), (narrow, [0.0, 1.0])):
        with Evaluator(stated_) as evaluate:
            for slopes in (True, False):
                (point,) = evaluate([scaled], slopes=slopes)
                assert not point.solved[0] and point.margin[0] < 0.0
                assert all(np.all(np.isfinite(array)) for array in point)
        assert evaluate.captures == 2


def hertz(built, **options):
    """Stands in for `measure`: a first impact of 100 N at an angle of 1, falling with it by 50 N/rad."""
    angle = float(built[0].cone.half_angle)
    found = Measurement.lost(askew())
    peaks, slope = np.zeros(24), np.zeros((24, 1))
    peaks[0], slope[0] = 100.0 + 50.0 * (1.0 - angle), -50.0
    return found._replace(code=int(Outcome.timeout), peaks=peaks, first=peaks[0], peaks_slope=slope)


def test_the_lowest_floor_is_looked_for_among_designs_that_fit(monkeypatch):
    """It falls with the angle up to π/2 - 0.5, where designs cease to fit: 100 + 50 (1 - 1.0708) N."""
    monkeypatch.setattr(checks, "measure", hertz)
    stated_ = askew()
    found = lower_bound(stated_, stated_.start())
    edge = np.pi / 2 - 0.5
    assert found.simulated[0] == pytest.approx(100.0 + 50.0 * (1.0 - np.pi / 4))
    assert found.unknown == 0 and 100.0 + 50.0 * (1.0 - edge) <= found.lowest <= found.simulated[0]
    assert np.pi / 4 <= found.at["cone.half_angle"] < edge


def test_a_floor_that_can_not_be_had_is_said_in_words(monkeypatch):
    from made_up import made_up_tuning

    stated_ = askew()
    monkeypatch.setattr(checks, "measure", lambda *_, **options: Measurement.lost(stated_))
    found = lower_bound(stated_, stated_.start())
    assert found.unknown == 1 and np.isnan(found.lowest)
    tuned = made_up_tuning(stated_)
    object.__setattr__(tuned, "lower_bound", found)
    shown = tuned_table(tuned)
    assert "unknown, as the first impact can not be simulated in 1 of 1 scenarios" in " ".join(shown.split())
    assert "nan" not in shown


@pytest.mark.long
def test_an_answer_survives_bounds_that_do_not_fit(tmp_path):
    """A half-angle of 0.1 to 1.5 under a misalignment of 0.5: the bound's search comes by angles that do not fit."""
    variables = [ANGLE, Variable("buffer.k_A", 100.0, 2000.0)]
    tuned = tune(Problem(table2(), [Scenario(misalignment=0.5)], variables), iterations=3, starts=4, folder=tmp_path)
    assert tuned.lower_bound.unknown == 0 and tuned.lower_bound.lowest <= tuned.lower_bound.simulated[0]
    assert 0.5 < tuned.design.cone.half_angle < np.pi / 2 - 0.5
    assert json.loads((tmp_path / "log.jsonl").read_text().splitlines()[0])["evaluation"] == 0
