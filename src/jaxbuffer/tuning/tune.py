"""`tune`: search for the best design of a problem, or tell the best one of an interrupted run."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import InputError, check_flag, check_type, check_whole
from ..fields import Part
from ..progress import reported
from .descent import check_optimizer, descend
from .evaluation import Evaluator
from .problem import Problem, Settings, settings_of
from .rounds import Rounds, best_branch, stage_search
from .store import Progress, Record, Store, in_words, read_state
from .tuned import Tuned

if TYPE_CHECKING:
    import optax  # takes half a second to import; a caller who has an optimizer has it imported


def tune(
    problem: Problem,
    *,
    optimizer: "optax.GradientTransformation | None" = None,
    folder: str | Path | None = None,
    resume: bool = False,
    workers: int | None = None,
    client: Any = None,
    report: Callable[[Record], None] | bool | None = None,
    save: bool = True,
    **settings: Any,
) -> Tuned:
    """Find the best design of a problem.

    Steps minimise a model that is first-order in every impact's peak of every load case, with the curvature that past
    steps have shown, in a trust region (docs/tuning.md). An infeasible start is led to feasibility first.
    ``problem.then`` is a second search from the first one's best.

    **Arguments:**

    - ``problem``: design variables, load cases, objective and constraints.
    - ``optimizer``: search by this instead, on the certified gradient with projected bounds and an augmented
      Lagrangian for the limits (``optax.adam(0.05)`` say; rates are of the variables' ranges), without a second
      objective and not to be resumed.
    - ``folder``: for log and state, and at the end for the result, which `load` and `report` read, without figures
      (``tuned.save(folder, force=True)`` draws them); an earlier run's files there are overwritten.
    - ``resume``: go on with the run in ``folder`` instead.
    - ``workers``: threads, by default one a core.
    - ``client``: a `distributed.Client`, the address of Dask's scheduler, "local" or "processes": its workers evaluate
      the scenarios, each a task; the search itself stays here (docs/clusters.md).
    - ``report``: called with the log's record of each evaluation, also those of the run that is resumed, or True for a
      line that tells the last one.
    - ``save``: whether the result is written into ``folder``.
    - ``settings``: the fields of `Settings`, such as ``iterations``, ``starts``, ``seed``.

    **Returns:** a `Tuned`, its numbers simulated at rtol 1e-9. The same arguments give the same result, interrupted or
    not.

    **Raises:** `InputError` for settings out of range, for starts of which no capture can be solved or climbed from,
    and on resuming another problem's run.

    **Example:** two steps from Table 2's stiffness; leave out the settings for a real search.

    >>> problem = jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", 100.0, 2000.0)])
    >>> tuned = jb.tune(problem, iterations=2, starts=1)
    >>> before, after = tuned.objective
    >>> print(f"from {before:.2f} N to {after:.0f} N")
    from 253.13 N to 245 N
    """
    check_type(
        "problem", problem, Problem, "Problem(jb.table2(), [Scenario()], [Variable('buffer.k_A', 100.0, 2000.0)])"
    )
    check_flag("save", save)
    if workers is not None:
        check_whole("workers", workers, 1)
    if folder is not None and not str(folder):
        raise InputError("folder = '' is empty; name the folder for log and state, or leave it out")
    chosen = settings_of(settings)
    if optimizer is not None:
        check_optimizer(problem, optimizer, resume)
    with (
        Store(None if folder is None else Path(folder), _fingerprint(problem, chosen), resume) as store,
        Evaluator(problem, workers, True, client) as evaluator,
        reported(report, lambda record: in_words(record, problem.mechanism.success)) as show,
    ):
        if show is not None:
            for record in store.records:  # of the run that is resumed
                show(record)
        store.report = show
        if optimizer is not None:
            tuned = descend(problem, optimizer, chosen, evaluator, store)
        else:
            rounds = Rounds(problem, chosen, evaluator, store)
            tuned = rounds.result(rounds.run(Progress.read(store.state)))
    if save and folder is not None:
        tuned.save(folder, force=True, figures=False)
    return tuned


class Unfinished(NamedTuple):
    """The best design of a run that was interrupted.

    ``objective`` [``unit``]: of the ``stage`` it was in, 0 for the first; ``feasible``: whether every constraint holds;
    ``evaluations`` so far.
    """

    design: Part
    objective: float
    unit: str
    feasible: bool
    stage: int
    evaluations: int


def best_so_far(problem: Problem, folder: str | Path, **settings: Any) -> Unfinished | None:
    """Read the best design of an interrupted run, or None before its first designs were evaluated. Changes nothing.

    **Arguments:** as for `tune`; ``settings``: those that the run was started with.
    """
    chosen = settings_of(settings)
    state, lines = read_state(Path(folder), _fingerprint(problem, chosen))
    progress = Progress.read(state or None)
    if progress is None:
        return None
    search = stage_search(problem, chosen, progress)
    best = best_branch(search, progress.branches).best
    return Unfinished(
        problem.built(best.scaled),
        search.goal.value(best),
        search.goal.objective.unit(problem.catalogue),
        search.goal.feasible(best),
        progress.stage,
        lines.count(b"\n"),
    )


def _fingerprint(problem: Problem, settings: Settings) -> str:
    return f"{problem.fingerprint()}-{settings}"
