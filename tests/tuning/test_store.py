"""A run that is killed goes on as if nothing had happened."""

import json
import shutil

import pytest

from jaxbuffer import InputError, Objective, SecondObjective
from jaxbuffer.tuning import tune as module
from jaxbuffer.tuning.tune import tune
from tuning.analytic import Functions, problem, shifted
from tuning.test_search import CB2, SHIFT

THEN = SecondObjective(Objective({"peak_hinge_force": 1.0}), tolerance=0.1)
SETTINGS = {"starts": 3, "searches": 2, "seed": 1}


def stated():
    return problem([SHIFT - 5] * 2, [SHIFT + 5] * 2, [SHIFT + 1.0, SHIFT - 0.1], then=THEN)


@pytest.fixture
def run(monkeypatch):
    monkeypatch.setattr("jaxbuffer.tuning.assessment.lower_bound", lambda *_: None)

    def call(folder, dies_after=None, **options):
        functions = Functions(stated(), [shifted(CB2, SHIFT)], {"peak_hinge_force": lambda x: 1 + (x[1] - 12) ** 2})
        functions.dies_after = dies_after
        monkeypatch.setattr(module, "Evaluator", lambda *_: functions)
        return tune(stated(), **{**SETTINGS, **options}, folder=folder)

    return call


@pytest.fixture
def whole(run, tmp_path):
    return run(tmp_path / "whole")


@pytest.mark.parametrize("batches", [0, 1, 2, 5, 9])
def test_resumed_after_any_step_gives_the_same(run, whole, tmp_path, batches):
    folder = tmp_path / "cut"
    with pytest.raises(KeyboardInterrupt):
        run(folder, dies_after=batches)
    resumed = run(folder, resume=True)
    assert resumed.records == whole.records and resumed.design == whole.design
    assert resumed.captures == whole.captures, "no capture was solved twice"
    assert (folder / "log.jsonl").read_bytes() == (tmp_path / "whole" / "log.jsonl").read_bytes()


def test_lines_of_a_step_that_was_cut_short_are_dropped(run, whole, tmp_path):
    """Killed in the middle of writing a line, after the state of the step before."""
    folder = tmp_path / "cut"
    with pytest.raises(KeyboardInterrupt):
        run(folder, dies_after=4)
    with (folder / "log.jsonl").open("ab") as log:
        log.write(b'{"evaluation": 99, "stage"')
    (folder / "state.npz.new").write_bytes(b"half a state")
    assert run(folder, resume=True).records == whole.records


def test_a_finished_run_resumes_to_itself(run, whole, tmp_path):
    before = [json.loads(line) for line in (tmp_path / "whole" / "log.jsonl").read_text().splitlines()]
    assert run(tmp_path / "whole", resume=True).records == whole.records == tuple(before)


def test_what_can_not_be_resumed_is_refused(run, whole, tmp_path):
    with pytest.raises(InputError, match="no run to resume"):
        run(tmp_path / "nowhere", resume=True)
    with pytest.raises(InputError, match="another problem or other settings"):
        run(tmp_path / "whole", resume=True, seed=2)
    with pytest.raises(InputError, match="resume needs the folder"):
        run(None, resume=True)


def test_a_new_run_starts_afresh(run, whole, tmp_path):
    shutil.copytree(tmp_path / "whole", tmp_path / "again")
    assert run(tmp_path / "again").records == whole.records
