"""Sweeps as labelled arrays and as rows of a table."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from .._types import Dataset
from ..block_store import IDENTITY, identity_text
from ..fields import addresses, unit_at, value_at
from ..labelled.arrays import Labelled, dataset
from ..mechanisms.dataset import attributes
from ..version import version
from .columns import RunTable
from .grid import Grid

Rows = tuple[list[str], Iterator[Sequence[Any]]]


def sweep_dataset(sweep: RunTable) -> Dataset:
    """Return the labelled arrays of `Sweep.to_xarray`."""
    own = {} if sweep.identity is None else {IDENTITY: identity_text(sweep.identity)}
    if isinstance(sweep.grid, Grid):
        axes = {axis.path: Labelled((axis.path,), axis.values, axis.unit, axis.name) for axis in sweep.grid.axes}
        about = attributes(sweep.mechanism, sweep.design, sweep.scenario)
        return dataset(_variables(sweep, tuple(axes), sweep.grid.shape), axes, about | own)
    runs = {"run": Labelled(("run",), np.arange(len(sweep)), "", "number of the run, from 0")}
    inputs = {path: Labelled(("run",), values, unit) for path, (unit, values) in _inputs(sweep).items()}
    about = {"title": sweep.mechanism.view.title, "kind": sweep.mechanism.name, "jaxbuffer": version()}
    return dataset(_variables(sweep, ("run",), (len(sweep),)), runs | inputs, about | own)


def sweep_rows(sweep: RunTable) -> Rows:
    """Return the header and a row for each run that was computed; what a failed run lacks stays empty."""
    if sweep.grid is None:
        inputs = {f"{path} [{unit}]": values for path, (unit, values) in _inputs(sweep).items()}
    else:
        values = sweep.grid.columns()
        inputs = {axis.heading: values[axis.path] for axis in sweep.grid.axes}
    contact = f"peak_{sweep.mechanism.view.contact}"
    numbers = [name for name in sweep.columns if name not in ("code", contact, "trust")]
    header = [*inputs, "outcome", *(heading(sweep, name) for name in numbers), contact, "trust"]
    return header, _rows(sweep, inputs, numbers)


def heading(sweep: RunTable, column: str) -> str:
    """Return a column's name with its unit: "peak_force [N]"."""
    catalogue = sweep.mechanism.quantities
    return f"{column} [{catalogue[column].unit}]" if column in catalogue else column


def _inputs(sweep: RunTable) -> dict[str, tuple[str, np.ndarray]]:
    """Return unit and values (n,) of each number that differs between the runs, by its address."""
    if sweep.design is None or sweep.scenarios is None:
        return {}
    both = sweep.design, sweep.scenarios
    values = {path: value_at(*both, path) for path in addresses(*both)}
    return {path: (unit_at(*both, path), np.asarray(it)) for path, it in values.items() if np.ndim(it)}


def _variables(sweep: RunTable, dims: tuple[str, ...], shape: tuple[int, ...]) -> dict[str, Labelled]:
    mechanism, contact = sweep.mechanism, f"peak_{sweep.mechanism.view.contact}"

    def labelled(values: Any, unit: str, description: str) -> Labelled:
        return Labelled(dims, np.asarray(values).reshape(shape), unit, description)

    outcomes = np.array([outcome.name for outcome in sweep.outcomes], str)
    variables = {"outcome": labelled(outcomes, "", "how the run ended")}
    for name in mechanism.swept:
        quantity = mechanism.quantities[name]
        variables[name] = labelled(sweep.columns[name], quantity.unit, quantity.description)
    names = sweep.contacts()
    # A failed run, and one without an impact, has no contact with the largest force.
    where = [
        names[k] if solved and k >= 0 else "" for k, solved in zip(sweep.columns[contact], sweep.solved, strict=True)
    ]
    variables[contact] = labelled(np.array(where, str), "", f"{mechanism.view.contact} with the largest force")
    trust = "how far the numbers can be trusted, empty for no verdict"
    variables["trust"] = labelled(np.array(sweep.verdicts, str), "", trust)
    for name in ("impact_count", "attempts"):
        description = f"number of {name.removesuffix('_count').rstrip('s')}s, -1 where not computed"
        variables[name] = labelled(sweep.columns[name], "-", description)
    return variables


def _rows(sweep: RunTable, inputs: Mapping[str, np.ndarray], numbers: Sequence[str]) -> Iterator[Sequence[Any]]:
    columns, solved, names = [sweep.columns[name] for name in numbers], sweep.solved, sweep.contacts()
    largest, verdicts = sweep.columns[f"peak_{sweep.mechanism.view.contact}"], sweep.verdicts
    for i in np.flatnonzero(sweep.done):
        values = [None if math.isnan(value) else value for value in (column[i].item() for column in columns)]
        outcome = sweep.mechanism.outcomes(int(sweep.columns["code"][i])).name
        where = names[largest[i]] if solved[i] and largest[i] >= 0 else None
        yield [*(column[i].item() for column in inputs.values()), outcome, *values, where, verdicts[i] or None]
