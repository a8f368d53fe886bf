"""Sweeps as labelled arrays and as rows of a table."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..fields import addresses, unit_at, value_at
from ..labelled.arrays import Labelled, dataset
from ..mechanisms.dataset import attributes
from ..mechanisms.outcome import NotComputed
from ..version import version

if TYPE_CHECKING:
    import xarray as xr

    from .computed import Computed
    from .found import Sweep
    from .swept import Swept

UNDONE = NotComputed().name
Rows = tuple[list[str], Iterator[Sequence[Any]]]


def swept_dataset(swept: "Swept") -> "xr.Dataset":
    """See `Swept.to_xarray`."""
    dims, shape = tuple(axis.path for axis in swept.grid.axes), swept.grid.shape
    axes = {axis.path: Labelled((axis.path,), axis.values, axis.unit, axis.name) for axis in swept.grid.axes}
    variables = _variables(swept.found, swept.done, _contacts(swept.found, swept.design), dims, shape)
    about = attributes(swept.found.mechanism, swept.design, swept.scenario)
    return dataset(variables, axes, about)


def sweep_dataset(sweep: "Sweep", done: np.ndarray | None = None) -> "xr.Dataset":
    """See `Sweep.to_xarray`. ``done`` (n,): which runs were computed, by default all."""
    runs = {"run": Labelled(("run",), np.arange(len(sweep)), "", "number of the run, from 0")}
    inputs = {path: Labelled(("run",), values, unit) for path, (unit, values) in _inputs(sweep).items()}
    contacts = _contacts(sweep, sweep.design)
    computed = np.ones(len(sweep), bool) if done is None else done
    variables = _variables(sweep, computed, contacts, ("run",), (len(sweep),))
    about = {"title": sweep.mechanism.title, "kind": sweep.mechanism.name, "jaxbuffer": version()}
    return dataset(variables, runs | inputs, about)


def swept_rows(swept: "Computed") -> Rows:
    """Header and a row for each run that was computed; what a failed one lacks stays empty."""
    inputs = {axis.heading: swept.grid.columns()[axis.path] for axis in swept.grid.axes}
    return _table(swept.found, inputs, swept.done, _contacts(swept.found, swept.design))


def sweep_rows(sweep: "Sweep") -> Rows:
    """Header and a row for each run."""
    inputs = {f"{path} [{unit}]": values for path, (unit, values) in _inputs(sweep).items()}
    return _table(sweep, inputs, np.ones(len(sweep), bool), _contacts(sweep, sweep.design))


def named(sweep: "Sweep", column: str) -> str:
    """A column with its unit: "peak_force [N]"."""
    catalogue = sweep.mechanism.quantities
    return f"{column} [{catalogue[column].unit}]" if column in catalogue else column


def _contacts(sweep: "Sweep", design: Any) -> tuple[str, ...]:
    return sweep.mechanism.names(sweep.mechanism.design() if design is None else design).contacts


def _inputs(sweep: "Sweep") -> dict[str, tuple[str, np.ndarray]]:
    """Unit and values (n,) of each number that differs between the runs, by its address."""
    if sweep.design is None or sweep.scenarios is None:
        return {}
    both = sweep.design, sweep.scenarios
    values = {path: value_at(*both, path) for path in addresses(*both)}
    return {path: (unit_at(*both, path), np.asarray(it)) for path, it in values.items() if np.ndim(it)}


def _variables(
    sweep: "Sweep", done: np.ndarray, contacts: Sequence[str], dims: tuple[str, ...], shape: tuple[int, ...]
) -> dict[str, Labelled]:
    mechanism, largest = sweep.mechanism, f"peak_{sweep.mechanism.contact}"
    outcomes = [it.name if is_done else UNDONE for it, is_done in zip(sweep.outcomes, done, strict=True)]
    found = {"outcome": Labelled(dims, np.array(outcomes, str).reshape(shape), "", "how the run ended")}
    for name in mechanism.swept:
        quantity = mechanism.quantities[name]
        found[name] = Labelled(dims, sweep.columns[name].reshape(shape), quantity.unit, quantity.description)
    solved = done & sweep.solved
    where = [contacts[k] if is_solved else "" for k, is_solved in zip(sweep.columns[largest], solved, strict=True)]
    what = f"{mechanism.contact} with the largest force"
    found[largest] = Labelled(dims, np.array(where, str).reshape(shape), "", what)
    trusted = np.array(sweep.verdicts, str).reshape(shape)
    found["trust"] = Labelled(dims, trusted, "", "how far the numbers can be trusted, empty for no verdict")
    for name in ("impact_count", "attempts"):
        counted = f"number of {name.removesuffix('_count').rstrip('s')}s, -1 where not computed"
        found[name] = Labelled(dims, sweep.columns[name].reshape(shape), "-", counted)
    return found


def _table(sweep: "Sweep", inputs: Mapping[str, np.ndarray], done: np.ndarray, contacts: Sequence[str]) -> Rows:
    contact = f"peak_{sweep.mechanism.contact}"
    numbers = [name for name in sweep.columns if name not in ("code", contact, "trust")]
    header = [*inputs, "outcome", *(named(sweep, name) for name in numbers), contact, "trust"]
    return header, _rows(sweep, list(inputs.values()), numbers, done, contacts)


def _rows(
    sweep: "Sweep", inputs: Sequence[np.ndarray], numbers: Sequence[str], done: np.ndarray, contacts: Sequence[str]
) -> Iterator[Sequence[Any]]:
    columns, solved = [sweep.columns[name] for name in numbers], done & sweep.solved
    largest, verdicts = sweep.columns[f"peak_{sweep.mechanism.contact}"], sweep.verdicts
    for i in np.flatnonzero(done):
        values = [None if math.isnan(value) else value for value in (column[i].item() for column in columns)]
        outcome = sweep.mechanism.outcomes(int(sweep.columns["code"][i])).name
        where = contacts[largest[i]] if solved[i] else None
        yield [*(column[i].item() for column in inputs), outcome, *values, where, verdicts[i] or None]
