"""A sweep as files: a table with a row for each run, and arrays in the grid's shape, which can be read back."""

import io
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..mechanisms.registry import mechanism_of
from ..study.config import design_toml, loads
from ..sweeps.grid import Axis, Grid
from ..sweeps.sweep import Sweep
from ..sweeps.swept import Computed, Swept
from ..version import version

TABLE, FIGURE = "sweep.csv", "sweep.png"
INDEX = "sweep"  # key of the arrays' description


def named(sweep: Sweep, column: str) -> str:
    """A column with its unit: "peak_force [N]"."""
    catalogue = sweep.mechanism.quantities
    return f"{column} [{catalogue[column].unit}]" if column in catalogue else column


def rows(swept: Computed) -> tuple[list[str], Iterator[Sequence[Any]]]:
    """Header and a row for each run that was computed; what a failed one lacks stays empty."""
    found = swept.found
    contact = f"peak_{found.mechanism.contact}"
    numbers = [name for name in found.columns if name not in ("code", contact)]
    header = [
        *(f"{axis.path} [{axis.unit}]" for axis in swept.grid.axes),
        "outcome",
        *(named(found, name) for name in numbers),
        contact,
    ]
    return header, _rows(swept, numbers, contact)


def _rows(swept: Computed, numbers: Sequence[str], contact: str) -> Iterator[Sequence[Any]]:
    found, inputs = swept.found, list(swept.grid.columns().values())
    contacts = found.mechanism.names(swept.design).contacts
    columns, outcomes = [found.columns[name] for name in numbers], found.outcomes
    for i in np.flatnonzero(swept.done):
        values = [None if math.isnan(value) else value for value in (column[i].item() for column in columns)]
        largest = contacts[found.columns[contact][i]] if swept.solved[i] else None
        yield [*(column[i].item() for column in inputs), outcomes[i].name, *values, largest]


def arrays(swept: Swept) -> bytes:
    """An .npz file's content: each axis' values, each quantity in the grid's shape, and what they belong to."""
    found = swept.found
    description = {
        "axes": [[axis.path, axis.unit, axis.scale] for axis in swept.grid.axes],
        "study": design_toml(swept.design, [swept.scenario]),
        "outcomes": {str(int(outcome)): outcome.name for outcome in found.mechanism.outcomes},
        "jaxbuffer": version(),
    }
    stored: dict[str, Any] = {INDEX: np.array(json.dumps(description))}
    stored |= {f"{axis.path} [{axis.unit}]": axis.values for axis in swept.grid.axes}
    stored |= {named(found, name): swept.shaped(name) for name in found.columns}
    stored["done"] = swept.done.reshape(swept.grid.shape)
    content = io.BytesIO()
    np.savez_compressed(content, **stored)
    return content.getvalue()


def read(file: Path) -> Swept:
    """The sweep that `arrays` wrote. Raises `InputError` if the file is not one."""
    try:
        with file.open("rb") as content, np.load(content, allow_pickle=False) as stored:
            arrays = dict(stored)
        description = json.loads(str(arrays[INDEX]))
        axes = tuple(
            Axis(path, unit, tuple(arrays[f"{path} [{unit}]"].tolist()), scale)
            for path, unit, scale in description["axes"]
        )
        grid = Grid(axes)
        study = loads(description["study"].encode(), file)
        empty = Sweep.empty(mechanism_of(study.design), len(grid))
        found = Sweep(empty.mechanism, {name: arrays[named(empty, name)].reshape(len(grid)) for name in empty.columns})
        done = arrays["done"].reshape(len(grid)).astype(bool)
        for code in np.unique(found.code[done]):
            empty.mechanism.outcomes(int(code))
    except Exception as error:  # zip files and arrays fail in many ways; all mean the same
        raise InputError(f"{file} is not a sweep's result, or is damaged: {error}") from None
    return Swept(grid, study.design, study.scenario, found, done)
