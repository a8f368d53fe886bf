"""What `jaxbuffer sweep` and `jaxbuffer sample` share: many runs, with a bar, as far as they came."""

from collections.abc import Callable
from typing import TypeVar

from ...cluster.extra import executor_at
from ...study.config import Config
from ...sweeps.columns import RunTable
from ...sweeps.result import SweepInterrupted
from ..exits import OK, fail, goes_on
from ..streams import note
from .progress import sweeping
from .request import CommandLine, asked_for

T = TypeVar("T", bound=RunTable)


def computed_runs(
    work: Callable[..., T],
    count: int,
    request: CommandLine,
    study: Config,
    *,
    scheduler: str | None,
    resume: bool,
    trust: str,
) -> tuple[T, bool]:
    """Compute ``count`` runs as the command line and the study say, here or by the workers of a scheduler; ``work``
    takes the options of `jaxbuffer.sweep`. Return them as far as they came, and whether they were interrupted."""
    usual, folder = study.options, request.output
    # Whether files that are there may be replaced was said by the command line, before anything is computed.
    options = {"solver": usual.stepper(), "rtol": usual.rtol, "folder": folder, "force": not resume, "resume": resume}
    options["trust"] = asked_for(trust)
    with executor_at(scheduler) as (executor, workers):
        options |= {"executor": executor, "workers": workers}
        try:
            return sweeping(count, lambda report: work(progress=report, **options)), False
        except SweepInterrupted as stop:
            if folder is not None:
                runs = f"{stop.partial.mechanism.view.run_name}s"
                note(goes_on(folder, f"{int(stop.done.sum())} of {stop.done.size} {runs} are kept"))
            return stop.partial, True


def any_solved(runs: RunTable) -> int:
    """Return the exit code of many runs: `FAILED`, with a line that says so, where not one of them was solved."""
    if runs.solved.any():
        return OK
    return fail(f"none of the {int(runs.done.sum())} {runs.mechanism.view.run_name}s was solved; the outcomes say why")
