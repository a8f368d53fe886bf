"""Sweeps as labelled arrays and as rows of a table."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from .._types import Dataset
from ..block_store import IDENTITY, identity_text
from ..fields import addresses, unit_at, value_at
from ..labelled.arrays import Labelled, dataset
from ..labelled.record import heading
from ..mechanisms.dataset import attributes
from ..version import version
from .columns import RunTable
from .grid import Grid

Rows = tuple[list[str], Iterator[Sequence[Any]]]
COUNTS = {"impact_count": "number of impacts", "attempts": "number of attempts"}
RUN = ("run",)


def sweep_dataset(sweep: RunTable) -> Dataset:
    """Return the labelled arrays of `Sweep.to_xarray`."""
    own = {} if sweep.identity is None else {IDENTITY: identity_text(sweep.identity)}
    columns = _outputs(sweep)
    if isinstance(sweep.grid, Grid):
        axes = {axis.path: Labelled((axis.path,), axis.values, axis.unit, axis.name) for axis in sweep.grid.axes}
        about, shape = attributes(sweep.mechanism, sweep.design, sweep.scenario), sweep.grid.shape
        over = {n: it._replace(dims=tuple(axes), values=it.values.reshape(shape)) for n, it in columns.items()}
        return dataset(over, axes, about | own)
    runs = {"run": Labelled(RUN, np.arange(len(sweep)), "", "number of the run, from 0")}
    about = {"title": sweep.mechanism.view.title, "kind": sweep.mechanism.name, "jaxbuffer": version()}
    return dataset(columns, runs | _inputs(sweep), about | own)


def sweep_rows(sweep: RunTable) -> Rows:
    """Return the header and a row for each run that was computed; what a failed run lacks stays empty."""
    if sweep.grid is None:
        inputs = _inputs(sweep)
    else:
        values = sweep.grid.columns()
        inputs = {axis.path: Labelled(RUN, values[axis.path], axis.unit) for axis in sweep.grid.axes}
    outputs = _outputs(sweep)
    header = [heading(name, it.unit) for name, it in inputs.items()]
    header += [name if name in COUNTS else heading(name, it.unit) for name, it in outputs.items()]
    columns = [it.values for it in (*inputs.values(), *outputs.values())]
    return header, ([_cell(column[i].item()) for column in columns] for i in np.flatnonzero(sweep.done))


def _cell(value: Any) -> Any:
    """Return a number or a word; None for what is not known."""
    return None if value == "" or (isinstance(value, float) and math.isnan(value)) else value


def _inputs(sweep: RunTable) -> dict[str, Labelled]:
    """Return each number (n,) that differs between runs which were given one by one, by its address."""
    if sweep.design is None or sweep.scenarios is None:
        return {}
    both = sweep.design, sweep.scenarios
    values = {path: value_at(*both, path) for path in addresses(*both)}
    return {path: Labelled(RUN, np.asarray(it), unit_at(*both, path)) for path, it in values.items() if np.ndim(it)}


def _outputs(sweep: RunTable) -> dict[str, Labelled]:
    """Return what the runs gave, each with an entry a run (n,), in the order of a table's columns."""
    mechanism, contact = sweep.mechanism, f"peak_{sweep.mechanism.view.contact}"
    outcomes = np.array([outcome.name for outcome in sweep.outcomes], str)
    quantities = {name: mechanism.quantities[name] for name in mechanism.swept}
    names = sweep.names()
    # A failed run, and one without an impact, has no contact with the largest force.
    where = [
        names.contact(int(k)) if solved else "" for k, solved in zip(sweep.columns[contact], sweep.solved, strict=True)
    ]
    trust = "how far the numbers can be trusted, empty for no verdict"
    return {
        "outcome": Labelled(RUN, outcomes, "", "how the run ended"),
        **{name: Labelled(RUN, sweep.columns[name], it.unit, it.description) for name, it in quantities.items()},
        **{
            name: Labelled(RUN, sweep.columns[name], "-", f"{count}, -1 where not computed")
            for name, count in COUNTS.items()
        },
        contact: Labelled(RUN, np.array(where, str), "", f"{mechanism.view.contact} with the largest force"),
        "trust": Labelled(RUN, np.array(sweep.verdicts, str), "", trust),
    }
