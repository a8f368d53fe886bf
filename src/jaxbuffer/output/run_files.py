"""The files of a run and of its sensitivities: names, and what makes their contents."""

from ..labelled.netcdf import SUFFIX, content
from ..mechanisms.run import Run
from ..run.trust import Trust
from ..sensitivities.result import Sensitivity, sensitivity_rows
from ..tables import text
from ..tuning.problem.cases import numbered
from ..tuning.problem.objective import Constraints
from ..tuning.report.levers import NO_LEVERS, Levers, lever_table, levers_record
from ..tuning.report.limit_rows import run_limit_table, tightest_text
from . import matlab, records, style
from .field_files import field_files
from .figures import run_figure
from .formats import Contents, Made, Writers, compact_json, csv_text
from .motion import motion_figure
from .page_data import force_record, motion_record
from .provenance import record_text
from .sensitivity_figure import drawn, sensitivity_figure


def run_files(
    run: Run,
    made: Made = None,
    constraints: Constraints | None = None,
    trust: Trust | None = None,
    number: str = "",
    levers: Levers = NO_LEVERS,
) -> Contents:
    """Return the files of `jaxbuffer simulate`, named after what the mechanism calls a run.

    **Arguments:** ``run``: without its history it has neither figures nor tables of it; ``made``: how it came about;
    ``constraints``: of its study; ``trust``: how far its numbers can be trusted; ``number``: of its scenario among the
    study's, "" for a single one; ``levers`` of its limits, where they were asked for.
    """
    name, label = run.mechanism.view.run_name, numbered(run.mechanism.view.label(run.scenario), number)
    files: Writers = {
        f"{name}.json": lambda: record_text(
            records.run_record(run, constraints, trust, number) | ({"levers": levers_record(levers)} if levers else {}),
            made,
        ),
        "force.json": lambda: compact_json(force_record({name: run}, label)),
        "history.csv": lambda: csv_text(*records.run_history(run)),
        "motion.json": lambda: compact_json(motion_record(run)),
        f"{name}.txt": lambda: f"{run_text(run, constraints, number, levers)}\n",
        **style.both(name, lambda: run_figure(run, "" if constraints is None else tightest_text(run, constraints))),
        **style.both("motion", lambda: motion_figure(run)),
        f"{name}{SUFFIX}": lambda: content(run.to_xarray()),
        f"{name}{matlab.SUFFIX}": lambda: matlab.run_mat(run),
        **field_files(run),
    }
    # All others draw or list values over time.
    without_history = (f"{name}.json", f"{name}.txt", f"{name}{SUFFIX}", f"{name}{matlab.SUFFIX}")
    return files if run.history is not None else {file: files[file] for file in without_history}


def run_text(run: Run, constraints: Constraints | None = None, number: str = "", levers: Levers = NO_LEVERS) -> str:
    """Return how a run ended, the table of its study's limits with their levers, and the rest of its summary; arguments
    as of `run_files`."""
    limits = None if constraints is None else run_limit_table(run, constraints, number)
    if limits is None or constraints is None:
        return repr(run)
    ended, _, rest = repr(run).partition("\n")
    moved = lever_table(levers, constraints.catalogue(run.mechanism))
    # Margins first: they are what a reader asks for.
    return "\n".join([ended, text(limits, *([] if moved is None else [moved])), rest])


def sensitivity_files(result: Sensitivity, made: Made = None) -> Contents:
    """Return the files of `jaxbuffer sensitivity`. ``made``: how it came about."""
    figures = style.both("sensitivity", lambda: sensitivity_figure(result)) if drawn(result) else {}
    return {
        "sensitivity.json": lambda: record_text(records.sensitivity_record(result), made),
        "sensitivity.csv": lambda: csv_text(*sensitivity_rows(result)),
        "sensitivity.txt": lambda: f"{result!r}\n",
        **figures,
    }
