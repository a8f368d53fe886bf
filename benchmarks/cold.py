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
STUDY = "[scenario]\napproach_speed = 0.1\n"  # Table 2 in so many words


def shell(study: Path, cache: Path) -> float:
    """Seconds of `jaxbuffer simulate` from a shell, start of the interpreter included."""
    begin = time.perf_counter()
    command = [sys.executable, "-m", "jaxbuffer", "simulate", str(study)]
    subprocess.run(command, cwd=ROOT, env=fresh.environment(cache), capture_output=True, check=True)
    return time.perf_counter() - begin


def measure(plan: Plan) -> Part:
    """Every figure once: what is measured takes seconds; the cached command thrice."""
    checks = []
    for task, what, bound in plan.track(
        (
            ("compile-capture", "compilation of a capture", COMPILE_CAPTURE),
            ("compile-gradient", "compilation of a capture with five derivatives", COMPILE_GRADIENT),
        ),
        "compilation",
    ):
        found = fresh.measured(task)
        checks.append(Check(what, Figure("jaxbuffer", found["first"] - found["warm"], "s"), bound))
    with tempfile.TemporaryDirectory() as folder:
        study, cache = Path(folder) / "table2.toml", Path(folder) / "cache"
        study.write_text(STUDY)
        times = [shell(study, cache) for _ in plan.track(range(4), "jaxbuffer simulate from a shell")]
    for what, seconds, bound in (
        ("`jaxbuffer simulate` from a fresh shell, empty cache", times[0], SHELL),
        ("`jaxbuffer simulate` from a fresh shell, filled cache", min(times[1:]), SHELL_CACHED),
    ):
        checks.append(Check(what, Figure("jaxbuffer", seconds, "s"), bound))
    return Part("cold", "Compilation and cold start", checks=tuple(checks))
