"""`jaxbuffer sweep`: captures over a grid."""

from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import InputError
from .exits import INTERRUPTED, OK
from .request import Request
from .streams import note

if TYPE_CHECKING:
    from ..study.config import Config
    from ..sweeps.grid import Grid

Over = Annotated[
    list[str] | None,
    typer.Option(metavar="FIELD=VALUES", help="Values of a field: FROM:TO:COUNT[:log] or A,B,…; repeatable."),
]


Resume = Annotated[bool, typer.Option("--resume", help="Go on with the sweep in DIR, however it ended.")]


def sweep(request: Request, over: Over = None, resume: Resume = False) -> int:
    """Simulate every combination of the values of some fields of the design and the scenario, on all cores.

    The grid is that of [sweep] in CONFIG.toml, with the fields of --over added or put in their place. Without either:
    approach speeds from 0.05 to 0.25 m/s by misalignments from -0.1 to 0.1 rad, 11 of each. A capture that fails is
    counted and named; it does not touch the others. Ctrl-C ends the sweep and saves what was done; --resume goes on,
    also after a kill.

    \b
    In CONFIG.toml:
      [sweep]
      scenario.approach_speed = {from = 0.05, to = 0.3, count = 20}        # m/s
      buffer.k_A = {from = 100, to = 2000, count = 8, scale = "log"}       # N/m
      buffer.c_A = [2, 5, 10]                                              # N s/m

    \b
    Files in DIR:
      sweep.csv  a row for each capture: its values, outcome and results, units in the header
      sweep.npz  the same as NumPy arrays in the grid's shape; `jaxbuffer report DIR` reads it
      sweep.png  over one field lines, over two heat maps, over more slices of heat maps
      envelope.png, envelope.txt  over two fields: which runs keep every limit, and the largest rectangle of them
      sweep.chunks  kept up while running; --resume needs it

    \b
    Examples:
      jaxbuffer sweep --over scenario.approach_speed=0.05:0.3:20
      jaxbuffer sweep study.toml --over buffer.k_A=100:2000:30:log --over buffer.c_A=2,5,10 --output results/buffer
    """
    from ..output.formats import ARRAYS, ENVELOPE
    from ..output.sweep_files import FIGURE, TABLE
    from ..sweeps.grid import check_swept_once
    from ..sweeps.store import STORE

    study = request.study()
    grid = _grid(study, over or [])
    check_swept_once(request.fields, (axis.path for axis in grid.axes), "this sweep")
    design, scenarios = grid.applied(study.design, study.scenario)
    limits = _limits(study, grid)
    drawn = () if limits is None else ENVELOPE
    files = request.files(*drawn, TABLE, ARRAYS, FIGURE, resumable=(STORE,), resume=resume)
    import numpy as np

    from ..output.results import swept_files
    from ..sweeps.sweep import SweepInterrupted
    from ..sweeps.sweep import sweep as compute
    from ..sweeps.swept import Swept
    from .progress import sweeping

    options = study.options
    interrupted = False
    try:
        found = sweeping(
            len(grid),
            lambda report: compute(
                design,
                scenarios,
                options.duration,
                solver=options.stepper(),
                rtol=options.rtol,
                progress=report,
                folder=request.output,
                resume=resume,
            ),
        )
        done = np.ones(len(grid), bool)
    except SweepInterrupted as stop:
        found, done, interrupted = stop.found, stop.done, True
        if request.output is not None:
            told = f"{done.sum()} of {done.size} {study.mechanism.run_name}s are kept"
            note(f"{told}; the same command with --resume goes on in {request.output}")
        if not done.any():
            return INTERRUPTED
    swept = Swept(grid, study.design, study.scenario, found, done)
    if limits is None:
        files.save_and_show(lambda: swept_files(swept), swept)
    else:
        from ..experiments.rectangle import safe_rectangle

        envelope = safe_rectangle(swept, limits)
        files.save_and_show(lambda: swept_files(swept, envelope), f"{swept!r}\n{envelope!r}")
    return INTERRUPTED if interrupted else OK


def _grid(study: "Config", over: list[str]) -> "Grid":
    from ..sweeps.grid import grid, typed

    asked = dict(study.sweep)
    typed_in = [typed(text) for text in over]
    for path, values in typed_in:
        if sum(path == other for other, _ in typed_in) > 1:
            raise InputError(f"--over {path} is given more than once; put its values into one")
        asked[path] = values
    return grid(asked or study.mechanism.defaults.grid, study.design, study.scenario)


def _limits(study: "Config", over: "Grid") -> dict[str, float] | None:
    """The limits of a sweep's envelope: the problem's, or the mechanism's own; None where there is no envelope."""
    from ..study.problem_toml import read_limits

    mechanism = study.mechanism
    if sum(len(axis) > 1 for axis in over.axes) != 2:
        return None
    asked = read_limits(study.table, mechanism)
    limits = {name: limit for name, limit in asked.at_most.items() if name in mechanism.swept}
    if asked.impacts is not None:
        limits["impact_count"] = float(asked.impacts)
    return limits if limits or mechanism.success is not None else None
