"""The store of a choice's runs: what is read back, what damage costs, and what is refused."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.choosing.store import BEGUN, ChoiceStore, Columns

IDENTITY = {"version": "0.1.0", "ranking": "8"}
KEYS = [(3, 0), (3, 1)]


def columns(first):
    return Columns(np.array([1, 2]), np.array([4, 5]), first + np.arange(4.0).reshape(2, 2))


@pytest.fixture
def folder(tmp_path):
    """A store with two blocks of runs, at two tolerances."""
    store = ChoiceStore(tmp_path / "runs", IDENTITY, resume=False)
    for rtol, first in ((1e-6, 0.1), (1e-9, 0.2)):
        store.add(KEYS, rtol, columns(first))
    assert not list((tmp_path / "runs").glob("[0-9]*.npz")), "written by save alone"
    store.save()
    return tmp_path / "runs"


def rows(store):
    return [[store.row(key, rtol) for key in KEYS] for rtol in (1e-6, 1e-9)]


def test_runs_are_read_back_to_the_bit_and_others_are_added(folder):
    store = ChoiceStore(folder, IDENTITY, resume=True)
    for (one, other), first in zip(rows(store), (0.1, 0.2), strict=True):
        assert one[:2] == (1, 4) and other[:2] == (2, 5)
        np.testing.assert_array_equal([one[2], other[2]], columns(first).values)
    assert store.row((4, 0), 1e-6) is None and store.row(KEYS[0], 1e-7) is None
    store.add([(7, 0), (7, 1)], 1e-6, columns(0.3))
    store.save()
    assert len(list(folder.glob("[0-9]*.npz"))) == 3
    assert ChoiceStore(folder, IDENTITY, resume=True).row((7, 0), 1e-6)[:2] == (1, 4)


@pytest.mark.parametrize("damage", ["flip", "cut", "of another block"])
def test_damage_costs_its_block_and_stays(folder, damage):
    first, second = sorted(folder.glob("[0-9]*.npz"))
    content = bytearray(first.read_bytes())
    content[300] ^= 1
    first.write_bytes({"flip": content, "cut": content[:200], "of another block": second.read_bytes()}[damage])
    before = first.read_bytes()
    store = ChoiceStore(folder, IDENTITY, resume=True)
    lost, kept = rows(store)
    assert lost == [None, None] and None not in kept
    store.add(KEYS, 1e-6, columns(0.1))
    store.save()
    assert first.read_bytes() == before and None not in rows(ChoiceStore(folder, IDENTITY, resume=True))[0]


def test_another_choice_a_damaged_one_and_one_of_an_earlier_version_are_refused(folder):
    with pytest.raises(jb.InputError, match="holds another choice, differing in ranking; repeat the study"):
        ChoiceStore(folder, IDENTITY | {"ranking": "2"}, resume=True)
    (folder / BEGUN).write_bytes(b"#")
    with pytest.raises(jb.InputError, match=r"begun\.npz is damaged and cannot be resumed; it is left as it is"):
        ChoiceStore(folder, IDENTITY, resume=True)
    (folder / BEGUN).rename(folder / "choose.json")
    with pytest.raises(jb.InputError, match=r"begun\.npz is missing and cannot be resumed"):
        ChoiceStore(folder, IDENTITY, resume=True)
    ChoiceStore(folder, IDENTITY, resume=False)
    assert {file.name for file in folder.iterdir()} == {BEGUN}


def test_what_could_not_be_written_waits(folder, monkeypatch):
    store = ChoiceStore(folder, IDENTITY, resume=True)
    store.add([(9, 0), (9, 1)], 1e-6, columns(0.4))

    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched, pytest.raises(OSError):
        patched.setattr("jaxbuffer.block_store.write", full)
        store.save()
    store.save()
    assert ChoiceStore(folder, IDENTITY, resume=True).row((9, 1), 1e-6)[:2] == (2, 5)
