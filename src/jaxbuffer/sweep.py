"""`sweep`: many captures, on all cores, in memory that does not grow with what a capture remembers.

Captures are solved in small chunks, one after the other within a chunk so that none waits for the slowest, and chunks
are handed to one thread a core: a compiled chunk runs outside Python.
"""

import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any, NamedTuple

import jax
import numpy as np

from ._types import Scalar
from .capture import DEFAULT_DURATION, DEFAULT_TOLERANCE, TOLERANCES, simulate
from .errors import InputError, as_number, check_number, check_single, check_whole
from .integrate import Solver, solver_named
from .mechanisms import Design, Scenario, check_fit
from .mechanisms.design import POSITIVE
from .outcome import Outcome
from .programs import kept
from .sweep_store import SweepStore, identity

CHUNK = 16
ONE_FOR_ALL = "all captures of a sweep share it"
QUANTITIES = (
    "code",
    "peak_force",
    "peak_time",
    "peak_flank",
    "peak_hinge_force",
    "peak_buffer_force",
    "peak_stop_force",
    "stroke",
    "stroke_margin",
    "hinge_angle",
    "penetration",
    "end_time",
    "contact_time",
    "impact_count",
    "attempts",
)
INTEGERS = frozenset({"code", "peak_flank", "impact_count", "attempts"})


class Sweep(NamedTuple):
    """What a sweep found: an array of n entries a quantity, in the order asked; numbers of failed captures are NaN.

    Names and units are those of `Capture`; ``code`` is the `Outcome`.
    """

    code: np.ndarray
    peak_force: np.ndarray
    peak_time: np.ndarray
    peak_flank: np.ndarray
    peak_hinge_force: np.ndarray
    peak_buffer_force: np.ndarray
    peak_stop_force: np.ndarray
    stroke: np.ndarray
    stroke_margin: np.ndarray
    hinge_angle: np.ndarray
    penetration: np.ndarray
    end_time: np.ndarray
    contact_time: np.ndarray
    impact_count: np.ndarray
    attempts: np.ndarray

    def __len__(self) -> int:
        return len(self.code)

    @property
    def outcomes(self) -> list[Outcome]:
        """The outcome of each capture."""
        return [Outcome(int(code)) for code in self.code]

    def __repr__(self) -> str:
        from .report import sweep_summary

        return sweep_summary(self)


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C during a sweep. ``found`` has what was done until then, ``done`` (n,) says which captures those are."""

    def __init__(self, found: Sweep, done: np.ndarray) -> None:
        super().__init__(f"{int(done.sum())} of {done.size} captures done")
        self.found, self.done = found, done


def sweep(
    design: Design,
    scenarios: Scenario,
    duration: Scalar = DEFAULT_DURATION,
    *,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
) -> Sweep:
    """Simulate many captures.

    **Arguments:** ``design``, ``scenarios``: any of their numbers may be an array of shape (n,), one entry a capture;
    ``duration`` [s], ``solver``, ``rtol``, ``stabilisation`` as for `simulate`; ``workers``: threads, by default one a
    core (one on an accelerator, which gets large chunks); ``progress``: called with captures done and asked for;
    ``folder``: where captures are stored as they are finished (`sweep_store`), over an earlier sweep's unless
    ``resume`` goes on with it.

    **Returns:** a `Sweep`, the same bits whether it was interrupted and resumed or not. A capture that fails says so in
    its ``code``; the others are not touched by it.

    **Raises:** `InputError` for values out of range, arrays of unequal lengths, a folder in use, and on resuming
    another sweep; `SweepInterrupted`, a `KeyboardInterrupt` that has what was done, on Ctrl-C.
    """
    check_fit(design, scenarios)
    check_number("duration", duration, "s", **POSITIVE)
    check_single("rtol", rtol, "-", ONE_FOR_ALL, **TOLERANCES)
    check_single("stabilisation", stabilisation, "1/s", ONE_FOR_ALL, low=0.0)
    solver = None if solver is None else solver_named(solver)
    if workers is not None:
        check_whole("workers", workers, 1)
    leaves, structure = jax.tree.flatten((design, scenarios, as_number(duration)))
    arrays = [np.asarray(leaf, float) for leaf in leaves]
    count = _common_length(structure, arrays)
    on_cpu = jax.default_backend() == "cpu"
    chunk = min(CHUNK if on_cpu else 4096, count)
    workers = (len(os.sched_getaffinity(0)) if on_cpu else 1) if workers is None else workers
    result = Sweep(*(np.full(count, *((-1, int) if name in INTEGERS else (np.nan, float))) for name in QUANTITIES))
    finished = np.zeros(count, bool)
    options = (np.asarray(rtol, float), np.asarray(stabilisation, float), solver)
    store = None
    if folder is not None:
        asked = identity(design=design, scenarios=scenarios, options=(duration, *options), quantities=QUANTITIES)
        store = SweepStore(Path(folder), asked, result, finished, resume)
    elif resume:
        raise InputError("resume needs the folder of the sweep to go on with")

    def solve(first: int) -> None:
        index = np.minimum(np.arange(first, first + chunk), count - 1)  # the last chunk is filled up with its last
        batch = [np.broadcast_to(array, (count,))[index] for array in arrays]
        found = _chunk(jax.tree.unflatten(structure, batch), *options)
        its_own = slice(first, min(first + chunk, count))
        for mine, values in zip(result, found, strict=True):
            mine[its_own] = np.asarray(values)[: its_own.stop - first]
        finished[its_own] = True

    todo = [first for first in range(0, count, chunk) if not finished[first : first + chunk].all()]
    try:
        if progress is not None and finished.any():
            progress(int(finished.sum()), count)
        for _ in _in_threads(solve, todo, workers):
            if store is not None:
                store.save()
            if progress is not None:
                progress(int(finished.sum()), count)
    except KeyboardInterrupt:
        done = finished.copy()  # calls under way go on for a moment
        raise SweepInterrupted(Sweep(*(mine.copy() for mine in result)), done) from None
    finally:
        if store is not None:
            store.close()
    return result


@kept
def _chunk(batch: tuple[Design, Scenario, Any], rtol: Any, stabilisation: Any, solver: Solver | None) -> tuple:
    def one(design: Design, scenario: Scenario, duration: Any) -> tuple:
        capture = simulate(design, scenario, duration, solver=solver, rtol=rtol, stabilisation=stabilisation)
        return tuple(getattr(capture, name) for name in QUANTITIES)

    return jax.vmap(one)(*batch)


def _common_length(structure: Any, arrays: list[np.ndarray]) -> int:
    lengths = {array.shape for array in arrays if array.ndim}
    if not lengths:
        return 1
    if len(lengths) > 1 or len(shape := lengths.pop()) != 1 or shape[0] == 0:
        raise InputError("the arrays of a sweep must all have one shape (n,), n at least 1; found " + _shapes(arrays))
    return int(shape[0])


def _shapes(arrays: list[np.ndarray]) -> str:
    return ", ".join(sorted({str(array.shape) for array in arrays if array.ndim}))


def _in_threads(function: Callable[[int], None], items: Iterable[int], workers: int) -> Iterator[None]:
    """Whenever some are done, with few calls waiting; an interrupt leaves at once the calls under way to themselves."""
    todo, running = iter(items), set[Future[None]]()
    pool = ThreadPoolExecutor(workers)
    try:
        while True:
            running |= {pool.submit(function, item) for item in itertools.islice(todo, 2 * workers - len(running))}
            if not running:
                return
            finished, running = wait(running, return_when=FIRST_COMPLETED)
            for future in finished:
                future.result()
            yield
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
