"""(c) The front of peak force against stroke: the same problem under ever tighter limits on the stroke."""

import dataclasses
from pathlib import Path
from typing import Any

from jaxbuffer import Limits
from jaxbuffer.output.formats import csv_text

from .study import config, figure, tuned, write

LIMITS = (0.006, 0.008, 0.01, 0.013, 0.016, 0.02, 0.025)  # m


def main(folder: Path, resume: bool = False) -> None:
    """A tuning a limit, each from the last one's design; the front as table and figure."""
    study = config("pareto")
    problem, rows = study.problem(), []
    for limit in reversed(LIMITS):
        limits = Limits(problem.limits.captured, {"stroke": limit}, problem.limits.impacts)
        problem = dataclasses.replace(problem, limits=limits)
        found = tuned(study, folder / f"{1e3 * limit:g}mm", resume, problem)
        worst = found.after.quantities.max(axis=0)
        rows.append(
            [limit, float(worst[3]), float(worst[0]), float(worst[1]), float(found.floor.lowest), found.feasible]
        )
        problem = dataclasses.replace(problem, design=found.design)
    header = ["limit [m]", "stroke [m]", "peak_force [N]", "peak_hinge_force [N]", "floor [N]", "feasible"]
    write(folder, "pareto.csv", csv_text(header, rows))

    def draw(axes: Any) -> None:
        kept = [row for row in rows if row[-1]]
        axes.plot([1e3 * row[1] for row in kept], [row[2] for row in kept], "o-", label="peak contact force")
        axes.plot([1e3 * row[1] for row in kept], [row[3] for row in kept], "s--", label="peak hinge force")
        axes.axhline(rows[0][4], color="#888888", linewidth=0.8, label="floor within the bounds")
        axes.set(xlabel="stroke, worst scenario [mm]", ylabel="force, worst scenario [N]", title="Force against stroke")
        axes.legend()

    figure(folder, "pareto.png", draw)
