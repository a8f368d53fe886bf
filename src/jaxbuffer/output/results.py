"""`save`: a result of any kind written into a folder."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..choosing.choice import Choice
from ..errors import InputError, check_choice
from ..experiments.sample import Sample
from ..files import Lock, user_path
from ..fitting.fitted import Fitted
from ..mechanisms.run import Run
from ..sensitivities.result import Sensitivity
from ..sweeps.result import Sweep
from ..tuning.report.front import Front
from ..tuning.report.tuned import Tuned
from . import formats, style
from .choice_files import choice_files
from .companions import stale
from .fit_files import fit_files
from .formats import Contents
from .provenance import made_in_python
from .run_files import run_files, sensitivity_files
from .swept_files import sample_files, swept_files
from .tuned_files import front_files, tuned_files

OF_FIGURES = ("force.json", "motion.json")  # what a page draws itself, for which runs are evaluated again

KINDS: dict[type, Callable[..., Contents]] = {
    Run: run_files,
    Sensitivity: sensitivity_files,
    Sweep: swept_files,
    Sample: sample_files,
    Tuned: tuned_files,
    Front: front_files,
    Choice: choice_files,
    Fitted: fit_files,
}


def save(
    result: Run | Sensitivity | Sweep | Sample | Tuned | Front | Choice | Fitted,
    folder: str | Path,
    *,
    force: bool = False,
    figures: bool = True,
    format: str = "png",
    **beside: Any,
) -> tuple[Path, ...]:
    """Write a result into a folder, as the command of its kind does: what `load` and `report` read.

    ``result.save(folder)`` is the same.

    **Arguments:**

    - ``result``: of `simulate`, `sensitivity`, `sweep`, `sample`, `tune`, `pareto` or `choose`. A run is drawn where it
      has a history.
    - ``folder``: made if it is not there.
    - ``force``: whether to replace files that are there; those of an earlier result of the same kind are removed.
    - ``figures``: whether to draw; without, the force over time of a tuning is left out too, which takes two runs.
    - ``format``: of the figures: "png", "svg" or "both".
    - ``beside``: what was computed from it: ``trust`` of a run, ``envelope`` (a `SafeRectangle`) of a sweep,
      ``indices`` and ``surfaces`` of a sample.

    **Returns:** the files' paths.

    **Raises:** `InputError` for files that are there, a folder in use, runs that failed, and what is no result.

    **Example:**

    >>> import tempfile
    >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in jb.save(run, folder)], jb.load(folder).run.outcome
    (['drop.json', 'drop.txt', 'drop.nc', 'drop.mat'], 'finished')
    """
    folder = user_path(folder)
    check_choice("format", format, ("png", "svg", "both"))
    contents = formats.with_figures(_contents(result, beside), format)
    if not figures:
        contents = {name: it for name, it in contents.items() if not (formats.is_figure(name) or name in OF_FIGURES)}
    if any(map(formats.is_figure, contents)):
        # Said before anything is written, not when figures are drawn at the end.
        style.require_matplotlib()
    formats.check_folder(folder)
    formats.check_free(folder, [*sorted(contents), *(path.name for path in stale(folder, contents))], force)
    lock = Lock(folder)
    try:
        written, failure = formats.write_all(folder, contents, force)
    finally:
        lock.release()
    if failure is not None:
        raise failure
    return tuple(written)


def _contents(result: Any, beside: Mapping[str, Any]) -> Contents:
    """Return the files of any result. **Raises:** `InputError` for what is none, or has failed."""
    files = next((files for kind, files in KINDS.items() if isinstance(result, kind)), None)
    if files is None:
        raise InputError(
            f"save: expected a result of simulate, sensitivity, sweep, sample, tune, pareto, choose or fit; found a"
            f" {type(result).__name__}"
        )
    run = result.run if isinstance(result, Sensitivity) else result
    if isinstance(run, Run) and run._many:
        raise InputError("save takes one run that is solved, not a batch or a traced one; sweep many with jb.sweep")
    if isinstance(run, Run) and run.outcome.failed:
        raise InputError(f"save: the {run.mechanism.view.run_name} failed, {run.outcome.reason}")
    return files(result, made_in_python(), **beside)
