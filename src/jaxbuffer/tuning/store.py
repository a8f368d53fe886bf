"""A tuning on disk: a log that only grows and a state that is replaced whole, so that a kill loses one step at most.

``log.jsonl`` has a line for each evaluated design, for people and other programs. ``state.npz`` has all that the search
needs to go on, the log up to then included, and a checksum; ``state.old.npz`` is the same one step earlier. Either of
the two is enough to resume: lines of a step that was cut short are dropped from the log, a damaged log is restored.
"""

import hashlib
import io
import json
import os
import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..files import Lock, naming, write, write_beside
from ..version import version

LOG, STATE, PREVIOUS = "log.jsonl", "state.npz", "state.old.npz"
CHECKSUM, VERSION, FINGERPRINT, LINES = "checksum", "jaxbuffer", "fingerprint", "log"
_SETTING = re.compile(r"(\w+)(?: \[[^\]]*\])? ?= ?([^,\n)]+)")  # "seed=0" or "tolerance [-] = 0.0001"
Record = dict[str, Any]


class Store:
    """The files of one tuning, in a folder that is locked until `close`; without a ``folder`` it keeps the log in
    memory only.

    ``records``: the evaluations so far; ``state``: the arrays last given to `keep`, None before the first.
    """

    def __init__(self, folder: Path | None, fingerprint: str, resume: bool) -> None:
        self.folder, self.fingerprint, self.records = folder, fingerprint, list[Record]()
        self.state: dict[str, np.ndarray] | None = None
        self.lines = b""
        if folder is None:
            if resume:
                raise InputError("resume needs the folder of the run to go on with")
            return
        if resume and not any((folder / name).exists() for name in (LOG, STATE, PREVIOUS)):
            raise InputError(f"{folder}: there is no run to resume; {LOG} is missing; leave out --resume to begin one")
        self.lock = Lock(folder)
        try:
            if resume:
                self._resume(folder)
            else:
                self._begin(folder)
        except BaseException:
            self.lock.release()
            raise

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, *_: object) -> None:
        if self.folder is not None:
            self.lock.release()

    def _begin(self, folder: Path) -> None:
        (folder / PREVIOUS).unlink(missing_ok=True)
        write(folder / LOG, b"")
        self.keep({})

    def _resume(self, folder: Path) -> None:
        state, self.lines = read_state(folder, self.fingerprint)
        self.state = state or None
        self.records = [json.loads(line) for line in self.lines.splitlines()]
        log = folder / LOG
        found = log.read_bytes() if log.exists() else None
        told = f"restored from {STATE}, {len(self.records)} evaluations"
        if found is None:
            warnings.warn(f"{log} is missing; {told}", stacklevel=2)
        elif not found.startswith(self.lines):
            warnings.warn(f"{log} is damaged; {told}; what it was is in {write_beside(log, found)}", stacklevel=2)
        if found != self.lines:
            write(log, self.lines)

    def append(self, record: Mapping[str, Any]) -> None:
        """Add one evaluation to the log."""
        self.records.append(dict(record))
        if self.folder is not None:
            line = (json.dumps(record, allow_nan=False) + "\n").encode()
            self.lines += line
            with naming(self.folder / LOG), (self.folder / LOG).open("ab") as log:
                log.write(line)
                log.flush()
                os.fsync(log.fileno())

    def keep(self, state: Mapping[str, np.ndarray]) -> None:
        """Replace the state by the one after a finished step; the one before stays as the previous one."""
        if self.folder is None:
            return
        head = {VERSION: version(), FINGERPRINT: self.fingerprint, LINES: np.frombuffer(self.lines, np.uint8)}
        arrays: dict[str, Any] = {name: np.asarray(value) for name, value in {**head, **state}.items()}
        arrays[CHECKSUM] = np.asarray(_checksum(arrays))
        content = io.BytesIO()
        np.savez(content, **arrays)
        if state and (self.folder / STATE).exists():
            (self.folder / STATE).replace(self.folder / PREVIOUS)
        write(self.folder / STATE, content.getvalue())


def read_state(folder: Path, fingerprint: str) -> tuple[dict[str, np.ndarray], bytes]:
    """The latest good state in a folder, empty if no step was finished, and the log's lines up to then.

    Nothing is changed. **Raises:** `InputError` where there is none, or where it is another run's.
    """
    damage = []
    for name in (STATE, PREVIOUS):
        try:
            state = _read(folder / name)
        except InputError as error:
            damage.append(f"{name} {error}")
            continue
        if (found := str(state.pop(VERSION))) != version():
            raise InputError(f"{folder} holds a run of jaxbuffer {found}, which cannot be resumed by {version()}")
        if (found := str(state.pop(FINGERPRINT))) != fingerprint:
            told = "repeat the study and the options of the first run, or choose another --output"
            raise InputError(
                f"{folder} holds the run of another problem or other settings: {_differing(found, fingerprint)}; {told}"
            )
        lines = state.pop(LINES).tobytes()
        if damage:
            count = len(lines.splitlines())
            warnings.warn(f"{folder}: {damage[0]}; going on from {name}, {count} evaluations", stacklevel=2)
        return state, lines
    raise InputError(f"{folder}: the run cannot be resumed: {', '.join(damage)}; everything is left as it is")


def _differing(found: str, asked: str) -> str:
    """What differs between two fingerprints, of the problem and, behind a dash, of the settings by name."""
    (problem, _, there), (other, _, here) = found.partition("-"), asked.partition("-")
    settings, others = (dict(_SETTING.findall(text)) for text in (there, here))
    told = [] if problem == other else ["its study is another one (design, scenarios, [problem] or options)"]
    told += [
        f"{name} is {settings.get(name)} there, {value} here"
        for name, value in others.items()
        if value != settings.get(name)
    ]
    return ", ".join(told)


def _read(file: Path) -> dict[str, np.ndarray]:
    """The arrays of a state. Raises `InputError` that says what is wrong with it."""
    try:
        with file.open("rb") as content, np.load(content, allow_pickle=False) as stored:
            arrays = dict(stored)
    except FileNotFoundError:
        raise InputError("is missing") from None
    except Exception:  # zip files and arrays fail in many ways; all mean the same
        raise InputError("is damaged") from None
    if CHECKSUM not in arrays:
        raise InputError("is of another version of jaxbuffer")
    if str(arrays.pop(CHECKSUM)) != _checksum(arrays):
        raise InputError("is damaged")
    return arrays


def _checksum(arrays: Mapping[str, np.ndarray]) -> str:
    content = hashlib.sha256()
    for name in sorted(arrays):
        content.update(f"{name} {arrays[name].dtype} {arrays[name].shape}\n".encode() + arrays[name].tobytes())
    return content.hexdigest()
