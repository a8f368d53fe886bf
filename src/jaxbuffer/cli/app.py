"""Commands, options and exit codes."""

import dataclasses
from typing import Annotated

import typer

import jaxbuffer

from .exits import OK, fail
from .fields import fields
from .laws import laws
from .overrides import WITH_QUANTITIES, Plain
from .pareto import pareto
from .report import report
from .reproduce import reproduce
from .request import Request, given, verb
from .sample import sample
from .streams import note
from .sweep import sweep

ScenarioNumber = Annotated[
    str | None, typer.Option(metavar="N", help="Which of the study's [[scenarios]], from 1; default: the first.")
]

RUN_FILES = ("log.jsonl", "state.npz", "state.old.npz")  # of a tuning, which `tuning.store` keeps

app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


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
    Exit codes: 0 done, 1 the simulation failed or a file could not be written, 2 bad input; interrupted: 130 by Ctrl-C,
    143 by SIGTERM, 129 by SIGHUP.
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

    Another mechanism is chosen by kind = "NAME" in CONFIG.toml; `jaxbuffer fields` lists them with their fields.

    \b
    Files in DIR, of a capture:
      capture.json  every number, its unit in the name, and every impact
      history.csv   forces, gaps, motion and energies at each step
      capture.png   contact force, gap, stroke, hinge angle, energies over time
      capture.txt   the summary

    \b
    Example: jaxbuffer simulate --buffer.k_A 800 --output results
    """
    study = request.one_scenario(scenario_number)
    name = study.mechanism.run_name
    files = request.files(f"{name}.json", "history.csv", f"{name}.png", f"{name}.txt")
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

    files.save_and_show(lambda: run_files(run), run)
    return OK


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
    the active peak and its runner-up, and a verdict: trusted, check or refused.

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

    files.save_and_show(lambda: sensitivity_files(result), result)
    return OK


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
      tune.png     peaks before and after, objective, variables, worst values
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
    names = ("design.toml", "tuned.json", "history.csv", "tune.png", "tune.txt")
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

    files.save_and_show(lambda: tuned_files(tuned), tuned)
    return OK if tuned.feasible else fail(tuned.message)


verb(app, "The front of two objectives or more.", without=("solver",))(pareto)
verb(app, "Many runs: every combination of values of some fields.")(sweep)
verb(app, "Many runs spread over ranges: what matters most, and a fitted surface.")(sample)
verb(app, "The contact laws side by side: restitution and one impact.", without=("solver", "rtol", "duration"))(laws)
app.command(cls=Plain, short_help="A mechanism's fields and quantities, with units.")(fields)
app.command(cls=Plain, short_help="Print again what a folder of results holds.")(report)
app.command(cls=Plain, short_help="A paper's own studies: figures, and its claims held against the model.")(reproduce)
