"""`jaxbuffer sweep`: captures over a grid."""

import dataclasses
import json
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .exits import INTERRUPTED, OK, any_solved
from .request import CommandLine, Trust, asked_for, each_once
from .scheduler import LARGEST, Scheduler, check, computed
from .streams import note

if TYPE_CHECKING:
    from ..study.config import Config
    from ..sweeps.grid import Grid
    from ..tuning.objective import Limits

Over = Annotated[
    list[str] | None,
    typer.Option(
        metavar="FIELD=VALUES", help="Values of a field: FROM:TO:COUNT[:log] or A,B,…, numbers or choices; repeatable."
    ),
]


Resume = Annotated[bool, typer.Option("--resume", help="Go on with the sweep in DIR, however it ended.")]


def sweep(
    request: CommandLine, over: Over = None, scheduler: Scheduler = None, resume: Resume = False, trust: Trust = "on"
) -> int:
    """Simulate every combination of the values of some fields of the design and the scenario, on all cores.

    The grid is that of [sweep] in CONFIG.toml, with the fields of --over added or put in their place. Without either:
    approach speeds from 0.05 to 0.25 m/s by misalignments from -0.1 to 0.1 rad, 11 of each. A capture that fails is
    counted and named; it does not touch the others. Ctrl-C ends the sweep and saves what was done; --resume goes on,
    also after a kill.

    Each is run again at a tenth of the tolerance: those whose numbers may be off, or where little decides what
    happens, are counted, and marked in the column trust. --trust off takes half the time.

    --scheduler hands the captures to the workers of a Dask cluster, which store them in DIR/sweep.zarr as they are
    found; "processes" starts some on this machine. Tables and figures are made of up to 100 000 captures, larger sweeps
    are read from the store. It needs pip install 'jaxbuffer[cluster]'.

    \b
    In CONFIG.toml:
      [sweep]
      scenario.approach_speed = {from = 0.05, to = 0.3, count = 20}        # m/s
      buffer.k_A = {from = 100, to = 2000, count = 8, scale = "log"}       # N/m
      buffer.c_A = [2, 5, 10]                                              # N s/m
      contact.law = ["hertz", "lankarani-nikravesh"]

    \b
    Files in DIR:
      sweep.csv  a row for each capture: its values, outcome and results, units in the header
      sweep.png, .svg  over one field lines, over two heat maps, over more slices of heat maps
      envelope.png, .svg  over two fields: which runs keep every limit, and the largest rectangle of them
      sweep.json  how the runs ended, what is safe, how the sweep came about
      sweep.nc   the same as labelled arrays (netCDF), for xarray or jb.load
      sweep.txt  the summary, and what is safe
      sweep.zarr  kept up while running, all captures as labelled arrays for xarray; --resume needs it

    \b
    Examples:
      jaxbuffer sweep --over scenario.approach_speed=0.05:0.3:20
      jaxbuffer sweep --over scenario.approach_speed=0.05:0.3:20 --over contact.law=hertz,lankarani-nikravesh
      jaxbuffer sweep study.toml --over buffer.k_A=100:2000:30:log --over buffer.c_A=2,5,10 --output results/buffer
    """
    from ..output.results import swept_files, swept_json
    from ..sweeps.grid import check_swept_once
    from ..sweeps.grid import grid as made
    from ..sweeps.store import STORE

    study = request.study()
    if scheduler is not None:
        check(scheduler, request)
    asked = _asked(study, over or [])
    grid = made(asked, study.design, study.scenario, in_memory=scheduler is None)
    check_swept_once(request.fields, (axis.path for axis in grid.axes), "this sweep")
    told = scheduler is None or len(grid) <= LARGEST
    if told:
        grid.batches(study.design, study.scenario)  # checks that the values go together
    limits = _limits(study, grid) if told else None
    drawn = () if limits is None else ("envelope.png",)
    names = (*drawn, *(f"sweep.{kind}" for kind in ("csv", "png", "txt", "nc", "json"))) if told else ()
    files = request.files(*names, resumable=(STORE,), resume=resume)
    from ..sweeps.stored import StoredSweep
    from ..sweeps.sweep import sweep as compute

    options: dict[str, Any] = {"trust": asked_for(trust)} | ({} if scheduler is None else {"client": scheduler})
    found, interrupted = computed(compute, study, asked, len(grid), folder=request.output, resume=resume, **options)
    if isinstance(found, StoredSweep) and not told:
        files.save_and_show(dict, found, lambda: json.dumps(found.outcomes))
        return INTERRUPTED if interrupted else OK
    swept = found.load() if isinstance(found, StoredSweep) else found
    if not swept.done.any():
        return INTERRUPTED
    from ..experiments.rectangle import safe_rectangle

    envelope = None if limits is None else safe_rectangle(swept, limits, study.scenarios)
    shown = swept if envelope is None else f"{swept!r}\n{envelope!r}"
    about = request.made(study, resume)
    files.save_and_show(lambda: swept_files(swept, about, envelope), shown, lambda: swept_json(swept))
    return INTERRUPTED if interrupted else any_solved(swept)


def _asked(study: "Config", over: list[str]) -> dict[str, Any]:
    """The values of each field: those of the study, with those of the command line added or in their place."""
    from ..sweeps.grid import typed

    return {**study.sweep, **each_once(over, typed, "put its values into one")} or dict(study.mechanism.defaults.grid)


def _limits(study: "Config", over: "Grid") -> "Limits | None":
    """The limits of a sweep's envelope: the study's; None where there is no envelope."""
    from ..study.problem_toml import limits
    from ..tuning.objective import Limits

    mechanism = study.mechanism
    moving = [axis for axis in over.axes if len(axis) > 1]
    if len(moving) != 2 or not all(axis.unit for axis in moving):
        return None
    asked = limits(study.table, mechanism) if "constraints" in study.table else Limits()
    in_sweeps = lambda sides: {name: limit for name, limit in sides.items() if name in mechanism.swept}  # noqa: E731
    found = dataclasses.replace(asked, at_most=in_sweeps(asked.at_most), at_least=in_sweeps(asked.at_least))
    if left_out := [name for name in (*asked.at_most, *asked.at_least) if name not in mechanism.swept]:
        note(f"the envelope leaves limits on {', '.join(left_out)} out, which sweeps do not have")
    limited = found.at_most or found.at_least or found.impacts is not None
    return found if limited or mechanism.success is not None else None
