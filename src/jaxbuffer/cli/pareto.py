"""`jaxbuffer pareto`: the front of several objectives."""

import dataclasses
from typing import Annotated

import typer

from ..errors import InputError
from .exits import INTERRUPTED, LIMITS_BROKEN, OK, fail
from .request import CommandLine, given
from .scheduler import Scheduler
from .streams import note

Objectives = Annotated[
    str, typer.Option(metavar="A,B", help="Quantities to lower; the first under limits on the others.")
]
Points = Annotated[str, typer.Option(metavar="N", help="Points of the front, both ends included; default 9.")]
Number = Annotated[str | None, typer.Option(metavar="N", help="As for tune.")]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with the run in DIR, however it ended.")]


def pareto(
    request: CommandLine,
    objectives: Objectives,
    points: Points = "9",
    iterations: Number = None,
    starts: Number = None,
    seed: Number = None,
    scheduler: Scheduler = None,
    resume: Resume = False,
) -> int:
    """Find the front of two objectives or more: designs of which none is better than another in every objective.

    Each point is the least worst value of the first objective under limits on the others, tuned as `tune` does: over
    all scenarios, within bounds and [problem.constraints]. Its values are simulated again at rtol 1e-9, and
    its first-order residual tells what is left to gain. The [problem.objective] is put aside. --scheduler hands the
    scenarios to a Dask cluster, as for tune.

    \b
    Files in DIR:
      pareto.csv  objectives, limits, certificate and variables of each point
      pareto.png, .svg  the front
      pareto.txt  the table
      pareto.json  the same and how it came about, for jaxbuffer report
      design-1.toml, …  each point's design, a study for the other commands
      least-…, point-…  folders, kept up while running; --resume needs them

    \b
    Example: jaxbuffer pareto optimise/pareto.toml --objectives peak_force,stroke --points 9 --output results/front
    """
    from ..study.config import apply_options

    study = request.study()
    chosen = given(iterations=iterations, starts=starts, seed=seed)
    study = dataclasses.replace(study, tuning=apply_options(study.tuning, chosen))
    problem = study.problem()
    names = [name.strip() for name in objectives.split(",")]
    if not (points.isdecimal() and int(points) >= 2):
        raise InputError(f"--points {points} must be a whole number from 2 up; 9 say")
    number = int(points)
    from ..tuning.pareto import check_front
    from ..tuning.pareto import pareto as compute
    from .progress import tuning

    total = check_front(problem, names, number)
    designs = [f"design-{k + 1}.toml" for k in range(total)]
    folders = [f"least-{name}" for name in names] + [f"point-{k + 1}" for k in range(1, total)]
    files = request.files(
        "pareto.csv", "pareto.png", "pareto.txt", "pareto.json", *designs, resumable=folders, resume=resume
    )
    settings = vars(study.tuning)
    keeping = {"folder": request.output, "resume": resume, **given(client=scheduler)}
    try:
        front = tuning(
            lambda report: compute(
                problem, names, number, **settings, **keeping, save=False, report=report, finished=_said
            ),
            problem.mechanism.success,
        )
    except KeyboardInterrupt:
        kept = "nothing is kept without --output DIR"
        if request.output is not None:
            kept = f"the points so far are kept; the same command with --resume goes on in {request.output}"
        note(kept)
        return INTERRUPTED
    from ..output.formats import table_json
    from ..output.records import front_rows
    from ..output.results import front_files

    made = request.made(study, resume)
    files.save_and_show(lambda: front_files(front, made), front, lambda: table_json("points", *front_rows(front)))
    return OK if front.kept.any() else fail("no design was found that keeps to the limits", LIMITS_BROKEN)


def _said(done: int, total: int) -> None:
    note(f"{done} of {total} points of the front are done")
