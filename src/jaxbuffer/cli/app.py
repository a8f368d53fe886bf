"""Commands, options and exit codes."""

import dataclasses
from typing import Annotated

import typer

import jaxbuffer

from .animate import animate
from .exits import LIMITS_BROKEN, OK, fail
from .fields import fields
from .laws import laws
from .limits import asked_limits, keeps_limits
from .overrides import WITH_QUANTITIES, Plain
from .pareto import pareto
from .report import compare, report
from .reproduce import reproduce
from .request import Request, given, verb
from .sample import sample
from .streams import note
from .study import check, init, schema
from .sweep import sweep

ScenarioNumber = Annotated[
    str | None, typer.Option(metavar="N", help="Which of the study's [[scenarios]], from 1; default: the first.")
]

RUN_FILES = ("log.jsonl", "state.npz", "state.old.npz")  # of a tuning, which `tuning.store` keeps

app = typer.Typer(add_completion=True, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.callback(invoke_without_command=True)
def root(
    ctx: typer.Context,
    version: Annotated[bool, typer.Option("--version", is_eager=True, help="Show the version and stop.")] = False,
) -> None:
    """Which spring, damper and tip mass behind a docking probe give the smallest impact force?

    Everything is in SI units. Without CONFIG.toml, the mechanism is the paper's Table 2. Any field of the design and
    the scenario can be set on the command line by its dotted name.

    \b
    Examples:
      jaxbuffer simulate
      jaxbuffer simulate study.toml --buffer.k_A 800 --scenario.approach_speed 0.2
      jaxbuffer sensitivity study.toml --output results
      jaxbuffer sweep --over scenario.approach_speed=0.05:0.3:20 --output results/speeds
      jaxbuffer tune optimise/table2.toml --output results/table2

    \b
    A study, with everything optional:
      [buffer]
      k_A = 800.0               # N/m
      [scenario]
      approach_speed = 0.2      # m/s
      [options]
      duration = 8.0            # s
      rtol = 1e-6
      [problem.variables]
      buffer.k_A = [100, 2000]  # N/m, low and high bound
      [problem.constraints]
      stroke = 0.025            # m
      [sweep]
      scenario.approach_speed = {from = 0.05, to = 0.3, count = 20}  # m/s

    \b
    Exit codes: 0 done; 1 limits broken (no feasible design, or a run outside [problem.constraints]); 2 bad input; 3 the
    solver failed or a file could not be written; interrupted: 130 by Ctrl-C, 143 by SIGTERM, 129 by SIGHUP.
    Compiled programs are kept in ~/.cache/jaxbuffer (or $JAXBUFFER_CACHE).
    """
    if version:
        typer.echo(f"jaxbuffer {jaxbuffer.__version__}")
        raise typer.Exit
    if ctx.invoked_subcommand is None:
        typer.echo(ctx.get_help())


@verb(app, "One run: peak forces, stroke, hinge angle, energies.")
def simulate(request: Request, scenario_number: ScenarioNumber = None) -> int:
    """Simulate one run (of the default mechanism: a capture) and print its peak forces, motion and energies.

    Of a capture that did not succeed it says what held it back: way and energy left, where the rest went, and the
    impact that turned it round. Which parameter to change first takes derivatives: jaxbuffer sensitivity does that.

    Another mechanism is chosen by kind = "NAME" in CONFIG.toml; `jaxbuffer fields` lists them with their fields.

    \b
    Files in DIR, of a capture:
      capture.json  every number, its unit in the name, and every impact
      history.csv   forces, gaps, motion and energies at each step
      capture.png, .svg  contact force, gap, stroke, hinge angle, energies over time
      motion.png, .svg   the mechanism at a few telling times, contact forces as arrows
      motion.json, force.json  the same and the force over time, for the page of jaxbuffer report
      capture.txt   the summary
      capture.nc    all of it as labelled arrays (netCDF), for xarray or jb.load

    \b
    Example: jaxbuffer simulate --buffer.k_A 800 --output results
    """
    study = request.one_scenario(scenario_number)
    limits, name = asked_limits(study), study.mechanism.run_name
    named = (f"{name}.{kind}" for kind in ("json", "png", "txt", "nc"))
    files = request.files(*named, "history.csv", "motion.json", "force.json", "motion.png")
    from ..run.simulate import simulate as compute
    from .progress import working

    options = study.options
    run = working(
        "simulating",
        lambda: compute(
            study.design,
            study.scenario,
            options.duration,
            solver=options.stepper(),
            rtol=options.rtol,
            history=request.output is not None,
        ),
    )
    if run.outcome.failed:
        return fail(run.outcome.reason)
    if study.mechanism.chaotic:
        from ..sensitivities.horizon import horizon

        note(str(horizon(run)))
    if run.history is not None and (kept := run.history.time.size) < int(run.accepted):
        note(f"the history holds the first {kept} steps only")
    from ..output.results import run_files

    contents = run_files(run, request.made(study), limits)
    files.save_and_show(lambda: contents, run, lambda: str(contents[f"{name}.json"]()))
    return keeps_limits(limits, run)


@verb(app, "One run's gradients and elasticities, certified.", epilog=WITH_QUANTITIES)
def sensitivity(
    request: Request,
    wrt: Annotated[
        list[str] | None,
        typer.Option(metavar="FIELD", help="Differentiate by FIELD; repeatable; default: the buffer's."),
    ] = None,
    of: Annotated[
        list[str] | None,
        typer.Option(metavar="QUANTITY", help="Differentiate QUANTITY; repeatable; default: the first five below."),
    ] = None,
    certify: Annotated[
        str, typer.Option(metavar="HOW", help="quick (default), thorough (a difference a parameter) or none.")
    ] = "quick",
    scenario_number: ScenarioNumber = None,
) -> int:
    """Differentiate one run: gradients and elasticities of peak forces, stroke, hinge angle and end time, or of any
    quantity below.

    They come with a certificate: estimated errors from a second tolerance and from differences of tight simulations,
    the active peak and its runner-up, and a verdict: trusted, check or refused. Of a capture that did not succeed,
    --of capture_share says by how much each parameter would have to change, to first order.

    \b
    Files in DIR:
      sensitivity.json, sensitivity.csv  values, gradients, elasticities, units
      sensitivity.txt                    the tables

    \b
    Examples:
      jaxbuffer sensitivity study.toml --wrt buffer.k_A --wrt probe.tip_mass
      jaxbuffer sensitivity --of peak_force --of impact.1.peak_force --of capture_margin --certify thorough
    """
    study = request.one_scenario(scenario_number)
    limits = asked_limits(study)
    files = request.files("sensitivity.json", "sensitivity.csv", "sensitivity.txt")
    from ..errors import check_choice
    from ..fields import check_numbers
    from ..mechanisms.quantity import check_quantities
    from ..run.simulate import ONE_RUN
    from ..sensitivities.sensitivity import CERTIFICATES
    from ..sensitivities.sensitivity import sensitivity as compute
    from .progress import working

    check_choice("certify", certify, CERTIFICATES)
    options, mechanism = study.options, study.mechanism
    names = check_quantities(mechanism.quantities, of or mechanism.defaults.differentiated)
    one = ONE_RUN.format(mechanism.run_name)
    paths, _ = check_numbers(study.design, study.scenario, wrt or mechanism.defaults.parameters, one)
    result = working(
        "differentiating",
        lambda: compute(
            study.design,
            study.scenario,
            paths,
            options.duration,
            quantities=names,
            rtol=options.rtol,
            solver=options.stepper(),
            certify=certify,
        ),
    )
    if result.run.outcome.failed:
        return fail(result.run.outcome.reason)
    from ..output.results import sensitivity_files

    contents = sensitivity_files(result, request.made(study))
    files.save_and_show(lambda: contents, result, lambda: str(contents["sensitivity.json"]()))
    return keeps_limits(limits, result.run)


@verb(app, "The best design over all scenarios, within bounds and limits.", without=("solver",))
def tune(
    request: Request,
    iterations: Annotated[str | None, typer.Option(metavar="N", help="Steps of a search at most; default 40.")] = None,
    starts: Annotated[str | None, typer.Option(metavar="N", help="Designs screened in a round; default 32.")] = None,
    seed: Annotated[str | None, typer.Option(metavar="N", help="Of the starts' sample; default 0.")] = None,
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

    Ctrl-C saves the best design so far.

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

    settings = {field.name: getattr(study.tuning, field.name) for field in dataclasses.fields(study.tuning)}
    try:
        tuned = tuning(lambda report: compute(problem, **settings, folder=request.output, resume=resume, report=report))
    except KeyboardInterrupt:
        from .unfinished import keep_best

        return keep_best(problem, settings, files)
    from ..output.results import tuned_files

    contents = tuned_files(tuned, request.made(study, resume), note)
    files.save_and_show(lambda: contents, tuned, lambda: str(contents["tuned.json"]()))
    return OK if tuned.feasible else fail(tuned.message, LIMITS_BROKEN)


verb(app, "The front of two objectives or more.", without=("solver",))(pareto)
verb(app, "Many runs: every combination of values of some fields.")(sweep)
verb(app, "Many runs spread over ranges: what matters most, and a fitted surface.")(sample)
verb(app, "One run as an animation: the mechanism, its contact forces, slow motion around impacts.")(animate)
verb(
    app, "The contact laws side by side: restitution and one impact.", without=("solver", "rtol", "duration", "as_json")
)(laws)
app.command(cls=Plain, short_help="A mechanism's fields and quantities, with units.")(fields)
app.command(cls=Plain, short_help="A commented study to begin with.")(init)
app.command(cls=Plain, short_help="What a study says, and what the commands would do with it.")(check)
app.command(cls=Plain, short_help="The JSON Schema of a mechanism's studies, for editors.")(schema)
app.command(cls=Plain, short_help="A page for a design review, of folders of results.")(report)
app.command(cls=Plain, short_help="Designs side by side, of folders of results.")(compare)
app.command(cls=Plain, short_help="A paper's own studies: figures, and its claims held against the model.")(reproduce)
