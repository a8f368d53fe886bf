"""What is swept: which runs, in which arrays their numbers lie, and what tells one sweep from another."""

import dataclasses
import functools
import hashlib
from typing import Any

import jax
import numpy as np

from ..block_store import Identity
from ..contact import laws_named
from ..errors import InputError, as_number
from ..fields import Part, addresses, unit_at, value_at
from ..labelled.arrays import Labelled
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.registry import mechanism_of
from ..programs.identity import user_code
from ..version import version
from .chunk import SweepSettings
from .columns import column_names
from .cut import Cut, box
from .grid import Batch, Grid

CODE = "code"  # of the user's, a part of a sweep's identity where it uses some


@dataclasses.dataclass(frozen=True)
class SweepSpec:
    """The specification of a sweep.

    ``design``, ``scenarios``, ``duration`` [s]: what the values of the ``grid`` are put into, or where that is None the
    runs themselves, with arrays (n,) for the numbers that differ; ``settings``: what all runs share.
    """

    design: Part
    scenarios: Part
    duration: Any
    grid: Grid | None
    settings: SweepSettings

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism of which these are runs."""
        return mechanism_of(self.design)

    @functools.cached_property
    def batches(self) -> list[Batch]:
        """Return all runs, those of one program together.

        **Raises:** `InputError` for arrays of unequal lengths.
        """
        if self.grid is None:
            return [_batch(None, self.design, self.scenarios, self.duration)]
        made = self.grid.batches(self.design, self.scenarios)
        return [_batch(it.places, it.design, it.scenarios, self.duration) for it in made]

    @property
    def shape(self) -> tuple[int, ...]:
        """Return the shape of the sweep's arrays."""
        return (self.batches[0].places.size,) if self.grid is None else self.grid.shape

    @property
    def dims(self) -> tuple[str, ...]:
        """Return the name of each dimension of the arrays."""
        return ("run",) if self.grid is None else tuple(axis.path for axis in self.grid.axes)

    def cut(self, size: int) -> Cut:
        """Return how a store cuts the arrays, into blocks of at most ``size`` runs."""
        if self.grid is None:
            return Cut(self.shape, (min(size, *self.shape),))
        # Choices change the program and are solved one after the other: so a block has the runs of one choice.
        return Cut(self.shape, box([len(axis) if axis.unit else 1 for axis in self.grid.axes], size))

    def coordinates(self) -> dict[str, Labelled]:
        """Return the values along the dimensions as labelled arrays, by path; of single runs the numbers that differ,
        and the runs' own numbers."""
        if self.grid is not None:
            return {it.path: Labelled((it.path,), it.values, it.unit, it.name) for it in self.grid.axes}
        both = self.design, self.scenarios
        values = {path: np.asarray(value_at(*both, path)) for path in addresses(*both)}
        differ = {path: Labelled(("run",), it, unit_at(*both, path)) for path, it in values.items() if it.ndim}
        return {"run": Labelled(("run",), np.arange(*self.shape), "", "number of the run, from 0"), **differ}

    def first(self) -> tuple[Part, Part, float]:
        """Return design, scenario and duration with single numbers: those of the first run where runs differ."""
        leaves, structure = jax.tree.flatten((self.design, self.scenarios, as_number(self.duration)))
        design, scenario, duration = jax.tree.unflatten(structure, [float(np.ravel(leaf)[0]) for leaf in leaves])
        return design, scenario, duration

    @property
    def identity(self) -> Identity:
        """Return what makes the sweep the one it is, by name: a hash of each part's numbers and of how they are
        arranged."""
        axes = [] if self.grid is None else self.grid.axes
        values = [(axis.path, axis.unit, axis.values.tolist()) for axis in axes]
        settings = self.settings
        parts = {
            "design": self.design,
            "scenarios": self.scenarios if self.grid is None else (self.scenarios, values),
            "options": (self.duration, *settings),
            "quantities": column_names(self.mechanism),
        }
        hashes = {"version": version()}
        # Laws that the grid names may be code of the user's own, too.
        choices = [value for axis in axes if not axis.unit for value in axis.values.tolist()]
        used = self.mechanism, settings.solver, self.design, self.scenarios
        if code := user_code(*used, *laws_named(choices)):
            hashes[CODE] = code
        return hashes | {name: _hash(part) for name, part in parts.items()}


def _hash(part: Any) -> str:
    leaves, structure = jax.tree.flatten(part)
    content = hashlib.sha256(str(structure).encode())
    for leaf in leaves:
        # One byte order, so that every machine comes to the same hash.
        content.update(repr(leaf).encode() if isinstance(leaf, str) else np.asarray(leaf, "<f8").tobytes())
    return content.hexdigest()[:16]


def _batch(places: np.ndarray | None, design: Part, scenarios: Part, duration: Any) -> Batch:
    """Return a batch with NumPy's arrays for all numbers; ``places`` None: of all runs, in order.

    **Raises:** `InputError` for arrays of unequal lengths.
    """
    inputs = jax.tree.map(lambda leaf: np.asarray(leaf, float), (design, scenarios, as_number(duration)))
    # Without any array there is a single run.
    lengths = {leaf.shape for leaf in jax.tree.leaves(inputs) if leaf.ndim} or {(1,)}
    (*shape,) = next(iter(lengths))
    if len(lengths) > 1 or len(shape) != 1 or shape[0] == 0:
        shapes = ", ".join(sorted(map(str, lengths)))
        raise InputError(f"the arrays of a sweep must all have one shape (n,), n at least 1; found {shapes}")
    return Batch(np.arange(shape[0]) if places is None else places, *inputs)
