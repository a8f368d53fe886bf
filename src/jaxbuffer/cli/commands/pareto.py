"""`jaxbuffer pareto`: the front of several objectives."""

from typing import Any

from ...cluster.extra import executor_at
from ...errors import InputError
from ...output.formats import table_json
from ...output.tuned_files import front_files
from ...output.tuned_records import front_rows
from ...tuning.pareto import check_front, two_objectives
from ...tuning.pareto import pareto as compute
from ..exits import LIMITS_BROKEN, OK, fail, interrupted
from ..streams import note
from .progress import tuning
from .request import CommandLine, tuned_problem


def pareto(
    request: CommandLine, objectives: str | None, points: str, scheduler: str | None, resume: bool, **search: str | None
) -> int:
    """Tune every point of the front."""
    study = request.tuning_study(**search)
    for field, value, only in (
        ("options.solver", study.options.solver, "automatic"),
        ("tune.optimizer", study.tuning.optimizer, "quadratic"),
    ):
        if value != only:
            raise InputError(f"{field} = {value!r}: a front has the {only} one only; leave it out")
    problem = tuned_problem(study)
    if objectives is None:
        raise InputError(f"--objectives is missing; write --objectives {two_objectives(problem)}")
    names = [name.strip() for name in objectives.split(",")]
    if not (points.isdecimal() and int(points) >= 2):
        raise InputError(f"--points {points} must be a whole number from 2 up; 9 say")
    number = int(points)
    total = check_front(problem, names, number)
    designs = [f"design-{k + 1}.toml" for k in range(total)]
    folders = [f"least-{name}" for name in names] + [f"point-{k + 1}" for k in range(1, total)]
    files = request.files(
        "pareto.csv", "pareto.png", "pareto.txt", "pareto.json", *designs, resumable=folders, resume=resume
    )
    settings = vars(study.tuning)
    report = lambda done, total: note(f"{done} of {total} points of the front are done")  # noqa: E731
    keeping: dict[str, Any] = {"folder": request.output, "resume": resume, "save": False, "finished": report}
    try:
        with executor_at(scheduler) as (executor, _):
            front = tuning(
                lambda report: compute(problem, names, number, **settings, **keeping, executor=executor, report=report),
                problem.success,
            )
    except KeyboardInterrupt:
        return interrupted(request.output, "the points so far are kept")
    made = request.made(study, resume)
    files.save_and_show(lambda: front_files(front, made), front, lambda: table_json("points", *front_rows(front)))
    return OK if front.non_dominated.any() else fail("no design was found that keeps to the limits", LIMITS_BROKEN)
