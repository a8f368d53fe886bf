"""`--scheduler` of the commands: what is asked for, and what is refused before anything begins."""

import json

import pytest

from jaxbuffer.cli.commands import sweep as command
from jaxbuffer.cli.entry import run
from jaxbuffer.sensitivities.sensitivity import sensitivity
from jaxbuffer.sweeps.cut import GridSweep, Template
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.sweeps.stored import StoredInterrupted, StoredSweep
from jaxbuffer.tuning.pareto import pareto

WHERE = ["--scheduler", "tcp://127.0.0.1:8786"]
SPEEDS = ["--over", "scenario.approach_speed=0.1:0.3:5"]


@pytest.mark.parametrize(
    "words", [["sweep", *SPEEDS], ["sample", "--over", "buffer.k_A=100:400", "--count", "4"], ["tune"]]
)
def test_the_scheduler_is_asked(computed, no_figures, words):
    assert run([*words, *WHERE, "--output", "out"]) == 0
    asked = computed.asked("tune" if words[0] == "tune" else "sweep")
    assert asked["client"] == "tcp://127.0.0.1:8786" and str(asked["folder"]) == "out"
    assert run([*words, "--output", "again"]) == 0
    assert computed.asked("tune" if words[0] == "tune" else "sweep").get("client") is None


@pytest.mark.parametrize("words", [["sensitivity"], ["pareto", "--objectives", "peak_force,stroke", "--points", "2"]])
def test_certificates_and_fronts_ask_it_too(computed, no_figures, words):
    """Without a folder, which their workers do not write to."""
    assert run([*words, *WHERE]) == 0
    assert computed.asked(words[0])["client"] == "tcp://127.0.0.1:8786"
    assert run(words) == 0
    assert "client" not in computed.asked(words[0])


@pytest.mark.parametrize(
    ("words", "compute"),
    [(["sensitivity"], sensitivity), (["pareto", "--objectives", "peak_force,stroke"], pareto)],
)
def test_a_scheduler_that_is_none_is_bad_input(computed, capsys, monkeypatch, words, compute):
    monkeypatch.setattr(f"jaxbuffer.cli.commands.{words[0]}.compute", compute)
    assert run([*words, "--scheduler", "lokal"]) == 2
    shown = capsys.readouterr().err
    assert "scheduler lokal is unknown; expected local, processes or an address as in tcp://host:8786" in shown
    monkeypatch.setattr("jaxbuffer.cluster.extra.find_spec", lambda name: None)
    assert run([*words, *WHERE]) == 2
    assert "needs distributed and zarr, not installed here: pip install 'jaxbuffer[cluster]'" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["sweep", "sample"])
def test_a_scheduler_needs_a_folder_and_the_extra(computed, capsys, monkeypatch, name):
    assert run([name, *WHERE]) == 2
    assert "--scheduler needs --output DIR, where its workers store what they find" in capsys.readouterr().err
    monkeypatch.setattr("jaxbuffer.cluster.extra.find_spec", lambda name: None)
    assert run([name, *WHERE, "--output", "out"]) == 2
    shown = capsys.readouterr().err
    assert "needs distributed and zarr, not installed here: pip install 'jaxbuffer[cluster]'" in shown
    assert run([name, "--output", "out"]) == 0, "which nothing else needs"


def test_a_store_that_is_there_is_resumed_or_overwritten_on_purpose(computed, capsys, tmp_path):
    (tmp_path / "out" / "sweep.zarr").mkdir(parents=True)
    assert run(["sweep", *SPEEDS, *WHERE, "--output", "out"]) == 2
    assert "out/sweep.zarr exists; --resume goes on, --force overwrites" in capsys.readouterr().err
    assert run(["sweep", *SPEEDS, *WHERE, "--output", "out", "--resume"]) == 0
    assert computed.asked("sweep")["resume"]


@pytest.fixture
def large(monkeypatch, tmp_path, computed):
    """A sweep that is too large for tables, stored; what it ends with."""
    monkeypatch.setattr(command, "LARGEST", 4)
    ends = []

    def sweep(design, scenario, duration, *, over, client, **options):
        asked = GridSweep(grid(over, design, scenario, in_memory=False), Template(design, scenario, duration), 16)
        stored = StoredSweep(
            tmp_path / "out" / "sweep.zarr", asked, 5, 3 if ends else 5, {0: 3 if ends else 5}, {0: 2, 2: 1}
        )
        if ends:
            raise StoredInterrupted(stored)
        return stored

    monkeypatch.setattr(command, "compute", sweep)
    return ends


def test_of_a_large_sweep_only_the_store_is_left(large, capsys, tmp_path):
    assert run(["sweep", *SPEEDS, *WHERE, "--output", "out"]) == 0
    shown = capsys.readouterr().out
    assert "Sweep of 5 captures: 5 captured" in shown and "1 of 5 captures are ill-conditioned" in shown
    assert run(["sweep", *SPEEDS, *WHERE, "--output", "out", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"captured": 5}
    assert not (tmp_path / "out").exists(), "the workers write it"


def test_interrupted_it_says_how_to_go_on(large, capsys):
    large.append("interrupted")
    assert run(["sweep", *SPEEDS, *WHERE, "--output", "out"]) == 130
    shown = capsys.readouterr()
    assert "3 of 5 captures are kept; the same command with --resume goes on in out" in shown.err
    assert "Sweep of 5 captures; 3 of them done" in shown.out


def test_the_base_needs_nothing_of_the_extra():
    """Neither the package nor its sweeps import what may be missing."""
    import subprocess
    import sys

    code = (
        "import sys\n"
        "for name in ('dask', 'distributed', 'zarr', 'numcodecs'): sys.modules[name] = None\n"
        "import jaxbuffer as jb\n"
        "jb.sweep, jb.tune, jb.sample, jb.sensitivity, jb.pareto, jb.load\n"
        "import jaxbuffer.cli.commands.sweep, jaxbuffer.sweeps.sweep, jaxbuffer.tuning.evaluation\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
