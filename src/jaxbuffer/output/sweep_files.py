"""A sweep's files: their names, and arrays in the grid's shape, which can be read back."""

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..mechanisms.registry import mechanism_of
from ..study.config import design_toml, loads
from ..sweeps.grid import Axis, Grid
from ..sweeps.result import Sweep
from ..sweeps.table import heading
from ..version import version

TABLE, FIGURE, LABELLED, RECORD = "sweep.csv", "sweep.png", "sweep.nc", "sweep.json"
INDEX = "sweep"  # key of the arrays' description


def arrays(swept: Sweep) -> bytes:
    """An .npz file's content: each axis' values, each quantity in the grid's shape, and what they belong to."""
    description = {
        "axes": [[axis.path, axis.unit, axis.scale] for axis in swept.grid.axes],
        "study": design_toml(swept.design, [swept.scenario]),
        "outcomes": {str(int(outcome)): outcome.name for outcome in swept.mechanism.outcomes},
        "jaxbuffer": version(),
    }
    stored: dict[str, Any] = {INDEX: np.array(json.dumps(description))}
    stored |= {axis.heading: axis.values for axis in swept.grid.axes}
    stored |= {heading(swept, name): swept.shaped(name) for name in swept.columns}
    stored["done"] = swept.done.reshape(swept.grid.shape)
    content = io.BytesIO()
    np.savez_compressed(content, **stored)
    return content.getvalue()


def read(file: Path) -> Sweep:
    """The sweep that `arrays` wrote. Raises `InputError` if the file is not one."""
    try:
        with file.open("rb") as content, np.load(content, allow_pickle=False) as stored:
            arrays = dict(stored)
        description = json.loads(str(arrays[INDEX]))
        axes = tuple(
            Axis(path, unit, tuple(arrays[Axis(path, unit, ()).heading].tolist()), scale)
            for path, unit, scale in description["axes"]
        )
        grid = Grid(axes)
        study = loads(description["study"].encode(), file)
        empty = Sweep.empty(mechanism_of(study.design), len(grid))
        columns = {name: arrays[heading(empty, name)].reshape(len(grid)) for name in empty.columns}
        done = arrays["done"].reshape(len(grid)).astype(bool)
        for code in np.unique(columns["code"][done]):
            empty.mechanism.outcomes(int(code))
    except Exception as error:  # zip files and arrays fail in many ways; all mean the same
        raise InputError(f"{file} is not a sweep's result, or is damaged: {error}") from None
    return Sweep(empty.mechanism, columns, study.design, study.scenario, grid).only(done)
