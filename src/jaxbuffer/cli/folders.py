"""Folders of results as `report` and `compare` take them: what is said of those that hold too little."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from .streams import note

if TYPE_CHECKING:
    from ..output.folder import Results

MAKE = "jaxbuffer simulate STUDY.toml --output FOLDER makes some; so do sensitivity, sweep, tune, sample and pareto"
STORE = "sweep.zarr"
BEGUN = {  # what a command keeps while it runs, and the files of its results
    "tuning": ("log.jsonl", ("tuned.json",)),
    "sweep or sample": (STORE, ("sweep.npz", "sweep.nc", "sample.json")),
    "front": ("least-*/log.jsonl", ("pareto.json",)),
}
HELD = {"run": "a run", "tuned": "a tuning", "sensitivity": "derivatives", "sample": "a sample", "front": "a front"}


def loaded(folder: Path) -> "Results":
    """What a folder holds; a note on stderr says what in it is not finished.

    **Raises:** `InputError` for a folder without results, with what to do.
    """
    from ..output.folder import load

    told = unfinished(folder)
    try:
        found = load(folder)
    except InputError as error:
        if "holds no results" in str(error):
            raise InputError(told or f"{error}; {MAKE}") from None
        if told and STORE in str(error):  # it cannot be read either, for the package that does is missing, say
            raise InputError(told) from None
        raise
    if told and found.sweep is not None and not found.records:  # what an interrupted sweep has stored, and no more
        raise InputError(told)
    if told:
        note(told)
    return found


def unfinished(folder: Path) -> str:
    """What is begun in a folder and not finished, and how it goes on; "" where nothing is."""
    from ..sweeps.store import is_unfinished  # imports JAX, which a command without results is spared

    for what, (kept, results) in BEGUN.items():
        begun = is_unfinished(folder / STORE) if kept == STORE else any(folder.glob(kept))
        if begun and not any((folder / name).exists() for name in results):
            return f"{folder} holds an unfinished {what}: the command that began it, with --resume, goes on"
    return ""


def check_comparable(every: "Sequence[Results]") -> None:
    """Raise `InputError` unless all folders hold a run, or all a tuning; it says what each holds, and what to run."""
    if any(all(name in found.records for found in every) for name in ("run", "tuned")):
        return
    held = ", ".join(f"{found.folder} holds {_held(found)}" for found in every)
    runs = [
        f"jaxbuffer simulate {found.folder / 'design.toml' if found.tuned else 'STUDY.toml'} --output FOLDER"
        for found in every
        if "run" not in found.records
    ]
    raise InputError(
        f"nothing to compare: {held}; compare runs with runs or tunings with tunings;"
        f" a run is made by {' and '.join(dict.fromkeys(runs))}"
    )


def _held(found: "Results") -> str:
    held = [words for name, words in HELD.items() if name in found.records]
    held += ["a sweep"] if found.sweep is not None else []
    return " and ".join(held) or "a design alone"
