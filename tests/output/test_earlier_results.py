"""No file of an earlier result is taken for the new one's, and what was begun beside a finished result is said."""

import dataclasses
import json
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from test_saved import problem, sampled, swept

import jaxbuffer as jb
from jaxbuffer.block_store import Head, short_hash
from jaxbuffer.cli.entry import run
from jaxbuffer.output.formats import write_all
from jaxbuffer.sweeps import store
from jaxbuffer.sweeps.cut import Cut
from jaxbuffer.sweeps.result import Sweep
from jaxbuffer.tuning import pareto, tune
from jaxbuffer.tuning.pareto import BEGUN, OF_A_POINT, _begin, begun_identity
from jaxbuffer.tuning.problem.settings import Settings
from jaxbuffer.tuning.report.front import Front
from jaxbuffer.tuning.search.store import TuningStore
from made_up import made_up_capture, made_up_tuning

RUN = ("capture.json", "capture.txt", "capture.nc", "capture.mat")
HISTORY = ("history.csv", "force.json", "motion.json", "capture.png", "capture.svg", "motion.png", "motion.svg")
FORCES = {"run": '{"curves": [{"name": "capture"}]}', "tuned": '{"curves": [{"name": "before"}, {"name": "after"}]}'}
TABLES = {"run": "time [s],force [N]\n", "tuned": "evaluation,stage\n"}


def put(folder, *names, of="run"):
    folder.mkdir(exist_ok=True)
    for name in names:
        (folder / name).write_text({"force.json": FORCES, "history.csv": TABLES}.get(name, {}).get(of, "old"))


def names(folder):
    return {path.name for path in folder.iterdir() if not path.name.startswith(".")}


def test_a_run_without_a_history_has_none_of_an_earlier_one(tmp_path):
    put(tmp_path, *RUN, *HISTORY, "fields_end.vtu", "fields.png", "mine.csv", "motion.gif", "report.html")
    dataclasses.replace(made_up_capture(), history=None).save(tmp_path, force=True)
    assert names(tmp_path) == {*RUN, "mine.csv", "motion.gif", "report.html"}
    assert "force" not in jb.load(tmp_path).records


def test_what_an_earlier_run_left_is_refused_as_its_own_files_are(tmp_path):
    put(tmp_path, "motion.json", "force.json")
    with pytest.raises(jb.InputError, match=r"and 1 more exist; force=True overwrites"):
        dataclasses.replace(made_up_capture(), history=None).save(tmp_path)
    assert names(tmp_path) == {"motion.json", "force.json"}


@pytest.mark.parametrize(
    ("name", "entry"),
    [
        ("tuned", '"variables": [{"shown_in": "mm"}]'),
        ("tuned", '"design": {"buffer.k_A [N/m]": 500.0}'),
        ("sensitivity", '"peak_force [N]": 250.0'),
        ("sweep", '"made": {"wall_time [s]": 2.5}'),
        ("choice", '"combinations": 4'),
        ("fit", '"parameters": {}'),
    ],
)
def test_a_record_of_an_earlier_version_is_refused(tmp_path, name, entry):
    (tmp_path / f"{name}.json").write_text(f'{{"kind": "probe_cone", {entry}}}')
    with pytest.raises(jb.InputError, match=rf"{name}\.json was written by an earlier version"):
        jb.load(tmp_path)


def test_a_run_of_another_mechanism_takes_the_place_of_the_earlier_one(tmp_path):
    put(tmp_path, "drop.json", "drop.nc", "drop.txt", "drop.png")
    dataclasses.replace(made_up_capture(), history=None).save(tmp_path, force=True)
    assert names(tmp_path) == set(RUN) and jb.load(tmp_path).run.attrs["kind"] == "probe_cone"


@pytest.mark.parametrize(("kind", "other"), [("run", "tuned"), ("tuned", "run")])
def test_runs_and_tunings_keep_to_their_own_history_and_forces(tmp_path, kind, other):
    """Both have files of these names, and may share a folder."""
    new = {"run": {"capture.json": lambda: "{}"}, "tuned": {"tuned.json": lambda: "{}"}}[kind]
    for of, left in ((other, {"history.csv", "force.json"}), (kind, set())):
        put(tmp_path, "history.csv", "force.json", of=of)
        write_all(tmp_path, new, force=True)
        assert names(tmp_path) == {*new, *left}


@pytest.mark.parametrize(
    ("new", "earlier"),
    [
        ("sweep.json", ("sweep.csv", "sweep.png", "sweep.svg", "envelope.png", "envelope.svg", "sweep.nc")),
        ("sample.json", ("sample.png", "indices.csv", "indices.svg", "surface.csv", "surface.png", "sample.nc")),
        ("tuned.json", ("design.toml", "tune.png", "tune.svg", "tune.txt")),
        ("design.toml", ("tuned.json", "tune.png", "tune.txt")),  # of a tuning that was interrupted
        ("pareto.json", ("design-1.toml", "design-12.toml", "pareto.png", "pareto.csv")),
    ],
)
def test_what_the_new_result_has_not_goes_and_what_others_have_stays(tmp_path, new, earlier):
    others = {"sensitivity.json", "study.toml", "design-final.toml", "results.csv", "laws.png"}
    put(tmp_path, new, *earlier, *others)
    _written, failure = write_all(tmp_path, {new: lambda: "new"}, force=True)
    assert failure is None and names(tmp_path) == {new, *others} and (tmp_path / new).read_text() == "new"
    put(tmp_path, *earlier)
    write_all(tmp_path, {"laws.csv": lambda: "new"}, force=True)
    assert set(earlier) < names(tmp_path)


def test_a_command_refuses_what_an_earlier_result_left(computed, capsys, tmp_path):
    put(tmp_path / "out", "envelope.png")
    assert run(["sweep", "--over", "scenario.approach_speed=0.1,0.2", "--output", "out"]) == 2
    assert "out/envelope.png exists; --force overwrites" in capsys.readouterr().err


def test_a_front_begins_without_the_points_of_another_one(tmp_path):
    folders = ("least-peak_force", "least-stroke", "point-2", "point-7", "point-7-again")
    for name in folders:
        put(tmp_path / name, *OF_A_POINT)
    put(tmp_path / "point-7", "mine.txt")
    put(tmp_path / "point-of-view", "log.jsonl")
    put(tmp_path / "point-9", "tuned.json")  # of a command that was given this folder
    _begin(tmp_path, "one", resume=True)
    assert {*folders, BEGUN} < names(tmp_path)
    _begin(tmp_path, "two", resume=False)
    assert names(tmp_path) == {"point-7", "point-of-view", "point-9", BEGUN} and begun_identity(tmp_path) == "two"
    assert names(tmp_path / "point-7") == {"mine.txt"}


def words(folder):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        jb.load(folder)
    return [str(it.message) for it in caught]


def test_a_tuning_that_was_begun_beside_a_finished_one_is_said(tmp_path, no_figures):
    own, other = (tune._identity(problem(), Settings(seed=seed), None, None) for seed in (0, 1))
    tuned = dataclasses.replace(made_up_tuning(problem()), identity=short_hash(own))
    tuned.save(tmp_path, figures=False)
    for identity, said in ((own, []), (other, ["holds two tunings: tuned.json is of one, and another was begun"])):
        with TuningStore(tmp_path, identity, resume=False):
            pass
        found = words(tmp_path)
        assert len(found) == len(said) and all(text in it for text, it in zip(said, found, strict=True))


def test_a_front_that_was_begun_beside_a_finished_one_is_said(tmp_path, no_figures):
    names = ("peak_force", "stroke")
    one, two = (pareto._identity(problem(), names, points, None, {}) for points in (2, 3))
    points = tuple(made_up_tuning(problem()) for _ in range(2))
    Front(problem(), names, np.full((2, 1), np.inf), points, one).save(tmp_path, figures=False)
    _begin(tmp_path, one, resume=False)
    assert words(tmp_path) == []
    _begin(tmp_path, two, resume=False)
    (said,) = words(tmp_path)
    assert "holds two fronts: pareto.json is of one, and another was begun there and has no results yet" in said


@pytest.mark.parametrize("made", [swept, sampled])
def test_a_sweep_that_was_begun_beside_a_finished_one_is_said(made, tmp_path, monkeypatch):
    """Also where its only block has some of its runs."""
    finished = dataclasses.replace(made(), identity={"version": "same", "scenarios": "one"})
    finished.save(tmp_path, figures=False)

    def stop(self, solve, items):
        raise KeyboardInterrupt

    monkeypatch.setattr("jaxbuffer.cluster.pool.Pool.completed", stop)
    with pytest.raises(KeyboardInterrupt):
        jb.sweep(jb.table2(), jb.Scenario(approach_speed=[0.1, 0.2]), folder=tmp_path, save=False)
    (said,) = words(tmp_path)
    assert "holds two sweeps, differing in" in said and "which is not finished" in said


@pytest.mark.parametrize(("codes", "unfinished"), [([0, 1, -1], True), ([0, 1, 1], False)])
def test_a_block_with_some_of_its_runs_is_not_a_finished_one(tmp_path, monkeypatch, codes, unfinished):
    monkeypatch.setattr("jaxbuffer.cluster.pool.Pool.completed", lambda *_: iter(()))
    speeds = [0.1, 0.2, 0.3]
    jb.sweep(jb.table2(), jb.Scenario(approach_speed=speeds), folder=tmp_path, save=False, workers=1)
    path = tmp_path / store.STORE
    attributes = json.loads((path / ".zattrs").read_text())
    cut = Cut((3,), tuple(json.loads(attributes["block"])))
    types = json.loads((path / ".zmetadata").read_text())["metadata"]
    columns = {name.split("/")[0]: it["dtype"] for name, it in types.items() if name.endswith("/.zarray")}
    columns = {name: kind for name, kind in columns.items() if name in Sweep.empty(MECHANISM, 1).columns}
    made = store.SweepStore(Head.of(attributes), path, columns, cut)
    for number in range(len(cut)):
        (region,) = cut.region(number)
        values = [np.array(codes[region]) if name == "code" else np.zeros(cut.shape(number)) for name in columns]
        made.write_columns(number, values)
    assert store.is_unfinished(path) is unfinished


MECHANISM = swept().mechanism


def test_an_executor_that_was_shut_down_is_refused():
    executor = ThreadPoolExecutor(1)
    executor.shutdown()
    with pytest.raises(jb.InputError, match="the executor takes no calls: cannot schedule new futures after shutdown"):
        jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=[0.1, 0.15]), 0.22, executor=executor)


@pytest.mark.parametrize("name", ["m.avi", "m.MOV", "m.webm", "m.png"])
def test_a_film_of_another_format_is_refused_and_no_folder_is_made(computed, capsys, tmp_path, name):
    assert run(["animate", "--output", name]) == 2
    ending = name.partition(".")[2].lower()
    assert f"format = '{ending}' is unknown; choose one of gif, mp4" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
