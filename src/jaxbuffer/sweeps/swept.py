"""What a sweep over a grid found, and its summary."""

import dataclasses
from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from ..fields import as_typed
from ..tables import html, text
from .computed import Computed, outcomes_table, what_was_found
from .grid import Axis, Grid

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


@dataclasses.dataclass(frozen=True)
class Swept(Computed):
    """A sweep over a grid. Print it for a summary.

    ``design``, ``scenario``: what the grid's values were put into; ``found``: quantities (n,) in the grid's order;
    ``done`` (n,): which runs were computed, all of them unless the sweep was interrupted.

    **Example:**

    >>> found = jb.sweep(jb.BarDrop(), jb.BarDropScenario(), 0.05, over={"scenario.height": [0.1, 0.194]})
    >>> found.to_xarray().outcome.values.tolist()
    ['finished', 'finished']
    """

    grid: Grid

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
    over, done = swept.grid, int(swept.done.sum())
    mechanism = swept.found.mechanism
    title = f"Sweep of {len(over)} {mechanism.run_name}s: " + " × ".join(
        f"{len(axis)} {axis.name}" for axis in over.axes
    )
    parts: list[str | Table] = [title if done == len(over) else f"{title}; interrupted, {done} of them done"]
    parts += [f"  {axis.path:26} {_values(axis)}" for axis in over.axes]
    return [*parts, outcomes_table(swept), *what_was_found(swept, "sweep.csv")]


def _values(axis: Axis) -> str:
    if not axis.unit:
        return axis.spanned()
    typed = [as_typed(value, axis.unit, axis.typed) for value in axis.values.tolist()]
    few, symbol = [f"{value:g}" for value, _ in typed], typed[0][1]
    listed = ", ".join(few) if len(few) <= 3 else f"{few[0]}, {few[1]} … {few[-1]}"
    if symbol == "rad":
        low, high = np.degrees([min(axis.values), max(axis.values)])
        return f"{listed} rad ({low:+.3g}° … {high:+.3g}°)"
    return f"{listed} {symbol}".rstrip(" -")
