"""What an interrupted `jaxbuffer tune` leaves: its best design so far, and how to go on."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from .exits import INTERRUPTED
from .streams import note

if TYPE_CHECKING:
    from ..tuning import Problem
    from .output import Output


def keep_best(problem: "Problem", settings: Mapping[str, Any], files: "Output") -> int:
    """Save the best design that the search has found, as far as its folder knows."""
    if files.folder is None:
        note("nothing is kept without --output DIR")
        return INTERRUPTED
    from ..errors import InputError
    from ..study.designs import tuned_toml
    from ..tuning.store import objective_in_words
    from ..tuning.tune import best_so_far

    try:
        best = best_so_far(problem, files.folder, **settings)
    except InputError:  # before the run had taken the folder
        return INTERRUPTED
    if best is None:
        note(f"no step was finished; the same command with --resume goes on in {files.folder}")
        return INTERRUPTED
    which = "the problem's then" if best.stage else "the objective"
    kept = "within all limits" if best.feasible else "limits broken"
    value = objective_in_words(best.objective, best.unit, 6)
    words = f"interrupted after {best.evaluations} evaluations; best so far by {which}: {value}, {kept}"
    files.save_and_show(lambda: {"design.toml": lambda: tuned_toml(best.design, problem, words)}, words)
    note(f"the same command with --resume goes on in {files.folder}")
    return INTERRUPTED
