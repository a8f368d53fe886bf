"""Tests in a process forked from one that has imported JAX and the like already, but nothing of the package.

A process started afresh spends longer on these imports than on most unit tests.
"""

import contextlib
import json
import os
import resource
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path
from typing import Any, NamedTuple

WAIT = 0.1  # s between two looks at a child
SLOWER = 8.0  # times the time of the processor that a child may take on a busy machine
MEMORY = 12 * 2**30  # bytes of addresses


class Answer(NamedTuple):
    """What tests said: how the process ended (0: all passed; 1: one failed; below 0: by that signal), and its notes."""

    status: int
    notes: list[dict[str, Any]]
    seconds: float  # of the processor


def preload() -> None:
    """Import what each child needs; JAX's backend must not start here."""
    import beartype
    import diffrax
    import equinox
    import jax.numpy
    import optax
    import pytest
    import scipy.integrate
    import scipy.optimize
    import scipy.stats

    del beartype, diffrax, equinox, jax, optax, pytest, scipy


def run_tests(tree: Path, nodes: list[str], limit: float, reach: bool = False) -> Answer:
    """Run tests of a tree, to the first that fails, or with ``reach`` all of them and with the lines they reach.

    **Arguments:** ``tree``: a copy of the repository; ``nodes``: tests, in their order; ``limit``: seconds of the
    processor.
    """
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        notes = Path(folder) / "notes.jsonl"
        notes.touch()
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        process = os.fork()
        if process == 0:
            _child(tree, nodes, limit, Path(folder), notes, reach)
        status = _ended(process, time.monotonic() + SLOWER * limit)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return Answer(status, [json.loads(line) for line in notes.read_text().splitlines()], spent)


def _child(tree: Path, nodes: list[str], limit: float, folder: Path, notes: Path, reach: bool) -> None:
    """All that the forked process does; it never returns."""
    status = 3
    try:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit), int(limit) + 5))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        with (folder / "output").open("w") as output:
            os.dup2(output.fileno(), 1)
            os.dup2(output.fileno(), 2)
        os.chdir(tree)
        sys.dont_write_bytecode = not reach
        os.environ |= {"TMPDIR": str(folder), "PYTHONPATH": os.pathsep.join([str(tree / "src"), str(tree)])}
        tempfile.tempdir = None
        sys.path[:0] = [str(tree / "src"), str(tree)]
        import pytest

        from .listener import Listener

        options = ["-q", "-p", "no:cacheprovider", "--tb=line", "-W", "ignore::pytest.PytestAssertRewriteWarning"]
        options += ["-m", "not slow", *([] if reach else ["-x"])]
        status = int(pytest.main([*options, *nodes], plugins=[Listener(notes, tree, reach)]))
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(status)


def _ended(process: int, deadline: float) -> int:
    """Wait for a child, and end it and its own children at the deadline."""
    while True:
        done, status = os.waitpid(process, os.WNOHANG)
        if done or time.monotonic() > deadline:
            break
        time.sleep(WAIT)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process, signal.SIGKILL)
    if not done:
        _, status = os.waitpid(process, 0)
    return os.waitstatus_to_exitcode(status)
