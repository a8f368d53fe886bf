"""The files of each command: names, and what makes their contents, in the order in which they are saved."""

import functools
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from .formats import ARRAYS, ENVELOPE, Contents, Made, compact_json, csv_text, json_text, table_json
from .provenance import MADE

if TYPE_CHECKING:
    from ..experiments.rectangle import SafeRectangle
    from ..mechanisms.run import Run
    from ..run.trust import Trust
    from ..sensitivities.sensitivity import Sensitivity
    from ..sweeps.columns import RunTable
    from ..sweeps.result import Sweep
    from ..tuning.objective import Constraints
    from ..tuning.tuned import Tuned


def run_files(
    run: "Run", made: Made = None, constraints: "Constraints | None" = None, trust: "Trust | None" = None
) -> Contents:
    """Of `jaxbuffer simulate`, named after what the mechanism calls a run.

    **Arguments:** ``run``: with its history; ``made``: how it came about; ``constraints``: of its study;
    ``trust``: how far its numbers can be trusted.
    """
    from ..labelled.netcdf import SUFFIX, content
    from .field_files import field_files
    from .figures import run_figure
    from .force_record import force_record
    from .motion import motion_figure
    from .motion_record import motion_record
    from .records import run_history, run_record
    from .style import both

    name, label = run.mechanism.view.run_name, run.mechanism.view.label(run.scenario)
    return {
        f"{name}.json": lambda: json_text(_told(run_record(run, constraints, trust), made)),
        "force.json": lambda: compact_json(force_record({name: run}, label)),
        "history.csv": lambda: csv_text(*run_history(run)),
        "motion.json": lambda: compact_json(motion_record(run)),
        f"{name}.txt": lambda: f"{run!r}\n",
        **both(name, lambda: run_figure(run)),
        **both("motion", lambda: motion_figure(run)),
        f"{name}{SUFFIX}": lambda: content(run.to_xarray()),
        **field_files(run),
    }


def sensitivity_files(result: "Sensitivity", made: Made = None) -> Contents:
    """Of `jaxbuffer sensitivity`. ``made``: how it came about."""
    from ..sensitivities.result import sensitivity_rows
    from .records import sensitivity_record

    return {
        "sensitivity.json": lambda: json_text(_told(sensitivity_record(result), made)),
        "sensitivity.csv": lambda: csv_text(*sensitivity_rows(result)),
        "sensitivity.txt": lambda: f"{result!r}\n",
    }


def tuned_files(tuned: "Tuned", made: Made = None, report: Callable[[str], None] = lambda line: None) -> Contents:
    """Of `jaxbuffer tune`. ``made``: how it came about; ``report``: takes a line on what lacks because a run failed."""
    from ..errors import InputError
    from ..run.simulate import simulate
    from ..study.designs import tuned_toml
    from ..tuning.tuned import tuning_history
    from .force_record import force_record
    from .records import tuned_comment, tuned_record
    from .style import both
    from .tune_figure import tune_figure, worst_case

    problem, case = tuned.problem, tuned.problem.cases[worst_case(tuned)]

    @functools.cache
    def worst_runs() -> list[Any]:
        """The worst scenario before and after, with histories; none where one of them fails."""
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
        report(f"no force over time in tune.png, tune.svg, force.json: the worst scenario could not be run: {first}")
        return []

    return {
        "design.toml": lambda: tuned_toml(tuned.design, tuned.problem, tuned_comment(tuned), tuned.worst_first),
        "tuned.json": lambda: json_text(_told(tuned_record(tuned), made)),
        "history.csv": lambda: csv_text(*tuning_history(tuned)),
        "force.json": lambda: compact_json(
            force_record(dict(zip(("before", "after"), worst_runs(), strict=False)), case.label(problem.cases))
        ),
        "tune.txt": lambda: f"{tuned!r}\n",
        **both("tune", lambda: tune_figure(tuned, worst_runs())),
    }


def swept_json(swept: "RunTable") -> str:
    """A sweep or a sample as JSON: its table, a record for each run."""
    from ..sweeps.table import sweep_rows

    return table_json("runs", *sweep_rows(swept))


def swept_files(swept: "Sweep", envelope: "SafeRectangle | None" = None, made: Made = None) -> Contents:
    """Of `jaxbuffer sweep`. ``envelope``: what is safe of a sweep over two fields; ``made``: how it came about."""
    from ..labelled.netcdf import content
    from ..sweeps.table import sweep_rows
    from .experiment_records import sweep_record
    from .style import both
    from .sweep_figures import sweep_figure
    from .sweep_files import FIGURE, LABELLED, RECORD, TABLE, arrays

    files: dict[str, Callable[[], str | bytes]] = {
        ARRAYS: lambda: arrays(swept),
        TABLE: lambda: csv_text(*sweep_rows(swept)),
        **both(FIGURE.removesuffix(".png"), lambda: sweep_figure(swept)),
        LABELLED: lambda: content(swept.to_xarray()),
        RECORD: lambda: json_text(sweep_record(swept, envelope, made)),
    }
    if envelope is not None:
        from .envelope_figure import envelope_figure

        figure, words = ENVELOPE
        files |= both(figure.removesuffix(".png"), lambda: envelope_figure(envelope))
        files[words] = lambda: f"{envelope!r}\n"
    return files


def _told(record: Mapping[str, Any], made: Made) -> dict[str, Any]:
    """A record with how it came about at its end, where that is known."""
    return dict(record) if made is None else {**record, MADE: made}
