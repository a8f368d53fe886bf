"""The commands of many runs: tune, pareto, sweep and sample, as their help shows them."""

from typing import Annotated

import typer

from . import completion
from .options import Iterations, Levers, Resume, Scheduler, Seed, Starts, Trust


def tune(
    iterations: Iterations = None,
    starts: Starts = None,
    seed: Seed = None,
    optimizer: Annotated[
        str | None, typer.Option(metavar="NAME", help="One of optax takes the steps, adam say; default: quadratic.")
    ] = None,
    learning_rate: Annotated[
        str | None, typer.Option(metavar="RATE", help="Of an optimizer, in the variables' ranges; default 0.05.")
    ] = None,
    scheduler: Scheduler = None,
    resume: Resume = False,
    levers: Levers = "off",
) -> None:
    """Tune the fields in [problem.variables] for the [problem.objective] over all scenarios.

    Stays within bounds and [problem.constraints]; a start that breaks them is led back first. Without a
    [problem]: the worst peak contact force, stroke at most 25 mm, by k_A, c_A, k_T, c_T and the tip mass.

    Limits stand first, each with the three variables that move it most. --levers on adds the three other numbers of
    the design that do, where it is decided. That takes one more run with many derivatives for each scenario that
    decides a limit: seconds, and some compiling the first time. With --resume no search is repeated.

    \b
    Files in DIR:
      design.toml  the tuned design, a study for the other commands
      design.mat   the same for MATLAB
      tuned.json   result, lower bound, evidence, every scenario before and after
      history.csv  objective, worst values and variables of each evaluation
      force.json   force over time in the worst scenario, before and after
      tune.png  the worst scenario before and after, every scenario, variables, search
      tune.txt     the tables
      log.jsonl, state.npz, state.old.npz  kept up while running; --resume needs them

    Ctrl-C saves the best design so far. --scheduler hands the scenarios to a Dask cluster; the search stays here.

    \b
    Example: jaxbuffer tune optimise/table2.toml --output results/table2
    """


def choose(
    ranking: Annotated[
        str | None, typer.Option(metavar="N", help="How many of the best combinations are told; default 5.")
    ] = None,
    tuned: Annotated[
        str | None, typer.Option(metavar="N", help="For how many of them [problem.variables] are tuned; default 0.")
    ] = None,
    optimum: Annotated[
        str | None, typer.Option(metavar="WHEN", help="Whether to search the continuous optimum: true or false.")
    ] = None,
    scheduler: Scheduler = None,
    resume: Resume = False,
    levers: Levers = "off",
) -> None:
    """Choose one part of each catalogue in [parts], the best combination over all scenarios within all limits.

    Every combination counts: one is left only where a scenario proves that it breaks a limit, or that as many others
    as are told are better. The result says how many runs that spared, and compares with the continuous optimum over
    the catalogues' ranges. With [roundings] in place of [parts]: the design is tuned, and the best values near it that
    can be built are chosen. --levers on says which numbers, chosen or not, move each limit of the best most.

    \b
    In CONFIG.toml:
      [parts.spring]
      S1 = {k_A = "300 N/m", max_stroke = "25 mm", price = 11}
      S2 = {k_A = "500 N/m", max_stroke = "30 mm", price = 14}
      [parts.damper]
      file = "dampers.csv"  # name,c_A [N s/m],price
      [problem.constraints]
      price = 40            # of all parts together; mass likewise
      [roundings]
      buffer.k_A = "E24"
      buffer.c_A = "0.5 N s/m"

    \b
    Files in DIR:
      design.toml  the best combination, a study for the other commands
      design.mat   the same for MATLAB
      choice.json  ranking with margins, parts, how the result came about
      choice.csv   the ranking
      choice.png   objective and margins of the best
      choice.txt   the tables
      choose.runs…, choose.optimum, choose.tuned-…  folders, kept up while running; --resume needs them

    \b
    Example: jaxbuffer choose study.toml --output results/parts
    """


def pareto(
    objectives: Annotated[
        str | None,
        typer.Option(
            metavar="A,B",
            help="Quantities to lower; the first under limits on the others.",
            autocompletion=completion.quantities("tuned", listed=True),
            show_default=False,
        ),
    ] = None,
    points: Annotated[str, typer.Option(metavar="N", help="Points of the front, both ends included; default 9.")] = "9",
    iterations: Iterations = None,
    starts: Starts = None,
    seed: Seed = None,
    scheduler: Scheduler = None,
    resume: Resume = False,
) -> None:
    """Find the front of two objectives or more: designs of which none is better than another in every objective.

    Each point is the least worst value of the first objective under limits on the others, tuned as `tune` does: over
    all scenarios, within bounds and [problem.constraints]. Its values are simulated again at rtol 1e-9, and
    its first-order residual tells what is left to gain. The [problem.objective] is put aside. --scheduler hands the
    scenarios to a Dask cluster, as for tune.

    \b
    Files in DIR:
      pareto.csv  objectives, limits, certificate and variables of each point
      pareto.png  the front
      pareto.txt  the table
      pareto.json  the same and how it came about, for jaxbuffer report
      design-1.toml, …  each point's design, a study for the other commands
      least-…, point-…  folders, kept up while running; --resume needs them

    \b
    Example: jaxbuffer pareto optimise/pareto.toml --objectives peak_force,stroke --points 9 --output results/front
    """


def sweep(
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FIELD=VALUES",
            help="Values of a field: FROM:TO:COUNT[:log] or A,B,…, numbers or choices; repeatable.",
            autocompletion=completion.over,
        ),
    ] = None,
    scheduler: Scheduler = None,
    resume: Resume = False,
    trust: Trust = "on",
) -> None:
    """Simulate every combination of the values of some fields of the design and the scenario, on all cores.

    The grid is that of [sweep] in CONFIG.toml, with the fields of --over added or put in their place. Without either:
    approach speeds from 0.05 to 0.25 m/s by misalignments from -0.1 to 0.1 rad, 11 of each. A capture that fails is
    counted and named; it does not touch the others. Ctrl-C ends the sweep and saves what was done; --resume goes on,
    also after a kill.

    Each is run again at a tenth of the tolerance: those whose numbers may be off, or where little decides what
    happens, are counted, and marked in the column trust. --trust off takes half the time.

    --scheduler hands the captures to the workers of a Dask cluster; "processes" starts some on this machine. It needs
    pip install 'jaxbuffer[cluster]'.

    \b
    In CONFIG.toml:
      [sweep]
      scenario.approach_speed = {from = 0.05, to = 0.3, count = 20}        # m/s
      buffer.k_A = {from = 100, to = 2000, count = 8, scale = "log"}       # N/m
      buffer.c_A = [2, 5, 10]                                              # N s/m
      contact.law = ["hertz", "lankarani-nikravesh"]

    \b
    Files in DIR:
      sweep.csv  a row for each capture: its values, outcome and results, units in the header
      sweep.png  over one field lines, over two heat maps, over more slices of heat maps
      envelope.png  over two fields: which runs keep every limit, and the largest rectangle of them
      sweep.json  how the runs ended, what is safe, how the sweep came about
      sweep.nc   the same as labelled arrays (netCDF), for xarray or jb.load
      sweep.txt  the summary, and what is safe
      sweep.zarr  kept up while running, all captures as labelled arrays for xarray; --resume needs it

    \b
    Examples:
      jaxbuffer sweep --over scenario.approach_speed=0.05:0.3:20
      jaxbuffer sweep --over scenario.approach_speed=0.05:0.3:20 --over contact.law=hertz,lankarani-nikravesh
      jaxbuffer sweep study.toml --over buffer.k_A=100:2000:30:log --over buffer.c_A=2,5,10 --output results/buffer
    """


def sample(
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FIELD=RANGE",
            help="A field's range: LOW:HIGH[:log|linear]; repeatable.",
            autocompletion=completion.over,
        ),
    ] = None,
    count: Annotated[str | None, typer.Option(metavar="N", help="Points, a power of two; default 256.")] = None,
    method: Annotated[
        str | None,
        typer.Option(
            metavar="HOW",
            help="sobol (default), latin_hypercube, or saltelli (that of --indices).",
            autocompletion=completion.one_of("sobol", "latin_hypercube", "saltelli"),
        ),
    ] = None,
    seed: Annotated[str | None, typer.Option(metavar="N", help="Of the points; default 0.")] = None,
    of: Annotated[
        list[str] | None,
        typer.Option(
            metavar="QUANTITY",
            help="What --indices and --surface are of; repeatable.",
            autocompletion=completion.quantities("swept"),
        ),
    ] = None,
    indices: Annotated[bool, typer.Option("--indices", help="Sobol' indices: whose scatter matters most.")] = False,
    surface: Annotated[bool, typer.Option("--surface", help="Fit a response surface, and tell its error.")] = False,
    scheduler: Scheduler = None,
    resume: Resume = False,
    trust: Trust = "on",
) -> None:
    """Simulate runs spread evenly over ranges of some fields of the design and the scenario, on all cores.

    The ranges are those of [sample.ranges] in CONFIG.toml, with those of --over added or put in their place; without
    either, the bounds that a tuning has by default. A range of more than a decade is spread on a logarithmic scale.
    A run that fails is counted and named; it does not touch the others. Ctrl-C ends the sample and saves what was
    done; --resume goes on, also after a kill. --scheduler hands the runs to a Dask cluster, as in sweep.

    Each is run again at a tenth of the tolerance, and marked in the column trust, as in sweep. --trust off takes half
    the time.

    --indices makes count × (fields + 2) runs. With another --method, indices are those of the response surface.

    \b
    In CONFIG.toml:
      [sample]
      count = 256
      method = "sobol"
      [sample.ranges]
      buffer.k_A = [200, 2000]             # N/m; or [200, 2000, "linear"]
      scenario.misalignment = [-0.05, 0.05]  # rad

    \b
    Files in DIR:
      sample.csv   a row for each run: its values, outcome and results, units in the header
      sample.png  the quantities over each field
      sample.txt   the summary
      sample.json  indices, surfaces and how the sample came about, for jaxbuffer report
      sample.nc    the runs as labelled arrays (netCDF), for xarray or jb.load
      indices.csv, .png  of --indices: first-order and total indices with their intervals
      surface.csv, .png  of --surface: predicted against computed
      sweep.zarr   kept up while running, the runs as labelled arrays for xarray; --resume needs it

    \b
    Example:
      jaxbuffer sample --over buffer.k_A=200:2000 --over scenario.misalignment=-0.05:0.05 --indices --output results/doe
    """
