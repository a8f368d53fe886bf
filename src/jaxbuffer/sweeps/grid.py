"""Grids to sweep: every combination of the values of some fields of design and scenario, choices included."""

import dataclasses
import itertools
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import jax
import numpy as np

from ..errors import InputError
from ..fields import Part, with_values
from ..mechanisms.registry import mechanism_of
from ..run.request import check_pair
from .axis import Axis, axis_of

BYTES = 2000  # for each run: inputs, results, its row of text while files are written


class Batch(NamedTuple):
    """Runs of one program: their ``places`` (n,) in the results, and ``design``, ``scenarios`` and ``duration`` [s]
    (None where it is not known yet), with arrays (n,) for the numbers that differ."""

    places: np.ndarray
    design: Part
    scenarios: Part
    duration: Any = None

    def parts(self, size: int) -> Iterator["Batch"]:
        """Yield the runs as batches of at most ``size``, each made as it is asked for."""
        for first in range(0, self.places.size, size):
            some = slice(first, first + size)
            inputs = jax.tree.map(lambda leaf, some=some: leaf[some] if np.ndim(leaf) else leaf, self[1:])
            yield Batch(self.places[some], *inputs)

    def chunk(self, first: int, room: int) -> tuple[Any, np.ndarray]:
        """Return design, scenarios and duration of the runs from ``first`` on, arrays (room,) for all numbers, and
        which of these runs are enabled.

        The others fill up the arrays: every call has the same shape and needs no program of its own.
        """
        index = first + np.arange(room)
        # "clip" repeats the last run in the places that are left over; those are not enabled.
        filled = lambda leaf: np.broadcast_to(leaf, self.places.shape).take(index, mode="clip")  # noqa: E731
        return jax.tree.map(filled, self[1:]), index < self.places.size


class Places(Protocol):
    """Where runs lie: a grid, or points spread over ranges."""

    @property
    def axes(self) -> Sequence[Any]:
        """Return the fields that differ, each with its ``path``, ``unit``, ``name`` and ``heading``."""
        ...

    def __len__(self) -> int: ...

    def columns(self) -> dict[str, np.ndarray]:
        """Return each field's value in every run, shape (n,), by its path."""
        ...

    def point(self, index: int) -> str:
        """Return one run's values in words."""
        ...

    def batches(self, design: Part, scenario: Part) -> list[Batch]:
        """Return all runs, those of one program together."""
        ...

    def applied(self, design: Part, scenario: Part) -> tuple[Part, Part]:
        """Return design and scenario with an array (n,) for each field that differs."""
        ...


@dataclasses.dataclass(frozen=True)
class Grid:
    """The product of its axes, the last one changing fastest."""

    axes: tuple[Axis, ...]

    def __post_init__(self) -> None:
        if not self.axes:
            raise InputError("nothing to sweep; name a field and its values")
        # The memory is checked before any array is made: a mistyped count would otherwise fill it first.
        runs = math.prod(self.shape)
        need, have = BYTES * runs, _free_memory()
        size = f"the grid has {' × '.join(map(str, self.shape))} = {runs:.4g} runs"
        if need > have:
            raise InputError(f"{size}, which need {_size(need)} of memory; {_size(have)} are free")

    def __len__(self) -> int:
        return math.prod(self.shape)

    @property
    def shape(self) -> tuple[int, ...]:
        """Return how many values each axis has."""
        return tuple(len(axis) for axis in self.axes)

    def columns(self) -> dict[str, np.ndarray]:
        """Return each path's value in every run, shape (n,)."""
        meshed = np.meshgrid(*(axis.values for axis in self.axes), indexing="ij")
        return {axis.path: values.ravel() for axis, values in zip(self.axes, meshed, strict=True)}

    def point(self, index: int) -> str:
        """Return one run's values in words: "approach_speed 0.1 m/s, misalignment 0 rad"."""
        places = np.unravel_index(index, self.shape)
        shown = (f"{it.name} {it.words(it.values[place])}" for it, place in zip(self.axes, places, strict=True))
        return ", ".join(shown)

    def batches(self, design: Part, scenario: Part) -> list[Batch]:
        """Return all runs, a batch for each combination of choices, because these change the program.

        Each field of the grid that is a number has an array (n,) in a batch.
        """
        chosen, columns = [axis for axis in self.axes if not axis.unit], self.columns()
        numbers = {axis.path: columns[axis.path] for axis in self.axes if axis.unit}
        made = []
        for values in itertools.product(*(axis.values.tolist() for axis in chosen)):
            mine = np.ones(len(self), bool)
            for axis, value in zip(chosen, values, strict=True):
                mine &= columns[axis.path] == value
            places = np.flatnonzero(mine)
            choices = {axis.path: value for axis, value in zip(chosen, values, strict=True)}
            swept = with_values(design, scenario, choices | {path: it[places] for path, it in numbers.items()})
            check_pair(mechanism_of(design), *swept)
            made.append(Batch(places, *swept))
        return made

    def applied(self, design: Part, scenario: Part) -> tuple[Part, Part]:
        """Return design and scenario with an array (n,) for each field of the grid, the others as they are.

        The grid must have no choices.
        """
        # Without choices all runs are one batch.
        (batch,) = self.batches(design, scenario)
        return batch.design, batch.scenarios


def grid(over: Mapping[str, Any], design: Part, scenario: Part) -> Grid:
    """Return a grid of values as TOML writes them: a number, a list, or {from, to, count, scale = "linear" | "log"}.

    Of a choice the values are a word, a truth, a whole number, or a list of them.

    **Arguments:** ``over``: dotted path to values, "scenario.…" for the scenario's; ``design``, ``scenario``: whose
    fields they are.

    **Raises:** `InputError` for paths that are unknown, empty lists, values out of range, and for a grid that does not
    fit into memory.
    """
    return Grid(tuple(axis_of(path, values, design, scenario) for path, values in over.items()))


def _free_memory() -> int:
    """Return how many bytes of memory are free; where the system does not say, how many there are."""
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
        return 1024 * next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable:"))
    except (OSError, StopIteration):
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def _size(count: float) -> str:
    for symbol in ("B", "KiB", "MiB", "GiB"):
        if count < 1024:
            return f"{count:.3g} {symbol}"
        count /= 1024
    return f"{count:.4g} TiB"
