"""`python -m optimise --scheduler`: every study's tunings, fronts, certificates and sweeps go to the workers."""

from concurrent.futures import Executor, ThreadPoolExecutor

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.bar_drop import BAR_DROP
from jaxbuffer.sweeps.columns import column_names, column_types
from optimise import __main__ as command
from optimise import bending
from optimise.study import Sweeps

HEIGHTS = np.linspace(0.1, 0.2, 37)


class Enough(Exception):
    """Ends a study once it has asked for what is looked at."""


@pytest.fixture
def asked(monkeypatch):
    """What studies ask for, without the wait: the executor of each."""
    found = []

    def stands_in(*arguments, executor=None, **options):
        found.append(executor)
        raise Enough

    for name in ("study.tune", "study.sweep", "pareto.pareto", "bending.sensitivity"):
        monkeypatch.setattr(f"optimise.{name}", stands_in)
    monkeypatch.setattr(jb, "configure", lambda **options: None)
    return found


@pytest.mark.parametrize("name", [name for name in command.STUDIES if name != "bending"])
def test_every_study_passes_the_scheduler_on(asked, tmp_path, name):
    words = [name, "--output", str(tmp_path)]
    with pytest.raises(Enough):
        command.main([*words, "--scheduler", "local"])
    with pytest.raises(Enough):
        command.main(words)
    executor, none = asked
    assert isinstance(executor, Executor) and none is None


def test_so_do_the_certificates_of_the_probe_that_bends(asked):
    with pytest.raises(Enough):
        bending.elasticities("the executor", jb.table2(), jb.Scenario())
    assert asked == ["the executor"]


@pytest.mark.quick
def test_a_scheduler_that_is_none_is_one_line_and_bad_input(asked, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        command.main(["speeds", "--output", str(tmp_path), "--scheduler", "lokal"])
    assert ended.value.code == 2 and asked == []
    assert "scheduler lokal is unknown; expected local, processes or an address" in capsys.readouterr().err


def test_the_sweeps_of_a_study_are_stored_and_resumed(monkeypatch, tmp_path):
    """The same numbers by threads and by workers; on resuming nothing is solved twice."""
    names, types, solved = column_names(BAR_DROP), column_types(BAR_DROP), []

    def chunk(batch, wanted, *settings):
        height = np.asarray(batch[1].height)
        solved.extend(height[wanted].tolist())
        columns = (np.sin(height * (1 + k)) ** 2 for k in range(len(names)))
        return [(3 * c).astype(int) if types[n] == "<i8" else c for n, c in zip(names, columns, strict=True)]

    monkeypatch.setattr("jaxbuffer.sweeps.sweep.columns_of_chunk", chunk)
    drops = jb.BarDrop(), jb.BarDropScenario(height=HEIGHTS), 0.01, 1e-6
    here = Sweeps(tmp_path, False, None).found(*drops)
    assert not list(tmp_path.iterdir())
    with ThreadPoolExecutor(1) as executor:
        first, second = Sweeps(tmp_path, False, executor), Sweeps(tmp_path, True, executor)
        there = first.found(*drops)
        assert (tmp_path / "sweep-1" / "sweep.zarr").exists()
        count = len(solved)
        again = second.found(*drops)
        assert len(solved) == count == 2 * len(HEIGHTS)
        other = second.found(drops[0], jb.BarDropScenario(height=HEIGHTS + 0.01), *drops[2:])
        assert len(solved) == count + len(HEIGHTS) and (tmp_path / "sweep-2").exists()
    for found in (there, again):
        assert all(np.array_equal(found.columns[name], here.columns[name], equal_nan=True) for name in names)
    assert not np.array_equal(other.peak_force, here.peak_force)
