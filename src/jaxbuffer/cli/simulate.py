"""`jaxbuffer simulate`: one run."""

import sys
from typing import TYPE_CHECKING

from .exits import fail
from .limits import keeps_limits, study_constraints
from .request import CommandLine, ScenarioNumber, Trust, asked_for
from .streams import note

if TYPE_CHECKING:
    from ..mechanisms.run import Run
    from ..run.trust import Trust as HowFar
    from ..study.config import Config


def simulate(request: CommandLine, scenario_number: ScenarioNumber = None, trust: Trust = "on") -> int:
    """Simulate one run (of the default mechanism: a capture) and print its peak forces, motion and energies.

    Of a capture that did not succeed it says what held it back: way and energy left, where the rest went, and the
    impact that turned it round. A second run at a tenth of the tolerance tells how far its numbers can be trusted, and
    where little decides what happens, a bounce more or less say (--trust off spares it). Which parameter to change
    first takes derivatives: jaxbuffer sensitivity does that.

    Another mechanism is chosen by kind = "NAME" in CONFIG.toml; `jaxbuffer fields` lists them with their fields.

    \b
    Files in DIR, of a capture:
      capture.json  every number, its unit in the name, and every impact
      history.csv   forces, gaps, motion and energies at each step
      capture.png, .svg  contact force, gap, stroke, hinge angle, energies over time
      motion.png, .svg   the mechanism at a few telling times, contact forces as arrows
      motion.json, force.json  the same and the force over time, for the page of jaxbuffer report
      fields.png, .svg  stress, strain and pressure on the mesh, of a mechanism that has one; with meshio installed
                    fields.vtu, fields_end.vtu too
      capture.txt   the summary
      capture.nc    all of it as labelled arrays (netCDF), for xarray or jb.load

    \b
    Example: jaxbuffer simulate --buffer.k_A 800 --output results
    """
    study = request.one_scenario(scenario_number)
    limits, name = study_constraints(study), study.mechanism.view.run_name
    named = (f"{name}.{kind}" for kind in ("json", "png", "txt", "nc"))
    files = request.files(*named, "history.csv", "motion.json", "force.json", "motion.png")
    run, closer = simulated(study, request.output is not None, asked_for(trust))
    if run.outcome.failed:
        return fail(run.outcome.reason)
    if study.mechanism.view.chaotic:
        from ..sensitivities.horizon import horizon

        note(str(horizon(run)))
    from ..run.simulate import HISTORY_STEPS

    if run.history is not None and run.history.time.size == HISTORY_STEPS < int(run.accepted):
        note(f"the history holds the first {HISTORY_STEPS} steps only")
    told = trusted(run, closer) if asked_for(trust) else None
    from ..output.field_files import left_out
    from ..output.results import run_files

    contents = run_files(run, request.made(study), limits, told)
    if request.output is not None and (missing := left_out(contents)):
        note(missing)
    files.save_and_show(lambda: contents, run, lambda: str(contents[f"{name}.json"]()))
    return keeps_limits(limits, run)


def simulated(study: "Config", history: bool, again: bool) -> "tuple[Run, Run | None]":
    """The study's run, and, if it is asked for ``again``, the same at a tenth of the tolerance (None where that is not
    allowed), with a spinner."""
    from ..run.request import tenth
    from ..run.simulate import simulate as compute
    from .progress import working

    options = study.options

    def at(rtol: float) -> "Run":
        asked = (study.design, study.scenario, options.duration)
        return compute(*asked, solver=options.stepper(), rtol=rtol, history=history)

    closer = tenth(options.rtol) if again else None
    return working("simulating", lambda: (at(options.rtol), None if closer is None else at(closer)))


def trusted(run: "Run", closer: "Run | None") -> "HowFar":
    """How far the run's numbers can be trusted, said; ``closer``: at a tenth of the tolerance, None where there is no
    such run."""
    from ..run.request import NO_TENTH
    from ..run.trust import Trust, trust

    found = Trust({}, "", NO_TENTH) if closer is None else trust(run, closer)
    if found.verdict == "trusted":
        print(found, file=sys.stderr, flush=True)
    else:
        note(found)
    return found
