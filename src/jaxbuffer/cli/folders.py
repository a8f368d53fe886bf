"""Folders of results as `report` and `compare` take them: what is said of those that hold too little."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InputError
from .streams import note

if TYPE_CHECKING:
    from ..output.folder import Results

HELD = {"run": "a run", "tuned": "a tuning", "sensitivity": "derivatives", "sample": "a sample", "front": "a front"}


def loaded(folder: Path) -> "Results":
    """Return what a folder holds; a note on stderr says what in it is not finished."""
    from ..output.folder import load, unfinished

    results = load(folder)
    if begun := unfinished(folder):
        note(begun)
    return results


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
