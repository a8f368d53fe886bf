"""Programs that a command needed last time are loaded while it imports what it needs besides."""

import json
import threading

import numpy as np
import pytest

from jaxbuffer.programs import ahead, cache, identity, store
from jaxbuffer.programs.cache import stored


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of programs, and a process that has just begun."""
    monkeypatch.setattr(identity, "OURS", identity.OURS | {__name__})
    monkeypatch.setattr(ahead, "backend_is_up", lambda: False)
    store.store_in(tmp_path / "programs")
    yield tmp_path / "programs"
    store.store_in(None)


def doubled(numbers):
    return [2.0 * numbers]


def command():
    """What a command computes, in a process that has no program in memory."""
    with ahead.loading("simulate"):
        return float(stored(doubled)(np.asarray([3.0]))[0][0])


def test_what_was_needed_last_time_is_loaded_before_it_is_asked_for(folder, monkeypatch):
    assert command() == 6.0
    (file,) = folder.glob("*.program")
    assert json.loads((folder / ahead.NOTE).read_bytes()) == {"simulate": [file.name]}
    monkeypatch.setattr(cache.store, "read", _only_beside(store.read))
    assert command() == 6.0


def _only_beside(read):
    """Reading a file, as long as it is not the main thread that asks."""

    def checked(file):
        assert threading.current_thread().name.startswith("loading programs")
        return read(file)

    return checked


def test_the_first_program_does_not_wait_for_those_after_it(folder, monkeypatch):
    command()
    (file,) = folder.glob("*.program")
    (folder / "later.program").write_bytes(file.read_bytes())
    (folder / ahead.NOTE).write_text(json.dumps({"simulate": [file.name, "later.program"]}))
    read, first_taken = store.read, threading.Event()

    def waiting(path):
        if path.name == "later.program":
            assert first_taken.wait(60.0)
        return read(path)

    monkeypatch.setattr(store, "read", waiting)
    with ahead.loading("simulate"):
        assert float(stored(doubled)(np.asarray([3.0]))[0][0]) == 6.0
        first_taken.set()


@pytest.mark.parametrize(
    "note", [b"", b"[]", b'{"simulate": ["gone.program"]}', b'{"simulate": ["../other.program"]}', b'{"simulate": 4}']
)
def test_a_note_that_is_of_no_use_costs_nothing(folder, note):
    assert command() == 6.0
    (folder / ahead.NOTE).write_bytes(note)
    assert command() == 6.0
    (file,) = folder.glob("*.program")
    assert json.loads((folder / ahead.NOTE).read_bytes()) == {"simulate": [file.name]}


def test_a_damaged_file_is_compiled_anew(folder):
    command()
    (file,) = folder.glob("*.program")
    whole = file.read_bytes()
    file.write_bytes(whole[:-20])
    assert command() == 6.0
    assert [it.name for it in folder.glob("*.program")] == [file.name] and not list(folder.glob("*.loading"))


def test_a_process_whose_backend_is_up_has_its_programs_in_memory(folder, monkeypatch):
    command()
    monkeypatch.setattr(ahead, "backend_is_up", lambda: True)
    monkeypatch.setattr(ahead, "_load", None)
    assert command() == 6.0


def test_without_a_folder_nothing_is_noted(folder):
    store.store_in(None)
    assert command() == 6.0
    assert not list(folder.iterdir())
