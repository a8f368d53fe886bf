"""`jaxbuffer sweep`: runs over a grid."""

import dataclasses
from functools import partial

from ...experiments.rectangle import safe_rectangle
from ...fields import get
from ...output.swept_files import swept_files, swept_json
from ...study.config import Config
from ...sweeps.axis import typed
from ...sweeps.grid import Grid
from ...sweeps.grid import grid as made
from ...sweeps.store import STORE
from ...sweeps.sweep import sweep as compute
from ...tuning.problem.objective import Limits
from ..exits import INTERRUPTED
from ..streams import note
from .request import CommandLine, each_once
from .runs import any_solved, computed_runs


def sweep(request: CommandLine, over: list[str] | None, scheduler: str | None, resume: bool, trust: str) -> int:
    """Simulate every run of a grid, here or by the workers of a scheduler."""
    study = request.study()
    # The values of each field: those of the study, with those of the command line added or in their place.
    spans = {**study.sweep, **each_once(over or [], typed, "put its values into one")}
    spans = spans or dict(study.mechanism.defaults.grid)
    grid = made(spans, study.design, study.scenario)
    study = request.varying(study, [axis.path for axis in grid.axes], "this sweep")
    grid.batches(study.design, study.scenario)  # checks that the values go together
    limits = _limits(study, grid)
    drawn = () if limits is None else ("envelope.png",)
    names = (*drawn, *(f"sweep.{kind}" for kind in ("csv", "png", "txt", "nc", "json")))
    files = request.files(*names, resumable=(STORE,), resume=resume)
    # The command writes the files itself, because `save` would write them without figures.
    work = partial(compute, study.design, study.scenario, study.options.duration, over=spans, save=False)
    swept, interrupted = computed_runs(work, len(grid), request, study, scheduler=scheduler, resume=resume, trust=trust)
    # Interrupted before its first run: there is nothing to save.
    if not swept.done.any():
        return INTERRUPTED
    envelope = None if limits is None else safe_rectangle(swept, limits, [scenario for _, scenario in study.runs])
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
    # A rectangle has two sides, each along numbers: choices have no order.
    if len(moving) != 2 or not all(axis.unit for axis in moving):
        return None
    in_sweeps = lambda sides: {name: limit for name, limit in sides.items() if name in mechanism.swept}  # noqa: E731
    usable = dataclasses.replace(of_study, at_most=in_sweeps(of_study.at_most), at_least=in_sweeps(of_study.at_least))
    if left_out := [name for name in of_study.names if name not in mechanism.swept]:
        note(f"the envelope leaves limits on {', '.join(left_out)} out, which sweeps do not have")
    limited = usable.at_most or usable.at_least or usable.impacts is not None
    return usable if limited or mechanism.success is not None else None
