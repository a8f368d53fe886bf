"""What a folder of results holds, read back: `load`."""

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..fields import Part, paths
from ..fields.record import from_json
from ..labelled.netcdf import SUFFIX, read
from ..mechanisms import all_mechanisms, mechanism_named
from ..study.config import load as load_study
from .formats import ARRAYS
from .sweep_files import LABELLED
from .sweep_files import read as read_arrays

if TYPE_CHECKING:
    import xarray as xr

DESIGN = "design.toml"


@dataclasses.dataclass(frozen=True)
class Results:
    """What a folder of results holds; what it has not is None. Print it to see which.

    - ``folder``: where it is.
    - ``run``: of `jaxbuffer simulate`, as `Run.to_xarray` made it, history included.
    - ``sweep``: of `jaxbuffer sweep`, as `Swept.to_xarray` made it.
    - ``tuned``: of `jaxbuffer tune`, the record of tuned.json.
    - ``sensitivity``: of `jaxbuffer sensitivity`, the record of sensitivity.json.
    - ``design``: the tuned one, or else that of the run or the sweep.

    **Example:**

    >>> import pathlib
    >>> found = jb.Results(pathlib.Path("results"), tuned={"message": "no reduction is left"})
    >>> found.run is None, found.tuned["message"]
    (True, 'no reduction is left')
    """

    folder: Path
    run: "xr.Dataset | None" = None
    sweep: "xr.Dataset | None" = None
    tuned: Mapping[str, Any] | None = None
    sensitivity: Mapping[str, Any] | None = None
    design: Part | None = None

    def __repr__(self) -> str:
        return "\n".join(
            [f"Results in {self.folder}:", *(f"  {name:12} {told}" for name, told in self._told().items())]
        )

    def _repr_html_(self) -> str:
        from ..tables import summary_html

        return summary_html(repr(self))

    def _told(self) -> dict[str, str]:
        """A line for each thing there is."""
        told = {}
        if self.run is not None:
            steps = f"history of {self.run.sizes['step']} steps" if "step" in self.run.sizes else "no history"
            told["run"] = f"{self.run.title}: {self.run.outcome}; {self.run.sizes['impact']} impacts listed, {steps}"
        if self.sweep is not None:
            sizes = " × ".join(f"{count} {name}" for name, count in self.sweep.sizes.items())
            told["sweep"] = f"{self.sweep.title}: {sizes}"
        if self.tuned is not None:
            told["tuned"] = str(self.tuned.get("message", ""))
        if self.sensitivity is not None:
            pairs = self.sensitivity.get("derivatives", ())
            told["sensitivity"] = f"{len(pairs)} derivatives"
        if self.design is not None:
            told["design"] = f"{type(self.design).__name__} with {len(list(paths(self.design)))} fields"
        return told


def load(folder: str | Path) -> Results:
    """What a folder holds that `--output` named.

    **Arguments:**

    - ``folder``: a folder of `jaxbuffer simulate`, `sweep`, `sensitivity` or `tune`, or of several of them.

    **Returns:** `Results`.

    **Raises:** `InputError` for a folder that is not there, holds no results, or has a damaged file, which it names.

    **Example:**

    >>> try:
    ...     jb.load("no-such-folder")
    ... except jb.InputError as error:
    ...     print(error)
    no-such-folder: no such folder
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder")
    run, sweep = _run(folder), _sweep(folder)
    tuned, sensitivity = _record(folder / "tuned.json"), _record(folder / "sensitivity.json")
    design = load_study(folder / DESIGN).design if (folder / DESIGN).is_file() else None
    if run is None and sweep is None and tuned is None and sensitivity is None and design is None:
        raise InputError(f"{folder} holds no results of simulate, sensitivity, sweep, sample, tune or pareto")
    for found in (run, sweep):
        if design is None and found is not None:
            design = _design(folder, found)
    return Results(folder, run, sweep, tuned, sensitivity, design)


def _run(folder: Path) -> "xr.Dataset | None":
    """The run in a folder, named after what its mechanism calls it."""
    names = [f"{mechanism.run_name}{SUFFIX}" for mechanism in all_mechanisms()]
    files = [folder / name for name in dict.fromkeys(names) if (folder / name).is_file()]
    if len(files) > 1:
        raise InputError(f"{folder} holds several runs, {', '.join(it.name for it in files)}; keep one in a folder")
    return read(files[0]) if files else None


def _sweep(folder: Path) -> "xr.Dataset | None":
    if (folder / LABELLED).is_file():
        return read(folder / LABELLED)
    return read_arrays(folder / ARRAYS).to_xarray() if (folder / ARRAYS).is_file() else None


def _record(file: Path) -> Mapping[str, Any] | None:
    if not file.is_file():
        return None
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:  # no JSON, or no UTF-8
        raise InputError(f"{file} is damaged: {error}") from None
    if not isinstance(record, dict):
        raise InputError(f"{file} is damaged: it holds no record")
    return record


def _design(folder: Path, found: "xr.Dataset") -> Part:
    try:
        return from_json(mechanism_named(found.attrs["kind"]).design(), found.attrs["design"])
    except (KeyError, ValueError, AttributeError) as error:
        raise InputError(f"{folder}: the design of its dataset is damaged or of another release: {error}") from None
