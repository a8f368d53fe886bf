"""`jaxbuffer sample`: runs spread over ranges, and what can be read off them."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from ...errors import InputError
from ...experiments.indices import sobol_indices
from ...experiments.points import METHODS, points
from ...experiments.ranges import ranges, typed
from ...experiments.sample import Sample, sample_at
from ...experiments.surface import response_surface
from ...mechanisms.quantity import check_quantities
from ...output.swept_files import sample_files, sample_text, swept_json
from ...sweeps.store import STORE
from ..exits import INTERRUPTED
from .output import Output
from .progress import working
from .request import CommandLine, each_once
from .runs import any_solved, computed_runs


def sample(
    request: CommandLine,
    over: list[str] | None,
    count: str | None,
    method: str | None,
    seed: str | None,
    of: list[str] | None,
    indices: bool,
    surface: bool,
    scheduler: str | None,
    resume: bool,
    trust: str,
) -> int:
    """Simulate the runs of a sample, and find indices and response surfaces if they are asked for."""
    study = request.study()
    # Before anything is computed or written: mistakes of the command line are found at once.
    section, given = study.sample, each_once(over or [], typed, "keep one")
    bounds = {**(section.ranges or {}), **given} or study.mechanism.variables(study.design)
    drawn = points(
        ranges(bounds, study.design, study.scenario),
        section.count if count is None else _whole("count", count),
        method or section.method or ("saltelli" if indices else METHODS[0]),
        section.seed if seed is None else _whole("seed", seed),
    )
    study = request.varying(study, [axis.path for axis in drawn.axes], "this sample")
    parts = {"indices": indices, "surface": surface}
    names = check_quantities(study.mechanism.quantities, of or study.mechanism.defaults_for(study.design).mapped[:1])
    for name in names:
        if name not in study.mechanism.swept:
            raise InputError(f"--of {name}: samples have no such number; known: {', '.join(study.mechanism.swept)}")
    file_names = [f"sample.{kind}" for kind in ("csv", "png", "txt", "nc", "json")]
    file_names += [f"{name}.{kind}" for name, chosen in parts.items() if chosen for kind in ("csv", "png")]
    files = request.files(*file_names, resumable=(STORE,), resume=resume)
    work = partial(sample_at, drawn, study.design, study.scenario, study.options.duration)
    result, interrupted = computed_runs(
        work, len(drawn), request, study, scheduler=scheduler, resume=resume, trust=trust
    )
    # Interrupted before its first run: there is nothing to save.
    if not result.done.any():
        return INTERRUPTED
    made = request.made(study, resume)
    if interrupted:
        files.save_and_show(lambda: sample_files(result, made), result, lambda: swept_json(result))
        return INTERRUPTED
    return _finish(result, names, (indices, surface), files, made)


def _whole(name: str, text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise InputError(f"--{name} {text} is not a whole number; 256 say") from None


def _finish(
    result: Sample, names: tuple[str, ...], chosen: tuple[bool, bool], files: Output, made: Mapping[str, Any]
) -> int:
    """Save and print a sample with the indices and surfaces that are ``chosen``; where one cannot be had, the sample is
    saved and it is said why."""
    (indices, surface), refused = chosen, None
    sobol, surfaces, varying = None, list[Any](), list[str]()
    for name in names if indices or surface else ():
        try:
            result.check_varies(name, "indices and response surface")
            varying.append(name)
        except InputError as error:  # a quantity that is the same everywhere takes nothing from the others
            refused = error
    try:
        if surface:
            surfaces = working(
                "fitting response surfaces", lambda: [response_surface(result, name) for name in varying]
            )
        if indices and varying:
            sobol = working("resampling", lambda: sobol_indices(result, varying))
    except InputError as error:
        refused = error
    shown = sample_text(result, sobol, surfaces)
    files.save_and_show(lambda: sample_files(result, made, sobol, surfaces), shown, lambda: swept_json(result))
    if refused is not None:
        raise refused
    return any_solved(result)
