"""A sweep and a tuning of a drop onto a tank, killed in the middle: resumed, they find the same bits."""

import signal
import time

import pytest
from determinism import computed_part
from test_lost_work_kills import completed, run

WAIT = 120.0  # s at most until something is kept
ZONES = ("bottom", "lower_corner", "lower_side", "upper_side", "upper_corner", "top")
STUDY = "\n".join([
    'kind = "tank_drop"',
    "[wall]",
    *(f"{zone} = 0.015" for zone in ZONES),
    "[scenario]\nheight = 0.2\nfill = 0.6",
    "[options]\nduration = 0.003",
    "[problem.variables]\nwall.top = [0.008, 0.02]\ncushion.stiffness = [5e5, 1e7]",
    "[problem.objective]\npeak_stress = 1.0",
    "[problem.constraints]\nwall_mass = 18.0",
])  # fmt: skip
COMMANDS = {
    "sweep": (["--over", "scenario.height=0.1:0.3:40"], "sweep.zarr", ("sweep.csv", "sweep.txt", "sweep.json")),
    "tune": (
        ["--iterations", "4", "--starts", "2"],
        "state.npz",
        ("design.toml", "tuned.json", "history.csv", "tune.txt", "force.json", "log.jsonl"),
    ),
}


def killed_once_it_kept_something(folder, words, store):
    with run(folder, *words) as process:
        end = time.monotonic() + WAIT
        while not store.exists() and process.poll() is None and time.monotonic() < end:
            time.sleep(0.01)
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=60)
    assert store.exists() and process.returncode == -signal.SIGKILL, "it was killed in the middle"


@pytest.mark.long
@pytest.mark.parametrize("command", COMMANDS)
def test_a_tanks_study_that_was_killed_is_resumed_to_the_same_bits(tmp_path, command):
    options, store, files = COMMANDS[command]
    (tmp_path / "tank.toml").write_text(STUDY)
    words = [command, "tank.toml", *options, "--output"]
    completed(tmp_path, *words, "whole")
    killed_once_it_kept_something(tmp_path, [*words, "cut"], tmp_path / "cut" / store)
    assert not (tmp_path / "cut" / files[0]).exists()
    completed(tmp_path, *words, "cut", "--resume")
    for name in files:
        assert computed_part(tmp_path / "cut" / name) == computed_part(tmp_path / "whole" / name), name
