"""`tune`: search for the best design of a problem, or tell the best one of an interrupted run."""

import contextlib
import dataclasses
import hashlib
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..block_store import short_hash
from ..errors import InputError, check_flag, check_type, check_whole
from ..fields import Part
from ..files import user_path
from ..hybrid import Solver, name_of, solver_named
from ..programs.identity import code_hash, user_code
from ..progress import reported
from ..version import version
from .assessment import with_evidence, with_levers
from .descent import check_optimizer, descend, optimizer_named
from .problem.problem import Problem
from .problem.settings import Settings, settings_of
from .report.tuned import Tuned
from .rounds import Rounds, best_branch, stage_search
from .search.evaluation import Evaluator
from .search.goal import Goal
from .search.store import (
    CODE,
    OPTIMIZER,
    STUDY,
    VERSION,
    Progress,
    Record,
    TuningStore,
    evaluations_of,
    in_words,
    read_state,
)
from .tolerances.corner_search import with_corners, worse_corners

SIGNS, BEGIN = "corner_signs", "begin"  # in a state: the corners among the cases, and what the rounds begin with

if TYPE_CHECKING:
    import optax  # takes half a second to import; a caller who has an optimizer has it imported


def tune(
    problem: Problem,
    *,
    optimizer: "optax.GradientTransformation | str | None" = None,
    solver: Solver | str | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
    report: Callable[[Record], None] | bool | None = None,
    save: bool = True,
    levers: bool = False,
    **settings: Any,
) -> Tuned:
    """Find the best design of a problem.

    Steps minimise a model that is first-order in every impact's peak of every load case, with the curvature that past
    steps have shown, in a trust region (docs/tuning.md). An infeasible start is led to feasibility first.
    ``problem.then`` is a second search from the first one's best.

    **Arguments:**

    - ``problem``: design variables, load cases, objective and constraints.
    - ``optimizer``: search by this instead, on the certified gradient with projected bounds and an augmented
      Lagrangian for the limits (``optax.adam(0.05)`` say, or "adam" with a ``learning_rate``; rates are of the
      variables' ranges), without a second objective.
    - ``solver``: as for `simulate`, of all runs.
    - ``folder``: for log and state, and at the end for the result, which `load` and `report` read, without figures
      (``tuned.save(folder, force=True)`` draws them); an earlier run's files there are overwritten.
    - ``resume``: go on with the run in ``folder`` instead.
    - ``workers``: threads, by default one a core.
    - ``executor``: evaluates the load cases, each in a call, in place of threads of this process: any executor of
      `concurrent.futures`, as for `sweep`. The search itself stays here (docs/clusters.md).
    - ``report``: called with the log's record of each evaluation, also those of the run that is resumed, or True for a
      line that tells the last one.
    - ``save``: whether the result is written into ``folder``.
    - ``levers``: whether to find, after all else, which numbers that are no variables move limits and objective most:
      a run with derivatives by all numbers of each load case that decides one (`Tuned.levers`).
    - ``settings``: the fields of `Settings`, such as ``iterations``, ``starts``, ``seed``.

    **Returns:** a `Tuned`, its numbers simulated at rtol 1e-9, by diffrax at 1e-8. The same arguments give the same
    result, interrupted or not.

    **Raises:** `InputError` for settings out of range, for starts of which no capture can be solved or climbed from,
    and on resuming another problem's run.

    **Example:** two steps from Table 2's stiffness; leave out the settings for a real search.

    >>> problem = jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)])
    >>> tuned = jb.tune(problem, iterations=2, starts=1)
    >>> before, after = tuned.objective
    >>> print(f"from {before:.2f} N to {after:.0f} N")
    from 253.13 N to 245 N
    """
    check_flag("save", save)
    check_flag("levers", levers)
    saving = save and folder is not None

    def keep(tuned: Tuned) -> None:
        if saving:
            tuned.save(user_path(str(folder)), force=True, figures=False)

    tuned = tune_with(
        problem,
        keep,
        optimizer=optimizer,
        solver=solver,
        folder=folder,
        resume=resume,
        workers=workers,
        executor=executor,
        report=report,
        **settings,
    )
    keep(tuned)
    if levers:
        tuned = with_levers(tuned, workers, executor, solver)
        keep(tuned)
    return tuned


def tune_with(
    problem: Problem,
    keep: Callable[[Tuned], None],
    *,
    optimizer: "optax.GradientTransformation | str | None" = None,
    solver: Solver | str | None = None,
    folder: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    executor: Executor | None = None,
    report: Callable[[Record], None] | bool | None = None,
    **settings: Any,
) -> Tuned:
    """Tune as `tune` does. ``keep`` is called with the search's result before the evidence for it is computed, so that
    nothing after the search can lose it."""
    check_type(
        "problem", problem, Problem, "Problem(jb.table2(), [Scenario()], [Variable('buffer.k_A', 100.0, 2000.0)])"
    )
    problem.check_tunable()
    if workers is not None:
        check_whole("workers", workers, 1)
    if folder is not None and not str(folder):
        raise InputError("folder = '' is empty; name the folder for log and state, or leave it out")
    chosen, optimizer = _chosen(optimizer, settings)
    if optimizer is not None:
        check_optimizer(problem, optimizer)
    identity = _identity(problem, chosen, optimizer, solver)
    with contextlib.ExitStack() as until_assessed:
        with (
            TuningStore(None if folder is None else user_path(folder), identity, resume) as store,
            reported(report, lambda record: in_words(record, problem.success)) as show,
        ):
            evaluator = until_assessed.enter_context(Evaluator(problem, workers, True, executor, solver))
            if show is not None:
                for record in store.records:  # of the run that is resumed
                    show(record)
            store.report = show
            tuned = _search(problem, optimizer, chosen, evaluator, store)
        # The hash in the result says which store it is of.
        tuned = dataclasses.replace(tuned, identity=short_hash(identity))
        keep(tuned)
        return with_evidence(tuned, evaluator)


def _search(problem: Problem, optimizer: Any, settings: Settings, evaluator: Evaluator, store: TuningStore) -> Tuned:
    """Search for the best design: of a problem with many tolerances in the corners that matter, which are searched for
    at its start, and again at each result until none is worse."""
    progress, begin = None if optimizer is not None else Progress.read(store.state), None
    if problem.needs_search:
        # The corners that an interrupted run had got to, or else those of the start.
        state = store.state or {}
        if SIGNS in state:
            problem, begin = with_corners(problem, state[SIGNS]), state[BEGIN]
        else:
            begin = problem.start()
            problem = with_corners(problem, worse_corners(problem, evaluator, begin))
        store.beside = {SIGNS: np.array(problem.signs), BEGIN: begin}
    while True:
        # Corners may have joined the problem's cases, which the evaluator runs by default.
        evaluator.problem = problem
        if optimizer is not None:
            return descend(problem, optimizer, settings, evaluator, store)
        rounds = Rounds(problem, settings, evaluator, store, begin)
        progress = rounds.run(progress)
        if not problem.needs_search:
            return rounds.result(progress)
        best = best_branch(stage_search(problem, settings, progress), progress.branches).best.scaled
        more = worse_corners(problem, evaluator, best)
        if not more:
            return rounds.result(progress)
        problem, begin, progress = with_corners(problem, more), best, None
        store.beside = {SIGNS: np.array(problem.signs), BEGIN: begin}


class Unfinished(NamedTuple):
    """The best design of a run that was interrupted.

    ``objective`` [``unit``]: of the ``stage`` it was in, 0 for the first; ``feasible``: whether every constraint holds;
    ``obstacle``: the one that it is farthest beyond, in words; ``evaluations`` so far.
    """

    design: Part
    objective: float
    unit: str
    feasible: bool
    obstacle: str
    stage: int
    evaluations: int


def best_so_far(
    problem: Problem,
    folder: str | Path,
    *,
    optimizer: "optax.GradientTransformation | str | None" = None,
    solver: Solver | str | None = None,
    **settings: Any,
) -> Unfinished | None:
    """Read the best design of an interrupted run, or None before its first designs were evaluated. Changes nothing.

    **Arguments:** as for `tune`; ``settings``: those that the run was started with.
    """
    chosen, optimizer = _chosen(optimizer, settings)
    _, state, lines = read_state(user_path(folder), _identity(problem, chosen, optimizer, solver))
    # Whether a design is feasible is judged in the corners that the run had got to.
    if SIGNS in state:
        problem = with_corners(problem, state[SIGNS])
    stage, goal = 0, Goal(problem, problem.objective)
    if points := evaluations_of(state):  # of an optimiser's
        # A feasible design comes before any that is not, as in the search.
        best = min(points, key=lambda point: (not goal.feasible(point), goal.value(point)))
    else:
        progress = Progress.read(state or None)
        if progress is None:
            return None
        search = stage_search(problem, chosen, progress)
        best, goal, stage = best_branch(search, progress.branches).best, search.goal, progress.stage
    return Unfinished(
        problem.built(best.scaled),
        goal.value(best),
        goal.objective.unit(problem.catalogue),
        goal.feasible(best),
        goal.obstacle(best),
        stage,
        lines.count(b"\n"),
    )


def _chosen(optimizer: Any, settings: dict[str, Any]) -> tuple[Settings, Any]:
    """Return the settings and the optimiser, which is given, or named by them, or None."""
    chosen = settings_of({**settings, "optimizer": optimizer} if isinstance(optimizer, str) else settings)
    return chosen, optimizer_named(chosen) if optimizer is None or isinstance(optimizer, str) else optimizer


def _identity(problem: Problem, settings: Settings, optimizer: Any, solver: Solver | str | None) -> dict[str, str]:
    """Return what makes a tuning the one it is, by name."""
    used = solver_named(solver)
    try:
        name = name_of(used)
    except InputError:  # it has none
        name = hashlib.sha256(repr(used).encode()).hexdigest()[:8]
    named = optimizer is None or settings.optimizer != "quadratic"
    steps = "as named" if named else code_hash(optimizer)
    code = user_code(problem.mechanism, used, problem.design, *(case.scenario for case in problem.cases)) or "none"
    return {
        VERSION: version(),
        STUDY: problem.fingerprint(),
        **{field.name: repr(getattr(settings, field.name)) for field in dataclasses.fields(settings)},
        "solver": name,
        OPTIMIZER: steps,
        CODE: code,
    }
