"""A tuning's folder, damaged in every way: the run goes on to the same end, or is refused and nothing is touched."""

import itertools
import warnings

import numpy as np
import pytest

from jaxbuffer import InputError
from jaxbuffer.files import Lock
from jaxbuffer.tuning import tune as module
from jaxbuffer.tuning.tune import best_so_far, tune
from test_files import room_for
from tuning.analytic import Functions, problem, shifted
from tuning.test_search import CB2, SHIFT

SETTINGS = {"starts": 2, "searches": 1, "iterations": 2}
LOG, STATE, PREVIOUS = "log.jsonl", "state.npz", "state.old.npz"
STATED = problem([SHIFT - 5] * 2, [SHIFT + 5] * 2, [SHIFT + 1.0, SHIFT - 0.1])


def another_version(file):
    """A state as it was before there were checksums."""
    with np.load(file) as stored:
        arrays = {name: stored[name] for name in stored if name != "checksum"}
    np.savez(file, **arrays)


def in_the_middle(change):
    def damage(file):
        content = file.read_bytes()
        file.write_bytes(change(content, len(content) // 2))

    return damage


def flipped(content, k, count=100):
    """More bytes than an array's header in the archive has: some of it is never read, the time say."""
    return content[:k] + bytes(byte ^ 1 for byte in content[k : k + count]) + content[k + count :]


WHOLE = {"whole": lambda file: None}
DAMAGES = {
    "missing": lambda file: file.unlink(),
    "empty": lambda file: file.write_bytes(b""),
    "cut": in_the_middle(lambda content, middle: content[:middle]),
    "garbled": lambda file: file.write_bytes(np.random.default_rng(1).bytes(5000)),
    "flipped": in_the_middle(flipped),
}
STATES = {**DAMAGES, "another version's": another_version}


def finished(folder, dies_after=None, **options):
    functions = Functions(STATED, [shifted(CB2, SHIFT)])
    functions.dies_after = dies_after
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "Evaluator", lambda *_: functions)
        patch.setattr("jaxbuffer.tuning.assessment.lower_bound", lambda *_: None)
        return tune(STATED, **{**SETTINGS, **options}, folder=folder)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tuned")
    tuned = finished(folder)
    return tuned, {file.name: file.read_bytes() for file in folder.iterdir()}


@pytest.fixture
def folder(whole, tmp_path):
    for name, content in whole[1].items():
        (tmp_path / name).write_bytes(content)
    return tmp_path


def contents(folder):
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def resumed(folder):
    """The result and what was warned of."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        tuned = finished(folder, resume=True)
    return tuned, [str(warning.message) for warning in told]


@pytest.mark.parametrize("log", [*WHOLE, *DAMAGES])
@pytest.mark.parametrize("state", [*WHOLE, *STATES])
def test_one_good_state_is_enough(whole, folder, log, state):
    (WHOLE | STATES)[state](folder / STATE)
    (WHOLE | DAMAGES)[log](folder / LOG)
    before = contents(folder)
    tuned, told = resumed(folder)
    assert (tuned.design, tuned.records, tuned.captures) == (whole[0].design, whole[0].records, whole[0].captures)
    assert (folder / LOG).read_bytes() == whole[1][LOG]
    assert len(told) == (state != "whole") + (log != "whole") and all("\n" not in line for line in told)
    if state != "whole":
        earlier = whole[1][LOG].count(b"\n") - 1  # one search evaluates one design a step
        assert f"{STATE} is " in told[0] and f"going on from {PREVIOUS}, {earlier} evaluations" in told[0]
    if log in ("empty", "cut", "garbled", "flipped"):
        assert f"{LOG} is damaged" in told[-1] and "what it was is in" in told[-1]
        assert (folder / "log-1.jsonl").read_bytes() == before[LOG], "nothing is thrown away"


@pytest.mark.parametrize(("state", "previous"), list(itertools.product(STATES, STATES)))
def test_without_a_good_state_the_run_is_refused_and_left_as_it_is(folder, state, previous):
    STATES[state](folder / STATE)
    STATES[previous](folder / PREVIOUS)
    before = contents(folder)
    with pytest.raises(InputError) as refused:
        finished(folder, resume=True)
    line = str(refused.value)
    assert line.startswith(f"{folder}: the run cannot be resumed: {STATE} is ") and "\n" not in line
    assert f", {PREVIOUS} is " in line and line.endswith("; everything is left as it is")
    assert contents(folder) == before


def test_an_interrupt_before_the_first_step_leaves_a_run_to_resume(whole, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        finished(tmp_path, dies_after=0)
    assert best_so_far(STATED, tmp_path, **SETTINGS) is None
    tuned, told = resumed(tmp_path)
    assert tuned.records == whole[0].records and told == []


def test_a_state_of_another_release_is_refused(folder, monkeypatch):
    monkeypatch.setattr("jaxbuffer.tuning.tune.version", lambda: "9.9")
    before = contents(folder)
    with pytest.raises(InputError, match=r"holds a run of jaxbuffer .*, which cannot be resumed by 9\.9"):
        finished(folder, resume=True)
    assert contents(folder) == before


def test_one_run_at_a_time(folder):
    lock, before = Lock(folder), contents(folder)
    for resume in (True, False):
        with pytest.raises(InputError, match="is in use by another run, process"):
            finished(folder, resume=resume)
    assert contents(folder) == before
    lock.release()
    finished(folder, resume=True)
    assert not (folder / ".lock").exists()


def test_a_full_disk_is_named(whole, tmp_path):
    with room_for(2000), pytest.raises(OSError, match=r"File too large: '.*(log\.jsonl|state\.npz)'"):
        finished(tmp_path)
    assert not list(tmp_path.glob(".*")), "neither lock nor draft stays"


def test_the_best_so_far_is_what_the_state_holds(whole, folder):
    best = best_so_far(STATED, folder, **SETTINGS)
    lowest = min(record["objective"] for record in whole[0].records if record["feasible"])
    assert best.design == whole[0].design and best.feasible and best.stage == 0
    assert best.objective == lowest and best.evaluations == len(whole[0].records)
