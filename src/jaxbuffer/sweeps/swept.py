"""What a sweep over a grid found, and its summary."""

import dataclasses
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from rich.table import Table

from ..fields import Part
from ..tables import table, text
from .grid import Grid, grid
from .sweep import Sweep, sweep

SHOWN = 10  # runs that are listed of those that failed
QUANTILES = {"least": 0.0, "10 %": 0.1, "median": 0.5, "90 %": 0.9, "greatest": 1.0}


@dataclasses.dataclass(frozen=True)
class Swept:
    """A sweep over a grid. Print it for a summary.

    ``design``, ``scenario``: what the grid's values were put into; ``found``: quantities (n,) in the grid's order;
    ``done`` (n,): which runs were computed, all of them unless the sweep was interrupted.
    """

    grid: Grid
    design: Part
    scenario: Part
    found: Sweep
    done: np.ndarray

    @property
    def solved(self) -> np.ndarray:
        """Which runs have numbers, shape (n,): done, and not failed."""
        return self.done & self.found.solved

    def shaped(self, quantity: str) -> np.ndarray:
        """A quantity in the grid's shape."""
        return self.found.columns[quantity].reshape(self.grid.shape)

    def __repr__(self) -> str:
        return swept_summary(self)


def swept_over(design: Part, scenario: Part, values: Mapping[str, Any], **options: Any) -> Swept:
    """A sweep over every combination of some fields' values.

    **Arguments:** ``values``: by dotted path, as `grid` reads them; ``options``: the other arguments of `sweep`.
    """
    over = grid(values, design, scenario)
    return Swept(over, design, scenario, sweep(*over.applied(design, scenario), **options), np.ones(len(over), bool))


def swept_summary(swept: Swept) -> str:
    """Outcomes, the spread of every quantity, the worst and the best run, and those that failed."""
    over, done = swept.grid, int(swept.done.sum())
    mechanism = swept.found.mechanism
    title = f"Sweep of {len(over)} {mechanism.run_name}s: " + " × ".join(
        f"{len(axis)} {axis.name}" for axis in over.axes
    )
    parts: list = [title if done == len(over) else f"{title}; interrupted, {done} of them done"]
    parts += [f"  {axis.path:26} {_values(axis.values)} {axis.unit}".rstrip(" -") for axis in over.axes]
    return text(*parts, outcomes_table(swept), *what_was_found(swept, "sweep.csv"))


class Computed(Protocol):
    """Runs somewhere: ``grid`` says where each lies, ``design`` and ``scenario`` what its values were put into."""

    @property
    def grid(self) -> Any: ...
    @property
    def design(self) -> Part: ...
    @property
    def scenario(self) -> Part: ...
    @property
    def found(self) -> Sweep: ...
    @property
    def done(self) -> np.ndarray: ...
    @property
    def solved(self) -> np.ndarray: ...


def outcomes_table(swept: Computed) -> Table:
    """How many runs ended how."""
    mechanism = swept.found.mechanism
    codes, counts = np.unique(swept.found.code[swept.done], return_counts=True)
    outcomes = table("Outcomes", ("outcome",), (f"{mechanism.run_name}s", "share"))
    for code, count in zip(codes, counts, strict=True):
        share = f"{100.0 * count / int(swept.done.sum()):.1f} %"
        outcomes.add_row(mechanism.outcomes(int(code)).reason, str(count), share)
    return outcomes


def what_was_found(swept: Computed, file: str) -> list[str | Table]:
    """The spread of every quantity, the worst and the best run, what lies beyond validity, and those that failed.

    ``file``: where all of these can be looked up.
    """
    parts: list[str | Table] = []
    if swept.solved.any():
        parts += [_spread(swept), *_extremes(swept)]
    return [*parts, *_beyond_validity(swept), *_failures(swept, file)]


def _beyond_validity(swept: Computed) -> list[str]:
    """How many answers lie beyond each limit of validity, and the worst of them."""
    found, mechanism = swept.found, swept.found.mechanism
    design, _ = swept.grid.applied(swept.design, swept.scenario)
    lines = []
    for limit in mechanism.validity(design, found.peak_force, found.penetration):
        beyond = limit.passed & swept.solved
        if count := int(np.sum(beyond)):
            share = np.asarray(limit.share)
            worst = int(np.argmax(np.where(beyond, share, -np.inf)))
            lines.append(
                f"{limit.beyond}, {count} {mechanism.run_name}s;"
                f" by a factor of {share[worst]:.3g} at {swept.grid.point(worst)}"
            )
    return lines


def _values(values: np.ndarray) -> str:
    if len(values) <= 3:
        return ", ".join(f"{value:g}" for value in values)
    return f"{values[0]:g}, {values[1]:g} … {values[-1]:g}"


def _spread(swept: Computed):
    solved = swept.solved
    mechanism = swept.found.mechanism
    what = f"Quantities of the {int(solved.sum())} {mechanism.run_name}s that were solved"
    spread = table(what, ("quantity",), tuple(QUANTILES))
    for name in mechanism.swept:
        values, symbol = swept.found.columns[name][solved], mechanism.quantities[name].unit
        known = values[np.isfinite(values)]
        if known.size:
            spread.add_row(f"{name} [{symbol}]", *(f"{x:.5g}" for x in np.quantile(known, list(QUANTILES.values()))))
    return spread


def _extremes(swept: Computed) -> list[str]:
    found, success = swept.found, swept.found.mechanism.success
    force = np.where(swept.solved, found.peak_force, np.nan)
    lines = [f"greatest peak force {_run(swept, int(np.nanargmax(force)))}"]
    good = np.ones(len(found), bool) if success is None else found.code == found.mechanism.outcomes[success]
    least = np.where(swept.solved & good, found.peak_force, np.nan)
    if np.isfinite(least).any():
        of = "" if success is None else f" of those {success}"
        lines.append(f"least peak force{of} {_run(swept, int(np.nanargmin(least)))}")
    return lines


def _run(swept: Computed, index: int) -> str:
    found, names = swept.found, swept.found.mechanism.names(swept.design)
    kind = found.mechanism.contact
    contact = f"{names.contacts[int(found.columns[f'peak_{kind}'][index])]} {kind}"
    return (
        f"{found.peak_force[index]:.6g} N at {swept.grid.point(index)}: {contact} after"
        f" {found.peak_time[index]:.4g} s, {int(found.impact_count[index])} impacts, {found.outcomes[index].name}"
    )


def _failures(swept: Computed, file: str) -> list[str]:
    failed = np.flatnonzero(swept.done & ~swept.solved)
    lines = [
        f"  {swept.grid.point(i)}: {swept.found.mechanism.outcomes(int(swept.found.code[i])).reason}"
        for i in failed[:SHOWN].tolist()
    ]
    if failed.size > SHOWN:
        lines.append(f"  and {failed.size - SHOWN} more; see the column outcome in {file}")
    return ["failed:", *lines] if lines else []
