"""Commands, options and exit codes."""

import dataclasses
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from .exits import OK, fail
from .overrides import FIELDS, Command
from .reproduce import reproduce

if TYPE_CHECKING:
    from ..config import Config
    from .output import Output

app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)

ConfigFile = Annotated[Path | None, typer.Argument(metavar="CONFIG.toml", help="The study; default: Table 2.")]
Duration = Annotated[float | None, typer.Option(metavar="S", help="Simulated time until timeout [s]; default 8.")]
Rtol = Annotated[float | None, typer.Option(metavar="TOL", help="Relative error allowed in a step; default 3e-7.")]
Solver = Annotated[str | None, typer.Option(metavar="NAME", help="automatic (default), implicit or explicit.")]
OutputFolder = Annotated[Path | None, typer.Option(metavar="DIR", help="Folder for result files; default: none.")]
Force = Annotated[bool, typer.Option("--force", help="Overwrite result files that exist.")]


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
      jaxbuffer tune optimise/table2.toml --output results/table2

    \b
    A study, with everything optional:
      [buffer]
      k_A = 800.0               # N/m
      [scenario]
      approach_speed = 0.2      # m/s
      [options]
      duration = 8.0            # s
      rtol = 3e-7
      [tune]
      stroke_limit = 0.025      # m
      [tune.variables]
      buffer.k_A = [100, 2000]  # N/m, low and high bound

    \b
    Exit codes: 0 done, 1 the simulation failed, 2 bad input, 130 interrupted.
    Compiled programs are kept in ~/.cache/jaxbuffer (or $JAXBUFFER_CACHE).
    """
    if version:
        from .records import version as installed

        typer.echo(f"jaxbuffer {installed()}")
        raise typer.Exit
    if ctx.invoked_subcommand is None:
        typer.echo(ctx.get_help())


app.command(short_help="The paper's own studies: figures, and its claims held against the model.")(reproduce)


@app.command(cls=Command, epilog=FIELDS, short_help="One capture: peak forces, stroke, hinge angle, energies.")
def simulate(
    ctx: typer.Context,
    config: ConfigFile = None,
    solver: Solver = None,
    rtol: Rtol = None,
    duration: Duration = None,
    output: OutputFolder = None,
    force: Force = False,
) -> int:
    """Simulate one capture and print its peak forces, stroke, hinge angle and energies.

    \b
    Files in DIR:
      capture.json  every number, its unit in the name, and every impact
      history.csv   forces, gaps, motion and energies at each step
      capture.png   contact force, gap, stroke, hinge angle, energies over time

    \b
    Example: jaxbuffer simulate --buffer.k_A 800 --output results
    """
    study = _study(ctx, config, solver=solver, rtol=rtol, duration=duration)
    files = _output(output, ("capture.json", "history.csv", "capture.png"), force)
    from ..capture import simulate as compute
    from .progress import COMPILING, working

    options = study.options
    capture = working(
        f"simulating; {COMPILING}",
        lambda: compute(
            study.design,
            study.scenario,
            options.duration,
            solver=options.stepper(),
            rtol=options.rtol,
            history=output is not None,
        ),
    )
    if capture.outcome.failed:
        return fail(capture.outcome.reason)
    typer.echo(repr(capture))
    if output is not None:
        from .. import plot
        from .output import csv_text, json_text
        from .records import capture_history, capture_record

        if capture.history is not None and (kept := capture.history.time.size) < int(capture.accepted):
            typer.echo(f"note: the history holds the first {kept} steps only", err=True)
        _wrote(
            files.write(
                {
                    "capture.json": json_text(capture_record(capture)),
                    "history.csv": csv_text(*capture_history(capture)),
                    "capture.png": plot.png(plot.capture_figure(capture)),
                }
            )
        )
    return OK


@app.command(cls=Command, epilog=FIELDS, short_help="One capture's gradients and elasticities, verified.")
def sensitivity(
    ctx: typer.Context,
    config: ConfigFile = None,
    wrt: Annotated[
        list[str] | None,
        typer.Option(metavar="FIELD", help="Differentiate by FIELD; repeatable; default: the buffer's."),
    ] = None,
    solver: Solver = None,
    rtol: Rtol = None,
    duration: Duration = None,
    output: OutputFolder = None,
    force: Force = False,
) -> int:
    """Differentiate one capture: gradients and elasticities of peak forces, stroke, hinge angle and end time.

    The peak force's gradient is verified against differences of tight simulations.

    \b
    Files in DIR:
      sensitivity.json, sensitivity.csv  values, gradients, elasticities, units

    \b
    Example: jaxbuffer sensitivity study.toml --wrt buffer.k_A --wrt probe.tip_mass
    """
    study = _study(ctx, config, solver=solver, rtol=rtol, duration=duration)
    files = _output(output, ("sensitivity.json", "sensitivity.csv"), force)
    from ..sensitivity import PARAMETERS
    from ..sensitivity import sensitivity as compute
    from .progress import COMPILING, working

    options = study.options
    result = working(
        f"differentiating; {COMPILING}",
        lambda: compute(
            study.design,
            study.scenario,
            tuple(wrt or PARAMETERS),
            options.duration,
            rtol=options.rtol,
            solver=options.stepper(),
        ),
    )
    if result.capture.outcome.failed:
        return fail(result.capture.outcome.reason)
    typer.echo(repr(result))
    if output is not None:
        from .output import csv_text, json_text
        from .records import sensitivity_record, sensitivity_rows

        _wrote(
            files.write(
                {
                    "sensitivity.json": json_text(sensitivity_record(result)),
                    "sensitivity.csv": csv_text(*sensitivity_rows(result)),
                }
            )
        )
    return OK


@app.command(cls=Command, epilog=FIELDS, short_help="Smaller peak forces over all scenarios, within bounds.")
def tune(
    ctx: typer.Context,
    config: ConfigFile = None,
    iterations: Annotated[int | None, typer.Option(metavar="N", help="Iterations at most; default 40.")] = None,
    stroke_limit: Annotated[
        float | None, typer.Option(metavar="M", help="Largest stroke in any scenario [m]; default 0.025.")
    ] = None,
    rtol: Rtol = None,
    duration: Duration = None,
    output: OutputFolder = None,
    force: Force = False,
) -> int:
    """Tune the fields in [tune.variables] for small peak contact forces in all [[scenarios]].

    Starts from the study's design, stays within the bounds and the stroke limit, and verifies the result at tight
    tolerance. Without variables: k_A, c_A, k_T and c_T of the buffer and the tip mass.

    \b
    Files in DIR:
      design.toml  the tuned design, a study for the other commands
      history.csv  objective, peaks, strokes and variables of each iteration
      tune.png     contact force before and after, convergence, variables

    \b
    Example: jaxbuffer tune optimise/table2.toml --output results/table2
    """
    study = _study(ctx, config, rtol=rtol, duration=duration)
    given = _given(iterations=iterations, stroke_limit=stroke_limit)
    study = dataclasses.replace(study, tuning=dataclasses.replace(study.tuning, **given))
    problem = study.problem()
    files = _output(output, ("design.toml", "history.csv", "tune.png"), force)
    from ..tune import tune as compute
    from .progress import tuning

    limit = study.tuning.iterations
    tuned = tuning(limit, lambda report: compute(problem, iterations=limit, report=report))
    failed = [capture.outcome.reason for capture in tuned.after if capture.outcome.failed]
    if failed:
        return fail(failed[0])
    typer.echo(repr(tuned))
    if output is not None:
        from .. import plot
        from ..config import design_toml
        from .output import csv_text
        from .records import tuned_comment, tuning_history

        _wrote(
            files.write(
                {
                    "design.toml": design_toml(tuned.design, problem.scenarios, tuned_comment(tuned)),
                    "history.csv": csv_text(*tuning_history(tuned)),
                    "tune.png": plot.png(plot.tune_figure(tuned)),
                }
            )
        )
    return OK


def _wrote(paths: Sequence[Path]) -> None:
    for path in paths:
        typer.echo(f"wrote {path}")


def _given(**options: Any) -> dict[str, Any]:
    return {name: value for name, value in options.items() if value is not None}


def _study(ctx: typer.Context, file: Path | None, **options: Any) -> "Config":
    """The study with everything the command line overrides; JAX is set up on the way."""
    from ..runtime import configure

    configure(cache=_cache())
    from ..config import apply_overrides, load

    study = apply_overrides(load(file), ctx.obj)
    return dataclasses.replace(study, options=dataclasses.replace(study.options, **_given(**options)))


def _cache() -> Path:
    chosen = os.environ.get("JAXBUFFER_CACHE")
    if chosen:
        return Path(chosen).expanduser()
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "jaxbuffer"


def _output(folder: Path | None, names: Sequence[str], force: bool) -> "Output":
    """Everything that can go wrong with writing results, found before computing them."""
    from .output import Output

    if folder is not None and any(name.endswith(".png") for name in names):
        from ..plot import require_matplotlib

        require_matplotlib()
    return Output(folder, names, force)
