"""Histories of a run at any times, with derivatives: two compiled programs, whatever the length of a record."""

import functools
from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ..fields import Part, with_values
from ..hybrid import Status, Steps
from ..mechanisms.mechanism import Mechanism, Request
from ..mechanisms.run_arrays import series
from ..programs.cache import Static, stored
from ..run.instants import BLOCK, history_within
from ..run.request import options_of, request
from ..run.stepper import stepper_of
from .quantities import column_name

ROOM = 4096  # steps of a run to begin with; more double it


class Parameters(NamedTuple):
    """What a run is of: a ``mechanism``, its ``design`` and ``scenario``, the ``paths`` of the numbers to differentiate
    by, and the relative error ``rtol`` of a step [-]."""

    mechanism: Mechanism
    design: Part
    scenario: Part
    paths: tuple[str, ...]
    rtol: float


class SteppedRun(NamedTuple):
    """The accepted steps of a run: ``time`` [s]; ``closed`` contacts; ``rows`` (steps, 1 + paths, state): the state and
    its derivatives by the ``numbers``, relative to their size; ``status``: how it ended."""

    numbers: Float[np.ndarray, " paths"]
    time: Float[np.ndarray, " steps"]
    closed: Float[np.ndarray, "steps contacts"]
    rows: Float[np.ndarray, "steps rows state"]
    status: int

    @property
    def end_time(self) -> float:
        """Return when the run ended [s]."""
        return float(self.time[-1])

    @property
    def failed(self) -> bool:
        """Return whether the run could not be solved."""
        return self.status > Status.TIMEOUT


class Signals(NamedTuple):
    """Histories at some instants, in SI units: ``values`` (columns, instants), ``slopes`` by the paths (columns,
    instants, paths) and ``rates`` by time."""

    values: Float[np.ndarray, "columns instants"]
    slopes: Float[np.ndarray, "columns instants paths"]
    rates: Float[np.ndarray, "columns instants"]


def stepped_run(of: Parameters, numbers: np.ndarray, end: float) -> SteppedRun:
    """Step the run with ``numbers`` at the paths for ``end`` seconds, with their derivatives."""
    room = ROOM
    while True:
        parts = jax.tree.map(lambda x: np.asarray(x, float), (of.design, of.scenario))
        given = np.asarray(numbers, float), np.asarray(end, float), np.asarray(of.rtol, float)
        steps, status = _steps(of.mechanism, parts, *given, Static((of.paths, room)))
        count = int(steps.count)
        if count <= room:
            time, closed, rows = (np.asarray(it)[:count] for it in (steps.time, steps.active, steps.rows))
            return SteppedRun(np.asarray(numbers, float), time, closed, rows, int(status))
        room *= 4


def signals(of: Parameters, run: SteppedRun, names: Sequence[str], times: np.ndarray) -> Signals:
    """Return the histories of these names at some times; beyond its ends a run is taken to stand still."""
    known, inside = run.time, (times >= run.time[0]) & (times <= run.time[-1])
    times = np.clip(times, known[0], known[-1])
    first = np.clip(np.searchsorted(known, times, side="right") - 1, 0, len(known) - 1)
    after = np.minimum(first + 1, len(known) - 1)
    parts = jax.tree.map(lambda x: np.asarray(x, float), (of.design, of.scenario))
    chosen, blocks = Static((of.paths, tuple(names))), []
    # Blocks of one size, the last row repeated, so that one program serves records of any length.
    for rows in np.minimum(np.arange(-(-len(times) // BLOCK) * BLOCK), len(times) - 1).reshape(-1, BLOCK):
        f, a = first[rows], after[rows]
        given = (known[f], known[a], times[rows], run.closed[f], run.rows[f], run.rows[a])
        blocks.append(_block(of.mechanism, parts, run.numbers, given, chosen))
    values, slopes, rates = (
        np.concatenate([np.asarray(it) for it in each], axis=1)[:, : len(times)] for each in zip(*blocks, strict=True)
    )
    return Signals(values, slopes, rates * inside)


def _moved(
    mechanism: Mechanism, parts: Any, numbers: Any, paths: Sequence[str], end: Any, rtol: Any, room: int
) -> Request:
    design, scenario = parts
    design, scenario = with_values(design, scenario, {path: numbers[k] for k, path in enumerate(paths)})
    return request(mechanism, design, scenario, end, tolerances=(rtol, rtol), options=options_of(keep=room))


@functools.partial(stored, what="runs of a fit")
def _steps(
    mechanism: Mechanism, parts: Any, numbers: Array, end: Array, rtol: Array, chosen: Static
) -> tuple[Steps, Array]:
    paths, room = chosen.value

    def make(values: list[Array], others: Any) -> Request:
        parts, end, rtol = others
        return _moved(mechanism, parts, values, paths, end, rtol, room)

    separate = [numbers[k] for k in range(len(paths))]
    result = stepper_of(mechanism).step_with_tangents(make, separate, (parts, end, rtol))
    return result.steps, result.status


@functools.partial(stored, what="signals of a fit")
def _block(mechanism: Mechanism, parts: Any, numbers: Array, given: Any, chosen: Static) -> tuple[Array, Array, Array]:
    """Return values, slopes and rates of a block of instants."""
    paths, names = chosen.value
    start, end, times, closed, before, after = given

    def at(numbers: Array, times: Array, before: Array, after: Array) -> Array:
        # Neither the duration nor the tolerance matters between steps that are there.
        system = _moved(mechanism, parts, numbers, paths, 1.0, 1e-6, 0).system
        history = history_within(system, start, end, times, closed, before, after)
        known = {column_name(it.name): it.values for it in series(history, mechanism.names(parts[0]))}
        return jnp.stack([known[name] for name in names])

    states = before[:, 0], after[:, 0]
    # The run's derivatives are relative to the size of each number, and zero has none.
    sizes = jnp.where(numbers == 0.0, 1.0, jnp.abs(numbers))

    def along(move: Array, time: Array, first: Array, last: Array) -> tuple[Array, Array]:
        return jax.jvp(at, (numbers, times, *states), (move, time * jnp.ones_like(times), first, last))

    # A direction for each number, and time as the last one.
    no_state = jnp.zeros_like(states[0])[None]
    directions = (
        jnp.concatenate([jnp.diag(sizes), jnp.zeros((1, len(paths)))]),
        jnp.concatenate([jnp.zeros(len(paths)), jnp.ones(1)]),
        *(jnp.concatenate([jnp.moveaxis(it[:, 1:], 1, 0), no_state]) for it in (before, after)),
    )
    values, moves = jax.vmap(along, out_axes=(None, -1))(*directions)
    return values, moves[..., :-1] / sizes[None, None], moves[..., -1]
