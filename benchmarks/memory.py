"""Peak memory of this process and its children, from Linux's /proc.

``getrusage`` won't do: a fresh process inherits its parent's peak there.
"""

from __future__ import annotations

import threading
from pathlib import Path

PERIOD = 0.1  # [s] between looks at the children
MEBIBYTE = 1024.0  # [KiB]


def status(process: int | str, name: str) -> float:
    """A size of a process [MiB] by its ``name`` in /proc; 0 once the process is gone."""
    try:
        lines = Path(f"/proc/{process}/status").read_text().splitlines()
    except OSError:
        return 0.0
    return next((float(line.split()[1]) / MEBIBYTE for line in lines if line.startswith(f"{name}:")), 0.0)


def children(process: int | str = "self") -> list[int]:
    """All processes below that one."""
    pids: list[int] = []
    for task in Path(f"/proc/{process}/task").glob("*/children"):
        try:
            below = [int(word) for word in task.read_text().split()]
        except OSError:
            continue
        for child in below:
            pids += [child, *children(child)]
    return pids


class PeakMemory:
    """Watches from entry to exit; afterwards ``mebibytes`` is this process's peak plus its children's."""

    mebibytes: float = 0.0

    def __enter__(self) -> PeakMemory:
        self._below = 0.0
        self._over = threading.Event()
        self._watch = threading.Thread(target=self._look, daemon=True)
        self._watch.start()
        return self

    def _look(self) -> None:
        while True:
            self._below = max(self._below, sum(status(child, "VmRSS") for child in children()))
            if self._over.wait(PERIOD):
                return

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._watch.join()
        self.mebibytes = status("self", "VmHWM") + self._below
