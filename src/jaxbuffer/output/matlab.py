"""Runs and designs as MATLAB's .mat files: one structure for design and scenario, an array for each quantity."""

import io
import re
import unicodedata
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
import scipy

from .._types import Dataset
from ..fields import Curve, Part, get, paths, unit
from ..mechanisms.run import Run

SUFFIX = ".mat"
LONGEST = 63  # characters of a name in MATLAB
KEYWORDS = frozenset(
    [
        "break",
        "case",
        "catch",
        "classdef",
        "continue",
        "else",
        "elseif",
        "end",
        "for",
        "function",
        "global",
        "if",
        "otherwise",
        "parfor",
        "persistent",
        "return",
        "spmd",
        "switch",
        "try",
        "while",
    ]
)
ORIGINAL_NAMES = "original_names"  # pairs of a name in the file and the one that it replaces
Renamed = list[tuple[str, str]]
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
    renamed: Renamed = []
    # A quantity may be called like what the file has besides: it gets a number, and its unit is by that name too.
    arrays = _valid(_arrays(data), renamed, taken=("outcome", "units", "design", "scenario", ORIGINAL_NAMES))
    names = {original: name for name, original in renamed}
    units = {
        names.get(str(name), str(name)): it.attrs["units"] for name, it in data.variables.items() if "units" in it.attrs
    }
    outcome, design, scenario = run.outcome.name, structure(run.design), structure(run.scenario)
    return _content({"outcome": outcome, **arrays, "units": units, "design": design, "scenario": scenario}, renamed)


def design_mat(design: Part) -> bytes:
    """Return a design as a .mat file: a structure with a field for each part, and one of their units."""
    units: dict[str, Any] = {}
    for path in paths(design):
        if symbol := unit(design, path):
            section, _, name = path.rpartition(".")
            (units.setdefault(section, {}) if section else units)[name] = symbol
    return _content({"design": structure(design), "units": units}, [])


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


def _content(values: dict[str, Any], renamed: Renamed) -> bytes:
    """Return the file's content; ``renamed``: the names that were replaced so far, to which others are added."""
    file = io.BytesIO()
    valid = _valid(values, renamed)
    if renamed:
        valid[ORIGINAL_NAMES] = np.array(list(dict.fromkeys(renamed)), dtype=object)
    # Columns, as MATLAB has the numbers of a history.
    # A name may have 63 characters in MATLAB, of which scipy allows 31 unless it is told.
    scipy.io.savemat(file, valid, long_field_names=True, oned_as="column")
    return HEADER + file.getvalue()[len(HEADER) :]


def _valid(values: Mapping[str, Any], renamed: Renamed, taken: Collection[str] = ()) -> dict[str, Any]:
    """Return the values by names that MATLAB can have, those in structures too; ``renamed`` gets the new names."""
    valid = {it for it in values if re.fullmatch("[A-Za-z][A-Za-z0-9_]*", it) and len(it) <= LONGEST} - {*KEYWORDS}
    names = {it: it for it in values if it in valid and it not in taken}
    # Names that need no change keep theirs, whatever the others become.
    for original in values:
        if original not in names:
            names[original] = _made_valid(original, {*taken, *names.values()})
            renamed.append((names[original], original))
    return {names[original]: _valid(it, renamed) if isinstance(it, dict) else it for original, it in values.items()}


def _made_valid(name: str, taken: Collection[str]) -> str:
    """Return a name of letters, digits and underscores that begins with a letter, as long as MATLAB allows: "länge"
    becomes "lange", with a number behind it if that is taken."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    plain = re.sub("[^A-Za-z0-9_]", "_", plain)
    if not re.match("[A-Za-z]", plain) or plain in KEYWORDS:
        plain = f"x_{plain}"
    made, count = plain[:LONGEST], 1
    while made in taken:
        count += 1
        made = f"{plain[: LONGEST - 1 - len(str(count))]}_{count}"
    return made
