"""A tuning's files: a log that only grows and a state that is replaced whole, so that a kill loses one step at most.

``log.jsonl`` has a line for each evaluated design, for people and other programs. ``state.npz`` has all that the search
needs to go on, the log up to then included, and a checksum; ``state.old.npz`` is the same one step earlier. Either of
the two is enough to resume: lines of a step that was cut short are dropped from the log, a damaged log is restored.
`record_of` makes the log's lines, `Progress` the state's arrays.
"""

import contextlib
import hashlib
import io
import json
import os
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..fields import as_displayed
from ..files import Lock, naming, write, write_beside
from ..value_text import percent_text, with_unit
from ..version import version
from .evaluation import Evaluation
from .goal import Goal
from .search import Branch

LOG, STATE, PREVIOUS = "log.jsonl", "state.npz", "state.old.npz"
CHECKSUM, VERSION, FINGERPRINT, LINES = "checksum", "jaxbuffer", "fingerprint", "log"
OPTIMIZER, CODE = "optimizer_steps", "own_code"  # in a fingerprint: hashes, which say nothing to people
_SETTING = re.compile(r"(\w+)(?: \[[^\]]*\])? ?= ?([^,\n)]+)")  # "seed=0" or "tolerance [-] = 0.0001"
STATUS = ("running", "converged", "stalled", "behind")
NUMBERS = ("stage", "captures", "scale", "ceiling", "searches", "apart")
Record = dict[str, Any]


class Store:
    """The files of one tuning, in a folder that is locked until `close`; without a ``folder`` it keeps the log in
    memory only.

    ``records``: the evaluations so far; ``state``: the arrays of the last `keep`, None before the first; ``report``:
    called with each record that is appended.
    """

    def __init__(self, folder: Path | None, fingerprint: str, resume: bool) -> None:
        self.folder, self.fingerprint, self.records = folder, fingerprint, list[Record]()
        self.state: dict[str, np.ndarray] | None = None
        self.report: Callable[[Record], None] | None = None
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
                (folder / PREVIOUS).unlink(missing_ok=True)
                write(folder / LOG, b"")
                self.keep({})
        except BaseException:
            self.lock.release()
            raise

    def __enter__(self) -> "Store":
        return self

    def __exit__(self, *_: object) -> None:
        if self.folder is not None:
            self.lock.release()

    def _resume(self, folder: Path) -> None:
        state, self.lines = read_state(folder, self.fingerprint)
        self.state = state or None
        self.records = [json.loads(line) for line in self.lines.splitlines()]
        log = folder / LOG
        content = log.read_bytes() if log.exists() else None
        remedy = f"restored from {STATE}, {len(self.records)} evaluations"
        if content is None:
            warnings.warn(f"{log} is missing; {remedy}", stacklevel=2)
        elif not content.startswith(self.lines):
            warnings.warn(f"{log} is damaged; {remedy}; what it was is in {write_beside(log, content)}", stacklevel=2)
        if content != self.lines:
            write(log, self.lines)

    def append(self, record: Mapping[str, Any]) -> None:
        """Add one evaluation to the log and report it."""
        self.records.append(dict(record))
        if self.folder is not None:
            line = (json.dumps(record, allow_nan=False) + "\n").encode()
            self.lines += line
            with naming(self.folder / LOG), (self.folder / LOG).open("ab") as log:
                log.write(line)
                log.flush()
                os.fsync(log.fileno())
        if self.report is not None:
            self.report(self.records[-1])

    def keep(self, state: Mapping[str, np.ndarray]) -> None:
        """Replace the state by the one after a step; the one before stays as the previous one."""
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
    """Read the latest good state in a folder, empty if no step was finished, and the log's lines up to then.

    Nothing is changed. **Raises:** `InputError` where there is none, or where it is another run's.
    """
    damage = []
    for name in (STATE, PREVIOUS):
        try:
            state = _read(folder / name)
        except InputError as error:
            damage.append(f"{name} {error}")
            continue
        if (writer := str(state.pop(VERSION))) != version():
            raise InputError(f"{folder} holds a run of jaxbuffer {writer}, which cannot be resumed by {version()}")
        if (other := str(state.pop(FINGERPRINT))) != fingerprint:
            remedy = "repeat the study and the options of the first run, or choose another --output"
            difference = _difference(other, fingerprint)
            raise InputError(f"{folder} holds the run of another problem or other settings: {difference}; {remedy}")
        lines = state.pop(LINES).tobytes()
        if damage:
            count = len(lines.splitlines())
            warnings.warn(f"{folder}: {damage[0]}; going on from {name}, {count} evaluations", stacklevel=2)
        return state, lines
    raise InputError(f"{folder}: the run cannot be resumed: {', '.join(damage)}; everything is left as it is")


def identity_of(fingerprint: str) -> str:
    """Return a short hash of a fingerprint, which a result's record has."""
    return hashlib.sha256(fingerprint.encode()).hexdigest()[:16]


def stored_identity(folder: Path) -> str | None:
    """Return which tuning was begun in a folder, as of `identity_of`; None where there is none that is whole."""
    for name in (STATE, PREVIOUS):
        with contextlib.suppress(InputError, KeyError):
            return identity_of(str(_read(folder / name)[FINGERPRINT]))
    return None


def _difference(stored: str, present: str) -> str:
    """Say what differs between two fingerprints, of the problem and, behind a dash, of the settings by name."""
    (problem, _, there), (other, _, here) = stored.partition("-"), present.partition("-")
    settings, others = (dict(_SETTING.findall(text)) for text in (there, here))
    lines = [] if problem == other else ["its study is another one (design, scenarios, [problem] or options)"]
    words = {OPTIMIZER: "its optimizer is another one", CODE: "the code of its mechanism, laws or solver has changed"}
    lines += [
        words.get(name, f"{name} is {settings.get(name)} there, {value} here")
        for name, value in others.items()
        if value != settings.get(name)
    ]
    return ", ".join(lines)


def _read(file: Path) -> dict[str, np.ndarray]:
    """Read the arrays of a state. Raises `InputError` that says what is wrong with it."""
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


def record_of(goal: Goal, point: Evaluation, number: int, stage: int, search: int, branch: Branch | None) -> Record:
    """Return the log's record of a design tried.

    **Arguments:** ``number`` of the evaluation; ``stage``; ``search``: number of the search; ``branch``: the search
    after it was tried, None for a start.
    """
    problem = goal.problem
    values, known = map(float, problem.values(point.scaled)), problem.known(point.code)
    return {
        "evaluation": number,
        "stage": stage,
        "search": search,
        "step": 0 if branch is None else branch.steps,
        "accepted": branch is None or branch.point is point,
        "objective": goal.value(point),
        "unit": goal.objective.unit(problem.catalogue),
        "feasible": goal.feasible(point),
        "excess": excess if np.isfinite(excess := float(np.sum(goal.excess(point)))) else None,
        "obstacle": goal.obstacle(point),
        "radius": None if branch is None else branch.radius,
        "residual": None if branch is None or np.isnan(branch.residual) else branch.residual,
        "status": "start" if branch is None else STATUS[branch.status],
        "captures": len(problem.cases) * (number + 1),
        "values": dict(zip(problem.paths, values, strict=True)),
        "outcome": [problem.mechanism.outcomes(int(code)).name for code in point.code],
        "succeeded": [bool(success) for success in point.succeeded],
        "impacts": [int(count) for count in point.impacts],
        "margin": point.margin.tolist(),
        **{
            name: [float(x) if there else None for x, there in zip(point.quantities[:, q], known[:, q], strict=True)]
            for q, name in enumerate(problem.names)
        },
    }


def in_words(it: Mapping[str, Any], success: str | None = None, most: int | None = None) -> str:
    """Return one evaluation of a tuning on one line.

    ``success``: how runs should end, as the mechanism calls it; ``most`` evaluations that there can be.
    """
    count = "" if most is None else f"{it['evaluation'] + 1} of at most {most}, "
    where = "start" if it["status"] == "start" else f"search {it['search'] + 1}, step {it['step']}"
    stage = "then, " if it["stage"] else ""
    text = f"{count}{stage}{where}: {with_unit(*as_displayed(it['objective'], it['unit']), 5)}"
    if not it["feasible"]:
        ends = it["succeeded"]
        text += "" if all(ends) else f", {sum(ends)} of {len(ends)} {success or 'solved'}"
        text += ", limits broken" + (f": {obstacle}" if (obstacle := it.get("obstacle")) else "")
    return text + ("" if it["residual"] is None else f", {percent_text(it['residual'])} left to gain")


class Progress(NamedTuple):
    """How far a tuning has come, as arrays that can be stored and read back.

    ``stage``, 0 or 1; ``captures`` spent; ``scale`` of the objective [N]; ``ceiling`` [N] on the first objective in the
    second stage, else NaN; of the first stage, how many ``searches`` were begun and by how much the best independent
    two differ, ``apart`` [-]; ``first``: the problem's own start; ``branches``: the searches.
    """

    stage: int
    captures: int
    scale: float
    ceiling: float
    searches: int
    apart: float
    first: Evaluation
    branches: tuple[Branch, ...]

    def arrays(self) -> dict[str, np.ndarray]:
        """Return flat names and arrays; `read` reads them back."""
        flat = {name: np.asarray(getattr(self, name)) for name in NUMBERS}
        flat |= _flat("first", self.first)
        for k, branch in enumerate(self.branches):
            flat |= _flat(f"{k}/point", branch.point) | _flat(f"{k}/best", branch.best)
            flat |= {f"{k}/{name}": np.asarray(getattr(branch, name)) for name in Branch._fields[2:]}
        return flat

    @staticmethod
    def read(flat: Mapping[str, np.ndarray] | None) -> "Progress | None":
        """Read what `arrays` returned, or None for nothing."""
        if flat is None:
            return None
        try:
            return Progress._of(flat)
        except KeyError as error:
            raise InputError(f"the stored run is of another version of jaxbuffer: it has no {error}") from None

    @staticmethod
    def _of(flat: Mapping[str, np.ndarray]) -> "Progress":
        branches: list[Branch] = []
        while (k := f"{len(branches)}/radius") in flat:
            k = k.removesuffix("/radius")
            rest = {name: _plain(flat[f"{k}/{name}"]) for name in Branch._fields[2:]}
            branches.append(Branch(_evaluation(flat, f"{k}/point"), _evaluation(flat, f"{k}/best"), **rest))
        numbers = {name: _plain(flat[name]) for name in NUMBERS}
        return Progress(**numbers, first=_evaluation(flat, "first"), branches=tuple(branches))


def stored_evaluations(points: Sequence[Evaluation]) -> dict[str, np.ndarray]:
    """Return evaluations as arrays that `evaluations_of` reads back: the state of a descent."""
    flat = {"descent": np.asarray(len(points))}
    for k, point in enumerate(points):
        flat |= _flat(f"{k}/evaluation", point)
    return flat


def evaluations_of(state: Mapping[str, np.ndarray] | None) -> list[Evaluation]:
    """Return the evaluations of a descent's state, none of any other."""
    state = state or {}
    return [_evaluation(state, f"{k}/evaluation") for k in range(int(state.get("descent", 0)))]


def _flat(prefix: str, point: Evaluation) -> dict[str, np.ndarray]:
    return {f"{prefix}/{name}": value for name, value in zip(Evaluation._fields, point, strict=True)}


def _evaluation(flat: Mapping[str, np.ndarray], prefix: str) -> Evaluation:
    return Evaluation(*(flat[f"{prefix}/{name}"] for name in Evaluation._fields))


def _plain(value: np.ndarray) -> Any:
    return value if value.ndim else value.item()
