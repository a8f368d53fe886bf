"""`buildable`: the best values that can be built near those of a continuous design, and what rounding costs."""

import dataclasses
import shutil
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from ..cluster.pool import Pool
from ..errors import InputError, check_flag, check_type, check_whole
from ..fields import Part, check_path, get
from ..hybrid import Solver
from ..progress import counted
from ..tuning.problem.problem import Problem
from ..tuning.search.store import Record
from ..tuning.tune import tune
from .alternatives import alternatives
from .catalogue import CataloguePart, PartsCatalogue
from .choice import Choice
from .choose import EXAMPLE, ranked, save_with_levers
from .combinations import Combinations
from .criterion import Criterion, check_obeyed
from .means import OPTIMUM, Means
from .runs import Runs
from .series import check_rule, rounded_catalogues
from .store import FOLDER


def buildable(
    problem: Problem,
    roundings: Mapping[str, Any],
    design: Part | None = None,
    *,
    ranking: int = 5,
    solver: Solver | str | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    report: Callable[[Record], None] | None = None,
    save: bool = True,
    levers: bool = False,
    **settings: Any,
) -> Choice:
    """Round numbers of a continuous design to values that can be built: the best of those next to each.

    All combinations of the two values below and above each number are compared over all load cases; with many numbers,
    of one below and above.

    **Arguments:**

    - ``problem``: load cases, objective and limits.
    - ``roundings``: by path, an E series ("E3" to "E96") or a step ("5 N/m").
    - ``design``: what is rounded, such as ``tuned.design``; None: the problem is tuned first, with the ``settings``.
    - Others as for `choose`.

    **Returns:** a `Choice` that says what rounding costs; a part is a value there.

    **Raises:** `InputError` for what is no number of the design or no rounding, and a number that scenarios list or
    that has no allowed value beside it.

    **Example:**

    >>> problem = jb.Problem(jb.table2(), [jb.Scenario()], [])
    >>> choice = jb.buildable(problem, {"buffer.k_A": "E6"}, jb.replace(jb.table2(), {"buffer.k_A": 520.0}))
    >>> choice.best.names, choice.nearest.names
    (('470 N/m',), ('470 N/m',))
    """
    check_type("problem", problem, Problem, EXAMPLE)
    rules = checked_rules(roundings, problem.design)
    check_roundings(problem, rules)
    check_whole("ranking", ranking, 1)
    check_flag("levers", levers)
    shown = counted(progress, problem.mechanism.view.run_name)
    means = Means(folder, resume, workers, executor, solver, shown, report, settings)
    choice = rounded(problem, rules, continuous_design(problem, means) if design is None else design, means, ranking)
    return save_with_levers(choice, means, save, levers)


def checked_rules(roundings: Mapping[str, Any], design: Part) -> dict[str, str | float]:
    """Return the rounding rule of each path. **Raises:** `InputError` as `buildable`."""
    if not isinstance(roundings, Mapping) or not roundings:
        raise InputError('roundings is empty; name a field and its series, such as {"buffer.k_A": "E24"}')
    for path in roundings:
        check_path(design, path)
    return {path: check_rule(f"roundings.{path}", path, it, design) for path, it in roundings.items()}


def check_roundings(problem: Problem, paths: Iterable[str]) -> None:
    """Raise `InputError`, ahead of any tuning, for what the choice of roundings of these numbers cannot obey."""
    check_obeyed(problem, {path: f"roundings.{path}" for path in paths})


def continuous_design(problem: Problem, means: Means) -> Part:
    """Tune the problem, for a design to round."""
    if means.path is not None and not means.resume:
        shutil.rmtree(means.path / FOLDER, ignore_errors=True)  # an earlier choice's, with which none goes on
    return tune(problem, **means.tuning(OPTIMUM)).design


def rounded(problem: Problem, rules: Mapping[str, str | float], design: Part, means: Means, ranking: int) -> Choice:
    """Choose among the buildable values beside a design's numbers; ``rules``: as of `checked_rules`."""
    numbers = {path: float(get(design, path)) for path in rules}
    # Without variables, because a rounded value may lie beyond their bounds, where a problem accepts no design.
    problem = dataclasses.replace(problem, design=design, variables=())
    catalogues, places = rounded_catalogues(problem, numbers, rules)
    combinations = Combinations(design, catalogues)
    criterion = Criterion.of(problem, None, None, combinations)
    # The nearest values are run in any event: the result says what plain rounding costs beside the best one.
    choice = ranked(criterion, combinations, means, ranking, (combinations.number(places),))
    whole = [PartsCatalogue(path, (CataloguePart("continuous", {path: value}),)) for path, value in numbers.items()]
    with Pool(means.executor, means.workers) as pool:
        # In the same corners of tolerances as the roundings: the choice may have searched for some.
        runs = Runs(choice.problem, Combinations(design, whole), pool, None, means.solver)
        (continuous,) = alternatives(choice.criterion, runs, [0], choice.tight).values()
    return dataclasses.replace(choice, continuous=continuous)
