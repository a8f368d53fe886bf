"""One run: `jaxbuffer simulate`, and whether a run keeps to [problem.constraints]."""

import sys

from ...fields import get
from ...mechanisms.run import Run
from ...output.field_files import left_out
from ...output.run_files import run_files, run_text
from ...run.request import NO_TENTH, tenth
from ...run.simulate import HISTORY_STEPS
from ...run.simulate import simulate as compute
from ...run.trust import Trust, trust
from ...sensitivities.horizon import horizon
from ...study.config import Config
from ...study.own_quantities import own_quantities
from ...tuning.problem.objective import Constraints
from ...tuning.report.levers import NO_LEVERS, Levers, run_levers
from ..exits import LIMITS_BROKEN, OK, fail
from ..streams import note
from .progress import working
from .request import CommandLine, asked_for


def simulate(request: CommandLine, scenario_number: str | None, trust: str, levers: str) -> int:
    """Simulate a run, and show how far its numbers can be trusted and whether it keeps to the study's limits."""
    moved = asked_for(levers, "levers")
    study = request.one_scenario(scenario_number)
    limits, name = study_constraints(study), study.mechanism.view.run_name
    named = (f"{name}.{kind}" for kind in ("json", "png", "txt", "nc", "mat"))
    files = request.files(*named, "history.csv", "motion.json", "force.json", "motion.png")
    run, closer = simulated(study, request.output is not None, asked_for(trust))
    if run.outcome.failed:
        return fail(run.outcome.reason)
    if study.mechanism.view.chaotic:
        note(str(horizon(run)))
    if run.history is not None and run.history.time.size == HISTORY_STEPS < int(run.accepted):
        note(f"the history holds the first {HISTORY_STEPS} steps only")
    verdict = trusted(run, closer) if asked_for(trust) else None
    found = levers_of(study, run, limits) if moved and limits is not None else NO_LEVERS
    contents = run_files(run, request.made(study), limits, verdict, study.scenario_number, found)
    # Said only where files are wanted, since it is about files.
    if request.output is not None and (missing := left_out(contents)):
        note(missing)
    files.save_record(contents, run_text(run, limits, study.scenario_number, found), f"{name}.json")
    return keeps_limits(limits, run)


def simulated(study: Config, history: bool, again: bool) -> tuple[Run, Run | None]:
    """Simulate the study's run and, if it is asked for ``again``, the same at a tenth of the tolerance (None where that
    is not allowed), with a spinner."""
    options = study.options

    def at(rtol: float) -> Run:
        task = (study.design, study.scenario, options.duration)
        return compute(*task, solver=options.stepper(), rtol=rtol, history=history)

    closer = tenth(options.rtol) if again else None
    return working("simulating", lambda: (at(options.rtol), None if closer is None else at(closer)))


def levers_of(study: Config, run: Run, limits: Constraints) -> Levers:
    """Differentiate the run by all numbers of its design, and return what moves its limited quantities most."""
    given = study.table.variables
    variables = study.mechanism.variables(run.design) if given is None else given
    options, quantities = study.options, study.mechanism.quantities
    assert options.duration is not None
    # An end that is asked for has no slopes; the time until it has.
    awaited = [name for name, it in quantities.items() if it.awaits and it.awaits in limits.limits.ends]
    names = dict.fromkeys([*limits.limits.names, *awaited])
    task = (run, tuple(names), set(variables), options.duration, options.rtol, options.stepper())
    return working("finding levers", lambda: run_levers(*task))


def trusted(run: Run, closer: Run | None) -> Trust:
    """Say and return how far the run's numbers can be trusted; ``closer``: at a tenth of the tolerance, None where
    there is no such run."""
    verdict = Trust({}, "", NO_TENTH) if closer is None else trust(run, closer)
    if verdict.verdict == "trusted":
        print(verdict, file=sys.stderr, flush=True)
    else:
        note(verdict)
    return verdict


def study_constraints(study: Config) -> Constraints | None:
    """Read the study's constraints, or None.

    Call it before the run: own quantities that they name are read from files, which may fail.
    """
    of_study, own = study.table.constraints, study.table.quantities or {}
    if of_study is None:
        return None
    of_study.check(study.mechanism, lambda path: get(study.design, path), own)
    # Own quantities that nothing limits are not loaded, because loading them runs a file (docs/security.md).
    if not set(of_study.names) & set(own):
        return Constraints(of_study, {})
    return Constraints(of_study, own_quantities(own, study.mechanism, study.folder))


def keeps_limits(constraints: Constraints | None, run: Run) -> int:
    """Return the exit code: `LIMITS_BROKEN`, with a line that says which limits, where the run breaks some."""
    if constraints is None:
        return OK
    broken = constraints.broken_by(run)
    return fail(f"[problem.constraints] not kept: {'; '.join(broken)}", LIMITS_BROKEN) if broken else OK
