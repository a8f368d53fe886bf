"""A tuning on disk: a log that only grows and a state that is replaced whole, so that a kill loses one step at most.

``log.jsonl`` has a line for each evaluated design, for people and other programs; ``state.npz`` has all that the search
needs to go on. The state is written beside the old one and renamed over it; it says how long the log was, and what was
appended after it (by the step that was cut short) is dropped on resuming.
"""

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError

LOG, STATE = "log.jsonl", "state.npz"
Record = dict[str, Any]


class Store:
    """The files of one tuning; without a ``folder`` it keeps the log in memory only."""

    def __init__(self, folder: Path | None, fingerprint: str, resume: bool) -> None:
        self.folder, self.fingerprint, self.records = folder, fingerprint, list[Record]()
        self.state: dict[str, np.ndarray] | None = None
        if folder is None:
            if resume:
                raise InputError("resume needs the folder of the run to go on with")
            return
        if resume:
            self._read(folder)
        else:
            folder.mkdir(parents=True, exist_ok=True)
            (folder / STATE).unlink(missing_ok=True)
            (folder / LOG).write_bytes(b"")

    def _read(self, folder: Path) -> None:
        if not (folder / LOG).exists():
            raise InputError(f"{folder}: there is no run to resume; {LOG} is missing")
        length = 0
        if (folder / STATE).exists():
            with np.load(folder / STATE, allow_pickle=False) as stored:
                self.state = dict(stored)
            if (found := str(self.state.pop("fingerprint"))) != self.fingerprint:
                raise InputError(
                    f"{folder} holds the run of another problem or other settings ({found}, not {self.fingerprint})"
                )
            length = int(self.state.pop("log_length"))
        with (folder / LOG).open("r+b") as log:
            log.truncate(length)
            self.records = [json.loads(line) for line in log.read().decode().splitlines()]

    def append(self, record: Mapping[str, Any]) -> None:
        """Add one evaluation to the log."""
        self.records.append(dict(record))
        if self.folder is not None:
            with (self.folder / LOG).open("ab") as log:
                log.write((json.dumps(record, allow_nan=False) + "\n").encode())
                log.flush()
                os.fsync(log.fileno())

    def keep(self, state: Mapping[str, np.ndarray]) -> None:
        """Replace the state by the one after a finished step."""
        if self.folder is None:
            return
        length = (self.folder / LOG).stat().st_size
        new = self.folder / (STATE + ".new")
        with new.open("wb") as file:
            arrays: dict[str, Any] = {"fingerprint": self.fingerprint, "log_length": length, **state}
            np.savez(file, **arrays)
            file.flush()
            os.fsync(file.fileno())
        os.replace(new, self.folder / STATE)
