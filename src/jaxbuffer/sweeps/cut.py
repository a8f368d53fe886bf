"""A sweep cut into blocks, each solved and stored on its own: a block has the runs of one program."""

import dataclasses
import functools
import itertools
import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import jax
import numpy as np

from ..errors import as_number
from ..fields import Part, unit_at, with_values
from ..fields.address import addresses, value_at
from ..labelled.arrays import Labelled
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.registry import mechanism_of
from ..run.request import check_pair
from .grid import Batch, Grid

Region = tuple[slice, ...]


class Block(NamedTuple):
    """A part of a sweep: its number, where its runs are in the arrays of all, and the numbers and choices that are its
    own, by name."""

    number: int
    region: Region
    values: dict[Any, np.ndarray]

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the shape of its arrays."""
        return tuple(part.stop - part.start for part in self.region)


@dataclasses.dataclass(frozen=True)
class Cut:
    """How arrays are cut: ``sizes`` of all, ``block`` of one."""

    sizes: tuple[int, ...]
    block: tuple[int, ...]

    def __len__(self) -> int:
        return math.prod(self.counts)

    @property
    def counts(self) -> tuple[int, ...]:
        """Return the number of blocks along each axis."""
        return tuple(-(-size // length) for size, length in zip(self.sizes, self.block, strict=True))

    def numbers(self, places: np.ndarray) -> np.ndarray:
        """Return the numbers of the blocks that hold the runs at these ``places`` in the arrays of all."""
        corners = [
            place // length for place, length in zip(np.unravel_index(places, self.sizes), self.block, strict=True)
        ]
        return np.unique(np.ravel_multi_index(corners, self.counts))

    def region(self, number: int) -> Region:
        """Return the region of the arrays of all that a block covers."""
        corner = np.unravel_index(number, self.counts)
        starts = [int(place) * length for place, length in zip(corner, self.block, strict=True)]
        # The last block along an axis may be shorter than the others.
        ends = [min(a + n, size) for a, n, size in zip(starts, self.block, self.sizes, strict=True)]
        return tuple(itertools.starmap(slice, zip(starts, ends, strict=True)))


class Template(NamedTuple):
    """What all blocks share: a design, a scenario and a duration [s], of which blocks replace some values."""

    design: Part
    scenario: Part
    duration: Any


class _Blocks:
    """A sweep in blocks, which have a dimension of each name in ``dims``."""

    template: Template
    cut: Cut
    dims: tuple[str, ...]

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism of which these are runs."""
        return mechanism_of(self.template.design)

    @property
    def duration(self) -> Any:
        """Return the duration of the runs [s]."""
        return self.template.duration

    def blocks(self) -> Iterator[Block]:
        """Yield all blocks, each made as it is asked for."""
        for number in range(len(self.cut)):
            yield self.block(number)

    def block(self, number: int) -> Block:
        """Return the block of this number."""
        region = self.cut.region(number)
        return Block(number, region, self._values_in(region))

    def _values_in(self, region: Region) -> dict[Any, np.ndarray]:
        raise NotImplementedError


class GridSweep(_Blocks):
    """A sweep over a grid: blocks are boxes of it, one choice thick. Nothing here has an entry for each run."""

    def __init__(self, grid: Grid, template: Template, size: int) -> None:
        self.grid, self.template = grid, template
        # A choice changes the program, and a block has the runs of one program: it is one value thick along choices.
        self.cut = Cut(grid.shape, box([len(axis) if axis.unit else 1 for axis in grid.axes], size))
        self.dims = tuple(axis.path for axis in grid.axes)

    def identity(self) -> dict[str, Any]:
        """Return the parts that tell this sweep from others, by name."""
        axes = [(axis.path, axis.unit, axis.values.tolist()) for axis in self.grid.axes]
        return {"design": self.template.design, "scenarios": (self.template.scenario, axes)}

    def choices(self) -> list[Any]:
        """Return all values of the fields that are choices."""
        return [value for axis in self.grid.axes if not axis.unit for value in axis.values.tolist()]

    def coordinates(self) -> dict[str, Labelled]:
        """Return the fields' values as labelled arrays, by path."""
        return {it.path: Labelled((it.path,), it.values, it.unit, it.name) for it in self.grid.axes}

    @functools.cached_property
    def _values(self) -> tuple[np.ndarray, ...]:
        return tuple(axis.values for axis in self.grid.axes)

    def _values_in(self, region: Region) -> dict[Any, np.ndarray]:
        return {path: values[part] for path, values, part in zip(self.dims, self._values, region, strict=True)}

    @staticmethod
    def batch(template: Template, block: Block) -> tuple[Batch, Any]:
        """Return the runs of a block and their duration [s]."""
        meshed = np.meshgrid(*block.values.values(), indexing="ij")
        put = {}
        for path, values in zip(block.values, meshed, strict=True):
            is_number = bool(unit_at(template.design, template.scenario, path))
            put[path] = values.ravel() if is_number else block.values[path][0].item()
        swept = with_values(template.design, template.scenario, put)
        check_pair(mechanism_of(template.design), *swept)
        return Batch(None, *swept), template.duration


class RunsSweep(_Blocks):
    """A sweep of runs that are given one by one, as designs and scenarios with arrays (n,)."""

    def __init__(self, design: Part, scenarios: Part, duration: Any, count: int, size: int) -> None:
        leaves, structure = jax.tree.flatten((design, scenarios, as_number(duration)))
        self.arrays = {k: np.asarray(leaf, float) for k, leaf in enumerate(leaves) if np.ndim(leaf)}
        # The template goes to every worker: single numbers in place of arrays with an entry for each run keep it small.
        first = [float(np.ravel(leaf)[0]) for leaf in leaves]
        self.template = Template(*jax.tree.unflatten(structure, first))
        self.swept = design, scenarios, duration
        self.cut, self.dims = Cut((count,), (min(size, count),)), ("run",)

    def identity(self) -> dict[str, Any]:
        """Return the parts that tell this sweep from others, by name."""
        return {"design": self.swept[0], "scenarios": self.swept[1]}

    @property
    def duration(self) -> Any:
        """Return the duration of the runs [s], shape (n,) where they have one each."""
        return self.swept[2]

    def choices(self) -> list[Any]:
        """Return the values of choices that differ: none, because runs given one by one share their choices."""
        return []

    def coordinates(self) -> dict[str, Labelled]:
        """Return the numbers that differ, and the runs' own numbers, as labelled arrays."""
        both = self.swept[:2]
        values = {path: np.asarray(value_at(*both, path)) for path in addresses(*both)}
        differ = {path: Labelled(("run",), it, unit_at(*both, path)) for path, it in values.items() if it.ndim}
        return {"run": Labelled(("run",), np.arange(self.cut.sizes[0]), "", "number of the run, from 0"), **differ}

    def _values_in(self, region: Region) -> dict[Any, np.ndarray]:
        return {k: array[region] for k, array in self.arrays.items()}

    @staticmethod
    def batch(template: Template, block: Block) -> tuple[Batch, Any]:
        """Return the runs of a block and their duration [s]."""
        leaves, structure = jax.tree.flatten(tuple(template))
        leaves = [block.values.get(k, leaf) for k, leaf in enumerate(leaves)]
        design, scenarios, duration = jax.tree.unflatten(structure, leaves)
        return Batch(None, design, scenarios), duration


BlockSweep = GridSweep | RunsSweep


def box(sizes: list[int], most: int) -> tuple[int, ...]:
    """Return the lengths of a box of at most ``most`` cells in an array of these sizes.

    The box is longest along its last axes, along which runs are neighbours in the result.
    """
    lengths: list[int] = []
    for size in reversed(sizes):
        room = max(1, most // math.prod(lengths))
        # Equal pieces in place of full ones and a rest: all blocks take about the same time.
        pieces = -(-size // min(size, room))
        lengths.append(-(-size // pieces))
    return tuple(reversed(lengths))
