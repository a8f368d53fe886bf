"""The files of each command: names, and what makes their contents, in the order in which they are saved."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from .formats import ARRAYS, ENVELOPE, Contents, csv_text, json_text

if TYPE_CHECKING:
    from ..experiments.rectangle import SafeRectangle
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


def swept_files(swept: "Swept", envelope: "SafeRectangle | None" = None) -> Contents:
    """Of `jaxbuffer sweep`. ``envelope``: what is safe of a sweep over two fields."""
    from .style import png
    from .sweep_figures import sweep_figure
    from .sweep_files import FIGURE, TABLE, arrays, rows

    files: dict[str, Callable[[], str | bytes]] = {
        ARRAYS: lambda: arrays(swept),
        TABLE: lambda: csv_text(*rows(swept)),
        FIGURE: lambda: png(sweep_figure(swept)),
    }
    if envelope is not None:
        from .envelope_figure import envelope_figure

        figure, words = ENVELOPE
        files |= {figure: lambda: png(envelope_figure(envelope)), words: lambda: f"{envelope!r}\n"}
    return files
