"""`sweep`: many runs, on all cores, in memory that does not grow with what a run remembers.

Runs are solved in small chunks, one after the other within a chunk so that none waits for the slowest, and chunks are
handed to one thread a core: a compiled chunk runs outside Python.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, overload

import jax
import numpy as np
from jaxtyping import Array, Bool

from .._types import Scalar
from ..compiling.pool import Pool, cores
from ..compiling.programs import after
from ..errors import InputError, as_number, check_number, check_single, check_whole
from ..fields import POSITIVE, Part
from ..hybrid import Result, Solver, solver_named
from ..mechanisms.registry import mechanism_of
from ..progress import counted
from ..run.read_off import run_of
from ..run.request import DEFAULT_TOLERANCE, TOLERANCES, Request, check_pair, request, stepped
from .found import Sweep as Sweep
from .found import SweepInterrupted as SweepInterrupted
from .found import column_names as column_names
from .found import whole_numbers as whole_numbers
from .grid import Batch, grid
from .store import SweepStore, identity
from .swept import Swept

CHUNK = 16
ONE_FOR_ALL = "all runs of a sweep share it"


class Settings(NamedTuple):
    """What all runs of a sweep share: ``rtol`` [-], Baumgarte's gain ``stabilisation`` [1/s], ``solver``."""

    rtol: np.ndarray
    stabilisation: np.ndarray
    solver: Solver | None


class Storing(NamedTuple):
    """How a sweep is stored and watched; fields as in `sweep`."""

    workers: int | None
    progress: Callable[[int, int], None] | None
    folder: str | Path | None
    resume: bool


@overload
def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    over: None = None,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    workers: int | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
) -> Sweep: ...


@overload
def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    over: Mapping[str, Any],
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    workers: int | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
) -> Swept: ...


def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    over: Mapping[str, Any] | None = None,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    workers: int | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
) -> Sweep | Swept:
    """Simulate many runs of a mechanism.

    **Arguments:**

    - ``design``, ``scenarios``: any of their numbers may be an array of shape (n,), one entry a run.
    - ``duration``: as for `simulate`, or an array of shape (n,) [s].
    - ``over``: values of several fields, all combinations of which are run: by dotted path, "scenario.…" for the
      scenario's, a list of numbers in the field's unit, {"from", "to", "count", "scale"}, or a list of choices.
      ``design`` and ``scenarios`` then have single numbers.
    - ``solver``, ``rtol`` [-], ``stabilisation`` [1/s]: as for `simulate`, for all runs.
    - ``workers``: threads, by default one a core (one on an accelerator, which gets large chunks).
    - ``progress``: called with runs done and asked for, or True for a bar.
    - ``folder``: where runs are stored as they are finished (`SweepStore`), over an earlier sweep's.
    - ``resume``: go on with the sweep in ``folder`` instead.

    **Returns:** a `Sweep`, or with ``over`` a `Swept`, the same bits whether it was interrupted and resumed or not. A
    run that fails says so in its ``code``; the others are not touched by it. Each combination of choices is a program
    of its own, compiled once.

    **Raises:** `InputError` for values out of range, arrays of unequal lengths, a folder in use, and on resuming
    another sweep; `SweepInterrupted`, a `KeyboardInterrupt` that has what was done, on Ctrl-C.

    **Example:**

    >>> found = jb.sweep(jb.table2(), jb.Scenario(approach_speed=[0.1, 0.2]))
    >>> [f"{force:.2f} N" for force in found.peak_force]
    ['253.13 N', '325.18 N']
    >>> bar = jb.replace(jb.BarDrop(), {"impact.exponent": 1.5})
    >>> over = {"scenario.height": [0.1, 0.194], "impact.law": ["adams", "hertz"]}
    >>> forces = jb.sweep(bar, jb.BarDropScenario(), 0.22, over=over).to_xarray().peak_force
    >>> f"{float(forces.sel({'scenario.height': 0.1, 'impact.law': 'hertz'})):.1f} {forces.units}"
    '3894.2 N'
    """
    mechanism = mechanism_of(design)
    check_pair(mechanism, design, scenarios)
    duration = mechanism.defaults.duration if duration is None else duration
    check_number("duration", duration, "s", **POSITIVE)
    check_single("rtol", rtol, "-", ONE_FOR_ALL, **TOLERANCES)
    check_single("stabilisation", stabilisation, "1/s", ONE_FOR_ALL, low=0.0)
    solver = None if solver is None else solver_named(solver)
    if workers is not None:
        check_whole("workers", workers, 1)
    settings = Settings(np.asarray(rtol, float), np.asarray(stabilisation, float), solver)
    storing = Storing(workers, counted(progress, mechanism.run_name), folder, resume)
    if over is None:
        return _run([Batch(None, design, scenarios)], duration, settings, storing)
    check_single("duration", duration, "s", ONE_FOR_ALL)
    asked = grid(over, design, scenarios)
    try:
        found = _run(asked.batches(design, scenarios), duration, settings, storing)
    except SweepInterrupted as stop:
        assert isinstance(stop.found, Sweep)
        raise SweepInterrupted(Swept(asked, design, scenarios, stop.found, stop.done), stop.done) from None
    return Swept(asked, design, scenarios, found, np.ones(len(asked), bool))


class _Part(NamedTuple):
    """A batch in the making: its numbers as arrays of shape (n,) or (), the places of its runs in the results, how many
    of them a call solves, and how many its program has room for."""

    structure: Any
    arrays: list[np.ndarray]
    places: np.ndarray
    chunk: int
    room: int

    def call(self, first: int) -> tuple[Any, np.ndarray]:
        """The runs from ``first`` on as arrays (room,), and which of them are wanted: filled up, a call with few runs
        needs no program of its own."""
        room = np.arange(self.room)
        wanted = room < min(self.chunk, self.places.size - first)
        batch = [np.broadcast_to(x, self.places.shape).take(first + room, mode="clip") for x in self.arrays]
        return jax.tree.unflatten(self.structure, batch), wanted


def _run(batches: Sequence[Batch], duration: Any, settings: Settings, storing: Storing) -> Sweep:
    """All runs of all batches."""
    on_cpu = jax.default_backend() == "cpu"
    most, workers = (CHUNK, cores()) if on_cpu else (4096, 1)
    workers = workers if storing.workers is None else storing.workers
    parts = [_part(batch, duration, most, workers, on_cpu) for batch in batches]
    count, alone = sum(part.places.size for part in parts), batches[0] if len(batches) == 1 else None
    result = Sweep.empty(mechanism_of(batches[0].design), count, *(alone[1:] if alone else (None, None)))
    finished = np.zeros(count, bool)
    columns = list(result.columns.values())
    store, progress = _store(batches, duration, settings, storing, result, finished), storing.progress

    def solve(item: tuple[_Part, int]) -> None:
        part, first = item
        found = _chunk(*part.call(first), *settings)
        its_own = part.places[first : first + part.chunk]
        for mine, values in zip(columns, found, strict=True):
            mine[its_own] = np.asarray(values)[: its_own.size]
        finished[its_own] = True

    todo = [
        (part, first)
        for part in parts
        for first in range(0, part.places.size, part.chunk)
        if not finished[part.places[first : first + part.chunk]].all()
    ]
    try:
        if progress is not None and finished.any():
            progress(int(finished.sum()), count)
        for _ in Pool(workers).as_completed(solve, todo):
            if store is not None:
                store.save()
            if progress is not None:
                progress(int(finished.sum()), count)
    except KeyboardInterrupt:
        done = finished.copy()  # calls under way go on for a moment
        found = {name: column.copy() for name, column in result.columns.items()}
        raise SweepInterrupted(dataclasses.replace(result, columns=found), done) from None
    finally:
        if store is not None:
            store.close()
    return result


def _part(batch: Batch, duration: Any, most: int, workers: int, filled: bool) -> _Part:
    """``most``: runs of a call; ``filled``: whether each call has room for so many. On an accelerator, whose calls are
    large, runs that are not wanted would take memory."""
    leaves, structure = jax.tree.flatten((batch.design, batch.scenarios, as_number(duration)))
    arrays = [np.asarray(leaf, float) for leaf in leaves]
    count = _common_length(structure, arrays)
    places = np.arange(count) if batch.places is None else batch.places
    chunk = min(most, -(-count // workers))
    return _Part(structure, arrays, places, chunk, most if filled else chunk)


def _store(
    batches: Sequence[Batch],
    duration: Any,
    settings: Settings,
    storing: Storing,
    result: Sweep,
    finished: np.ndarray,
) -> SweepStore | None:
    """Where runs are stored as they are finished, if anywhere; what an earlier sweep finished is filled in."""
    if storing.folder is None:
        if storing.resume:
            raise InputError("resume needs the folder of the sweep to go on with")
        return None
    alone = len(batches) == 1
    asked = identity(
        design=batches[0].design if alone else [(batch.places, batch.design) for batch in batches],
        scenarios=batches[0].scenarios if alone else [batch.scenarios for batch in batches],
        options=(duration, *settings),
        quantities=tuple(result.columns),
    )
    return SweepStore(Path(storing.folder), asked, list(result.columns.values()), finished, storing.resume)


Chunk = tuple[Any, Any, Any]  # design, scenario and duration [s], each number an array with an entry for each run
Wanted = Bool[Array, " runs"]  # which of them are wanted: the others fill up the chunk


def _request(chunk: Chunk, rtol: Any, stabilisation: Any, solver: Solver | None) -> Request:
    return request(*chunk, solver, (rtol, rtol), stabilisation)


def _stepped(chunk: Chunk, wanted: Wanted, rtol: Any, stabilisation: Any, solver: Solver | None) -> Result:
    """What time stepping finds of each run."""

    def one(chunk: Chunk, wanted: Array) -> Result:
        return stepped(*_request(chunk, rtol, stabilisation, solver), wanted=wanted)

    return jax.vmap(one)(chunk, wanted)


@after(_stepped)
def _chunk(chunk: Chunk, wanted: Wanted, rtol: Any, stabilisation: Any, solver: Solver | None, result: Result) -> tuple:
    catalogue, swept = mechanism_of(chunk[0]).quantities, mechanism_of(chunk[0]).swept

    def numbers(chunk: Chunk, result: Result) -> tuple:
        parameters, duration, _, options = _request(chunk, rtol, stabilisation, solver)
        run = run_of(parameters, duration, options, result)
        own = (catalogue[name].of(run) for name in swept)
        return (run.code, *own, run.peak_contact, run.impact_count, run.attempts)

    return jax.vmap(numbers)(chunk, result)


def _common_length(structure: Any, arrays: list[np.ndarray]) -> int:
    lengths = {array.shape for array in arrays if array.ndim}
    if not lengths:
        return 1
    if len(lengths) > 1 or len(shape := lengths.pop()) != 1 or shape[0] == 0:
        raise InputError("the arrays of a sweep must all have one shape (n,), n at least 1; found " + _shapes(arrays))
    return int(shape[0])


def _shapes(arrays: list[np.ndarray]) -> str:
    return ", ".join(sorted({str(array.shape) for array in arrays if array.ndim}))
