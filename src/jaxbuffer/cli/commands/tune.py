"""`jaxbuffer tune`: the best design, or the best one so far of an interrupted search."""

from collections.abc import Mapping
from typing import Any

from ...cluster.extra import executor_at
from ...errors import InputError
from ...fields import as_displayed
from ...output.tuned_files import tuned_design, tuned_files
from ...study.tuned_toml import tuned_toml
from ...tuning import Problem
from ...tuning.assessment import with_levers
from ...tuning.problem.cases import grid_address
from ...tuning.tune import best_so_far
from ...tuning.tune import tune_with as compute
from ...value_text import with_unit
from ..exits import INTERRUPTED, LIMITS_BROKEN, OK, fail, interrupted
from ..streams import note
from .levers import LEFT_OUT, find_levers
from .output import Output
from .progress import tuning
from .request import CommandLine, asked_for, check_swept_once, tuned_problem

RUN_FILES = ("log.jsonl", "state.npz", "state.old.npz")  # of a tuning, which `tuning.store` keeps


def tune(request: CommandLine, scheduler: str | None, resume: bool, levers: str, **search: str | None) -> int:
    """Search for the best design, and save it or, if interrupted, the best one so far."""
    moved, left_out = asked_for(levers, "levers"), False
    study = request.tuning_study(**search)
    check_swept_once(request.fields, map(grid_address, study.table.grid or ()), "[problem.grid]")
    problem = tuned_problem(study)
    names = ("design.toml", "design.mat", "tuned.json", "history.csv", "force.json", "tune.png", "tune.txt")
    files = request.files(*names, resumable=RUN_FILES, resume=resume)
    settings = {**vars(study.tuning), "solver": study.options.solver}
    keeping: dict[str, Any] = {"folder": request.output, "resume": resume}
    try:
        with executor_at(scheduler) as (executor, _):
            tuned = tuning(
                lambda report: compute(
                    problem,
                    lambda first: files.keep("design.toml", tuned_design(first)),
                    **settings,
                    **keeping,
                    executor=executor,
                    report=report,
                ),
                problem.success,
                # How often the search begins anew for corners that it finds is not known before.
                None if problem.needs_search else study.tuning.most_evaluations * (1 if problem.then is None else 2),
            )
            if moved:
                tuned, left_out = find_levers(tuned, lambda it: with_levers(it, None, executor, study.options.solver))
    except KeyboardInterrupt:
        return keep_best(problem, settings, files)
    contents = tuned_files(tuned, request.made(study, resume), note)
    files.save_record(contents, tuned, "tuned.json")
    if left_out:
        return interrupted(request.output, LEFT_OUT)
    return OK if tuned.feasible else fail(tuned.message, LIMITS_BROKEN)


def keep_best(problem: Problem, settings: Mapping[str, Any], files: Output) -> int:
    """Save the best design that the search has found, as far as its folder knows."""
    # Designs are read back from the folder's log: without one none is left to save.
    if files.folder is None:
        return interrupted(None)
    try:
        best = best_so_far(problem, files.folder, **settings)
    except InputError:  # before the run had taken the folder
        return INTERRUPTED
    if best is None:
        return interrupted(files.folder, "no step was finished")
    which = "the problem's then" if best.stage else "the objective"
    verdict = "within all limits"
    if not best.feasible:
        # A smaller objective may be farther beyond a limit.
        which, verdict = f"{which} and limits", f"limits broken: {best.obstacle}"
    value = with_unit(*as_displayed(best.objective, best.unit))
    words = f"interrupted after {best.evaluations} evaluations; best so far by {which}: {value}, {verdict}"
    files.save_and_show(lambda: {"design.toml": lambda: tuned_toml(best.design, problem, words)}, words)
    return interrupted(files.folder)
