"""Measurements that need a process of their own: peak memory, and compilation with nothing compiled before.

``python -m benchmarks fresh TASK JSON`` prints one line of JSON; `measured` runs it and reads that line.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from .plan import ROOT

CACHE_SETTINGS = ("JAX_COMPILATION_CACHE", "JAX_PERSISTENT_CACHE", "JAX_ENABLE_COMPILATION_CACHE")
PATIENCE = 60.0  # [s] a sweep that took longer is not run again


def measured(task: str, **arguments: Any) -> dict[str, float]:
    """Figures of a task run by a fresh interpreter with an empty compilation cache."""
    with tempfile.TemporaryDirectory() as cache:
        command = [sys.executable, "-m", "benchmarks", "fresh", task, json.dumps(arguments)]
        done = subprocess.run(command, cwd=ROOT, env=environment(cache), capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(f"{task} failed:\n{done.stderr}")
    return json.loads(done.stdout.splitlines()[-1])


def environment(cache: str | Path) -> dict[str, str]:
    """This process's environment with a compilation cache of its own, and modules found as they are found here."""
    path = os.pathsep.join(filter(None, [str(ROOT / "src"), str(ROOT), os.environ.get("PYTHONPATH")]))
    # a cache of JAX's that the user has switched on would answer where compilation is measured
    own = {name: value for name, value in os.environ.items() if not name.startswith(CACHE_SETTINGS)}
    return {**own, "PYTHONPATH": path, "JAXBUFFER_CACHE": str(cache)}


def sweep(captures: int, rtol: float) -> dict[str, float]:
    """The product's sweep over the first ``captures`` of the grid, after a first chunk of them that compiles."""
    from . import ours
    from .grid import own_scenarios, parameters
    from .memory import PeakMemory

    cases = parameters(captures)

    def timed(number: int) -> float:
        begin = time.perf_counter()
        ours.sweep(own_scenarios(cases[:number]), rtol)
        return time.perf_counter() - begin

    with PeakMemory() as memory:
        first = timed(min(ours.CHUNK, captures))
        seconds = timed(captures)
        if seconds < PATIENCE:
            seconds = min(seconds, *(timed(captures) for _ in range(1 if captures > 100 else 4)))
    return {"first": first, "seconds": seconds, "mebibytes": memory.mebibytes}


def pool(peer: str, captures: int, rtol: float, parts: tuple[float, float]) -> dict[str, float]:
    """A two-process pool of a peer over the first ``captures`` of the grid."""
    from .grid import parameters
    from .memory import PeakMemory
    from .peers.pool import sweep as pooled
    from .peers.solvers import tolerances

    with PeakMemory() as memory:
        done = pooled(peer, parameters(captures), rtol, tolerances(rtol, parts))
    return {"seconds": done.seconds, "mebibytes": memory.mebibytes}


def compile_capture() -> dict[str, float]:
    """First and best later time of one capture."""
    from . import ours

    return _first_and_warm(lambda: ours.simulated("default", 1e-6, ours.jb.table2()))


def compile_gradient() -> dict[str, float]:
    """First and best later time of a capture with five derivatives."""
    from . import ours

    return _first_and_warm(lambda: ours.elasticities(1e-6))


def _first_and_warm(call: Callable[[], object]) -> dict[str, float]:
    times = []
    for _ in range(4):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return {"first": times[0], "warm": min(times[1:])}


TASKS = {"sweep": sweep, "pool": pool, "compile-capture": compile_capture, "compile-gradient": compile_gradient}


def main(task: str, arguments: str) -> None:
    """Print the figures of a task."""
    print(json.dumps(TASKS[task](**json.loads(arguments))))
