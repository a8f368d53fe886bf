"""The files of each command: names, and what makes their contents, in the order in which they are saved."""

import math
from typing import TYPE_CHECKING

from .formats import ARRAYS, Contents, csv_text, json_text

if TYPE_CHECKING:
    from ..mechanisms.run import Run
    from ..sensitivities.sensitivity import Sensitivity
    from ..sweeps.swept import Swept
    from ..tuning.tuned import Tuned


def run_files(run: "Run") -> Contents:
    """Of `jaxbuffer simulate`, named after what the mechanism calls a run."""
    from .figures import run_figure
    from .records import run_history, run_record
    from .style import png

    name = run.mechanism.run_name
    return {
        f"{name}.json": lambda: json_text(run_record(run)),
        "history.csv": lambda: csv_text(*run_history(run)),
        f"{name}.txt": lambda: f"{run!r}\n",
        f"{name}.png": lambda: png(run_figure(run)),
    }


def sensitivity_files(result: "Sensitivity") -> Contents:
    """Of `jaxbuffer sensitivity`."""
    from .records import sensitivity_record, sensitivity_rows

    return {
        "sensitivity.json": lambda: json_text(sensitivity_record(result)),
        "sensitivity.csv": lambda: csv_text(*sensitivity_rows(result)),
        "sensitivity.txt": lambda: f"{result!r}\n",
    }


def tuned_files(tuned: "Tuned") -> Contents:
    """Of `jaxbuffer tune`."""
    from ..study.config import design_toml
    from .records import tuned_comment, tuned_record, tuning_history
    from .style import png
    from .tune_figure import tune_figure

    return {
        "design.toml": lambda: design_toml(tuned.design, tuned.problem.scenarios_met, tuned_comment(tuned)),
        "tuned.json": lambda: json_text(tuned_record(tuned)),
        "history.csv": lambda: csv_text(*tuning_history(tuned)),
        "tune.txt": lambda: f"{tuned!r}\n",
        "tune.png": lambda: png(tune_figure(tuned)),
    }


def swept_json(swept: "Swept") -> str:
    """A sweep as JSON: what a run is called, and its table, a record for each run."""
    from .sweep_files import rows

    header, table = rows(swept)
    finite = lambda value: None if isinstance(value, float) and not math.isfinite(value) else value  # noqa: E731
    records = [{name: finite(value) for name, value in zip(header, row, strict=True)} for row in table]
    return json_text({"runs": records})


def swept_files(swept: "Swept") -> Contents:
    """Of `jaxbuffer sweep`."""
    from .style import png
    from .sweep_figures import sweep_figure
    from .sweep_files import FIGURE, TABLE, arrays, rows

    return {
        ARRAYS: lambda: arrays(swept),
        TABLE: lambda: csv_text(*rows(swept)),
        FIGURE: lambda: png(sweep_figure(swept)),
    }
