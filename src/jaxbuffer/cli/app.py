"""Commands, options and exit codes."""

from typing import Annotated

import typer

import jaxbuffer

from . import completion
from .exports import export_fmu, export_mjcf
from .fitting import fit
from .many_runs import choose, pareto, sample, sweep, tune
from .one_run import animate, laws, sensitivity, simulate
from .options import plain, verb
from .overrides import CommandOfQuantities
from .sizing import size
from .studies import check, compare, fields, init, report, reproduce, schema

# In rich's markup a unit in brackets, [kg] say, would be a style and not be shown.
app = typer.Typer(add_completion=True, rich_markup_mode=None, pretty_exceptions_enable=False)
completion.show_plain_texts()


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


verb(app, simulate, "One run: peak forces, stroke, hinge angle, energies.")
verb(app, size, "A latch and a buffer that fit the study's scenarios, in closed form, simulated.")
verb(app, sensitivity, "One run's gradients and elasticities, certified.", kind=CommandOfQuantities)
verb(app, tune, "The best design over all scenarios, within bounds and limits.")
verb(app, choose, "The best parts of catalogues, or values that can be built.")
verb(app, fit, "The numbers of a design that measured tests tell, with 95 % intervals.", without=("solver",))
verb(app, pareto, "The front of two objectives or more.", without=("solver",))
verb(app, sweep, "Many runs: every combination of values of some fields.")
verb(app, sample, "Many runs spread over ranges: what matters most, and a fitted surface.")
verb(
    app,
    animate,
    "One run as an animation: the mechanism, its contact forces, slow motion around impacts.",
    without=("figures",),
)
verb(
    app,
    laws,
    "The contact laws side by side: restitution and one impact.",
    without=("solver", "rtol", "duration", "as_json"),
)
verb(
    app,
    export_fmu,
    "One run as a co-simulation unit (FMI 3.0), for control in the loop.",
    without=("solver", "duration", "figures", "as_json"),
    module="export",
)
verb(
    app,
    export_mjcf,
    "A mechanism's bodies and joints for MuJoCo, and as tables.",
    without=("solver", "rtol", "duration", "figures", "as_json"),
    module="export",
)
plain(app, fields, "A mechanism's fields and quantities, with units.", "study")
plain(app, init, "A commented study to begin with.", "study")
plain(app, check, "What a study says, and what the commands would do with it.", "study")
plain(app, schema, "The JSON Schema of a mechanism's studies, for editors.", "study")
plain(app, report, "A page for a design review, of folders of results.", "report")
plain(app, compare, "Designs side by side, of folders of results.", "report")
plain(app, reproduce, "A paper's own studies: figures, and its claims held against the model.", "reproduce")
