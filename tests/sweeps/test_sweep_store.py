"""A sweep's file: what was finished is there again after whatever ended it, and damage is found."""

import numpy as np
import pytest
import xarray as xr

import jaxbuffer as jb
from jaxbuffer import InputError
from jaxbuffer.cluster.pool import Pool
from jaxbuffer.labelled.arrays import Labelled
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.sweeps import store as stored
from jaxbuffer.sweeps import sweep as module
from jaxbuffer.sweeps import zarr_format
from jaxbuffer.sweeps.columns import column_names, column_types
from jaxbuffer.sweeps.result import SweepInterrupted
from jaxbuffer.sweeps.store import CHECKSUM, FORMER, STORE
from test_files import room_for

COLUMNS = column_names(PROBE_CONE)
WHOLE = [name for name, kind in column_types(PROBE_CONE).items() if kind == "<i8"]

COUNT = 100
SPEEDS = np.linspace(0.1, 0.2, COUNT)
CHUNK = BLOCK = 16  # runs of a call, and of a block in the store


@pytest.fixture
def solved(monkeypatch):
    """Captures without the wait, each number from its speed, a record a chunk; the speeds of all that were solved."""
    speeds = []

    def chunk(batch, *options):
        found = np.asarray(batch[1].approach_speed)
        speeds.extend(found.tolist())
        columns = (np.sin(found * (1 + k)) for k in range(len(COLUMNS)))
        return [(1e6 * c).astype(int) if n in WHOLE else c for n, c in zip(COLUMNS, columns, strict=True)]

    monkeypatch.setattr(module, "columns_of_chunk", chunk)
    monkeypatch.setattr(Pool, "completed", lambda self, solve, items: map(solve, items))
    monkeypatch.setattr(stored, "PERIOD", 0.0)
    return speeds


def swept(folder, stop_at=COUNT, **options):
    def report(done, count):
        if done >= stop_at and done < count:
            raise KeyboardInterrupt

    settings = {"workers": 1, "progress": report, "rtol": 1e-6, "save": False, **options}
    return jb.sweep(jb.table2(), jb.Scenario(approach_speed=SPEEDS), folder=folder, **settings)


def same(one, other):
    return all(np.array_equal(one.columns[name], other.columns[name], equal_nan=True) for name in COLUMNS)


def test_a_sweep_goes_on_where_it_stopped(solved, tmp_path):
    whole = swept(None)
    for stop_at in (CHUNK, 3 * CHUNK, 5 * CHUNK):
        with pytest.raises(SweepInterrupted):
            swept(tmp_path, stop_at, resume=stop_at > CHUNK)
    solved.clear()
    assert same(swept(tmp_path, resume=True), whole)
    assert solved[: COUNT - 5 * CHUNK] == SPEEDS[5 * CHUNK :].tolist(), "the last chunks only"
    assert set(solved) == set(SPEEDS[5 * CHUNK :])
    solved.clear()
    assert same(swept(tmp_path, resume=True), whole) and solved == [], "a finished one computes nothing"


def files(folder):
    return sorted(file for file in (folder / STORE).rglob("*") if file.is_file())


def test_a_kill_costs_what_was_not_yet_written(solved, tmp_path, monkeypatch):
    """As after a kill -9 in the middle of a block: its first files are new, the others are missing."""
    whole = swept(tmp_path)
    write = zarr_format.write

    def killed(files):
        if len(solved) > 3 * CHUNK and len(files) > 1:
            write(dict([*files.items()][:4]))
            raise KeyboardInterrupt
        write(files)

    monkeypatch.setattr(zarr_format, "write", killed)
    solved.clear()
    with pytest.raises(KeyboardInterrupt):
        swept(tmp_path, force=True)
    monkeypatch.setattr(zarr_format, "write", write)
    solved.clear()
    assert same(swept(tmp_path, resume=True), whole) and COUNT - 3 * CHUNK <= len(set(solved)) < COUNT


def test_runs_of_a_block_that_has_not_all_are_kept(solved, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "task_size", lambda runs, threads: 40)
    with pytest.raises(SweepInterrupted) as interrupted:
        swept(tmp_path, 2 * CHUNK)
    assert interrupted.value.done.sum() == 2 * CHUNK
    solved.clear()
    whole = swept(None)
    solved.clear()
    assert same(swept(tmp_path, resume=True), whole) and set(solved) == set(SPEEDS[2 * CHUNK :])


def _cut_short(content):
    return content[: len(content) // 2]


def _flipped(content):
    return content[:-3] + bytes([content[-3] ^ 4]) + content[-2:]


@pytest.mark.parametrize("damage", [_cut_short, _flipped, lambda content: b"", lambda content: bytes(range(200))])
@pytest.mark.parametrize("name", ["code", "peak_force", CHECKSUM])
def test_damage_costs_its_block_only(solved, tmp_path, name, damage):
    whole = swept(tmp_path)
    file = tmp_path / STORE / name / "1"
    file.write_bytes(damage(file.read_bytes()))
    solved.clear()
    with pytest.warns(UserWarning, match=rf"1 blocks? (is|are) damaged; going on with {COUNT - BLOCK} of {COUNT} runs"):
        assert same(swept(tmp_path, resume=True), whole)
    assert set(solved) >= set(SPEEDS[BLOCK : 2 * BLOCK]) and len(set(solved)) <= BLOCK + 2 * CHUNK


@pytest.mark.parametrize(
    "content",
    [b"", b"\n", b"garbage", bytes(range(256)) * 40, b"{}", b"[1]", b'{"identity": "{}", "block": "x", "made_on": 3}'],
)
def test_a_damaged_beginning_is_refused_and_left(solved, tmp_path, content):
    swept(tmp_path)
    (tmp_path / STORE / ".zattrs").write_bytes(content)
    before = files(tmp_path)
    with pytest.raises(InputError, match=r"sweep\.zarr is damaged and cannot be resumed; it is left as it is"):
        swept(tmp_path, resume=True)
    assert (tmp_path / STORE / ".zattrs").read_bytes() == content and files(tmp_path) == before


def test_another_sweep_is_refused_with_what_differs(solved, tmp_path):
    swept(tmp_path)
    before = [file.read_bytes() for file in files(tmp_path)]
    with pytest.raises(InputError, match="holds another sweep, differing in options;"):
        swept(tmp_path, resume=True, rtol=1e-7)
    with pytest.raises(InputError, match="holds another sweep, differing in options;"):
        swept(tmp_path, resume=True, duration=2.0)
    with pytest.raises(InputError, match="differing in design and scenarios;"):
        design = jb.replace(jb.table2(), {"contact.law": "hertz"})
        jb.sweep(design, jb.Scenario(approach_speed=SPEEDS[1:]), folder=tmp_path, resume=True)
    assert [file.read_bytes() for file in files(tmp_path)] == before and len(list(tmp_path.iterdir())) == 1


def test_what_can_not_be_resumed(solved, tmp_path):
    with pytest.raises(InputError, match="resume needs the folder"):
        swept(None, resume=True)
    with pytest.raises(InputError, match=r"there is no sweep to resume; sweep\.zarr is missing"):
        swept(tmp_path / "new", resume=True)
    assert not (tmp_path / "new").exists()
    named = b'01234567 {"version": "0.0.9"}\n'
    for content, writer in ((b"garbage", "an earlier jaxbuffer"), (named, "jaxbuffer 0.0.9")):
        (tmp_path / FORMER).write_bytes(content)
        with pytest.raises(InputError, match=rf"sweep\.chunks is a sweep of {writer}, which .* cannot resume"):
            swept(tmp_path, resume=True)
    assert [file.name for file in tmp_path.iterdir()] == [FORMER]


def test_one_sweep_at_a_time(solved, tmp_path):
    def report(done, count):
        with pytest.raises(InputError, match="is in use by another run, process"):
            swept(tmp_path, resume=True)
        told.append(done)

    told = []
    swept(tmp_path, progress=report)
    assert told and same(swept(tmp_path, resume=True), swept(None))


def test_a_full_disk_is_named_and_what_fits_is_kept(solved, tmp_path, monkeypatch):
    def full(*arguments):
        if len(solved) >= 3 * CHUNK:
            limit.__enter__()
        return solve(*arguments)

    solve, limit = module.columns_of_chunk, room_for(20)
    monkeypatch.setattr(module, "columns_of_chunk", full)
    try:
        with pytest.raises(OSError, match=r"File too large: '.*sweep\.zarr'"):
            swept(tmp_path)
    finally:
        limit.__exit__(None, None, None)
    monkeypatch.setattr(module, "columns_of_chunk", solve)
    solved.clear()
    assert same(swept(tmp_path, resume=True), swept(None)) and len(solved) < 2 * COUNT, "some were there"


def test_blocks_are_written_once_a_second_not_once_a_chunk(solved, tmp_path, monkeypatch):
    monkeypatch.setattr(stored, "PERIOD", 3600.0)
    counted, write = [], stored.SweepStore.write
    monkeypatch.setattr(stored.SweepStore, "write", lambda *arguments: (counted.append(1), write(*arguments)))
    swept(tmp_path)
    assert len(counted) == -(-COUNT // BLOCK)


def test_a_store_without_zarr(solved, tmp_path):
    """Choices, truths and whole numbers are the coordinates that xarray would write."""
    over = {"scenario.approach_speed": [0.1, 0.2], "contact.law": ["hertz", "adams"]}
    swept_over = jb.sweep(jb.table2(), jb.Scenario(), over=over, folder=tmp_path, save=False)
    data = xr.open_zarr(tmp_path / STORE)
    assert data["contact.law"].values.tolist() == ["hertz", "adams"]
    assert data["scenario.approach_speed"].units == "m/s"
    np.testing.assert_array_equal(data.peak_force.values, swept_over.shaped("peak_force"))
    truths = zarr_format.write_coordinate(
        tmp_path / "other", "moves", Labelled(("moves",), np.array([True, False]), "", "")
    )
    assert truths["moves/.zarray"]["dtype"] == "|i1" and truths["moves/.zattrs"]["dtype"] == "bool"


@pytest.fixture
def captured(solved, monkeypatch):
    """The same, each solved with the first outcome."""
    chunk = module.columns_of_chunk
    whole = [name in WHOLE for name in COLUMNS]
    zeros = lambda *call: [0 * it if w else it for w, it in zip(whole, chunk(*call), strict=True)]  # noqa: E731
    monkeypatch.setattr(module, "columns_of_chunk", zeros)
    return solved


def killed(folder, **options):
    """As a kill after some blocks leaves it: without results."""
    with pytest.raises(SweepInterrupted):
        swept(folder, 3 * CHUNK, save=True, force=True, **options)


def test_a_sweep_begun_beside_the_results_of_another_is_named(captured, tmp_path):
    """The results stay those of the first one, and `load` says so until the second one is finished."""
    swept(tmp_path, save=True)
    assert jb.load(tmp_path).sweep.sizes["run"] == COUNT, "its own store is no other sweep"
    killed(tmp_path, rtol=1e-5)
    two = (
        r"holds two sweeps, differing in options: sweep\.nc is of one, sweep\.zarr of the other, which is not finished"
    )
    with pytest.warns(UserWarning, match=two):
        assert jb.load(tmp_path).sweep.sizes["run"] == COUNT
    with pytest.warns(UserWarning, match=two):
        jb.report(tmp_path)
    swept(tmp_path, rtol=1e-5, resume=True)
    with pytest.warns(
        UserWarning, match=r"sweep\.zarr of the other, which has all its runs: the command that began it"
    ):
        jb.load(tmp_path)
    swept(tmp_path, rtol=1e-5, resume=True, save=True)
    assert jb.load(tmp_path).sweep is not None


def test_results_saved_beside_an_unfinished_sweep_are_not_of_it(captured, tmp_path):
    other = swept(None, rtol=1e-5)
    killed(tmp_path)
    other.save(tmp_path, figures=False)
    with pytest.warns(
        UserWarning, match=r"holds two sweeps, differing in options: sweep\.nc is of one, sweep\.zarr of the other"
    ):
        jb.load(tmp_path)


def test_an_interrupted_sweep_saved_as_far_as_it_came_is_one(captured, tmp_path):
    with pytest.raises(SweepInterrupted) as interrupted:
        swept(tmp_path, 3 * CHUNK)
    interrupted.value.partial.save(tmp_path, figures=False)
    outcomes = jb.load(tmp_path).sweep.outcome.values
    assert np.sum(outcomes == "not computed") == COUNT - 3 * CHUNK


def test_a_sample_in_the_place_of_a_sweep(captured, tmp_path):
    """Both are finished: the store is the sample's, and sweep.nc says by itself what it is of."""
    swept(tmp_path, save=True)
    ranges = {"scenario.approach_speed": (0.1, 0.2)}
    with pytest.raises(jb.InputError, match=r"sweep\.zarr exists; force=True replaces it, resume=True goes on"):
        jb.sample(jb.table2(), jb.Scenario(), ranges, 16, folder=tmp_path)
    jb.sample(jb.table2(), jb.Scenario(), ranges, 16, folder=tmp_path, force=True)
    found = jb.load(tmp_path)
    assert found.sweep is not None and found.records["sample"]


def test_a_sweep_replaces_another_by_force_alone(tmp_path):
    """As `save` does: refused in words, before anything is computed, and the files stay as they are."""
    asked = jb.BarDrop(), jb.BarDropScenario(height=[0.1, 0.15]), 0.22
    jb.sweep(*asked, folder=tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    with pytest.raises(
        jb.InputError, match=r"sweep\.zarr and \d more exist; force=True replaces them, resume=True goes"
    ):
        jb.sweep(*asked, folder=tmp_path)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before
    (tmp_path / "beside").mkdir()
    jb.sweep(*asked, folder=tmp_path / "beside", save=False)  # a store without a result is refused too
    with pytest.raises(jb.InputError, match=r"sweep\.zarr exists; force=True replaces it"):
        jb.sweep(*asked, folder=tmp_path / "beside", save=False)
    jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=[0.1, 0.12, 0.15]), 0.22, folder=tmp_path, force=True)
    assert jb.load(tmp_path).sweep.sizes["run"] == 3
    assert jb.sweep(*asked, folder=tmp_path / "beside", resume=True).code.size == 2
    with pytest.raises(jb.InputError, match="force"):
        jb.sweep(*asked, folder=tmp_path, force="yes")
