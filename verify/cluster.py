"""A scheduler, workers and a driver as processes of this machine, on 127.0.0.1 only, to be killed at will."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from .run import ROOT

LOOPBACK = "127.0.0.1"
PATIENCE = 120.0  # s for a process to start or to end
OTHER_PROCESSOR = "import jaxbuffer.programs.process as kind; kind.processor = lambda: 'flags: of another one'; "
WORKER = "from distributed.cli.dask_worker import main; main()"


class Cluster:
    """A scheduler and workers, each a process. ``folder``: for their notes; ``cache``: of compiled programs."""

    def __init__(self, folder: Path, cache: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder, self.cache = folder, cache
        self.workers: list[subprocess.Popen[bytes]] = []
        self.scheduler: subprocess.Popen[bytes] | None = None
        self.address, self.port = "", 0

    def __enter__(self) -> Cluster:
        self.start_scheduler()
        return self

    def __exit__(self, *_: object) -> None:
        for process in (*self.workers, self.scheduler):
            if process is not None:
                killed(process)

    def start_scheduler(self) -> None:
        """Start it, at the same port as before if there was one."""
        note = self.folder / "scheduler.json"
        note.unlink(missing_ok=True)
        words = ["--host", LOOPBACK, "--port", str(self.port), "--no-dashboard", "--scheduler-file", str(note)]
        self.scheduler = self._started("from distributed.cli.dask_scheduler import main; main()", words, {})
        self.address = str(_read(note)["address"])
        self.port = int(self.address.rpartition(":")[2])

    def start_worker(self, source: Path | None = None, before: str = "") -> subprocess.Popen[bytes]:
        """Start one more. ``source``: of another jaxbuffer; ``before``: Python to be run first."""
        words = [self.address, "--host", LOOPBACK, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        words += ["--memory-limit", "0", "--local-directory", str(self.folder), "--death-timeout", "60"]
        environment = {} if source is None else {"PYTHONPATH": str(source)}
        process = self._started(before + WORKER, words, environment)
        self.workers.append(process)
        return process

    def tidy(self, count: int) -> None:
        """Start what is gone: the scheduler, and workers up to so many."""
        if self.scheduler is None or self.scheduler.poll() is not None:
            self.start_scheduler()
        self.workers = [process for process in self.workers if process.poll() is None]
        while len(self.workers) < count:
            self.start_worker()

    def _started(self, code: str, words: Sequence[str], environment: Mapping[str, str]) -> subprocess.Popen[bytes]:
        with open(self.folder / "log.txt", "ab") as log:
            return subprocess.Popen(
                [sys.executable, "-c", code, *words],
                env={**variables(self.cache), **environment},
                stdout=log,
                stderr=log,
                start_new_session=True,
            )


def variables(cache: Path) -> dict[str, str]:
    """The environment of every process here."""
    return {**os.environ, "PYTHONPATH": str(ROOT / "src"), "JAXBUFFER_CACHE": str(cache)}


def driver(cache: Path, *words: str) -> subprocess.Popen[str]:
    """`jaxbuffer sweep` with those words, under way."""
    return subprocess.Popen(
        [sys.executable, "-m", "jaxbuffer", "sweep", *words],
        env=variables(cache),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def killed(process: subprocess.Popen) -> None:
    """SIGKILL to the process and all that it started, if it is still there."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    for pipe in (process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()


@contextlib.contextmanager
def small_disk(folder: Path, size: str) -> Iterator[bool]:
    """A file system of that size in the folder; False where this user can't make one."""
    folder.mkdir(parents=True)
    made = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "none", folder], check=False, stderr=-3)
    try:
        yield made.returncode == 0
    finally:
        if made.returncode == 0:
            subprocess.run(["umount", "--lazy", folder], check=True)


def enlarged(folder: Path, size: str) -> None:
    """Give the file system of `small_disk` another size."""
    subprocess.run(["mount", "-o", f"remount,size={size}", folder], check=True)


def _read(note: Path) -> dict[str, object]:
    ends = time.monotonic() + PATIENCE
    while time.monotonic() < ends:
        with contextlib.suppress(OSError, ValueError):
            record: dict[str, object] = json.loads(note.read_text())
            return record
        time.sleep(0.1)
    raise TimeoutError(f"{note} did not come")
