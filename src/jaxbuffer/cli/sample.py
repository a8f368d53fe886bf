"""`jaxbuffer sample`: runs spread over ranges, and what can be read off them."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import InputError
from .exits import INTERRUPTED, any_solved
from .request import CommandLine, Trust, asked_for, each_once
from .scheduler import Scheduler, check, kept

if TYPE_CHECKING:
    from ..experiments.points import Points
    from ..experiments.sample import Sample
    from ..study.config import Config
    from .output import Output

Over = Annotated[
    list[str] | None, typer.Option(metavar="FIELD=RANGE", help="A field's range: LOW:HIGH[:log|linear]; repeatable.")
]
Count = Annotated[str | None, typer.Option(metavar="N", help="Points, a power of two; default 256.")]
Method = Annotated[
    str | None, typer.Option(metavar="HOW", help="sobol (default), latin_hypercube, or saltelli (that of --indices).")
]
Seed = Annotated[str | None, typer.Option(metavar="N", help="Of the points; default 0.")]
Of = Annotated[
    list[str] | None, typer.Option(metavar="QUANTITY", help="What --indices and --surface are of; repeatable.")
]
IndicesOf = Annotated[bool, typer.Option("--indices", help="Sobol' indices: whose scatter matters most.")]
SurfaceOf = Annotated[bool, typer.Option("--surface", help="Fit a response surface, and tell its error.")]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with the sample in DIR, however it ended.")]


def sample(
    request: CommandLine,
    over: Over = None,
    count: Count = None,
    method: Method = None,
    seed: Seed = None,
    of: Of = None,
    indices: IndicesOf = False,
    surface: SurfaceOf = False,
    scheduler: Scheduler = None,
    resume: Resume = False,
    trust: Trust = "on",
) -> int:
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
      sample.png, .svg  the quantities over each field
      sample.txt   the summary
      sample.json  indices, surfaces and how the sample came about, for jaxbuffer report
      sample.nc    the runs as labelled arrays (netCDF), for xarray or jb.load
      indices.csv, .png, .svg  of --indices: first-order and total indices with their intervals
      surface.csv, .png, .svg  of --surface: predicted against computed
      sweep.zarr   kept up while running, the runs as labelled arrays for xarray; --resume needs it

    \b
    Example:
      jaxbuffer sample --over buffer.k_A=200:2000 --over scenario.misalignment=-0.05:0.05 --indices --output results/doe
    """
    from ..mechanisms.quantity import check_quantities
    from ..output.results import sample_files, swept_json
    from ..sweeps.grid import check_swept_once
    from ..sweeps.store import STORE

    study = request.study()
    if scheduler is not None:
        check(scheduler, request)
    points = _points(study, over or [], count, method, seed, indices)
    check_swept_once(request.fields, (axis.path for axis in points.axes), "this sample")
    parts = {"indices": indices, "surface": surface}
    names = check_quantities(study.mechanism.quantities, of or study.mechanism.defaults.mapped[:1])
    for name in names:
        if name not in study.mechanism.swept:
            raise InputError(f"--of {name}: samples have no such number; known: {', '.join(study.mechanism.swept)}")
    wanted = [f"sample.{kind}" for kind in ("csv", "png", "txt", "nc", "json")]
    wanted += [f"{name}.{kind}" for name, asked in parts.items() if asked for kind in ("csv", "png")]
    files = request.files(*wanted, resumable=(STORE,), resume=resume)
    options: dict[str, Any] = {"trust": asked_for(trust)} | ({} if scheduler is None else {"client": scheduler})
    found, interrupted = _computed(study, points, folder=request.output, resume=resume, **options)
    if found is None:
        return INTERRUPTED
    made = request.made(study, resume)
    if interrupted:
        files.save_and_show(lambda: sample_files(found, made), found, lambda: swept_json(found))
        return INTERRUPTED
    return _told(found, names, (indices, surface), files, made)


def _points(
    study: "Config", over: list[str], count: str | None, method: str | None, seed: str | None, indices: bool
) -> "Points":
    from ..experiments.points import METHODS, points
    from ..experiments.ranges import ranges, typed

    section = dict(study.sample)
    asked = {**section.pop("ranges", {}), **each_once(over, typed, "keep one")}
    chosen = method or section.get("method") or ("saltelli" if indices else METHODS[0])
    number = _whole("count", count) if count is not None else section.get("count", 256)
    start = _whole("seed", seed) if seed is not None else section.get("seed", 0)
    axes = ranges(asked or study.mechanism.defaults.variables, study.design, study.scenario)
    return points(axes, number, chosen, start)


def _whole(name: str, text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise InputError(f"--{name} {text} is not a whole number; 256 say") from None


def _computed(study: "Config", points: "Points", folder: Any, **options: Any) -> "tuple[Sample | None, bool]":
    """The sample, as far as it came, and whether it was interrupted; ``options`` as of `sample`."""
    from ..experiments.sample import sample_at
    from ..sweeps.result import SweepInterrupted
    from .progress import sweeping

    options |= {"solver": study.options.stepper(), "rtol": study.options.rtol, "folder": folder}
    asked = (points, study.design, study.scenario, study.options.duration)
    try:
        return sweeping(len(points), lambda report: sample_at(*asked, progress=report, **options)), False
    except SweepInterrupted as stop:
        kept(stop.found, int(stop.done.sum()), stop.done.size, folder)
        return (stop.found if stop.done.any() else None), True


def _told(
    found: "Sample", names: tuple[str, ...], asked: tuple[bool, bool], files: "Output", made: Mapping[str, Any]
) -> int:
    """Indices and surfaces, if ``asked`` for, saved and printed; where one cannot be had, the sample is saved and it is
    said why."""
    from ..experiments.indices import sobol_indices
    from ..experiments.surface import response_surface
    from ..output.results import sample_files, sample_text, swept_json
    from .progress import working

    (indices, surface), refused = asked, None
    found_indices, surfaces, varying = None, list[Any](), list[str]()
    for name in names if indices or surface else ():
        try:
            found.check_varies(name, "indices and response surface")
            varying.append(name)
        except InputError as error:  # a quantity that is the same everywhere takes nothing from the others
            refused = error
    try:
        if surface:
            surfaces = working("fitting response surfaces", lambda: [response_surface(found, name) for name in varying])
        if indices and varying:
            found_indices = working("resampling", lambda: sobol_indices(found, varying))
    except InputError as error:
        refused = error
    shown = sample_text(found, found_indices, surfaces)
    files.save_and_show(lambda: sample_files(found, made, found_indices, surfaces), shown, lambda: swept_json(found))
    if refused is not None:
        raise refused
    return any_solved(found)
