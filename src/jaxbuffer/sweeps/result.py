"""The result of a sweep."""

import dataclasses
from typing import Any

import numpy as np

from .._types import DataFrame, Dataset
from ..labelled.arrays import frame
from ..mechanisms.mechanism import Mechanism
from ..tables import html, text
from .columns import RunTable, empty_columns
from .grid import Grid
from .summary import sweep_parts
from .table import sweep_dataset, sweep_rows


@dataclasses.dataclass(frozen=True)
class Sweep(RunTable):
    """The result of a sweep: an array of n entries a quantity, in the order asked. Print it for a summary.

    - ``mechanism``: of which these are runs.
    - ``columns``: by name, each of shape (n,) and an attribute too: ``code`` of the outcome, the mechanism's quantities
      that sweeps have (units in its catalogue), the contact with the largest force (``peak_flank`` where contacts are
      flanks), ``impact_count``, ``attempts``, and ``trust``: the index of its verdict in `VERDICTS`, or -1. Numbers of
      failed runs are NaN.
    - ``design``, ``scenarios``: what was swept, with arrays (n,) for the numbers that differ; over a grid, what the
      grid's values were put into.
    - ``grid``: the grid of ``over``, None without.
    - ``identity``: a hash of each part that makes the sweep the one it is, by name; None where that is not known.

    **Example:**

    >>> swept = jb.sweep(jb.table2(), jb.Scenario(approach_speed=[0.1, 0.2]))
    >>> [outcome.name for outcome in swept.outcomes], bool(swept.solved.all())
    (['captured', 'captured'], True)
    >>> [f"{1e3 * stroke:.2f} mm" for stroke in swept.stroke]
    ['7.50 mm', '15.18 mm']
    """

    grid: Grid = None  # type: ignore[assignment] # the runs were given one by one

    @staticmethod
    def empty(mechanism: Mechanism, count: int) -> "Sweep":
        """Return a sweep with room for ``count`` runs, none of which is done."""
        return Sweep(mechanism, empty_columns(mechanism, count))

    def shaped(self, quantity: str) -> np.ndarray:
        """Return a quantity in the grid's shape."""
        return self.columns[quantity].reshape(len(self) if self.grid is None else self.grid.shape)

    def only(self, done: np.ndarray) -> "Sweep":
        """Return a copy with the runs of ``done`` (n,), in which the others are not computed."""
        blank = empty_columns(self.mechanism, len(self))
        columns = {name: np.where(done, values, blank[name]) for name, values in self.columns.items()}
        return dataclasses.replace(self, columns=columns)

    def to_xarray(self) -> Dataset:
        """Return the sweep as labelled arrays, each with its unit in the attribute ``units``.

        Over a grid they have a dimension for each field, named by its dotted path, with its values; else one dimension,
        ``run``, counted from 0, with the numbers of design and scenario that differ as coordinates.

        Numbers are NaN where a run failed; ``outcome`` is in words, "not computed" where the sweep was interrupted.

        **Example:**

        >>> swept = jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=[0.1, 0.194]), 0.22)
        >>> data = swept.to_xarray()
        >>> data["scenario.height"].values.tolist(), data["scenario.height"].units, data.outcome.values.tolist()
        ([0.1, 0.194], 'm', ['finished', 'finished'])
        >>> swept = jb.sweep(jb.BarDrop(), jb.BarDropScenario(), 0.22, over={"scenario.height": [0.1, 0.194]})
        >>> data = swept.to_xarray()
        >>> dict(data.sizes), data.peak_force.units, str(data.outcome.sel({"scenario.height": 0.1}).item())
        ({'scenario.height': 2}, 'N', 'finished')
        """
        return sweep_dataset(self)

    def to_dataframe(self) -> DataFrame:
        """Return a row for each run that was computed, as in sweep.csv.

        The columns are the numbers that differ, the outcome and the results, named with their units.
        """
        return frame(*sweep_rows(self))

    def __repr__(self) -> str:
        return text(*sweep_parts(self))

    def _repr_html_(self) -> str:
        return html(*sweep_parts(self))


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C during a sweep. ``partial``: a `Sweep`, of a sample a `Sample`, with what was done until then; ``done``
    (n,): which runs those are."""

    def __init__(self, partial: Any, done: np.ndarray) -> None:
        super().__init__(f"{int(done.sum())} of {done.size} {partial.mechanism.view.run_name}s done")
        self.partial, self.done = partial, done

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle both arguments: an exception by itself would pickle its message alone."""
        return type(self), (self.partial, self.done)
