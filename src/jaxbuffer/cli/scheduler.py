"""Sweeps over a scheduler: its option, and what comes back."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import InputError
from .request import CommandLine
from .streams import note

if TYPE_CHECKING:
    from ..study.config import Config
    from ..sweeps.result import Sweep
    from ..sweeps.stored import StoredSweep

LARGEST = 100_000  # runs of a sweep over a scheduler up to which tables and figures are made as well

Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="WHERE",
        help="Over Dask: local (threads), processes, or an address as tcp://HOST:8786; see docs/clusters.md.",
        show_default=False,
    ),
]


def check(scheduler: str, request: CommandLine) -> None:
    """Raise `InputError` where the extra's packages or a folder for the store are missing."""
    from ..cluster.connect import require

    require()
    if request.output is None:
        raise InputError("--scheduler needs --output DIR, where its workers store what they find")


def computed(
    compute: "Callable[..., Sweep | StoredSweep]", study: "Config", asked: Mapping[str, Any], count: int, **options: Any
) -> "tuple[Sweep | StoredSweep, bool]":
    """A sweep, in memory or stored by workers, and whether it was interrupted."""
    from ..sweeps.result import SweepInterrupted
    from ..sweeps.stored import StoredInterrupted
    from .progress import sweeping

    given = study.options
    settings = {"over": asked, "solver": given.stepper(), "rtol": given.rtol, "save": False, **options}
    swept = study.design, study.scenario, given.duration
    try:
        return sweeping(count, lambda report: compute(*swept, progress=report, **settings)), False
    except SweepInterrupted as stop:
        kept(stop.found, int(stop.done.sum()), stop.done.size, options["folder"])
        return stop.found, True
    except StoredInterrupted as stop:
        kept(stop.found, stop.found.done, stop.found.count, options["folder"])
        return stop.found, True


def kept(found: Any, done: int, count: int, folder: Any) -> None:
    """Say how many runs of an interrupted sweep or sample are in its folder, if it has one."""
    if folder is not None:
        told = f"{done} of {count} {found.mechanism.view.run_name}s are kept"
        note(f"{told}; the same command with --resume goes on in {folder}")
