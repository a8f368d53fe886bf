"""What every study does: read its TOML, tune, write the result beside the log."""

import dataclasses
import sys
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from jaxbuffer import Problem, Sweep, Tuned, sweep, tune
from jaxbuffer.files import write as write_whole
from jaxbuffer.output.formats import csv_text, json_text
from jaxbuffer.output.style import png
from jaxbuffer.output.tune_figure import tune_figure
from jaxbuffer.output.tuned_records import tuned_comment, tuned_record
from jaxbuffer.study.config import Config
from jaxbuffer.study.design_toml import design_toml
from jaxbuffer.study.load import load
from jaxbuffer.sweeps.store import STORE
from jaxbuffer.tuning.report.tuned import tuning_history
from jaxbuffer.tuning.search.store import in_words

HERE = Path(__file__).parent


def config(name: str) -> Config:
    """The study's TOML."""
    return load(HERE / f"{name}.toml")


def tuned(
    study: Config, folder: Path, resume: bool, executor: Executor | None = None, problem: Problem | None = None
) -> Tuned:
    """Tune its problem (or a variant of it), by an ``executor`` if there is one, and write result, history and figure;
    go on where a log is, if asked."""
    settings = {field.name: getattr(study.tuning, field.name) for field in dataclasses.fields(study.tuning)}
    problem = problem or study.problem()
    resume = resume and (folder / "log.jsonl").exists()
    solver = study.options.solver
    keeping = {"folder": folder, "resume": resume}
    result = tune(problem, **settings, **keeping, solver=solver, executor=executor, report=print_record)
    write(folder, "design.toml", design_toml(result.design, problem.scenarios_met, tuned_comment(result)))
    write(folder, "tuned.json", json_text(tuned_record(result)))
    write(folder, "history.csv", csv_text(*tuning_history(result)))
    write(folder, "tune.png", png(tune_figure(result)))
    print(result, flush=True)
    return result


class Sweeps:
    """The sweeps of a study, one after the other: by threads, or by an ``executor``, then each stored in a folder of
    its own below ``folder``, from where ``resume`` goes on."""

    def __init__(self, folder: Path, resume: bool, executor: Executor | None) -> None:
        self.folder, self.resume, self.executor, self.count = folder, resume, executor, 0

    def found(self, design: Any, scenario: Any, duration: float | None, rtol: float) -> Sweep:
        """The next one: designs as an array of each number that differs."""
        if self.executor is None:
            return sweep(design, scenario, duration, rtol=rtol)
        self.count += 1
        place = self.folder / f"sweep-{self.count}"
        going_on = self.resume and (place / STORE).exists()
        keeping: dict[str, Any] = {"folder": place, "resume": going_on, "save": False}
        return sweep(design, scenario, duration, rtol=rtol, executor=self.executor, **keeping)


def write(folder: Path, name: str, content: str | bytes) -> None:
    """Write one result, over an earlier one."""
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / name, content)
    print(f"wrote {folder / name}", flush=True)


def figure(folder: Path, name: str, draw: Callable[[Any], None], columns: int = 1) -> None:
    """A figure of its own: ``draw`` gets its axes, an array if there are several columns."""
    import matplotlib
    from matplotlib.figure import Figure

    from jaxbuffer.output.style import STYLE

    with matplotlib.rc_context(STYLE):
        drawn = Figure(figsize=(5.0 * columns, 3.6), layout="constrained")
        draw(drawn.subplots(1, columns))
        write(folder, name, png(drawn))


def print_record(record: dict[str, Any]) -> None:
    """One evaluation on stderr."""
    print(in_words(record), file=sys.stderr, flush=True)
