"""The files of each command: names, and what makes their contents, in the order in which they are saved."""

from typing import TYPE_CHECKING

from .output import ARRAYS, Contents, csv_text, json_text
from .streams import note

if TYPE_CHECKING:
    from ..capture import Capture
    from ..sensitivity import Sensitivity
    from ..swept import Swept
    from ..tuning import Tuned


def capture_files(capture: "Capture") -> Contents:
    """Of `jaxbuffer simulate`."""
    from .. import plot
    from .records import capture_history, capture_record

    if capture.history is not None and (kept := capture.history.time.size) < int(capture.accepted):
        note(f"the history holds the first {kept} steps only")
    return {
        "capture.json": lambda: json_text(capture_record(capture)),
        "history.csv": lambda: csv_text(*capture_history(capture)),
        "capture.txt": lambda: f"{capture!r}\n",
        "capture.png": lambda: plot.png(plot.capture_figure(capture)),
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
    from .. import plot
    from ..config import design_toml
    from .records import tuned_comment, tuned_record, tuning_history

    return {
        "design.toml": lambda: design_toml(tuned.design, tuned.problem.meetings, tuned_comment(tuned)),
        "tuned.json": lambda: json_text(tuned_record(tuned)),
        "history.csv": lambda: csv_text(*tuning_history(tuned)),
        "tune.txt": lambda: f"{tuned!r}\n",
        "tune.png": lambda: plot.png(plot.tune_figure(tuned)),
    }


def swept_files(swept: "Swept") -> Contents:
    """Of `jaxbuffer sweep`."""
    from ..plot_style import png
    from ..sweep_plot import sweep_figure
    from .sweep_files import FIGURE, TABLE, arrays, rows

    return {
        ARRAYS: lambda: arrays(swept),
        TABLE: lambda: csv_text(*rows(swept)),
        FIGURE: lambda: png(sweep_figure(swept)),
    }
