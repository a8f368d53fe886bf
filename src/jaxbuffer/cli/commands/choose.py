"""`jaxbuffer choose`: the best parts of catalogues, or the best values that can be built near a tuned design."""

import dataclasses
from collections.abc import Callable
from typing import Any

from ...choosing.buildable import check_roundings, continuous_design, rounded
from ...choosing.choice import Choice
from ...choosing.choose import ranked, selection, with_levers, with_optimum, with_tuned
from ...choosing.means import OPTIMUM, TUNED, Means
from ...choosing.store import FOLDER
from ...cluster.extra import executor_at
from ...errors import InputError
from ...fields import declared
from ...output.choice_files import choice_design, choice_files
from ...study.config import Config
from ...study.overrides import apply_options
from ...tuning.problem.settings import Settings
from ..exits import LIMITS_BROKEN, OK, fail, interrupted
from .levers import LEFT_OUT, find_levers
from .progress import sweeping, tuning
from .request import CommandLine, asked_for, given, say_cautions

EMPTY = "the study has no [parts] and no [roundings]; 'jaxbuffer choose --help' shows both"


def choose(
    request: CommandLine,
    ranking: str | None,
    tuned: str | None,
    optimum: str | None,
    scheduler: str | None,
    resume: bool,
    levers: str,
) -> int:
    """Choose parts or roundings, and save the ranking."""
    moved, left_out = asked_for(levers, "levers"), False
    study, options = request.study(), given(ranking=ranking, tuned=tuned, optimum=optimum)
    study = dataclasses.replace(study, choosing=apply_options(study.choosing, options))
    if not study.parts and not study.roundings:
        raise InputError(EMPTY)
    if study.parts and study.roundings:
        raise InputError("[parts] and [roundings] both say what to choose from; keep one")
    say_cautions(study.runs, {path for it in study.parts for path in it.paths}, units=study.units)
    chosen = _parts if study.parts else _roundings
    work = chosen(study)
    folders = (FOLDER, OPTIMUM, *(f"{TUNED}-{k + 1}" for k in range(study.choosing.tuned)))
    names = ("design.toml", "design.mat", "choice.json", "choice.csv", "choice.png", "choice.txt")
    files = request.files(*names, resumable=folders, resume=resume)
    # Where [tune] is as by default, the tunings beside a choice have quicker settings (`means.QUICK`).
    settings = {name: getattr(study.tuning, name) for name in declared(Settings)} if study.tuning != Settings() else {}
    try:
        with executor_at(scheduler) as (executor, _):
            means = Means(request.output, resume, executor=executor, solver=study.options.solver, settings=settings)
            choice = work(means)
            if moved:
                files.keep("design.toml", choice_design(choice))
                choice, left_out = find_levers(choice, lambda it: with_levers(it, means))
    except KeyboardInterrupt:
        return interrupted(request.output, "the runs so far are kept")
    contents = choice_files(choice, request.made(study, resume))
    files.save_record(contents, choice, "choice.json")
    if left_out:
        return interrupted(request.output, LEFT_OUT)
    return OK if choice.feasible else fail(choice.message, LIMITS_BROKEN)


def _parts(study: Config) -> Callable[[Means], Choice]:
    """Return the choice of parts of a study, which is checked now."""
    told, settings = study.selection(), study.choosing
    criterion, combinations = selection(told.problem, study.parts, told.objective, told.at_most, told.then)
    # Said now, and not after all combinations have been run.
    if settings.tuned:
        told.problem.check_tunable()

    def work(means: Means) -> Choice:
        choice = sweeping(
            len(combinations) * len(criterion.problem.cases),
            lambda progress: ranked(criterion, combinations, _shown(means, progress), settings.ranking),
            f"choosing among {len(combinations)} combinations:",
            f"{criterion.problem.mechanism.view.run_name}s",
        )
        steps: list[Callable[[Choice, Means], Choice]] = [with_optimum] if settings.optimum else []
        if settings.tuned:
            steps.append(lambda it, by: with_tuned(it, settings.tuned, by))
        for step in steps:
            choice = _tuned(choice, means, step)
        return choice

    return work


def _roundings(study: Config) -> Callable[[Means], Choice]:
    """Return the choice of roundings of a study, which is checked now."""
    problem = study.selection().problem
    problem.check_tunable()
    for path in study.roundings:
        if path not in problem.paths:
            raise InputError(f"roundings.{path} is none of the variables, {', '.join(problem.paths)}: it is not tuned")
    check_roundings(problem, study.roundings)

    def work(means: Means) -> Choice:
        report = lambda by: continuous_design(problem, dataclasses.replace(means, report=by))  # noqa: E731
        design = tuning(report, problem.success)
        return sweeping(
            1,
            lambda progress: rounded(problem, study.roundings, design, _shown(means, progress), study.choosing.ranking),
        )

    return work


def _shown(means: Means, progress: Callable[[int, int], None]) -> Means:
    return dataclasses.replace(means, progress=progress)


def _tuned(choice: Choice, means: Means, step: Callable[[Choice, Means], Choice]) -> Choice:
    """Tune beside a choice, with a line for each evaluation."""

    def work(report: Any) -> Choice:
        return step(choice, dataclasses.replace(means, report=report))

    return tuning(work, choice.problem.success)
