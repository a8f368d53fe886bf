"""A folder belongs to one command at a time, whichever command it is."""

import json
import os
import subprocess
import sys

import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from jaxbuffer.errors import InputError
from jaxbuffer.files import LOCK, Lock

OVER = ["--over", "scenario.approach_speed=0.1,0.2"]  # m/s
COMMANDS = {
    "simulate": [],
    "sensitivity": [],
    "sweep": OVER,
    "sample": ["--over", "scenario.approach_speed=0.1:0.2", "--count", "4"],
    "tune": [],
    "pareto": ["--objectives", "peak_force,stroke"],
    "animate": [],
    "laws": [],
    "reproduce": ["docking"],
}


@pytest.mark.parametrize("command", COMMANDS)
def test_a_folder_that_another_run_has_is_refused_before_anything_is_computed(computed, capsys, tmp_path, command):
    other = Lock(tmp_path / "out")
    assert run([command, *COMMANDS[command], "--output", "out"]) == 2
    error = capsys.readouterr().err
    assert error == f"error: out is in use by another run, process {os.getpid()}; choose another folder\n"
    assert {name for name, _ in computed.calls} <= {"configure"}
    assert [file.name for file in (tmp_path / "out").iterdir()] == [LOCK]
    other.release()


@pytest.mark.parametrize("command", ["simulate", "sensitivity", "sweep", "tune", "pareto"])
def test_the_folder_is_free_afterwards(computed, no_figures, tmp_path, command):
    assert run([command, *COMMANDS[command], "--output", "new/out"]) == 0
    assert not list((tmp_path / "new" / "out").glob(".*"))
    Lock(tmp_path / "new" / "out").release()


@pytest.mark.parametrize("error", [jb.InputError("bad"), OSError("full"), KeyboardInterrupt()])
def test_a_command_that_ends_early_leaves_no_empty_folder(computed, tmp_path, error):
    (tmp_path / "there").mkdir()
    computed.error = error
    for folder in ("new/out", "there"):
        assert run(["simulate", "--output", folder]) != 0
    assert [path.name for path in tmp_path.rglob("*")] == ["there"]


def test_what_a_command_computes_has_its_folder_too(tmp_path):
    """A sweep's and a tuning's own lock is the command's; those of other folders are not."""
    command = Lock(tmp_path / "out")
    command.lend()
    Lock(tmp_path / "out" / ".." / "out").release()
    assert (tmp_path / "out" / LOCK).exists(), "released by its owner alone"
    other = Lock(tmp_path / "out" / "point-1")
    with pytest.raises(InputError, match="in use by another run"):
        Lock(tmp_path / "out" / "point-1")
    other.release()
    Lock.release_all()
    assert not (tmp_path / "out" / LOCK).exists() and not Lock.of_command


@pytest.mark.slow
def test_of_two_at_once_one_is_refused_and_the_other_s_files_are_its_own(tmp_path):
    (tmp_path / "drop.toml").write_text('kind = "bar_drop"\n[options]\nduration = 0.06\n')
    words = [sys.executable, "-m", "jaxbuffer", "simulate", "drop.toml", "--trust", "off", "--output", "out"]
    heights = ("0.01", "0.005")  # m
    both = [
        subprocess.Popen([*words, "--scenario.height", height], cwd=tmp_path, stderr=subprocess.PIPE, text=True)
        for height in heights
    ]
    errors = [one.communicate(timeout=240)[1] for one in both]
    codes = [one.returncode for one in both]
    assert sorted(codes) == [0, 2], errors
    winner = heights[codes.index(0)]
    record = json.loads((tmp_path / "out" / "drop.json").read_text())
    assert f"--scenario.height {winner}" in record["made"]["command"]
    assert jb.load(tmp_path / "out").run.attrs["scenario"].startswith(f'{{"height": {{"value": {winner},')
