"""Folders with results of every kind, as the commands write them, of runs that are made up."""

import functools
import shutil
import tempfile
from pathlib import Path

import pytest

from computed import stand_in
from jaxbuffer import Outcome
from jaxbuffer.cli.entry import run

STUDY = """[problem.constraints]
stroke = 0.025  # m
peak_force = 300.0  # N
"""
OVER = ("--over", "scenario.approach_speed=0.1:0.3:3", "--over", "buffer.k_A=100,1000")
RANGES = ("--over", "scenario.approach_speed=0.1:0.3", "--over", "buffer.k_A=100:1000")
COMMANDS = {
    "run": ("simulate",),
    "other": ("simulate", "--buffer.k_A", "750"),
    "sensitivity": ("sensitivity",),
    "tuned": ("tune",),
    "sweep": ("sweep", *OVER),
    "sample": ("sample", *RANGES, "--count", "32", "--method", "sobol", "--indices", "--surface"),
    "front": ("pareto", "--objectives", "peak_force,stroke", "--points", "2"),
    "missed": ("simulate", "--scenario.approach_speed", "0.05"),
}


def every_kind(place):
    """The folders by what is in them, copies of those that a process makes once."""
    shutil.copytree(_made().name, place, dirs_exist_ok=True)
    return {name: place / name for name in COMMANDS}


@functools.cache
def _made():
    folder = tempfile.TemporaryDirectory(prefix="every-kind-")
    place = Path(folder.name)
    study = place / "study.toml"
    study.write_text(STUDY)
    with pytest.MonkeyPatch.context() as patched:
        computed = stand_in(patched)
        for name, words in COMMANDS.items():
            computed.outcome = Outcome.escaped if name == "missed" else Outcome.captured
            code = run([words[0], str(study), *words[1:], "--output", str(place / name)])
            assert code == (1 if name == "missed" else 0)
    return folder
