"""Runs solved in one call of a compiled program: what every way of sweeping is made of.

Runs are solved in small chunks, one after the other within a chunk so that none waits for the slowest.
"""

import functools
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Bool

from ..hybrid import Solver, name_of, solver_named
from ..mechanisms.mechanism import Mechanism, Request
from ..mechanisms.registry import mechanism_of
from ..programs.cache import Static, after
from ..run.request import request, tenth
from ..run.stepper import run_of, stepped, stepper_of
from ..run.trust import SAFETY, VERDICTS, relative_changes, verdicts
from .columns import NO_VERDICT, column_names

CHUNK = 16
TASK = 512  # runs of a call at most on few threads: about a second
PER_THREAD = 8  # calls a thread at least there, so that none waits long for the last
BUSY = 2  # runs of a call for each thread at least, so that one scheduler can hand out so many (docs/clusters.md)


class SweepSettings(NamedTuple):
    """What all runs of a sweep share: ``rtol`` [-], Baumgarte's gain ``stabilisation`` [1/s], ``solver``; ``trust``:
    whether each is run again at a tenth of the tolerance."""

    rtol: np.ndarray
    stabilisation: np.ndarray
    solver: Solver
    trust: bool = False

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the solver by its name: one of diffrax's would not equal itself, and its programs be compiled anew."""
        return _settings, (float(self.rtol), float(self.stabilisation), name_of(self.solver), self.trust)


# The same object is returned for equal settings: a process that unpickles many tasks has one solver, and one program.
@functools.lru_cache(maxsize=8)
def _settings(rtol: float, stabilisation: float, solver: str, trust: bool) -> SweepSettings:
    return SweepSettings(np.asarray(rtol), np.asarray(stabilisation), solver_named(solver), trust)


Chunk = tuple[Any, Any, Any]  # design, scenario and duration [s], each number an array with an entry for each run
Enabled = Bool[Array, " runs"]  # which of them are stepped: the others fill up the chunk


def _request(mechanism: Mechanism, chunk: Chunk, rtol: Any, stabilisation: Any, solver: Solver) -> Request:
    return request(mechanism, *chunk, solver, (rtol, rtol), stabilisation)


def _stepped(
    mechanism: Mechanism,
    chunk: Chunk,
    enabled: Enabled,
    rtol: Any,
    stabilisation: Any,
    solver: Solver,
    names: Static,
) -> Any:
    """Step each run in time and return its raw result."""

    def one(chunk: Chunk, enabled: Array) -> Any:
        return stepped(_request(mechanism, chunk, rtol, stabilisation, solver), enabled=enabled)

    return stepper_of(mechanism).many(one)(chunk, enabled)


@after(_stepped, what="the runs of a sweep")
def solve_chunk(
    mechanism: Mechanism,
    chunk: Chunk,
    enabled: Enabled,
    rtol: Any,
    stabilisation: Any,
    solver: Solver,
    names: Static,
    result: Any,
) -> tuple:
    """Return code, the quantities of these names, number of the contact with the largest force, impacts and attempts,
    each an array with an entry for each run of the chunk."""

    def numbers(chunk: Chunk, result: Any) -> tuple:
        run = run_of(_request(mechanism, chunk, rtol, stabilisation, solver), result)
        own = (mechanism.quantities[name].of(run) for name in names.value)
        return (run.code, *own, run.peak_contact, run.impact_count, run.attempts)

    return jax.vmap(numbers)(chunk, result)


def columns_of_chunk(chunk: Chunk, enabled: Any, settings: SweepSettings) -> list[np.ndarray]:
    """Return the columns of a sweep (`column_names`), each with an entry for each run of the chunk.

    ``enabled`` (runs,): which runs are stepped; the others fill up the chunk.
    """
    mechanism = mechanism_of(chunk[0])

    def at(rtol: Any) -> dict[str, np.ndarray]:
        options = settings.stabilisation, settings.solver, Static(tuple(mechanism.swept))
        values = map(np.asarray, solve_chunk(mechanism, chunk, enabled, rtol, *options))
        return dict(zip(column_names(mechanism), values, strict=False))

    columns = at(settings.rtol)
    if not settings.trust:
        return [*columns.values(), np.full(len(enabled), NO_VERDICT)]
    # Close to the least tolerance that is allowed there is no tenth to compare with: the verdict is then "unknown".
    closer = tenth(float(settings.rtol))
    return [*columns.values(), _verdicts(mechanism, columns, None if closer is None else at(np.asarray(closer)))]


def _verdicts(mechanism: Mechanism, here: dict[str, np.ndarray], there: dict[str, np.ndarray] | None) -> np.ndarray:
    """Return the column ``trust`` from the columns ``here`` and from those at a tenth of the tolerance, None if not
    known."""
    failed, unknown = mechanism.outcomes["failed_steps"], VERDICTS.index("unknown")
    solved = here["code"] < failed
    if there is None:
        return np.where(solved, unknown, NO_VERDICT)
    changes = relative_changes(mechanism, here, there)
    error = SAFETY * np.max([*changes.values(), np.zeros(len(solved))], axis=0)
    # These are whole numbers: no relative change says how far they are off, only whether they are the same.
    others = (f"peak_{mechanism.view.contact}", "impact_count")
    differs = np.any([here[name] != there[name] for name in others], axis=0)
    index = verdicts(error, here["code"] != there["code"], differs)
    # A run that fails at the closer tolerance alone has nothing to be compared with.
    return np.where(solved, np.where(there["code"] < failed, index, unknown), NO_VERDICT)


def task_size(runs: int, threads: int) -> int:
    """Return how many runs a call in another process, or a block of the store, has at most."""
    return max(CHUNK, min(TASK, runs // (PER_THREAD * threads)), min(BUSY * threads, runs // threads))
