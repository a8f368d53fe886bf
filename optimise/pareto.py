"""(c) The front of peak force against stroke: the same problem under ever tighter limits on the stroke."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np

from jaxbuffer import pareto
from jaxbuffer.output.formats import csv_text
from jaxbuffer.output.tuned_records import front_rows

from .study import config, figure, print_record, write

LIMITS = (0.025, 0.02, 0.016, 0.013, 0.01, 0.008, 0.006)  # m


def main(folder: Path, resume: bool = False, client: Any = None) -> None:
    """A tuning a limit, each from the last one's design; the front as table and figure."""
    study = config("pareto")
    settings = {field.name: getattr(study.tuning, field.name) for field in dataclasses.fields(study.tuning)}
    front = pareto(
        study.problem(),
        ["peak_force", "stroke"],
        limits={"stroke": LIMITS},
        folder=folder,
        resume=resume,
        client=client,
        report=print_record,
        **settings,
    )
    print(front, flush=True)
    write(folder, "pareto.txt", f"{front!r}\n")
    write(folder, "pareto.csv", csv_text(*front_rows(front)))
    feasible, stroke = front.feasible, 1e3 * front.values[:, 1]
    hinge = front.problem.names.index("peak_hinge_force")
    hinge_force = np.array([point.after.quantities[:, hinge].max() for point in front.points])

    def draw(axes: Any) -> None:
        axes.plot(stroke[feasible], front.values[feasible, 0], "o-", label="peak contact force")
        axes.plot(stroke[feasible], hinge_force[feasible], "s--", label="peak hinge force")
        lower_bound = front.points[0].lower_bound
        assert lower_bound is not None
        axes.axhline(lower_bound.lowest, color="#888888", linewidth=0.8, label="lower bound within the bounds")
        axes.set(xlabel="stroke, worst scenario [mm]", ylabel="force, worst scenario [N]", title="Force against stroke")
        axes.legend()

    figure(folder, "pareto.png", draw)
