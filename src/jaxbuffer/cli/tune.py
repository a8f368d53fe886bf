"""`jaxbuffer tune`: the best design, or the best one so far of an interrupted search."""

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .exits import INTERRUPTED, LIMITS_BROKEN, OK, fail
from .request import CommandLine, given
from .scheduler import Scheduler
from .streams import note

if TYPE_CHECKING:
    from ..tuning import Problem
    from .output import Output


RUN_FILES = ("log.jsonl", "state.npz", "state.old.npz")  # of a tuning, which `tuning.store` keeps


def tune(
    request: CommandLine,
    iterations: Annotated[str | None, typer.Option(metavar="N", help="Steps of a search at most; default 40.")] = None,
    starts: Annotated[str | None, typer.Option(metavar="N", help="Designs screened in a round; default 32.")] = None,
    seed: Annotated[str | None, typer.Option(metavar="N", help="Of the starts' sample; default 0.")] = None,
    scheduler: Scheduler = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on with the run in DIR, however it ended.")] = False,
) -> int:
    """Tune the fields in [problem.variables] for the [problem.objective] over all scenarios.

    Stays within bounds and [problem.constraints]; a start that breaks them is led back first. Without a
    [problem]: the worst peak contact force, stroke at most 25 mm, by k_A, c_A, k_T, c_T and the tip mass.

    \b
    Files in DIR:
      design.toml  the tuned design, a study for the other commands
      tuned.json   result, floor, evidence, every scenario before and after
      history.csv  objective, worst values and variables of each evaluation
      force.json   force over time in the worst scenario, before and after
      tune.png, .svg  the worst scenario before and after, every scenario, variables, search
      tune.txt     the tables
      log.jsonl, state.npz, state.old.npz  kept up while running; --resume needs them

    Ctrl-C saves the best design so far. --scheduler hands the scenarios to a Dask cluster; the search stays here.

    \b
    Example: jaxbuffer tune optimise/table2.toml --output results/table2
    """
    from ..study.config import apply_options
    from ..sweeps.grid import check_swept_once

    study = request.study()
    chosen = given(iterations=iterations, starts=starts, seed=seed)
    study = dataclasses.replace(study, tuning=apply_options(study.tuning, chosen))
    check_swept_once(request.fields, (f"scenario.{name}" for name in study.table.get("grid", {})), "[problem.grid]")
    problem = study.problem()
    names = ("design.toml", "tuned.json", "history.csv", "force.json", "tune.png", "tune.txt")
    files = request.files(*names, resumable=RUN_FILES, resume=resume)
    from ..tuning.tune import tune as compute
    from .progress import tuning

    settings = vars(study.tuning)
    keeping = {"folder": request.output, "resume": resume, **given(client=scheduler)}
    try:
        tuned = tuning(
            lambda report: compute(problem, **settings, **keeping, report=report, save=False),
            problem.mechanism.success,
            study.tuning.most_evaluations * (1 if problem.then is None else 2),
        )
    except KeyboardInterrupt:
        from .tune import keep_best

        return keep_best(problem, settings, files)
    from ..output.results import tuned_files

    contents = tuned_files(tuned, request.made(study, resume), note)
    files.save_and_show(lambda: contents, tuned, lambda: str(contents["tuned.json"]()))
    return OK if tuned.feasible else fail(tuned.message, LIMITS_BROKEN)


def keep_best(problem: "Problem", settings: Mapping[str, Any], files: "Output") -> int:
    """Save the best design that the search has found, as far as its folder knows."""
    if files.folder is None:
        note("nothing is kept without --output DIR")
        return INTERRUPTED
    from ..errors import InputError
    from ..study.designs import tuned_toml
    from ..tuning.store import objective_in_words
    from ..tuning.tune import best_so_far

    try:
        best = best_so_far(problem, files.folder, **settings)
    except InputError:  # before the run had taken the folder
        return INTERRUPTED
    if best is None:
        note(f"no step was finished; the same command with --resume goes on in {files.folder}")
        return INTERRUPTED
    which = "the problem's then" if best.stage else "the objective"
    kept = "within all limits" if best.feasible else "limits broken"
    value = objective_in_words(best.objective, best.unit, 6)
    words = f"interrupted after {best.evaluations} evaluations; best so far by {which}: {value}, {kept}"
    files.save_and_show(lambda: {"design.toml": lambda: tuned_toml(best.design, problem, words)}, words)
    note(f"the same command with --resume goes on in {files.folder}")
    return INTERRUPTED
