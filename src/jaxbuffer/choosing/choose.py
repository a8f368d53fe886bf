"""`choose`: the best combination of parts."""

import dataclasses
import hashlib
import itertools
import shutil
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from ..block_store import short_hash
from ..cluster.pool import Pool
from ..errors import InputError, check_flag, check_type, check_whole
from ..hybrid import Solver, name_of, solver_named
from ..programs.identity import user_code
from ..progress import counted
from ..tuning.assessment import levers_of_design
from ..tuning.problem.objective import Objective, SecondObjective
from ..tuning.problem.problem import Problem
from ..tuning.report.governing import OBJECTIVE
from ..tuning.search.evaluation import Evaluator
from ..tuning.search.goal import Goal
from ..tuning.search.store import Record
from ..tuning.tolerances.corner_search import with_corners, worse_corners
from ..tuning.tune import tune
from ..version import version
from .alternatives import alternatives, best_first, ceiling, with_variables
from .bound import continuous_optimum
from .catalogue import TOTALS, PartsCatalogue, read_catalogues
from .choice import Choice, set_by
from .combinations import Combinations
from .criterion import Criterion, check_obeyed
from .enumeration import Enumeration
from .means import OPTIMUM, TUNED, Means
from .runs import Runs
from .store import FOLDER, ChoiceStore, round_folder

EXAMPLE = "Problem(jb.table2(), [Scenario()], [])"


def choose(
    problem: Problem,
    parts: Mapping[str, Any],
    *,
    objective: Objective | None = None,
    then: SecondObjective | None = None,
    at_most: Mapping[str, Any] | None = None,
    ranking: int = 5,
    optimum: bool = True,
    tuned: int = 0,
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
    """Choose one part of each catalogue: the combination with the least objective that keeps all limits.

    Every combination counts, none by a guess: one is dropped as soon as a load case proves it infeasible, or beaten by
    as many others as are ranked (docs/choose.md).

    **Arguments:**

    - ``problem``: load cases, objective and limits; its variables keep the design's values while parts are compared.
    - ``parts``: by role, a mapping of each part's name to the fields that it sets, {"S1": {"k_A": "500 N/m"}}, or the
      path of a CSV file. A field may be named by its last word where that is clear. ``price`` and ``mass`` are the
      part's own; their sums over the parts can be objective and limit.
    - ``objective``: in place of the problem's; it may use price and mass: ``jb.Objective({"price": 1.0})``.
    - ``then``: in place of the problem's; it orders the combinations whose objective is within its tolerance of the
      least, ahead of all others, and may use price and mass too.
    - ``at_most``: upper limits on price and mass, {"mass": "0.5 kg"}.
    - ``ranking``: how many of the best are told.
    - ``optimum``: whether to tune the numbers that parts set within their catalogue's range, for comparison.
    - ``tuned``: for how many of the best the problem's variables are tuned.
    - ``solver``: as for `simulate`.
    - ``folder``: where runs are kept as they are done, and at the end the result.
    - ``resume``: go on with the choice in ``folder``.
    - ``workers``, ``executor``: as for `sweep`.
    - ``progress``: called with the runs done or spared and all there are, or True for a bar.
    - ``report``: called with the log's record of each evaluation of a tuning.
    - ``save``: whether the result is written into ``folder``, without figures.
    - ``levers``: whether to find which numbers move each limit of the best combination most, as for `tune`.
    - ``settings``: of the tunings, fields of `Settings`.

    **Returns:** a `Choice`, its numbers at tight tolerance; the same whether it was interrupted or not.

    **Raises:** `InputError` for what is wrong with a catalogue, a part that sets a variable or a number that scenarios
    list, and on resuming another choice.

    **Example:**

    >>> parts = {
    ...     "spring": {"soft": {"k_A": "300 N/m"}, "stiff": {"k_A": "900 N/m"}},
    ...     "tip": {"light": {"tip_mass": "30 g"}, "heavy": {"tip_mass": "80 g"}},
    ... }
    >>> problem = jb.Problem(jb.table2(), [jb.Scenario(approach_speed=speed) for speed in (0.1, 0.2)], [])
    >>> choice = jb.choose(problem, parts, optimum=False)
    >>> choice.best.names, f"{choice.best.value:.1f} N"
    (('soft', 'light'), '316.2 N')
    """
    criterion, combinations = selection(problem, parts, objective, at_most, then)
    check_whole("ranking", ranking, 1)
    check_whole("tuned", tuned, 0)
    check_flag("optimum", optimum)
    check_flag("levers", levers)
    shown = counted(progress, problem.mechanism.view.run_name)
    means = Means(folder, resume, workers, executor, solver, shown, report, settings)
    if tuned:
        # Before the enumeration, because a mistake that only the tunings after it would meet costs all its runs.
        problem.check_tunable()
    choice = ranked(criterion, combinations, means, ranking)
    choice = with_optimum(choice, means) if optimum else choice
    choice = with_tuned(choice, tuned, means) if tuned else choice
    return save_with_levers(choice, means, save, levers)


def save_with_levers(choice: Choice, means: Means, save: bool, levers: bool) -> Choice:
    """Save a choice in its folder, if any and if ``save``, and return it; with ``levers`` save it again with them."""

    def keep(choice: Choice) -> Choice:
        if save and means.path is not None:
            choice.save(means.path, force=True, figures=False)
        return choice

    choice = keep(choice)
    return keep(with_levers(choice, means)) if levers else choice


def selection(
    problem: Problem,
    parts: Mapping[str, Any] | Sequence[PartsCatalogue],
    objective: Objective | None = None,
    at_most: Mapping[str, Any] | None = None,
    then: SecondObjective | None = None,
) -> tuple[Criterion, Combinations]:
    """Return what is chosen by and from, checked. Arguments and errors are those of `choose`."""
    check_type("problem", problem, Problem, EXAMPLE)
    given = parts if isinstance(parts, Mapping) else {it.role: it for it in parts}
    combinations = Combinations(problem.design, read_catalogues(given, problem.design))
    for catalogue in combinations.catalogues:
        for path in catalogue.paths:
            if path in problem.paths:
                raise InputError(f"parts.{catalogue.role} sets {path}, which is among the variables too; keep one")
    check_obeyed(problem, {path: f"parts.{it.role}" for it in combinations.catalogues for path in it.paths})
    shown = dataclasses.replace(problem, units={**combinations.units, **problem.units})
    return Criterion.of(shown, objective, at_most, combinations, then), combinations


def ranked(
    criterion: Criterion, combinations: Combinations, means: Means, ranking: int, first: Sequence[int] = ()
) -> Choice:
    """Enumerate the combinations and run the best ones again at tight tolerance.

    Of more tolerances than have all their corners among the cases, the worst corners of a round's best combination are
    searched for and join the cases, until none is worse. Every combination is then judged in some of its corners and
    the best one in its worst: so none is better, if that one was found.

    **Arguments:** ``first``: combinations that are judged in any event; the first of them is the result's ``nearest``.
    """
    if means.path is not None and not means.resume:
        for folder in means.path.glob(round_folder("*")):  # an earlier choice's, with which none goes on
            shutil.rmtree(folder, ignore_errors=True)
    runs, possible = 0, 0
    for number in itertools.count():
        # Corners that join stand among the cases and change their numbers: so each round has a folder of its own.
        choice = _enumerated(criterion, combinations, means, ranking, first, round_folder(number) if number else FOLDER)
        runs, possible = runs + choice.tally.runs, possible + choice.tally.possible
        more = _worse_corners(choice, means)
        if not more:
            break
        criterion = dataclasses.replace(criterion, problem=with_corners(criterion.problem, more))
    return dataclasses.replace(choice, tally=choice.tally._replace(runs=runs, possible=possible))


def _worse_corners(choice: Choice, means: Means) -> tuple[tuple[float, ...], ...]:
    """Return corners in which the best combination is worse than in all that it was run in, if these are not all.

    With a second objective the one with the least first objective counts as well, because it makes the ceiling.
    """
    # Further corners only add limits, so that none of them makes an infeasible choice feasible.
    if not choice.problem.needs_search or not choice.feasible:
        return ()
    designs, rows = [choice.design], dict[tuple[float, ...], None]()
    if choice.least is not None and choice.best is not None and choice.least.names != choice.best.names:
        designs.append(choice.least.design)
    for design in designs:
        problem = dataclasses.replace(choice.problem, design=design)
        with Evaluator(problem, means.workers, True, means.executor, means.solver) as evaluator:
            rows |= dict.fromkeys(worse_corners(problem, evaluator, problem.start()))
    return tuple(rows)


def _enumerated(
    criterion: Criterion,
    combinations: Combinations,
    means: Means,
    ranking: int,
    first: Sequence[int],
    folder: str,
) -> Choice:
    """Enumerate the combinations at the cases that the problem has; ``folder``: where the runs are kept."""
    problem, identity = criterion.problem, _identity(criterion, combinations, ranking, means.solver)
    tight = means.tight(problem)
    with means.locked(), Pool(means.executor, means.workers) as pool:
        store = None if means.path is None else ChoiceStore(means.path / folder, identity, means.resume)
        runs = Runs(problem, combinations, pool, store, means.solver)
        enumeration = Enumeration(
            runs,
            criterion.of_runs,
            constant=criterion.constants(combinations),
            allowed=criterion.allowed(combinations),
            ranking=ranking,
            first=first,
            progress=means.progress,
            second=criterion.second(combinations),
        )
        enumeration.run()
        best = [int(k) for k in enumeration.best()]
        least = [] if criterion.then is None else [int(k) for k in enumeration.least()[:1]]
        chosen = best or [int(k) for k in enumeration.nearest() if k not in runs.misfits]
        # A combination that is asked for may not go together either, and then it has no runs to be judged by.
        told = [k for k in dict.fromkeys([*chosen, *least, *first]) if k not in runs.misfits]
        made = alternatives(criterion, runs, told, tight)
    # Those nearest to the limits stay in their order: how far they are beyond comes before the objective. One on its
    # limit may keep it at the smaller tolerance alone, and the ceiling is that of the smaller tolerance too.
    highest = ceiling(criterion, [made[k] for k in (*chosen, *least)])
    order = [chosen[place] for place in best_first(criterion, [made[k] for k in chosen], highest)]
    return Choice(
        criterion=criterion,
        catalogues=combinations.catalogues,
        ranked=tuple(made[k] for k in order),
        tally=enumeration.tally({k: it.feasible for k, it in made.items()}),
        nearest=made.get(first[0]) if first else None,
        misfit=next(iter(runs.misfits.values()), ""),
        tight=tight,
        reordered=order != chosen,
        identity=short_hash(identity),
        least=made[least[0]] if least else None,
        ceiling=highest,
    )


def with_optimum(choice: Choice, means: Means) -> Choice:
    """Return the choice with the continuous optimum over the catalogues' ranges beside it."""
    if choice.best is None:
        return choice
    best = continuous_optimum(choice.criterion, choice.catalogues, choice.best.design, **means.tuning(OPTIMUM))
    return dataclasses.replace(choice, optimum=best)


def with_tuned(choice: Choice, count: int, means: Means) -> Choice:
    """Return the choice with the problem's variables tuned for the best combinations, ranked by what that reaches."""
    objective, made = choice.criterion.of_runs, list(choice.ranked)
    if objective is None:
        raise InputError("tuned needs an objective of the runs: price and mass do not depend on the variables")
    for place, it in enumerate(choice.ranked[:count]):
        problem = dataclasses.replace(choice.problem, design=it.design, objective=objective)
        result = tune(problem, **means.tuning(f"{TUNED}-{place + 1}"))
        made[place] = with_variables(choice.criterion, it, result)
    # The one with the least objective makes the ceiling also where it is not ranked.
    highest = ceiling(choice.criterion, [*made, *([] if choice.least is None else [choice.least])])
    order = best_first(choice.criterion, made, highest)
    return dataclasses.replace(choice, ranked=tuple(made[k] for k in order), ceiling=highest)


def with_levers(choice: Choice, means: Means) -> Choice:
    """Return the choice with the levers of its best combination's limits."""
    best = choice.best
    if best is None:
        return choice
    # Corners that its tuning has searched for are among the cases of that alone.
    problem = choice.problem if best.tuned is None else best.tuned.problem
    problem = dataclasses.replace(problem, design=best.design)
    goal, chosen = Goal(problem, choice.criterion.of_runs or problem.objective), set_by(choice, best)
    levers, missing = levers_of_design(goal, best.evaluation, chosen, means.workers, means.executor, means.solver)
    # Price and mass are no quantities of runs, so that the objective that they are part of has no elasticities.
    priced = any(name in TOTALS for name in choice.criterion.objective.weights)
    levers = {name: it for name, it in levers.items() if not (priced and name == OBJECTIVE)}
    return dataclasses.replace(choice, levers=levers, missing=missing)


def _identity(
    criterion: Criterion, combinations: Combinations, ranking: int, solver: Solver | str | None
) -> dict[str, str]:
    """Return what makes a choice the one it is, by name."""
    problem, used = criterion.problem, solver_named(solver)
    parts = [(it.role, [dataclasses.astuple(part) for part in it.parts]) for it in combinations.catalogues]
    code = user_code(problem.mechanism, used, problem.design, *(case.scenario for case in problem.cases)) or "none"
    return {
        "version": version(),
        "study": problem.fingerprint(),
        "parts": hashlib.sha256(repr(parts).encode()).hexdigest()[:16],
        "objective and limits": repr((criterion.objective, criterion.limits, criterion.then)),
        "ranking": str(ranking),
        "solver": name_of(used),
        "code": code,
    }
