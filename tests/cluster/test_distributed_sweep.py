"""A sweep over a scheduler: the numbers of the sweep without one, in a store that any end leaves to go on with."""

import dataclasses
import json
import pickle

import numcodecs
import numpy as np
import pytest
import xarray as xr

import jaxbuffer as jb
from jaxbuffer import InputError
from jaxbuffer.cluster.connect import connected
from jaxbuffer.mechanisms.bar_drop import BAR_DROP
from jaxbuffer.sweeps import distributed
from jaxbuffer.sweeps.chunk import task_size
from jaxbuffer.sweeps.columns import column_names, column_types
from jaxbuffer.sweeps.cut import Block, Cut, GridSweep, RunsSweep, Template, box
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.sweeps.result import SweepInterrupted
from jaxbuffer.sweeps.store import CHECKSUM, FORMER, STORE, existing
from jaxbuffer.sweeps.stored import StoredInterrupted
from test_files import room_for

COLUMNS = column_names(BAR_DROP)
WHOLE = [name for name, kind in column_types(BAR_DROP).items() if kind == "<i8"]
OVER = {"scenario.height": {"from": 0.1, "to": 0.2, "count": 43}, "impact.law": ["hertz", "adams"]}
BAR = jb.replace(jb.BarDrop(), {"impact.exponent": 1.5})
COUNT, BLOCKS, BLOCK, EDGE = 86, 6, 15, 13  # runs; blocks of 15, 15 and 13 heights for each law


@pytest.fixture(scope="module")
def client():
    """One thread of this process."""
    with connected("local", 1) as client:
        yield client


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

    monkeypatch.setattr(distributed, "columns_of_chunk", chunk)
    monkeypatch.setattr("jaxbuffer.sweeps.sweep.columns_of_chunk", chunk)
    return heights


def swept(folder, client, **options):
    given = {"client": client, "folder": folder, "save": False, **options}  # numbers made up fill no table
    return jb.sweep(BAR, jb.BarDropScenario(), 0.01, over=OVER, **given)


def whole():
    return jb.sweep(BAR, jb.BarDropScenario(), 0.01, over=OVER).found


def same(one, other):
    return all(np.array_equal(one.columns[name], other.columns[name], equal_nan=True) for name in COLUMNS)


def test_the_same_bits_as_without_a_scheduler(client, tmp_path):
    """Solved by the real program, in other chunks: blocks of 15, 15 and 13 rather than 16 of the 43."""
    stored = swept(tmp_path, client)
    assert same(stored.load().found, whole())
    assert stored.outcomes == {"finished": COUNT} and stored.done == COUNT
    assert "Sweep of 86 drops: 86 finished" in repr(stored) and str(tmp_path / STORE) in repr(stored)


def test_runs_that_are_not_trusted_are_marked_and_counted(client, tmp_path, solved):
    stored = swept(tmp_path, client, trust=True)
    words = stored.to_xarray().trust
    meanings = dict(zip(words.flag_values, words.flag_meanings.split(), strict=True))
    assert list(meanings.values()) == ["trusted", "check", "ill-conditioned", "unknown"]
    found = whole()
    for index, verdict in meanings.items():
        assert stored.verdicts.get(int(index), 0) == found.verdicts.count(verdict) > 0
    assert f"{stored.verdicts[2]} of 86 drops are ill-conditioned" in repr(stored)


def test_runs_one_by_one_and_durations(client, tmp_path, solved):
    heights, durations = np.linspace(0.1, 0.2, 37), np.linspace(0.01, 0.02, 37)
    asked = BAR, jb.BarDropScenario(height=heights), durations
    stored = jb.sweep(*asked, client=client, folder=tmp_path)
    assert same(stored.load(), jb.sweep(*asked))
    data = jb.load(tmp_path).sweep
    assert data["scenario.height"].values.tolist() == heights.tolist() and data["scenario.height"].units == "m"


def test_the_store_is_labelled_and_says_what_it_is(client, tmp_path, solved):
    swept(tmp_path, client)
    data = xr.open_zarr(tmp_path / STORE)
    assert dict(data.sizes) == {"scenario.height": 43, "impact.law": 2, "block_number": BLOCKS}
    assert data["impact.law"].values.tolist() == ["hertz", "adams"] and data.peak_force.units == "N"
    meanings = dict(zip(data.code.flag_values, data.code.flag_meanings.split(), strict=True))
    assert [meanings[code] for code in (0, 2)] == [BAR_DROP.outcomes(code).name for code in (0, 2)]
    here = data.peak_force.sel({"impact.law": "adams"}).values
    np.testing.assert_array_equal(here, whole().peak_force.reshape(43, 2)[:, 1])
    assert json.loads(data.design)["impact.exponent [-]"] == 1.5 and data.jaxbuffer
    assert json.loads(data.settings) == {
        **{"duration [s]": 0.01, "rtol [-]": 1e-06},
        **{"solver": "automatic", "stabilisation [1/s]": 20.0, "trust": False},
    }
    assert set(json.loads(data.made_on)) >= {"jaxbuffer", "Python", "jaxlib", "processor", "XLA"}


@pytest.mark.parametrize("stop_at", [15, 45, 70])
def test_what_was_done_is_not_computed_again(client, tmp_path, solved, stop_at):
    def report(done, count):
        if done >= stop_at:
            raise KeyboardInterrupt

    with pytest.raises(StoredInterrupted, match="of 86 drops done; they are in") as stop:
        swept(tmp_path, client, progress=report)
    assert stop_at <= stop.value.found.done < COUNT
    counts = []
    stored = swept(tmp_path, client, resume=True, progress=lambda done, count: counts.append((done, count)))
    assert same(stored.load().found, whole()) and counts[-1] == (COUNT, COUNT)
    first = len(solved) - COUNT  # `whole` solved all of them once more
    assert COUNT <= first <= COUNT + BLOCK, "none but the one under way"
    solved.clear()
    assert swept(tmp_path, client, resume=True).done == COUNT and solved == [], "a finished one computes nothing"


def _cut_short(file):
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])


def _flipped(file):
    content = bytearray(file.read_bytes())
    content[len(content) // 2] ^= 4
    file.write_bytes(content)


DAMAGES = {
    "cut short": _cut_short,
    "flipped": _flipped,
    "empty": lambda file: file.write_bytes(b""),
    "removed": lambda file: file.unlink(),
    "garbled": lambda file: file.write_bytes(np.random.default_rng(3).bytes(200)),
}


EDGE_FILE = "peak_force/2/1"
DAMAGED = [*((EDGE_FILE, damage) for damage in DAMAGES), ("peak_force/1/0", "cut short"), ("code/0/1", "flipped")]
DAMAGED += [(f"{CHECKSUM}/3", damage) for damage in ("empty", "removed")]


@pytest.mark.parametrize(("place", "damage"), DAMAGED)
def test_a_damaged_block_is_computed_again_and_no_other(client, tmp_path, solved, place, damage):
    """A block at the grid's edge, one in its middle, one of whole numbers, and a checksum."""
    swept(tmp_path, client)
    solved.clear()
    DAMAGES[damage](tmp_path / STORE / place)
    stored = swept(tmp_path, client, resume=True)
    assert len(solved) == (EDGE if place == EDGE_FILE else BLOCK)
    assert same(stored.load().found, whole())


def test_another_blocks_numbers_are_noticed(client, tmp_path, solved):
    """Whole files in a wrong place, with a checksum of their own."""
    swept(tmp_path, client)
    solved.clear()
    for name in (*COLUMNS, CHECKSUM):
        one, other = ("1/0", "0/0") if name != CHECKSUM else ("2", "0")
        content = (tmp_path / STORE / name / other).read_bytes()
        (tmp_path / STORE / name / one).write_bytes(content)
    assert same(swept(tmp_path, client, resume=True).load().found, whole())
    assert len(solved) == BLOCK + COUNT


@pytest.mark.parametrize("content", [b"", b"{}", b"garbage", b"[1]", b'{"identity": "{}", "block": "x", "made_on": 3}'])
def test_a_damaged_beginning_is_refused_and_left(client, tmp_path, solved, content):
    swept(tmp_path, client)
    (tmp_path / STORE / ".zattrs").write_bytes(content)
    with pytest.raises(InputError, match=r"sweep\.zarr is damaged and cannot be resumed; it is left as it is"):
        swept(tmp_path, client, resume=True)
    assert (tmp_path / STORE / ".zattrs").read_bytes() == content


@pytest.mark.parametrize("where", [".zmetadata", ".zarray"])
def test_a_store_with_a_pickle_in_it_is_not_read(client, tmp_path, solved, monkeypatch, where):
    """Zarr would unpickle what such an array holds, which runs code, if an older numcodecs or its user lets it."""
    monkeypatch.setattr("numcodecs.pickles.ALLOW_UNSAFE_PICKLE_DECODE", True, raising=False)
    swept(tmp_path, client)
    name = "scenario.height"
    file = tmp_path / STORE / (".zmetadata" if where == ".zmetadata" else f"{name}/.zarray")
    content = json.loads(file.read_text())
    array = content["metadata"][f"{name}/.zarray"] if where == ".zmetadata" else content
    array |= {"dtype": "|O", "filters": [{"id": "pickle", "protocol": 5}], "compressor": None}
    file.write_text(json.dumps(content))
    (tmp_path / STORE / name / "0").write_bytes(pickle.dumps(Runs(str(tmp_path / "was-run"))))
    for read in (lambda: jb.load(tmp_path), lambda: swept(tmp_path, client, resume=True)):
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


def test_another_sweep_is_refused_with_what_differs(client, tmp_path, solved):
    swept(tmp_path, client)
    solved.clear()
    with pytest.raises(InputError, match=r"sweep\.zarr holds another sweep, differing in options;"):
        swept(tmp_path, client, resume=True, rtol=1e-7)
    with pytest.raises(InputError, match="differing in design;"):
        jb.sweep(jb.BarDrop(), jb.BarDropScenario(), 0.01, over=OVER, client=client, folder=tmp_path, resume=True)
    with pytest.raises(InputError, match="differing in scenarios;"):
        over = {**OVER, "scenario.height": [0.1, 0.2]}
        jb.sweep(BAR, jb.BarDropScenario(), 0.01, over=over, client=client, folder=tmp_path, resume=True)
    assert solved == []
    assert same(swept(tmp_path, client, resume=True).load().found, whole())


def test_what_can_not_be_resumed(client, tmp_path, solved):
    with pytest.raises(InputError, match="over a scheduler needs a folder"):
        swept(None, client)
    with pytest.raises(InputError, match=r"no sweep to resume; sweep\.zarr is missing; leave out"):
        swept(tmp_path / "new", client, resume=True)
    (tmp_path / FORMER).write_bytes(b'01234567 {"version": "0.0.9"}\n')
    for where in (client, None):
        with pytest.raises(InputError, match=r"sweep\.chunks is a sweep of jaxbuffer 0\.0\.9, which .* cannot resume"):
            swept(tmp_path, where, resume=True)


def test_a_sweep_goes_on_with_a_scheduler_or_without(client, tmp_path, solved):
    """One store, whoever writes it; blocks with some of their runs only are computed by workers as a whole."""

    def stop(done, count):
        if done >= 45:  # of 86, the first law's heights mostly
            raise KeyboardInterrupt

    with pytest.raises(SweepInterrupted):
        swept(tmp_path / "one", None, progress=stop, workers=1)
    assert same(swept(tmp_path / "one", client, resume=True).load().found, whole())
    with pytest.raises(StoredInterrupted):
        swept(tmp_path / "two", client, progress=stop)
    solved.clear()
    resumed = swept(tmp_path / "two", None, resume=True)
    count = len(solved)
    assert same(resumed.found, whole()) and 0 < count < len(solved) - count, "fewer than all"


def test_the_same_sweep_begun_anew_in_other_blocks(client, tmp_path, solved, monkeypatch):
    """By workers that have written to the store which was there."""
    swept(tmp_path, client)
    monkeypatch.setattr("jaxbuffer.sweeps.chunk.CHUNK", 11)
    assert same(swept(tmp_path, client).load().found, whole())
    assert len(list((tmp_path / STORE / CHECKSUM).iterdir())) > BLOCKS


def test_a_new_sweep_takes_the_place_of_one_that_was_there(client, tmp_path, solved):
    swept(tmp_path, client, rtol=1e-3)
    assert same(swept(tmp_path, client).load().found, whole())
    assert sorted(path.name for path in tmp_path.iterdir()) == [STORE]


def test_one_driver_at_a_time(client, tmp_path, solved):
    def report(done, count):
        with pytest.raises(InputError, match="is in use by another run, process"):
            swept(tmp_path, client, resume=True)
        told.append(done)

    told = []
    stored = swept(tmp_path, client, progress=report)
    assert told and same(stored.load().found, whole())


def test_a_worker_left_over_writes_nothing_into_another_sweeps_store(client, tmp_path, solved):
    """As of a driver that was killed, while another one begins anew there."""
    stored = swept(tmp_path, client)
    block, present = Block(0, (slice(0, BLOCK), slice(0, 1)), {}), existing(tmp_path / STORE, stored.asked)
    late = dataclasses.replace(present, head=present.head._replace(token="that of before"))
    with pytest.raises(InputError, match="has become another sweep's meanwhile"):
        late.write_columns(block, [np.zeros(BLOCK, int if name in WHOLE else float) for name in COLUMNS])
    assert present.read_columns(block) is not None and late.read_columns(block) is None


def test_a_full_disk_is_named_and_what_is_stored_is_kept(client, tmp_path, solved, monkeypatch):
    def chunk(*arguments):
        if len(solved) >= 45:
            resource_limit.__enter__()
        return one(*arguments)

    one, resource_limit = distributed.columns_of_chunk, room_for(100)
    monkeypatch.setattr(distributed, "columns_of_chunk", chunk)
    try:
        with pytest.raises(OSError, match=r"File too large; \d+ of 86 drops are known to be in .*sweep\.zarr") as full:
            swept(tmp_path, client)
    finally:
        resource_limit.__exit__(None, None, None)
    assert str(full.value.filename).endswith(STORE)
    monkeypatch.setattr(distributed, "columns_of_chunk", one)
    solved.clear()
    assert same(swept(tmp_path, client, resume=True).load().found, whole())
    assert len(solved) - COUNT < COUNT, "some were there"


def test_a_full_disk_at_the_beginning_leaves_no_store(client, tmp_path, solved):
    with room_for(10), pytest.raises(OSError, match="File too large"):
        swept(tmp_path, client)
    assert not (tmp_path / STORE).exists()


def test_what_a_worker_refuses_is_said_as_here(client, tmp_path, solved, monkeypatch):
    def bad(template, block):
        raise InputError("k_A and c_A don't go together")

    monkeypatch.setattr(GridSweep, "batch", staticmethod(bad))
    with pytest.raises(InputError, match="don't go together"):
        swept(tmp_path, client)


def test_tasks_are_few_at_a_time_and_small(client, tmp_path, solved, monkeypatch):
    """Neither what waits nor what is sent grows with the sweep."""
    made, done = [], []
    blocks = GridSweep.blocks

    def counted(self):
        for block in blocks(self):
            made.append(block)
            done.append(len(told))
            yield block

    told = []
    monkeypatch.setattr(GridSweep, "blocks", counted)
    monkeypatch.setattr("jaxbuffer.sweeps.chunk.TASK", 16)
    over = {"scenario.height": {"from": 0.1, "to": 0.2, "count": 1600}}
    report = lambda done, count: told.append(done)  # noqa: E731
    jb.sweep(BAR, jb.BarDropScenario(), 0.01, over=over, client=client, folder=tmp_path, progress=report)
    assert len(made) == 100 and max(k - n for k, n in enumerate(done)) <= 2, "of one thread"
    million = {"scenario.height": {"from": 0.1, "to": 0.2, "count": 10**6}, "impact.stiffness": [1e10] * 1000}
    template = Template(BAR, jb.BarDropScenario(), 0.01)
    sweep = GridSweep(grid(million, BAR, jb.BarDropScenario(), in_memory=False), template, 512)
    assert len(pickle.dumps(sweep.block(10**6))) < 10_000 and len(pickle.dumps(template)) < 2000


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
def test_tasks_are_larger_where_many_wait_for_one_scheduler(runs, threads, size):
    assert task_size(runs, threads) == size


def test_the_missing_extra_is_named(monkeypatch, tmp_path):
    monkeypatch.setattr("jaxbuffer.cluster.extra.find_spec", lambda name: None if name == "zarr" else True)
    with pytest.raises(
        InputError, match=r"a scheduler needs zarr, not installed here: pip install 'jaxbuffer\[cluster\]'"
    ):
        swept(tmp_path, "local")


@pytest.mark.parametrize(
    ("where", "message"),
    [
        ("lokal", "scheduler lokal is unknown; expected local, processes or an address"),
        ("tcp://127.0.0.1:9", "no scheduler answers at tcp://127.0.0.1:9"),
        (3, "client = 3 is no distributed.Client"),
    ],
)
def test_schedulers_that_are_none(monkeypatch, tmp_path, where, message):
    monkeypatch.setattr("jaxbuffer.cluster.connect.PATIENCE", 0.5)
    with pytest.raises(InputError, match=message):
        swept(tmp_path, where)


def test_runs_template_has_the_numbers_that_are_the_same():
    sweep = RunsSweep(BAR, jb.BarDropScenario(height=np.array([0.1, 0.2, 0.3])), 0.01, 3, 2)
    batch, duration = RunsSweep.batch(sweep.template, sweep.block(1))
    assert batch.scenarios.height.tolist() == [0.3] and duration == 0.01
    assert float(batch.design.impact.exponent) == 1.5
