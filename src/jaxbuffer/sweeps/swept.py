"""What a sweep over a grid found, and its summary."""

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from ..fields import Part
from ..mechanisms.mechanism import Mechanism
from ..tables import html, table, text
from .found import Sweep
from .grid import Axis, Grid

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

SHOWN = 10  # runs that are listed of those that failed
QUANTILES = {"least": 0.0, "10 %": 0.1, "median": 0.5, "90 %": 0.9, "greatest": 1.0}


@dataclasses.dataclass(frozen=True)
class Swept:
    """A sweep over a grid. Print it for a summary.

    ``design``, ``scenario``: what the grid's values were put into; ``found``: quantities (n,) in the grid's order;
    ``done`` (n,): which runs were computed, all of them unless the sweep was interrupted.

    **Example:**

    >>> found = jb.sweep(jb.BarDrop(), jb.BarDropScenario(), 0.05, over={"scenario.height": [0.1, 0.194]})
    >>> found.to_xarray().outcome.values.tolist()
    ['finished', 'finished']
    """

    grid: Grid
    design: Part
    scenario: Part
    found: Sweep
    done: np.ndarray

    @property
    def mechanism(self) -> Mechanism:
        """Of which these are runs."""
        return self.found.mechanism

    @property
    def solved(self) -> np.ndarray:
        """Which runs have numbers, shape (n,): done, and not failed."""
        return self.done & self.found.solved

    def shaped(self, quantity: str) -> np.ndarray:
        """A quantity in the grid's shape."""
        return self.found.columns[quantity].reshape(self.grid.shape)

    def to_xarray(self) -> "xr.Dataset":
        """The sweep as labelled arrays: a dimension for each field, named by its dotted path, with its values.

        Each quantity is a variable of the grid's shape with its unit in the attribute ``units``, NaN where a run
        failed; ``outcome`` is in words, "not computed" where the sweep was interrupted.

        **Example:**

        >>> found = jb.sweep(jb.BarDrop(), jb.BarDropScenario(), 0.22, over={"scenario.height": [0.1, 0.194]})
        >>> data = found.to_xarray()
        >>> dict(data.sizes), data.peak_force.units, str(data.outcome.sel({"scenario.height": 0.1}).item())
        ({'scenario.height': 2}, 'N', 'finished')
        """
        from .dataset import swept_dataset

        return swept_dataset(self)

    def to_pandas(self) -> "pd.DataFrame":
        """A row for each run that was computed, as in sweep.csv: its values, outcome and results, units in the
        columns' names."""
        from ..labelled.arrays import frame
        from .dataset import swept_rows

        return frame(*swept_rows(self))

    def __repr__(self) -> str:
        return text(*swept_parts(self))

    def _repr_html_(self) -> str:
        return html(*swept_parts(self))


def swept_parts(swept: Swept) -> list[str | Table]:
    """Outcomes, the spread of every quantity, the worst and the best run, and those that failed."""
    grid, done = swept.grid, int(swept.done.sum())
    mechanism = swept.found.mechanism
    title = f"Sweep of {len(grid)} {mechanism.run_name}s: " + " × ".join(
        f"{len(axis)} {axis.name}" for axis in grid.axes
    )
    parts: list[str | Table] = [title if done == len(grid) else f"{title}; interrupted, {done} of them done"]
    parts += [f"  {axis.path:26} {_values(axis)}" for axis in grid.axes]
    codes, counts = np.unique(swept.found.code[swept.done], return_counts=True)
    outcomes = table("Outcomes", ("outcome",), (f"{mechanism.run_name}s", "share"))
    for code, count in zip(codes, counts, strict=True):
        outcomes.add_row(mechanism.outcomes(int(code)).reason, str(count), f"{100.0 * count / done:.1f} %")
    parts.append(outcomes)
    if swept.solved.any():
        parts += [_spread(swept), *_extremes(swept)]
    return [*parts, *_beyond_validity(swept), *_failures(swept)]


def _beyond_validity(swept: Swept) -> list[str]:
    """How many answers lie beyond each limit of validity, and the worst of them."""
    found, mechanism, shares = swept.found, swept.found.mechanism, dict[str, np.ndarray]()
    for places, design, _ in swept.grid.batches(swept.design, swept.scenario):
        for limit in mechanism.validity(design, found.peak_force[places], found.penetration[places]):
            share = shares.setdefault(limit.beyond, np.full(len(found), -np.inf))
            share[places] = np.where(limit.passed & swept.solved[places], limit.share, -np.inf)
    lines = []
    for beyond, share in shares.items():
        if count := int(np.sum(share > -np.inf)):
            worst = int(np.argmax(share))
            furthest = f"by a factor of {share[worst]:.3g} at {swept.grid.point(worst)}"
            lines.append(f"{beyond}, {count} {mechanism.run_name}s; {furthest}")
    return lines


def _values(axis: Axis) -> str:
    values = axis.values
    if not axis.unit:
        return ", ".join(axis.words(value) for value in values)
    few = [f"{value:g}" for value in values]
    listed = ", ".join(few) if len(few) <= 3 else f"{few[0]}, {few[1]} … {few[-1]}"
    return f"{listed} {axis.unit}".rstrip(" -")


def _spread(swept: Swept) -> Table:
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


def _extremes(swept: Swept) -> list[str]:
    found, success = swept.found, swept.found.mechanism.success
    force = np.where(swept.solved, found.peak_force, np.nan)
    lines = [f"greatest peak force {_run(swept, int(np.nanargmax(force)))}"]
    good = np.ones(len(found), bool) if success is None else found.code == found.mechanism.outcomes[success]
    least = np.where(swept.solved & good, found.peak_force, np.nan)
    if np.isfinite(least).any():
        of = "" if success is None else f" of those {success}"
        lines.append(f"least peak force{of} {_run(swept, int(np.nanargmin(least)))}")
    return lines


def _run(swept: Swept, index: int) -> str:
    found, names = swept.found, swept.found.mechanism.names(swept.design)
    kind = found.mechanism.contact
    contact = f"{names.contacts[int(found.columns[f'peak_{kind}'][index])]} {kind}"
    return (
        f"{found.peak_force[index]:.6g} N at {swept.grid.point(index)}: {contact} after"
        f" {found.peak_time[index]:.4g} s, {int(found.impact_count[index])} impacts, {found.outcomes[index].name}"
    )


def _failures(swept: Swept) -> list[str]:
    failed = np.flatnonzero(swept.done & ~swept.solved)
    lines = [
        f"  {swept.grid.point(i)}: {swept.found.mechanism.outcomes(int(swept.found.code[i])).reason}"
        for i in failed[:SHOWN].tolist()
    ]
    if failed.size > SHOWN:
        lines.append(f"  and {failed.size - SHOWN} more; see the column outcome in sweep.csv")
    return ["failed:", *lines] if lines else []
