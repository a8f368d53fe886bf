"""`--scheduler` of the commands: what is asked for, and what is refused before anything is computed."""

import contextlib
from concurrent.futures import ThreadPoolExecutor

import pytest

from jaxbuffer.cli.entry import run

WHERE = ["--scheduler", "tcp://127.0.0.1:8786"]
SPEEDS = ["--over", "scenario.approach_speed=0.1:0.3:5"]
COMMANDS = {
    "sweep": ["sweep", *SPEEDS],
    "sample": ["sample", "--over", "buffer.k_A=100:400", "--count", "4"],
    "tune": ["tune"],
    "pareto": ["pareto", "--objectives", "peak_force,stroke", "--points", "2"],
    "sensitivity": ["sensitivity"],
}


@pytest.fixture
def schedulers(monkeypatch):
    """Connections without Dask: the address and the executor of each."""
    made = []

    @contextlib.contextmanager
    def executor_of(where):
        made.append((where, ThreadPoolExecutor(1)))
        yield made[-1][1], 7

    monkeypatch.setattr("jaxbuffer.cluster.connect.executor_of", executor_of)
    return made


@pytest.mark.parametrize("name", COMMANDS)
def test_the_executor_of_the_scheduler_computes(computed, no_figures, schedulers, name):
    words, command = COMMANDS[name], "sweep" if name == "sample" else name
    assert run([*words, *WHERE]) == 0
    ((where, executor),) = schedulers
    asked = computed.asked(command)
    assert where == WHERE[1] and asked["executor"] is executor
    assert asked.get("workers") == (7 if command == "sweep" else None), "by which a sweep is divided into calls"
    assert run(words) == 0
    assert computed.asked(command)["executor"] is None and len(schedulers) == 1


@pytest.mark.parametrize("name", COMMANDS)
def test_a_scheduler_that_is_none_is_bad_input(computed, capsys, monkeypatch, name):
    assert run([*COMMANDS[name], "--scheduler", "lokal"]) == 2
    shown = capsys.readouterr().err
    assert "scheduler lokal is unknown; expected local, processes or an address as in tcp://host:8786" in shown
    monkeypatch.setattr("jaxbuffer.cluster.extra.find_spec", lambda name: None)
    assert run([*COMMANDS[name], *WHERE]) == 2
    assert "needs distributed and zarr, not installed here: pip install 'jaxbuffer[cluster]'" in capsys.readouterr().err
    assert not [it for it, _ in computed.calls if it != "configure"], "nothing is computed"


def test_a_store_that_is_there_is_resumed_or_overwritten_on_purpose(computed, schedulers, capsys, tmp_path):
    (tmp_path / "out" / "sweep.zarr").mkdir(parents=True)
    assert run(["sweep", *SPEEDS, *WHERE, "--output", "out"]) == 2
    assert "out/sweep.zarr exists; --resume goes on, --force overwrites" in capsys.readouterr().err
    assert run(["sweep", *SPEEDS, *WHERE, "--output", "out", "--resume"]) == 0
    assert computed.asked("sweep")["resume"]


def test_the_base_needs_nothing_of_the_extra():
    """Neither the package nor its sweeps import what may be missing."""
    import subprocess
    import sys

    code = (
        "import sys\n"
        "for name in ('dask', 'distributed', 'zarr', 'numcodecs'): sys.modules[name] = None\n"
        "import jaxbuffer as jb\n"
        "jb.sweep, jb.tune, jb.sample, jb.sensitivity, jb.pareto, jb.load\n"
        "import jaxbuffer.cli.commands.sweep, jaxbuffer.sweeps.sweep, jaxbuffer.tuning.search.evaluation\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
