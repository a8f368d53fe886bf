"""Files are whole or not there, errors name them, and a folder belongs to one run at a time."""

import contextlib
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import jaxbuffer
from jaxbuffer import InputError, save_design, table2
from jaxbuffer.files import Lock, sealed, unsealed, whole_folder, write, write_all, write_beside

SOURCE = str(Path(jaxbuffer.__file__).resolve().parents[1])
BIG = b"x" * 10**6


@contextlib.contextmanager
def room_for(size):
    """Files of this process hold no more bytes than this, as on a disk that is full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize("before", [None, b"old"])
def test_a_full_disk_leaves_the_old_file_and_no_part_of_the_new_one(tmp_path, before):
    file = tmp_path / "a.csv"
    if before is not None:
        file.write_bytes(before)
    with room_for(10**5), pytest.raises(OSError, match=r"File too large: '.*a\.csv'"):
        write(file, BIG)
    assert [path.read_bytes() for path in tmp_path.iterdir()] == ([] if before is None else [before])


def test_a_design_is_written_whole_too(tmp_path):
    save_design(tmp_path / "design.toml", table2())
    before = (tmp_path / "design.toml").read_text()
    with room_for(100), pytest.raises(OSError, match=r"design\.toml"):
        save_design(tmp_path / "design.toml", table2(), comment="again", overwrite=True)
    assert (tmp_path / "design.toml").read_text() == before and len(list(tmp_path.iterdir())) == 1


def test_a_name_that_is_taken_is_left_alone(tmp_path):
    (tmp_path / "a.csv").write_text("mine")
    with pytest.raises(FileExistsError):
        write(tmp_path / "a.csv", "new", overwrite=False)
    assert write_beside(tmp_path / "a.csv", "new") == tmp_path / "a-1.csv"
    assert write_beside(tmp_path / "a.csv", "newer") == tmp_path / "a-2.csv"
    assert [file.read_text() for file in sorted(tmp_path.iterdir())] == ["new", "newer", "mine"]


def test_without_links_a_taken_name_is_left_alone_too(tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, "link", refuse)
    assert write_beside(tmp_path / "a.csv", "mine") == tmp_path / "a.csv"
    assert write_beside(tmp_path / "a.csv", "new") == tmp_path / "a-1.csv"
    assert {file.read_text() for file in tmp_path.iterdir()} == {"mine", "new"}


def test_of_several_files_none_is_written_before_there_is_room_for_all(tmp_path):
    (tmp_path / "a").write_bytes(b"old")
    files = {tmp_path / "a": b"new", tmp_path / "sub" / "b": BIG}
    with room_for(10**5), pytest.raises(OSError, match="File too large"):
        write_all(files)
    assert [path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()] == [b"old"]
    write_all(files)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == files


@pytest.mark.parametrize("before", [None, "old"])
def test_a_folder_is_whole_or_as_it_was(tmp_path, before):
    folder = tmp_path / "store"
    if before is not None:
        folder.mkdir()
        (folder / "a").write_text(before)
    (tmp_path / ".store.draft").mkdir()  # of a process that was killed
    with pytest.raises(KeyboardInterrupt), whole_folder(folder) as draft:
        (draft / "a").write_text("half")
        raise KeyboardInterrupt
    assert [path.read_text() for path in tmp_path.rglob("a")] == ([] if before is None else [before])
    with whole_folder(folder) as draft:
        (draft / "b").write_text("new")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [folder / "b"]
    assert [path.name for path in tmp_path.iterdir()] == ["store"]


@pytest.mark.parametrize("content", [b"", b"numbers", b"\njaxbuffer checksum " * 2])
def test_a_sealed_content_is_what_it_was_or_refused(content):
    whole = sealed(content)
    assert unsealed(whole) == content
    assert unsealed(b"of another program") is None
    for k in range(len(whole)):
        with contextlib.suppress(ValueError):
            assert unsealed(whole[:k] + bytes([whole[k] ^ 1]) + whole[k + 1 :]) is None, "the mark is damaged"


def test_one_run_at_a_time(tmp_path):
    lock = Lock(tmp_path / "out")
    with pytest.raises(InputError, match=rf"out is in use by another run, process {os.getpid()};"):
        Lock(tmp_path / "out")
    lock.release()
    lock.release()
    assert list((tmp_path / "out").iterdir()) == []
    Lock(tmp_path / "out").release()


def test_the_lock_of_a_run_that_was_killed_is_free(tmp_path):
    code = (
        f"from jaxbuffer.files import Lock; Lock(__import__('pathlib').Path({str(tmp_path)!r})); print(1, flush=True)"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code + "; print(1, flush=True); input()"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": SOURCE},
    ) as process:
        assert process.stdout.readline() == b"1\n"
        with pytest.raises(InputError, match=f"process {process.pid};"):
            Lock(tmp_path)
        (tmp_path / f".a.csv.{process.pid}.part").write_text("half")
        process.send_signal(signal.SIGKILL)
    assert (tmp_path / ".lock").exists()
    (tmp_path / f".b.csv.{os.getpid()}.part").write_text("being written")
    Lock(tmp_path).release()
    assert [file.name for file in tmp_path.iterdir()] == [f".b.csv.{os.getpid()}.part"], "its draft goes as well"
