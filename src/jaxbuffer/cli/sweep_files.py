"""A sweep as files: a table with a row for each capture, and arrays in the grid's shape, which can be read back."""

import io
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..config import design_toml, loads
from ..errors import InputError
from ..grid import Axis, Grid
from ..outcome import Outcome
from ..report import FLANKS, UNITS
from ..sweep import QUANTITIES, Sweep
from ..swept import Swept
from .records import version

TABLE, FIGURE = "sweep.csv", "sweep.png"
INDEX = "sweep"  # key of the arrays' description


def named(quantity: str) -> str:
    """A quantity with its unit: "peak_force [N]"."""
    return f"{quantity} [{UNITS[quantity]}]" if quantity in UNITS else quantity


def rows(swept: Swept) -> tuple[list[str], Iterator[Sequence[Any]]]:
    """Header and a row for each capture that was computed; what a failed one lacks stays empty."""
    numbers = [name for name in QUANTITIES if name not in ("code", "peak_flank")]
    header = [
        *(f"{axis.path} [{axis.unit}]" for axis in swept.grid.axes),
        "outcome",
        *map(named, numbers),
        "peak_flank",
    ]
    return header, _rows(swept, numbers)


def _rows(swept: Swept, numbers: Sequence[str]) -> Iterator[Sequence[Any]]:
    found, inputs = swept.found, list(swept.grid.columns().values())
    columns = [getattr(found, name) for name in numbers]
    for i in np.flatnonzero(swept.done):
        values = [None if math.isnan(value) else value for value in (column[i].item() for column in columns)]
        flank = FLANKS[found.peak_flank[i]] if swept.solved[i] else None
        yield [*(column[i].item() for column in inputs), Outcome(int(found.code[i])).name, *values, flank]


def arrays(swept: Swept) -> bytes:
    """An .npz file's content: each axis' values, each quantity in the grid's shape, and what they belong to."""
    description = {
        "axes": [[axis.path, axis.unit, axis.scale] for axis in swept.grid.axes],
        "study": design_toml(swept.design, [swept.scenario]),
        "outcomes": {str(int(outcome)): outcome.name for outcome in Outcome},
        "jaxbuffer": version(),
    }
    stored: dict[str, Any] = {INDEX: np.array(json.dumps(description))}
    stored |= {f"{axis.path} [{axis.unit}]": axis.values for axis in swept.grid.axes}
    stored |= {named(name): swept.shaped(name) for name in QUANTITIES}
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
        found = Sweep(*(arrays[named(name)].reshape(len(grid)) for name in QUANTITIES))
        done = arrays["done"].reshape(len(grid)).astype(bool)
        for code in np.unique(found.code[done]):
            Outcome(int(code))
        study = loads(description["study"].encode(), file)
    except Exception as error:  # zip files and arrays fail in many ways; all mean the same
        raise InputError(f"{file} is not a sweep's result, or is damaged: {error}") from None
    return Swept(grid, study.design, study.scenario, found, done)
