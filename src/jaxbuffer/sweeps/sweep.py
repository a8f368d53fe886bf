"""`sweep`: many runs, on all cores, in memory that does not grow with what a run remembers.

Runs are solved in small chunks, one after the other within a chunk so that none waits for the slowest, and chunks are
handed to one thread a core: a compiled chunk runs outside Python.
"""

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import numpy as np

from .._types import Scalar
from ..compiling.pool import Pool, cores
from ..compiling.programs import stored
from ..errors import InputError, as_number, check_number, check_single, check_whole
from ..fields import POSITIVE, Part
from ..hybrid import Solver, solver_named
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.outcome import RunOutcome
from ..mechanisms.registry import mechanism_of
from ..run.simulate import DEFAULT_TOLERANCE, TOLERANCES, check_pair, simulate
from .store import SweepStore, identity

CHUNK = 16
ONE_FOR_ALL = "all runs of a sweep share it"


@dataclasses.dataclass(frozen=True)
class Sweep:
    """What a sweep found: an array of n entries a quantity, in the order asked; numbers of failed runs are NaN.

    - ``mechanism``: of which these are runs.
    - ``columns``: by name, each of shape (n,) and an attribute too: ``code`` of the outcome, the mechanism's quantities
      that sweeps have (units in its catalogue), the contact with the largest force (``peak_flank`` where contacts are
      flanks), ``impact_count`` and ``attempts``.

    **Example:**

    >>> found = jb.sweep(jb.table2(), jb.Scenario(approach_speed=[0.1, 0.2]))
    >>> [outcome.name for outcome in found.outcomes], bool(found.solved.all())
    (['captured', 'captured'], True)
    >>> [f"{1e3 * stroke:.2f} mm" for stroke in found.stroke]
    ['7.50 mm', '15.18 mm']
    """

    mechanism: Mechanism
    columns: dict[str, np.ndarray]

    def __getattr__(self, name: str) -> np.ndarray:
        columns = object.__getattribute__(self, "columns")
        if name in columns:
            return columns[name]
        raise AttributeError(f"Sweep has no {name!r}")

    def __len__(self) -> int:
        return len(self.columns["code"])

    @property
    def outcomes(self) -> list[RunOutcome]:
        """The outcome of each run."""
        return [self.mechanism.outcomes(int(code)) for code in self.columns["code"]]

    @property
    def solved(self) -> np.ndarray:
        """Which runs have numbers, shape (n,)."""
        return (self.columns["code"] >= 0) & (self.columns["code"] < self.mechanism.outcomes["failed_steps"])

    @staticmethod
    def empty(mechanism: Mechanism, count: int) -> "Sweep":
        """Room for a number of runs, none of them done."""
        whole = whole_numbers(mechanism)
        columns = {
            name: np.full(count, *((-1, int) if name in whole else (np.nan, float)))  # type: ignore[arg-type]
            for name in column_names(mechanism)
        }
        return Sweep(mechanism, columns)

    def __repr__(self) -> str:
        from .summary import sweep_summary

        return sweep_summary(self)


def column_names(mechanism: Mechanism) -> tuple[str, ...]:
    """What a sweep of the mechanism finds, in order."""
    return ("code", *mechanism.swept, *whole_numbers(mechanism)[1:])


def whole_numbers(mechanism: Mechanism) -> tuple[str, ...]:
    """Those of `column_names` that are whole numbers."""
    return ("code", f"peak_{mechanism.contact}", "impact_count", "attempts")


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C during a sweep. ``found`` has what was done until then, ``done`` (n,) says which runs those are."""

    def __init__(self, found: Sweep, done: np.ndarray) -> None:
        super().__init__(f"{int(done.sum())} of {done.size} {found.mechanism.run_name}s done")
        self.found, self.done = found, done


def sweep(
    design: Part,
    scenarios: Part,
    duration: Scalar | None = None,
    *,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    stabilisation: float = 20.0,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
) -> Sweep:
    """Simulate many runs of a mechanism.

    **Arguments:**

    - ``design``, ``scenarios``: any of their numbers may be an array of shape (n,), one entry a run.
    - ``duration``: as for `simulate`, or an array of shape (n,) [s].
    - ``solver``, ``rtol`` [-], ``stabilisation`` [1/s]: as for `simulate`, for all runs.
    - ``workers``: threads, by default one a core (one on an accelerator, which gets large chunks).
    - ``progress``: called with runs done and asked for.
    - ``folder``: where runs are stored as they are finished (`SweepStore`), over an earlier sweep's.
    - ``resume``: go on with the sweep in ``folder`` instead.

    **Returns:** a `Sweep`, the same bits whether it was interrupted and resumed or not. A run that fails says so in
    its ``code``; the others are not touched by it.

    **Raises:** `InputError` for values out of range, arrays of unequal lengths, a folder in use, and on resuming
    another sweep; `SweepInterrupted`, a `KeyboardInterrupt` that has what was done, on Ctrl-C.

    **Example:**

    >>> found = jb.sweep(jb.table2(), jb.Scenario(approach_speed=[0.1, 0.2]))
    >>> [f"{force:.2f} N" for force in found.peak_force]
    ['253.13 N', '325.18 N']
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
    leaves, structure = jax.tree.flatten((design, scenarios, as_number(duration)))
    arrays = [np.asarray(leaf, float) for leaf in leaves]
    count = _common_length(structure, arrays)
    on_cpu = jax.default_backend() == "cpu"
    chunk = min(CHUNK if on_cpu else 4096, count)
    workers = (cores() if on_cpu else 1) if workers is None else workers
    result = Sweep.empty(mechanism, count)
    finished = np.zeros(count, bool)
    options = (np.asarray(rtol, float), np.asarray(stabilisation, float), solver)
    store = None
    if folder is not None:
        asked = identity(
            design=design, scenarios=scenarios, options=(duration, *options), quantities=tuple(result.columns)
        )
        store = SweepStore(Path(folder), asked, list(result.columns.values()), finished, resume)
    elif resume:
        raise InputError("resume needs the folder of the sweep to go on with")

    def solve(first: int) -> None:
        index = np.minimum(np.arange(first, first + chunk), count - 1)  # the last chunk is filled up with its last
        batch = [np.broadcast_to(array, (count,))[index] for array in arrays]
        found = _chunk(jax.tree.unflatten(structure, batch), *options)
        its_own = slice(first, min(first + chunk, count))
        for mine, values in zip(result.columns.values(), found, strict=True):
            mine[its_own] = np.asarray(values)[: its_own.stop - first]
        finished[its_own] = True

    todo = [first for first in range(0, count, chunk) if not finished[first : first + chunk].all()]
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
        raise SweepInterrupted(Sweep(mechanism, found), done) from None
    finally:
        if store is not None:
            store.close()
    return result


@stored
def _chunk(batch: tuple[Any, Any, Any], rtol: Any, stabilisation: Any, solver: Solver | None) -> tuple:
    catalogue, swept = mechanism_of(batch[0]).quantities, mechanism_of(batch[0]).swept

    def one(design: Part, scenario: Part, duration: Any) -> tuple:
        run = simulate(design, scenario, duration, solver=solver, rtol=rtol, stabilisation=stabilisation)
        numbers = (catalogue[name].of(run) for name in swept)
        return (run.code, *numbers, run.peak_contact, run.impact_count, run.attempts)

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
