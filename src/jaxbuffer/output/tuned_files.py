"""The files of a tuning and of a front: names, and what makes their contents."""

import functools
from collections.abc import Callable
from typing import Any

from ..errors import InputError
from ..run.simulate import simulate
from ..study.tuned_toml import tuned_toml
from ..tuning.report.front import Front
from ..tuning.report.tuned import Tuned, tuning_history
from . import style, tuned_records
from .formats import Contents, Made, Writers, compact_json, csv_text
from .matlab import design_mat
from .motion import contact_names
from .page_data import force_record
from .provenance import record_text
from .tune_figure import front_figure, tune_figure, worst_case


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
        # Without a contact there is no force to draw.
        if not contact_names(runs[0]):
            return []
        failed = [run.outcome.name for run in runs if run.outcome.failed]
        return left_out(failed[0]) if failed else runs

    def left_out(why: str) -> list[Any]:
        first = why.strip().splitlines()[0] if why.strip() else "the run failed"
        report(f"no force over time in tune.png, force.json: the worst scenario could not be run: {first}")
        return []

    return {
        "design.toml": lambda: tuned_design(tuned),
        "design.mat": lambda: design_mat(tuned.design),
        "tuned.json": lambda: record_text(tuned_records.tuned_record(tuned), made),
        "history.csv": lambda: csv_text(*tuning_history(tuned)),
        "force.json": lambda: compact_json(
            force_record(dict(zip(("before", "after"), worst_runs(), strict=False)), problem.label(worst_case(tuned)))
        ),
        "tune.txt": lambda: f"{tuned!r}\n",
        **style.both("tune", lambda: tune_figure(tuned, worst_runs())),
    }


def front_files(front: Front, made: Made = None) -> Contents:
    """Return the files of `jaxbuffer pareto`. ``made``: how it came about."""
    files: Writers = {f"design-{k + 1}.toml": functools.partial(tuned_design, it) for k, it in enumerate(front.points)}
    return files | {
        "pareto.csv": lambda: csv_text(*tuned_records.front_rows(front)),
        "pareto.json": lambda: record_text(tuned_records.front_record(front), made),
        "pareto.txt": lambda: f"{front!r}\n",
        **style.both("pareto", lambda: front_figure(front)),
    }


def tuned_design(tuned: Tuned) -> str:
    """Return the tuned design as a study."""
    return tuned_toml(tuned.design, tuned.problem, tuned_records.tuned_comment(tuned), tuned.worst, tuned.settings)
