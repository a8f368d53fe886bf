"""Runs and designs as MATLAB's .mat files: one structure for design and scenario, an array for each quantity."""

import io
from typing import Any

import numpy as np
import scipy

from .._types import Dataset
from ..fields import Curve, Part, get, paths, unit
from ..mechanisms.run import Run

SUFFIX = ".mat"
HEADER = b"MATLAB 5.0 MAT-file, jaxbuffer".ljust(116)  # scipy's own has the time, and differs from run to run


def run_mat(run: Run) -> bytes:
    """Return a run as a .mat file: what its netCDF file has, with units by name, its design and its scenario.

    **Example:**

    >>> import io, scipy
    >>> from jaxbuffer.output.matlab import run_mat
    >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22)
    >>> read = scipy.io.loadmat(io.BytesIO(run_mat(run)), simplify_cells=True)
    >>> float(read["scenario"]["height"]), read["units"]["peak_force"]
    (0.194, 'N')
    """
    data = run.to_xarray()
    return _content(
        {
            "outcome": run.outcome.name,
            **_arrays(data),
            "units": {str(name): it.attrs["units"] for name, it in data.variables.items() if "units" in it.attrs},
            "design": structure(run.design),
            "scenario": structure(run.scenario),
        }
    )


def design_mat(design: Part) -> bytes:
    """Return a design as a .mat file: a structure with a field for each part, and one of their units."""
    units: dict[str, Any] = {}
    for path in paths(design):
        if symbol := unit(design, path):
            section, _, name = path.rpartition(".")
            (units.setdefault(section, {}) if section else units)[name] = symbol
    return _content({"design": structure(design), "units": units})


def structure(part: Part) -> dict[str, Any]:
    """Return a design or a scenario as nested dictionaries, which become structures; what is not set is []."""
    made: dict[str, Any] = {}
    for path in paths(part):
        section, _, name = path.rpartition(".")
        (made.setdefault(section, {}) if section else made)[name] = _value(get(part, path))
    return made


def _value(value: Any) -> Any:
    if value is None:
        return np.zeros((0, 0))
    if isinstance(value, Curve):
        return np.array(value.points(), float)
    return str(value) if isinstance(value, str) else value  # a law's name is more than a text


def _arrays(data: Dataset) -> dict[str, Any]:
    """Return a dataset's arrays; words become cell arrays."""
    values = {str(name): np.asarray(it) for name, it in data.variables.items()}
    return {name: it.astype(object) if it.dtype.kind in "UO" else it for name, it in values.items()}


def _content(values: dict[str, Any]) -> bytes:
    file = io.BytesIO()
    # Columns, as MATLAB has the numbers of a history.
    # A name may have 63 characters in MATLAB, of which scipy allows 31 unless it is told.
    scipy.io.savemat(file, values, long_field_names=True, oned_as="column")
    return HEADER + file.getvalue()[len(HEADER) :]
