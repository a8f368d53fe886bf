"""What the first call costs: compilation in a fresh process, and the command line with and without its cache."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from . import fresh
from .figures import Check, Figure, Part
from .plan import ROOT, Plan

COMPILE_CAPTURE = 5.0  # [s] bounds
COMPILE_GRADIENT = 10.0
SHELL = 10.0
SHELL_CACHED = 3.0
RUNS = 3
STUDY = "[scenario]\napproach_speed = 0.1\n"  # Table 2 in so many words


def shell(study: Path, cache: Path) -> float:
    """Seconds of `jaxbuffer simulate` from a shell, start of the interpreter included."""
    begin = time.perf_counter()
    command = [sys.executable, "-m", "jaxbuffer", "simulate", str(study)]
    subprocess.run(command, cwd=ROOT, env=fresh.environment(cache), capture_output=True, check=True)
    return time.perf_counter() - begin


def measure(plan: Plan) -> Part:
    """The best of three each, as everywhere: another process can only add."""
    checks = []
    for task, what, bound in plan.track(
        (
            ("compile-capture", "compilation of a capture", COMPILE_CAPTURE),
            ("compile-gradient", "compilation of a capture with five derivatives", COMPILE_GRADIENT),
        ),
        "compilation",
    ):
        runs = [fresh.measured(task) for _ in range(RUNS)]
        seconds = min(run["first"] - run["warm"] for run in runs)
        checks.append(Check(what, Figure("jaxbuffer", seconds, "s"), bound))
    with tempfile.TemporaryDirectory() as folder:
        study = Path(folder) / "table2.toml"
        study.write_text(STUDY)
        caches = [Path(folder) / f"cache{k}" for k in range(RUNS)]
        empty, filled = (
            min(shell(study, cache) for cache in plan.track(caches, f"jaxbuffer simulate from a shell, {state} cache"))
            for state in ("empty", "filled")
        )
    for what, seconds, bound in (
        ("`jaxbuffer simulate` from a fresh shell, empty cache", empty, SHELL),
        ("`jaxbuffer simulate` from a fresh shell, filled cache", filled, SHELL_CACHED),
    ):
        checks.append(Check(what, Figure("jaxbuffer", seconds, "s"), bound))
    return Part("cold", "Compilation and cold start", checks=tuple(checks))
