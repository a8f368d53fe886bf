"""The files of each kind of result: names, and what makes their contents; `save` writes them."""

import functools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError, check_choice
from ..experiments.indices import Indices
from ..experiments.rectangle import SafeRectangle
from ..experiments.sample import Sample
from ..experiments.surface import Surface
from ..files import Lock, user_path
from ..labelled.netcdf import SUFFIX, content
from ..mechanisms.run import Run
from ..run.simulate import simulate
from ..run.trust import Trust
from ..sensitivities.result import Sensitivity, sensitivity_rows
from ..study.tuned_toml import tuned_toml
from ..sweeps.columns import RunTable
from ..sweeps.result import Sweep
from ..sweeps.table import sweep_rows
from ..tuning.objective import Constraints
from ..tuning.pareto import Front
from ..tuning.tuned import Tuned, tuning_history
from . import formats, records, style, sweep_records, tuned_records
from .companions import stale
from .field_files import field_files
from .figures import run_figure
from .formats import Contents, Made, csv_text
from .motion import motion_figure
from .page_data import force_record, motion_record
from .provenance import MADE, made_in_python
from .sample_figures import indices_figure, sample_figure, surfaces_figure
from .sensitivity_figure import drawn, sensitivity_figure
from .sweep_figures import envelope_figure, sweep_figure
from .tune_figure import front_figure, tune_figure, worst_case

Writers = dict[str, Callable[[], str | bytes]]
OF_FIGURES = ("force.json", "motion.json")  # what a page draws itself, for which runs are evaluated again


def run_files(
    run: Run, made: Made = None, constraints: Constraints | None = None, trust: Trust | None = None
) -> Contents:
    """Return the files of `jaxbuffer simulate`, named after what the mechanism calls a run.

    **Arguments:** ``run``: without its history it has neither figures nor tables of it; ``made``: how it came about;
    ``constraints``: of its study; ``trust``: how far its numbers can be trusted.
    """
    name, label = run.mechanism.view.run_name, run.mechanism.view.label(run.scenario)
    files: Writers = {
        f"{name}.json": lambda: _json(records.run_record(run, constraints, trust), made),
        "force.json": lambda: formats.compact_json(force_record({name: run}, label)),
        "history.csv": lambda: csv_text(*records.run_history(run)),
        "motion.json": lambda: formats.compact_json(motion_record(run)),
        f"{name}.txt": lambda: f"{run!r}\n",
        **style.both(name, lambda: run_figure(run)),
        **style.both("motion", lambda: motion_figure(run)),
        f"{name}{SUFFIX}": lambda: content(run.to_xarray()),
        **field_files(run),
    }
    # All others draw or list values over time.
    without_history = (f"{name}.json", f"{name}.txt", f"{name}{SUFFIX}")
    return files if run.history is not None else {file: files[file] for file in without_history}


def sensitivity_files(result: Sensitivity, made: Made = None) -> Contents:
    """Return the files of `jaxbuffer sensitivity`. ``made``: how it came about."""
    figures = style.both("sensitivity", lambda: sensitivity_figure(result)) if drawn(result) else {}
    return {
        "sensitivity.json": lambda: _json(records.sensitivity_record(result), made),
        "sensitivity.csv": lambda: csv_text(*sensitivity_rows(result)),
        "sensitivity.txt": lambda: f"{result!r}\n",
        **figures,
    }


def tuned_files(tuned: Tuned, made: Made = None, report: Callable[[str], None] = lambda line: None) -> Contents:
    """Return the files of `jaxbuffer tune`.

    **Arguments:** ``made``: how it came about; ``report``: takes a line on what is missing because a run failed.
    """
    problem, case = tuned.problem, tuned.problem.cases[worst_case(tuned)]

    # Run once and only where a file asks for it: both the record and the figures draw the same runs.
    @functools.cache
    def worst_runs() -> list[Any]:
        """Return the worst scenario before and after, with histories; none where one of them fails."""
        try:
            runs = [
                simulate(case.of(design), case.scenario, problem.duration, history=True)
                for design in (problem.design, tuned.design)
            ]
        except (InputError, RuntimeError) as error:
            return left_out(str(error))
        failed = [run.outcome.name for run in runs if run.outcome.failed]
        return left_out(failed[0]) if failed else runs

    def left_out(why: str) -> list[Any]:
        first = why.strip().splitlines()[0] if why.strip() else "the run failed"
        report(f"no force over time in tune.png, force.json: the worst scenario could not be run: {first}")
        return []

    return {
        "design.toml": lambda: _design(tuned),
        "tuned.json": lambda: _json(tuned_records.tuned_record(tuned), made),
        "history.csv": lambda: csv_text(*tuning_history(tuned)),
        "force.json": lambda: formats.compact_json(
            force_record(dict(zip(("before", "after"), worst_runs(), strict=False)), case.label(problem.cases))
        ),
        "tune.txt": lambda: f"{tuned!r}\n",
        **style.both("tune", lambda: tune_figure(tuned, worst_runs())),
    }


def swept_json(swept: RunTable) -> str:
    """Return a sweep or a sample as JSON: its table, a record for each run."""
    return formats.table_json("runs", *sweep_rows(swept))


def swept_files(swept: Sweep, made: Made = None, envelope: SafeRectangle | None = None) -> Contents:
    """Return the files of `jaxbuffer sweep`.

    **Arguments:** ``made``: how it came about; ``envelope``: what is safe of a sweep over two fields.
    """
    files: Writers = {
        "sweep.csv": lambda: csv_text(*sweep_rows(swept)),
        "sweep.txt": lambda: "".join(f"{it!r}\n" for it in (swept, envelope) if it is not None),
        "sweep.nc": lambda: content(swept.to_xarray()),
        "sweep.json": lambda: _json(sweep_records.sweep_record(swept, envelope), made),
    }
    if swept.grid is not None:
        files |= style.both("sweep", lambda: sweep_figure(swept))
    if envelope is not None:
        files |= style.both("envelope", lambda: envelope_figure(envelope))
    return files


def sample_files(
    sample: Sample, made: Made = None, indices: Indices | None = None, surfaces: Sequence[Surface] = ()
) -> Contents:
    """Return the files of `jaxbuffer sample`.

    **Arguments:** ``made``: how it came about; ``indices``, ``surfaces``: what was computed from the sample.
    """
    files: Writers = {
        "sample.csv": lambda: csv_text(*sweep_rows(sample)),
        "sample.json": lambda: _json(sweep_records.sample_record(sample, indices, surfaces), made),
        "sample.txt": lambda: f"{sample_text(sample, indices, surfaces)}\n",
        "sample.nc": lambda: content(sample.to_xarray()),
        **style.both("sample", lambda: sample_figure(sample)),
    }
    if indices is not None:
        files["indices.csv"] = lambda: csv_text(*sweep_records.indices_rows(indices))
        files |= style.both("indices", lambda: indices_figure(indices))
    if surfaces:
        files["surface.csv"] = lambda: csv_text(*sweep_records.surface_rows(surfaces))
        files |= style.both("surface", lambda: surfaces_figure(surfaces))
    return files


def sample_text(sample: Sample, indices: Indices | None, surfaces: Sequence[Surface]) -> str:
    """Return the summaries of a sample and of what was computed from it."""
    return "\n\n".join(map(repr, [sample, *([] if indices is None else [indices]), *surfaces]))


def front_files(front: Front, made: Made = None) -> Contents:
    """Return the files of `jaxbuffer pareto`. ``made``: how it came about."""
    files: Writers = {f"design-{k + 1}.toml": functools.partial(_design, it) for k, it in enumerate(front.points)}
    return files | {
        "pareto.csv": lambda: csv_text(*tuned_records.front_rows(front)),
        "pareto.json": lambda: _json(tuned_records.front_record(front), made),
        "pareto.txt": lambda: f"{front!r}\n",
        **style.both("pareto", lambda: front_figure(front)),
    }


def _design(tuned: Tuned) -> str:
    return tuned_toml(
        tuned.design, tuned.problem, tuned_records.tuned_comment(tuned), tuned.worst_first, tuned.settings
    )


def _json(record: Mapping[str, Any], made: Made) -> str:
    """Return a record with how it came about at its end, where that is known, as text."""
    return formats.json_text(record if made is None else {**record, MADE: made})


KINDS: dict[type, Callable[..., Contents]] = {
    Run: run_files,
    Sensitivity: sensitivity_files,
    Sweep: swept_files,
    Sample: sample_files,
    Tuned: tuned_files,
    Front: front_files,
}


def save(
    result: Run | Sensitivity | Sweep | Sample | Tuned | Front,
    folder: str | Path,
    *,
    force: bool = False,
    figures: bool = True,
    format: str = "png",
    **beside: Any,
) -> tuple[Path, ...]:
    """Write a result into a folder, as the command of its kind does: what `load` and `report` read.

    ``result.save(folder)`` is the same.

    **Arguments:**

    - ``result``: of `simulate`, `sensitivity`, `sweep`, `sample`, `tune` or `pareto`. A run is drawn where it has a
      history.
    - ``folder``: made if it is not there.
    - ``force``: whether to replace files that are there; those of an earlier result of the same kind are removed.
    - ``figures``: whether to draw; without, the force over time of a tuning is left out too, which takes two runs.
    - ``format``: of the figures: "png", "svg" or "both".
    - ``beside``: what was computed from it: ``trust`` of a run, ``envelope`` (a `SafeRectangle`) of a sweep,
      ``indices`` and ``surfaces`` of a sample.

    **Returns:** the files' paths.

    **Raises:** `InputError` for files that are there, a folder in use, runs that failed, and what is no result.

    **Example:**

    >>> import tempfile
    >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in jb.save(run, folder)], jb.load(folder).run.outcome
    (['drop.json', 'drop.txt', 'drop.nc'], 'finished')
    """
    folder = user_path(folder)
    check_choice("format", format, ("png", "svg", "both"))
    contents = formats.with_figures(_contents(result, beside), format)
    if not figures:
        contents = {name: it for name, it in contents.items() if not (formats.is_figure(name) or name in OF_FIGURES)}
    if any(map(formats.is_figure, contents)):
        style.require_matplotlib()
    formats.check_folder(folder)
    formats.check_free(folder, [*sorted(contents), *(path.name for path in stale(folder, contents))], force)
    lock = Lock(folder)
    try:
        written, failure = formats.write_all(folder, contents, force)
    finally:
        lock.release()
    if failure is not None:
        raise failure
    return tuple(written)


def _contents(result: Any, beside: Mapping[str, Any]) -> Contents:
    """Return the files of any result. **Raises:** `InputError` for what is none, or has failed."""
    files = next((files for kind, files in KINDS.items() if isinstance(result, kind)), None)
    if files is None:
        raise InputError(
            f"save: expected a result of simulate, sensitivity, sweep, sample, tune or pareto; found a"
            f" {type(result).__name__}"
        )
    run = result.run if isinstance(result, Sensitivity) else result
    if isinstance(run, Run) and run._many:
        raise InputError("save takes one run that is solved, not a batch or a traced one; sweep many with jb.sweep")
    if isinstance(run, Run) and run.outcome.failed:
        raise InputError(f"save: the {run.mechanism.view.run_name} failed, {run.outcome.reason}")
    return files(result, made_in_python(), **beside)
