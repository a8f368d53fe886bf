"""A sweep's file: what was finished is there again after whatever ended it, and damage is found."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer import InputError
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.sweeps import store as stored
from jaxbuffer.sweeps import sweep as module
from jaxbuffer.sweeps.columns import column_names, whole_numbers
from jaxbuffer.sweeps.result import SweepInterrupted
from jaxbuffer.sweeps.store import HEAD, MARK, STORE
from test_files import room_for

COLUMNS, WHOLE = column_names(PROBE_CONE), whole_numbers(PROBE_CONE)

COUNT = 100
SPEEDS = np.linspace(0.1, 0.2, COUNT)
CHUNK = 16


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
    monkeypatch.setattr(module, "completed", lambda solve, items, *where: map(solve, items))
    monkeypatch.setattr(stored, "PERIOD", 0.0)
    return speeds


def swept(folder, stop_at=COUNT, **options):
    def report(done, count):
        if done >= stop_at and done < count:
            raise KeyboardInterrupt

    settings = {"workers": 1, "progress": report, "rtol": 1e-6, **options}
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


def test_a_kill_costs_what_was_not_yet_written(solved, tmp_path, monkeypatch):
    """As after a kill -9 in the middle of a write: the file ends anywhere."""
    whole = swept(tmp_path)
    content = (tmp_path / STORE).read_bytes()
    record = HEAD.size + 8 * CHUNK * (1 + len(COLUMNS))
    begin = content.find(MARK)
    assert len(content) == begin + 6 * record + HEAD.size + 8 * (COUNT % CHUNK) * (1 + len(COLUMNS))
    for length in (begin, begin + 1, begin + HEAD.size, begin + record - 1, begin + 2 * record + 5):
        (tmp_path / STORE).write_bytes(content[:length])
        solved.clear()
        kept = (length - begin) // record * CHUNK
        if (length - begin) % record:
            with pytest.warns(UserWarning, match=f"are damaged; going on with {kept} of {COUNT} runs"):
                found = swept(tmp_path, resume=True)
        else:
            found = swept(tmp_path, resume=True)
        assert same(found, whole) and min(solved) == SPEEDS[kept]


@pytest.mark.parametrize("place", [0, 4, 9, 13, 17, 200, -1])
def test_a_flipped_bit_costs_its_record_only(solved, tmp_path, place):
    """Anywhere in the second record: its mark, its length, its checksum, its places, its numbers."""
    whole = swept(tmp_path)
    content = bytearray((tmp_path / STORE).read_bytes())
    record = HEAD.size + 8 * CHUNK * (1 + len(COLUMNS))
    content[content.find(MARK) + record + place % record] ^= 4
    (tmp_path / STORE).write_bytes(content)
    solved.clear()
    with pytest.warns(UserWarning, match=f"{record} bytes are damaged; going on with {COUNT - CHUNK} of {COUNT}"):
        assert same(swept(tmp_path, resume=True), whole)
    assert solved == SPEEDS[CHUNK : 2 * CHUNK].tolist()


@pytest.mark.parametrize("content", [b"", b"\n", b"garbage", bytes(range(256)) * 40, b"00000000 {}\n"])
def test_a_damaged_beginning_is_refused_and_left(solved, tmp_path, content):
    (tmp_path / STORE).write_bytes(content)
    with pytest.raises(InputError, match=r"sweep\.chunks is damaged at its beginning.*left as it is|holds another"):
        swept(tmp_path, resume=True)
    assert (tmp_path / STORE).read_bytes() == content and len(list(tmp_path.iterdir())) == 1


def test_another_sweep_is_refused_with_what_differs(solved, tmp_path):
    swept(tmp_path)
    before = (tmp_path / STORE).read_bytes()
    with pytest.raises(InputError, match="holds another sweep, differing in options;"):
        swept(tmp_path, resume=True, rtol=1e-7)
    with pytest.raises(InputError, match="holds another sweep, differing in options;"):
        swept(tmp_path, resume=True, duration=2.0)
    with pytest.raises(InputError, match="differing in design and scenarios;"):
        design = jb.replace(jb.table2(), {"contact.law": "hertz"})
        jb.sweep(design, jb.Scenario(approach_speed=SPEEDS[1:]), folder=tmp_path, resume=True)
    assert (tmp_path / STORE).read_bytes() == before and len(list(tmp_path.iterdir())) == 1


def test_what_can_not_be_resumed(solved, tmp_path):
    with pytest.raises(InputError, match="resume needs the folder"):
        swept(None, resume=True)
    with pytest.raises(InputError, match=r"there is no sweep to resume; sweep\.chunks is missing"):
        swept(tmp_path / "new", resume=True)
    assert not (tmp_path / "new").exists()


def test_one_sweep_at_a_time(solved, tmp_path):
    def report(done, count):
        with pytest.raises(InputError, match="is in use by another run, process"):
            swept(tmp_path, resume=True)
        told.append(done)

    told = []
    swept(tmp_path, progress=report)
    assert told and same(swept(tmp_path, resume=True), swept(None))


def test_a_full_disk_is_named_and_what_fits_is_kept(solved, tmp_path):
    with room_for(3000), pytest.raises(OSError, match=r"File too large: '.*sweep\.chunks'"):
        swept(tmp_path)
    with pytest.warns(UserWarning, match=f"going on with {CHUNK} of {COUNT}"):
        assert same(swept(tmp_path, resume=True), swept(None))


def test_records_come_once_a_second_not_once_a_chunk(solved, tmp_path, monkeypatch):
    monkeypatch.setattr(stored, "PERIOD", 3600.0)
    swept(tmp_path)
    assert (tmp_path / STORE).read_bytes().count(MARK) == 1
