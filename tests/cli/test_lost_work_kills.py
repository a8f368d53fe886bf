"""Kills of sweep and tune at random moments; what comes out in the end is what comes out undisturbed.

Each command is killed as often as `--kills` says, twice by default: sweep by the first two signals, tune by the others.
"""

import random
import signal
import subprocess
import time

import pytest
from determinism import computed_part
from test_lost_work import started

QUICK_RECORDS = "import jaxbuffer.sweeps.store as s; s.PERIOD = 0.1; from jaxbuffer.cli import main; main()"
COMMANDS = {
    "sweep": (
        ["--over", "scenario.approach_speed=0.1:0.2:500", "--duration", "1"],
        "sweep.zarr",
        ("sweep.csv", "sweep.txt", "sweep.json"),
    ),
    "tune": (
        ["--duration", "1", "--iterations", "8", "--starts", "2"],
        "state.npz",
        ("design.toml", "tuned.json", "history.csv", "tune.txt", "force.json", "log.jsonl"),
    ),
}
SIGNALS = {
    "kill -9": [signal.SIGKILL],
    "SIGTERM": [signal.SIGTERM],
    "SIGHUP": [signal.SIGHUP],
    "three quick Ctrl-C": [signal.SIGINT] * 3,
}


def run(folder, *words):
    # what a shell without job control runs in the background ignores Ctrl-C, and so would what it starts
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    process = started(folder, *words, code=QUICK_RECORDS, text=True)
    signal.signal(signal.SIGINT, before)
    return process


def completed(folder, *words):
    with run(folder, *words) as process:
        errors = process.communicate(timeout=300)[1]
    assert process.returncode == 0, errors


@pytest.mark.long
@pytest.mark.parametrize(("command", "first_signal"), [("sweep", 0), ("tune", 2)])
def test_killed_at_random_moments(tmp_path, pytestconfig, command, first_signal):
    options, store, files = COMMANDS[command]
    words = [command, *options, "--output"]
    completed(tmp_path, *words, "warm")  # compiles
    begin = time.monotonic()
    completed(tmp_path, *words, "whole")
    usual = time.monotonic() - begin
    chance, kills = random.Random(16), 0
    while kills < pytestconfig.getoption("--kills"):
        how = list(SIGNALS)[(first_signal + kills) % len(SIGNALS)]
        again = "--resume" if (tmp_path / "cut" / store).exists() else "--force"
        with run(tmp_path, *words, "cut", again) as process:
            try:
                process.wait(chance.uniform(0.1, 0.7) * usual)
            except subprocess.TimeoutExpired:
                for number in SIGNALS[how]:
                    process.send_signal(number)
                    time.sleep(0.02)
                kills += 1
                _check_ending(process)
            else:
                assert process.returncode == 0, process.communicate()[1]
    completed(tmp_path, *words, "cut", "--resume" if (tmp_path / "cut" / store).exists() else "--force")
    for name in files:
        assert computed_part(tmp_path / "cut" / name) == computed_part(tmp_path / "whole" / name), name


def _check_ending(process):
    """The exit code is of the signal or, a moment too late for it, of success; and there is no traceback."""
    errors = process.communicate(timeout=60)[1]
    assert "Traceback" not in errors, errors
    expected = {number for numbers in SIGNALS.values() for number in numbers}
    assert process.returncode in {0, *(128 + n for n in expected), *(-n for n in expected)}, errors
