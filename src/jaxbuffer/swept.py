"""What a sweep over a grid found, and its summary."""

import dataclasses

import numpy as np

from .grid import Grid
from .mechanisms import Design, Scenario
from .outcome import Outcome
from .report import FLANKS, UNITS
from .sweep import Sweep
from .tables import table, text
from .validity import validity

SHOWN = 10  # captures that are listed of those that failed
QUANTILES = {"least": 0.0, "10 %": 0.1, "median": 0.5, "90 %": 0.9, "greatest": 1.0}


@dataclasses.dataclass(frozen=True)
class Swept:
    """A sweep over a grid. Print it for a summary.

    ``design``, ``scenario``: what the grid's values were put into; ``found``: quantities (n,) in the grid's order;
    ``done`` (n,): which captures were computed, all of them unless the sweep was interrupted.
    """

    grid: Grid
    design: Design
    scenario: Scenario
    found: Sweep
    done: np.ndarray

    @property
    def solved(self) -> np.ndarray:
        """Which captures have numbers, shape (n,): done, and not failed."""
        return self.done & (self.found.code < int(Outcome.failed_steps))

    def shaped(self, quantity: str) -> np.ndarray:
        """A quantity in the grid's shape."""
        return np.asarray(getattr(self.found, quantity)).reshape(self.grid.shape)

    def __repr__(self) -> str:
        return swept_summary(self)


def swept_summary(swept: Swept) -> str:
    """Outcomes, the spread of every quantity, the worst and the best capture, and those that failed."""
    grid, done = swept.grid, int(swept.done.sum())
    title = f"Sweep of {len(grid)} captures: " + " × ".join(f"{len(axis)} {axis.name}" for axis in grid.axes)
    parts: list = [title if done == len(grid) else f"{title}; interrupted, {done} of them done"]
    parts += [f"  {axis.path:26} {_values(axis.values)} {axis.unit}".rstrip(" -") for axis in grid.axes]
    codes, counts = np.unique(swept.found.code[swept.done], return_counts=True)
    outcomes = table("Outcomes", ("outcome",), ("captures", "share"))
    for code, count in zip(codes, counts, strict=True):
        outcomes.add_row(Outcome(int(code)).reason, str(count), f"{100.0 * count / done:.1f} %")
    parts.append(outcomes)
    if swept.solved.any():
        parts += [_spread(swept), *_extremes(swept)]
    return text(*parts, *_beyond_validity(swept), *_failures(swept))


def _beyond_validity(swept: Swept) -> list[str]:
    """How many answers lie beyond what the contact law is good for, and the worst of them."""
    found = swept.found
    design, _ = swept.grid.applied(swept.design, swept.scenario)
    share, lines = validity(design, found.penetration, found.peak_force), []
    for values, beyond, what in (
        (share.depth, share.too_deep, "the tip goes deeper into a flank than a tenth of its radius"),
        (share.pressure, share.yields, "the materials yield"),
    ):
        count = int(np.sum(beyond & swept.solved))
        if count:
            worst = int(np.argmax(np.where(beyond & swept.solved, values, -np.inf)))
            lines.append(
                f"outside the contact law's validity: {count} captures, {what};"
                f" by a factor of {values[worst]:.3g} at {swept.grid.point(worst)}"
            )
    return lines


def _values(values: np.ndarray) -> str:
    if len(values) <= 3:
        return ", ".join(f"{value:g}" for value in values)
    return f"{values[0]:g}, {values[1]:g} … {values[-1]:g}"


def _spread(swept: Swept):
    solved = swept.solved
    spread = table(f"Quantities of the {int(solved.sum())} captures that were solved", ("quantity",), tuple(QUANTILES))
    for name, symbol in ((name, symbol) for name, symbol in UNITS.items() if name in Sweep._fields):
        values = getattr(swept.found, name)[solved]
        known = values[np.isfinite(values)]
        if known.size:
            spread.add_row(f"{name} [{symbol}]", *(f"{x:.5g}" for x in np.quantile(known, list(QUANTILES.values()))))
    return spread


def _extremes(swept: Swept) -> list[str]:
    found = swept.found
    force = np.where(swept.solved, found.peak_force, np.nan)
    worst = int(np.nanargmax(force))
    lines = [f"greatest peak force {_capture(swept, worst)}"]
    captured = np.where(swept.done & (found.code == int(Outcome.captured)), found.peak_force, np.nan)
    if np.isfinite(captured).any():
        lines.append(f"least peak force of those captured {_capture(swept, int(np.nanargmin(captured)))}")
    return lines


def _capture(swept: Swept, index: int) -> str:
    found = swept.found
    flank, outcome = FLANKS[int(found.peak_flank[index])], Outcome(int(found.code[index])).name
    return (
        f"{found.peak_force[index]:.6g} N at {swept.grid.point(index)}: {flank} flank after"
        f" {found.peak_time[index]:.4g} s, {int(found.impact_count[index])} impacts, {outcome}"
    )


def _failures(swept: Swept) -> list[str]:
    failed = np.flatnonzero(swept.done & ~swept.solved)
    lines = [f"  {swept.grid.point(i)}: {Outcome(int(swept.found.code[i])).reason}" for i in failed[:SHOWN].tolist()]
    if failed.size > SHOWN:
        lines.append(f"  and {failed.size - SHOWN} more; see the column outcome in sweep.csv")
    return ["failed:", *lines] if lines else []
