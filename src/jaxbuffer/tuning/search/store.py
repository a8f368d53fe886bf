"""A tuning's files: a log that only grows and a state that is replaced whole, so that a kill loses one step at most.

``log.jsonl`` has a line for each evaluated design, for people and other programs. ``state.npz`` has all that the search
needs to go on, the log up to then included, and a checksum; ``state.old.npz`` is the same one step earlier. Either of
the two is enough to resume: lines of a step that was cut short are dropped from the log, a damaged log is restored.
`record_of` makes the log's lines, `Progress` the state's arrays.
"""

import contextlib
import dataclasses
import json
import os
import uuid
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np

from ...block_store import ArchiveStore, Arrays, BlockError, Head, Identity, short_hash
from ...errors import InputError
from ...fields import as_displayed
from ...files import Lock, naming, write, write_beside
from ...value_text import percent_text, with_unit
from .evaluation import Evaluation
from .goal import Goal
from .search import Branch

LOG, STATE, PREVIOUS = "log.jsonl", "state.npz", "state.old.npz"
LINES = "log"  # an array of a state beside those of the search
VERSION, STUDY = "version", "study"  # parts of a tuning's identity beside its settings by name
OPTIMIZER, CODE = "optimizer_steps", "own_code"  # parts that are hashes, which say nothing to people
STATUS = ("running", "converged", "stalled", "behind")
NUMBERS = ("stage", "captures", "scale", "ceiling", "searches", "apart")
Record = dict[str, Any]


@dataclasses.dataclass(frozen=True)
class StateStore(ArchiveStore):
    """The states of one tuning in a folder."""

    def _name(self, block: str) -> str:
        return ""  # a state becomes the previous one by its name alone

    def _refusal(self, identity: Identity, parts: list[str]) -> str:
        known = self.head.identity
        if VERSION in parts:
            writer = known.get(VERSION)
            return f"{self.folder} holds a run of jaxbuffer {writer}, which cannot be resumed by {identity[VERSION]}"
        words = {
            STUDY: "its study is another one (design, scenarios, [problem] or options)",
            OPTIMIZER: "its optimizer is another one",
            CODE: "the code of its mechanism, laws or solver has changed",
        }
        differ = [words.get(name, f"{name} is {known.get(name)} there, {identity.get(name)} here") for name in parts]
        remedy = "repeat the study and the options of the first run, or choose another --output"
        return f"{self.folder} holds the run of another problem or other settings: {', '.join(differ)}; {remedy}"


class TuningStore:
    """The files of one tuning, in a folder that is locked until the store's ``with`` block ends; without a ``folder``
    the log is kept in memory only.

    ``records``: the evaluations so far; ``state``: the arrays of the last `keep`, None before the first; ``report``:
    called with each record that is appended; ``beside``: arrays that every `keep` stores, too.
    """

    def __init__(self, folder: Path | None, identity: Identity, resume: bool) -> None:
        self.folder, self.records = folder, list[Record]()
        self.state: dict[str, np.ndarray] | None = None
        self.report: Callable[[Record], None] | None = None
        self.beside: dict[str, np.ndarray] = {}
        self.lines = b""
        if folder is None:
            if resume:
                raise InputError("resume needs the folder of the run to go on with")
            return
        if resume and not any((folder / name).exists() for name in (LOG, STATE, PREVIOUS)):
            raise InputError(f"{folder}: there is no run to resume; {LOG} is missing; leave out --resume to begin one")
        with contextlib.ExitStack() as locked:
            self.lock = locked.enter_context(Lock(folder))
            if resume:
                self._resume(folder, identity)
            else:
                self.states = StateStore(Head(identity, uuid.uuid4().hex), folder)
                # The previous state of an earlier run is none of this one's.
                (folder / PREVIOUS).unlink(missing_ok=True)
                write(folder / LOG, b"")
                # An empty state from the beginning, so that a run killed in its first step can be resumed too.
                self.keep({})
            locked.pop_all()  # until the end of the block

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.folder is not None:
            self.lock.release()

    def _resume(self, folder: Path, identity: Identity) -> None:
        self.states, state, self.lines = read_state(folder, identity)
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
            # The state stores the log's lines too, and compares them with the file when the run is resumed.
            self.lines += line
            with naming(self.folder / LOG), (self.folder / LOG).open("ab") as log:
                log.write(line)
                log.flush()
                # On disk before the step goes on, so that a power failure costs no line of it.
                os.fsync(log.fileno())
        if self.report is not None:
            self.report(self.records[-1])

    def keep(self, state: Arrays) -> None:
        """Replace the state by the one after a step; the one before stays as the previous one."""
        if self.folder is None:
            return
        # The empty state of a new run replaces that of an earlier one, which is nothing to go back to.
        if state and (self.folder / STATE).exists():
            # A rename keeps the last state whole while the new one is written.
            (self.folder / STATE).replace(self.folder / PREVIOUS)
        arrays = {name: np.asarray(value) for name, value in {**state, **self.beside}.items()}
        self.states.write(STATE, {LINES: np.frombuffer(self.lines, np.uint8), **arrays})


def read_state(folder: Path, identity: Identity) -> tuple[StateStore, dict[str, np.ndarray], bytes]:
    """Read the latest good state in a folder, empty if no step was finished, and the log's lines up to then.

    Nothing is changed. **Raises:** `InputError` where there is none, or where it is another run's.
    """
    damage = []
    for name in (STATE, PREVIOUS):
        try:
            states = StateStore.of(folder, name)
            state = states.read(name)
        except BlockError as error:
            damage.append(f"{name} {error}")
            continue
        # After the checksum: a damaged state must not be taken for another run's.
        states.check_identity(identity)
        lines = state.pop(LINES).tobytes()
        if damage:
            count = len(lines.splitlines())
            warnings.warn(f"{folder}: {damage[0]}; going on from {name}, {count} evaluations", stacklevel=2)
        return states, state, lines
    raise InputError(f"{folder}: the run cannot be resumed: {', '.join(damage)}; everything is left as it is")


def stored_identity(folder: Path) -> str | None:
    """Return the hash of what was begun in a folder, as a `Tuned` has it; None where there is no whole state."""
    for name in (STATE, PREVIOUS):
        with contextlib.suppress(BlockError):
            states = StateStore.of(folder, name)
            states.read(name)
            return short_hash(states.head.identity)
    return None


def record_of(
    goal: Goal,
    point: Evaluation,
    number: int,
    stage: int,
    search: int,
    branch: Branch | None,
    captures: int | None = None,
) -> Record:
    """Return the log's record of a design tried.

    **Arguments:** ``number`` of the evaluation; ``stage``; ``search``: number of the search; ``branch``: the search
    after it was tried, None for a start; ``captures`` spent before it, by default those of as many such evaluations.
    """
    problem = goal.problem
    captures = len(problem.cases) * number if captures is None else captures
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
        # The excess of a value that is not known is infinite, which JSON lacks.
        "excess": excess if np.isfinite(excess := float(np.sum(goal.excess(point)))) else None,
        "obstacle": goal.nearest_limit(point) if goal.feasible(point) else goal.obstacle(point),
        "radius": None if branch is None else branch.radius,
        "residual": None if branch is None or np.isnan(branch.residual) else branch.residual,
        "status": "start" if branch is None else STATUS[branch.status],
        "captures": captures + len(problem.cases),
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
    # Of a feasible design it is the limit that it has nearly reached.
    obstacle = ": ".join(filter(None, ("" if it["feasible"] else "limits broken", it.get("obstacle", ""))))
    text += f", {obstacle}" if obstacle else ""
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
