"""`jaxbuffer sweep`: runs over a grid, and what `sample` shares with it."""

import dataclasses
from collections.abc import Mapping
from typing import Any

from ...cluster.extra import executor_at
from ...experiments.rectangle import safe_rectangle
from ...fields import get
from ...output.swept_files import swept_files, swept_json
from ...study.config import Config
from ...sweeps.axis import typed
from ...sweeps.columns import RunTable
from ...sweeps.grid import Grid
from ...sweeps.grid import grid as made
from ...sweeps.result import Sweep, SweepInterrupted
from ...sweeps.store import STORE
from ...sweeps.sweep import sweep as compute
from ...tuning.objective import Limits
from ..exits import INTERRUPTED, OK, fail
from ..streams import note
from .progress import sweeping
from .request import CommandLine, asked_for, check_swept_once, each_once, say_cautions


def sweep(request: CommandLine, over: list[str] | None, scheduler: str | None, resume: bool, trust: str) -> int:
    """Simulate every run of a grid, here or by the workers of a scheduler."""
    study = request.study()
    # The values of each field: those of the study, with those of the command line added or in their place.
    spans = {**study.sweep, **each_once(over or [], typed, "put its values into one")}
    spans = spans or dict(study.mechanism.defaults.grid)
    grid = made(spans, study.design, study.scenario)
    check_swept_once(request.fields, (axis.path for axis in grid.axes), "this sweep")
    varied = [axis.path for axis in grid.axes]
    say_cautions(study.design, (study.scenario,), varied, geometry=False, units=study.units)
    study = study.varying(varied)
    grid.batches(study.design, study.scenario)  # checks that the values go together
    limits = _limits(study, grid)
    drawn = () if limits is None else ("envelope.png",)
    names = (*drawn, *(f"sweep.{kind}" for kind in ("csv", "png", "txt", "nc", "json")))
    files = request.files(*names, resumable=(STORE,), resume=resume)
    with executor_at(scheduler) as (executor, workers):
        keeping = {"folder": request.output, "resume": resume, "trust": asked_for(trust)}
        swept, interrupted = _computed(study, spans, len(grid), executor=executor, workers=workers, **keeping)
    # Interrupted before its first run: there is nothing to save.
    if not swept.done.any():
        return INTERRUPTED
    envelope = None if limits is None else safe_rectangle(swept, limits, study.scenarios)
    shown = swept if envelope is None else f"{swept!r}\n{envelope!r}"
    about = request.made(study, resume)
    files.save_and_show(lambda: swept_files(swept, about, envelope), shown, lambda: swept_json(swept))
    return INTERRUPTED if interrupted else any_solved(swept)


def _limits(study: Config, over: Grid) -> Limits | None:
    """Return the study's limits for a sweep's envelope; None where there is no envelope."""
    mechanism = study.mechanism
    of_study = study.table.constraints or Limits()
    varied = {axis.path for axis in over.axes}
    own = study.table.quantities or ()
    of_study.check(mechanism, lambda path: path in varied or get(study.design, path), own)
    moving = [axis for axis in over.axes if len(axis) > 1]
    if len(moving) != 2 or not all(axis.unit for axis in moving):
        return None
    in_sweeps = lambda sides: {name: limit for name, limit in sides.items() if name in mechanism.swept}  # noqa: E731
    usable = dataclasses.replace(of_study, at_most=in_sweeps(of_study.at_most), at_least=in_sweeps(of_study.at_least))
    if left_out := [name for name in of_study.names if name not in mechanism.swept]:
        note(f"the envelope leaves limits on {', '.join(left_out)} out, which sweeps do not have")
    limited = usable.at_most or usable.at_least or usable.impacts is not None
    return usable if limited or mechanism.success is not None else None


def _computed(study: Config, spans: Mapping[str, Any], count: int, **options: Any) -> tuple[Sweep, bool]:
    """Compute a sweep, and return it and whether it was interrupted."""
    usual = study.options
    settings = {"over": spans, "solver": usual.stepper(), "rtol": usual.rtol, "save": False, **options}
    swept = study.design, study.scenario, usual.duration
    try:
        return sweeping(count, lambda report: compute(*swept, progress=report, **settings)), False
    except SweepInterrupted as stop:
        return resumable(stop, options["folder"]), True


def resumable(stop: SweepInterrupted, folder: Any) -> Any:
    """Say how many runs of an interrupted sweep or sample are in its folder, if it has one, and return them."""
    if folder is not None:
        line = f"{int(stop.done.sum())} of {stop.done.size} {stop.partial.mechanism.view.run_name}s are kept"
        note(f"{line}; the same command with --resume goes on in {folder}")
    return stop.partial


def any_solved(runs: RunTable) -> int:
    """Return the exit code of many runs: `FAILED`, with a line that says so, where not one of them was solved."""
    if runs.solved.any():
        return OK
    return fail(f"none of the {int(runs.done.sum())} {runs.mechanism.view.run_name}s was solved; the outcomes say why")
