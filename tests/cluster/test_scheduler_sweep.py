"""A sweep by a Dask client's executor: the numbers of the sweep without one, in a store that any end leaves to go on
with."""

import itertools
import json
import pickle
import re
from concurrent.futures import Future, ThreadPoolExecutor

import numcodecs
import numpy as np
import pytest
import xarray as xr

import jaxbuffer as jb
from jaxbuffer import InputError
from jaxbuffer.cluster.connect import connected
from jaxbuffer.hybrid import AUTOMATIC
from jaxbuffer.labelled.record import amount
from jaxbuffer.mechanisms.bar_drop import BAR_DROP
from jaxbuffer.sweeps import sweep as module
from jaxbuffer.sweeps.chunk import SweepSettings, task_size
from jaxbuffer.sweeps.columns import column_names, column_types
from jaxbuffer.sweeps.cut import Cut, box
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.sweeps.result import SweepInterrupted
from jaxbuffer.sweeps.spec import SweepSpec
from jaxbuffer.sweeps.store import CHECKSUM, STORE, begun
from test_files import room_for

COLUMNS = column_names(BAR_DROP)
WHOLE = [name for name, kind in column_types(BAR_DROP).items() if kind == "<i8"]
OVER = {"scenario.height": {"from": 0.1, "to": 0.2, "count": 43}, "impact.law": ["hertz", "adams"]}
BAR = jb.replace(jb.BarDrop(), {"impact.exponent": 1.5})
COUNT, BLOCKS, BLOCK, EDGE = 86, 6, 15, 13  # runs; blocks of 15, 15 and 13 heights for each law
CALLS = (16, 16, 11)  # runs of each, for each law


@pytest.fixture(scope="module")
def executor():
    """One thread of this process."""
    with connected("local", 1) as client:
        yield client.get_executor()


@pytest.fixture
def solved(monkeypatch):
    """Runs without the wait, each number from its height and law; the heights of all that were solved."""
    heights = []

    def chunk(batch, wanted, *settings):
        found, hertz = np.asarray(batch[1].height), batch[0].impact.law == "hertz"
        heights.extend(found[wanted].tolist())
        columns = (np.sin(found * (1 + k) + hertz) ** 2 for k in range(len(COLUMNS)))
        ends = {"trust": 4} | {name: 3 for name in WHOLE[:-1]}  # of whole numbers from 0
        return [(ends[n] * c).astype(int) if n in WHOLE else c for n, c in zip(COLUMNS, columns, strict=True)]

    monkeypatch.setattr(module, "columns_of_chunk", chunk)
    return heights


def swept(folder, executor, **options):
    given = {"executor": executor, "workers": 1, "folder": folder, "save": False, **options}  # made up: no tables
    return jb.sweep(BAR, jb.BarDropScenario(), 0.01, over=OVER, **given)


def whole():
    return swept(None, None)


def same(one, other):
    return all(np.array_equal(one.columns[name], other.columns[name], equal_nan=True) for name in COLUMNS)


def test_runs_one_by_one_and_durations(executor, tmp_path, solved):
    heights, durations = np.linspace(0.1, 0.2, 37), np.linspace(0.01, 0.02, 37)
    asked = BAR, jb.BarDropScenario(height=heights), durations
    assert same(jb.sweep(*asked, executor=executor, folder=tmp_path, save=False), jb.sweep(*asked))
    data = jb.load(tmp_path).sweep
    assert data["scenario.height"].values.tolist() == heights.tolist() and data["scenario.height"].units == "m"


def test_the_store_is_labelled_and_says_what_it_is(executor, tmp_path, solved):
    found = swept(tmp_path, executor, trust=True)
    data = xr.open_zarr(tmp_path / STORE)
    assert dict(data.sizes) == {"scenario.height": 43, "impact.law": 2, "block_number": BLOCKS}
    assert data["impact.law"].values.tolist() == ["hertz", "adams"] and data.peak_force.units == "N"
    meanings = dict(zip(data.code.flag_values, data.code.flag_meanings.split(), strict=True))
    assert [meanings[code] for code in (0, 2)] == [BAR_DROP.outcomes(code).name for code in (0, 2)]
    assert data.trust.flag_meanings.split() == ["trusted", "check", "ill-conditioned", "unknown"]
    np.testing.assert_array_equal(data.trust.values, found.shaped("trust"))
    here = data.peak_force.sel({"impact.law": "adams"}).values
    np.testing.assert_array_equal(here, whole().peak_force.reshape(43, 2)[:, 1])
    assert json.loads(data.design)["impact.exponent"]["value"] == 1.5 and data.jaxbuffer
    assert json.loads(data.settings) == {
        **{"duration": amount(0.01, "s"), "rtol": amount(1e-06, "-")},
        **{"solver": "automatic", "stabilisation": amount(20.0, "1/s"), "trust": True},
    }
    assert set(json.loads(data.made_on)) >= {"jaxbuffer", "Python", "jaxlib", "processor", "XLA"}


@pytest.mark.quick
@pytest.mark.parametrize("stop_at", [15, 45, 70])
def test_what_was_done_is_not_computed_again(executor, tmp_path, solved, stop_at):
    def report(done, count):
        if done >= stop_at:
            raise KeyboardInterrupt

    with pytest.raises(SweepInterrupted, match="of 86 drops done") as stop:
        swept(tmp_path, executor, progress=report)
    done = int(stop.value.done.sum())
    assert stop_at <= done < COUNT and same(stop.value.partial, whole().only(stop.value.done))
    executor.submit(int).result()  # the one thread is done with what it was at
    counts, _ = [], solved.clear()
    resumed = swept(tmp_path, executor, resume=True, progress=lambda done, count: counts.append((done, count)))
    assert len(solved) == COUNT - done and counts[0] == (done, COUNT) and counts[-1] == (COUNT, COUNT)
    assert same(resumed, whole())
    solved.clear()
    assert swept(tmp_path, executor, resume=True).done.all() and solved == [], "a finished one computes nothing"


def _flipped(file):
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 4
    file.write_bytes(content)


@pytest.mark.parametrize(
    ("place", "damage"),
    [("peak_force/2/1", _flipped), ("peak_force/1/0", lambda file: file.unlink()), ("code/0/1", _flipped)],
)
def test_a_damaged_block_is_computed_again_and_no_other(executor, tmp_path, solved, place, damage):
    """A block at the grid's edge, one in its middle, one of whole numbers."""
    swept(tmp_path, executor)
    solved.clear()
    damage(tmp_path / STORE / place)
    with pytest.warns(UserWarning, match=rf"1 block is damaged; going on with \d+ of {COUNT} runs"):
        resumed = swept(tmp_path, executor, resume=True)
    assert 0 < len(solved) <= CALLS[0] + CALLS[1], "the calls that have its runs"
    assert same(resumed, whole())


def test_another_blocks_numbers_are_noticed(executor, tmp_path, solved):
    """Whole files in a wrong place, with a checksum of their own."""
    swept(tmp_path, executor)
    for name in (*COLUMNS, CHECKSUM):
        one, other = ("1/0", "0/0") if name != CHECKSUM else ("2", "0")
        content = (tmp_path / STORE / name / other).read_bytes()
        (tmp_path / STORE / name / one).write_bytes(content)
    with pytest.warns(UserWarning, match=f"1 block is damaged; going on with {COUNT - BLOCK}"):
        assert same(swept(tmp_path, executor, resume=True), whole())


@pytest.mark.parametrize("where", [".zmetadata", ".zarray"])
def test_a_store_with_a_pickle_in_it_is_not_read(tmp_path, solved, monkeypatch, where):
    """Zarr would unpickle what such an array holds, which runs code, if an older numcodecs or its user lets it."""
    monkeypatch.setattr("numcodecs.pickles.ALLOW_UNSAFE_PICKLE_DECODE", True, raising=False)
    swept(tmp_path, None)
    name = "scenario.height"
    file = tmp_path / STORE / (".zmetadata" if where == ".zmetadata" else f"{name}/.zarray")
    content = json.loads(file.read_text())
    array = content["metadata"][f"{name}/.zarray"] if where == ".zmetadata" else content
    array |= {"dtype": "|O", "filters": [{"id": "pickle", "protocol": 5}], "compressor": None}
    file.write_text(json.dumps(content))
    (tmp_path / STORE / name / "0").write_bytes(pickle.dumps(Runs(str(tmp_path / "was-run"))))
    for read in (lambda: jb.load(tmp_path), lambda: swept(tmp_path, None, resume=True)):
        with pytest.raises(InputError, match="it has arrays of another kind; it is not read"):
            read()
    assert not (tmp_path / "was-run").exists()
    decoded = numcodecs.get_codec({"id": "pickle"}).decode((tmp_path / STORE / name / "0").read_bytes())
    decoded.close()
    assert (tmp_path / "was-run").exists(), "which Zarr's codec of that name does"


class Runs:
    """Makes a file when it is unpickled."""

    def __init__(self, file):
        self.file = file

    def __reduce__(self):
        return open, (self.file, "w")


def test_a_sweep_goes_on_by_an_executor_or_without(executor, tmp_path, solved):
    """One store, whoever computes."""

    def stop(done, count):
        if done >= 45:  # of 86, the first law's heights mostly
            raise KeyboardInterrupt

    for name, first, second in (("one", None, executor), ("two", executor, None)):
        with pytest.raises(SweepInterrupted) as interrupted:
            swept(tmp_path / name, first, progress=stop)
        solved.clear()
        resumed = swept(tmp_path / name, second, resume=True, workers=2)
        assert len(solved) == COUNT - interrupted.value.done.sum() < COUNT and same(resumed, whole())


def test_a_store_of_another_machine_is_not_gone_on_with(executor, tmp_path, solved):
    """Its other blocks have the bits of that machine."""
    swept(tmp_path, executor)
    file = tmp_path / STORE / ".zattrs"
    described = json.loads(file.read_text())
    made_on = {**json.loads(described["made_on"]), "processor": "another"}
    file.write_text(json.dumps({**described, "made_on": json.dumps(made_on)}))
    with pytest.warns(UserWarning, match="left out"), pytest.raises(InputError, match="differs in processor"):
        swept(tmp_path, executor, resume=True)


def test_the_same_sweep_begun_anew_in_other_blocks(executor, tmp_path, solved, monkeypatch):
    swept(tmp_path, executor, rtol=1e-3)
    monkeypatch.setattr("jaxbuffer.sweeps.chunk.CHUNK", 11)
    assert same(swept(tmp_path, executor, force=True), whole())
    assert len(list((tmp_path / STORE / CHECKSUM).iterdir())) > BLOCKS
    assert sorted(path.name for path in tmp_path.iterdir()) == [STORE]


def spec(over=OVER):
    settings = SweepSettings(np.asarray(1e-6), np.asarray(20.0), AUTOMATIC)
    return SweepSpec(BAR, jb.BarDropScenario(), 0.01, grid(over, BAR, jb.BarDropScenario()), settings)


def test_a_driver_left_over_writes_nothing_into_another_sweeps_store(tmp_path):
    """As of one whose lock did not reach another machine."""
    first, second = (begun(tmp_path / STORE, spec(), 16, {}) for _ in range(2))
    columns = [np.zeros(BLOCK, int if name in WHOLE else float) for name in COLUMNS]
    with pytest.raises(InputError, match="has become another sweep's meanwhile"):
        first.write_columns(0, columns)
    second.write_columns(0, columns)
    assert second.read(0)["code"].tolist() == [0] * BLOCK


def test_a_full_disk_at_the_beginning_leaves_no_store(tmp_path, solved):
    with room_for(10), pytest.raises(OSError, match="File too large"):
        swept(tmp_path, None)
    assert not (tmp_path / STORE).exists()


class Ending(ThreadPoolExecutor):
    """Ends after its first calls, as a Dask client without its scheduler: what waits is cancelled."""

    calls = itertools.count()

    def submit(self, *arguments):
        if next(self.calls) < 4:
            return super().submit(*arguments)
        future = Future()
        future.cancel()
        future.set_running_or_notify_cancel()
        return future


def test_a_scheduler_that_ends_leaves_what_was_done(tmp_path, solved):
    """And the message says how much."""
    kept = r"its scheduler is gone or it was shut down; (\d+) of 86 drops are kept"
    with Ending(1) as executor, pytest.raises(ConnectionError, match=kept) as ended:
        swept(tmp_path, executor)
    done = int(re.search(kept, str(ended.value))[1])
    solved.clear()
    assert same(swept(tmp_path, None, resume=True), whole()) and len(solved) == COUNT - done + COUNT


def test_what_a_call_refuses_is_said_as_here(executor, tmp_path, monkeypatch):
    def bad(*call):
        raise InputError("k_A and c_A don't go together")

    monkeypatch.setattr(module, "columns_of_chunk", bad)
    with pytest.raises(InputError, match="don't go together"):
        swept(tmp_path, executor)


def test_calls_are_few_at_a_time_and_small(executor, solved, monkeypatch):
    """Neither what waits nor what is sent grows with the sweep."""
    handed_out, told, calls = [], [], module._calls

    def counted(*arguments):
        for call in calls(*arguments):
            handed_out.append(len(told))
            yield call

    monkeypatch.setattr(module, "_calls", counted)
    monkeypatch.setattr("jaxbuffer.cluster.pool.WAITING", 5)
    monkeypatch.setattr("jaxbuffer.sweeps.chunk.TASK", 16)
    over = {"scenario.height": {"from": 0.1, "to": 0.2, "count": 1600}}
    options = {"executor": executor, "workers": 1, "progress": lambda *done: told.append(done)}
    jb.sweep(BAR, jb.BarDropScenario(), 0.01, over=over, **options)
    assert len(handed_out) == 100 and max(k - n for k, n in enumerate(handed_out)) <= 5
    many = {"scenario.height": {"from": 0.1, "to": 0.2, "count": 2000}, "impact.stiffness": [1e10, 1e11]}
    (batch,) = spec(many).batches
    assert len(pickle.dumps(next(batch.parts(512)))) < 20_000


@pytest.mark.quick
@pytest.mark.parametrize(
    ("sizes", "most", "found"),
    [
        ([45, 1], 16, (15, 1)),
        ([40, 25], 50, (2, 25)),
        ([10, 1, 12], 16, (1, 1, 12)),
        ([3, 4], 100, (3, 4)),
        ([1000], 512, (500,)),
        ([7, 1000], 16, (1, 16)),
    ],
)
def test_blocks_are_even_and_cover_all_once(sizes, most, found):
    assert box(sizes, most) == found
    cut, seen = Cut(tuple(sizes), found), np.zeros(sizes, int)
    for number in range(len(cut)):
        seen[cut.region(number)] += 1
    assert np.all(seen == 1)


@pytest.mark.parametrize(
    ("runs", "threads", "size"),
    [
        (86, 1, 16),
        (4096, 2, 256),
        (50_000, 2, 512),
        (10**6, 32, 512),
        (10**8, 1000, 2000),
        (10**6, 1000, 1000),
        (50, 64, 16),
    ],
)
def test_calls_are_larger_where_many_wait_for_one_scheduler(runs, threads, size):
    assert task_size(runs, threads) == size
