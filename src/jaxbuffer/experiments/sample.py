"""`sample`: runs at points spread over ranges of any numbers of design and scenario."""

import dataclasses
from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float
from rich.table import Table

from .._types import DataFrame, Dataset, Scalar
from ..errors import InputError, check_flag, suggest
from ..fields import Part
from ..files import user_path
from ..hybrid import Solver
from ..labelled.arrays import frame
from ..run.request import DEFAULT_TOLERANCE
from ..run.trust import scales
from ..sweeps.columns import RunTable
from ..sweeps.result import Sweep, SweepInterrupted
from ..sweeps.store import check_vacant
from ..sweeps.summary import summary
from ..sweeps.sweep import sweep
from ..sweeps.table import sweep_rows
from ..tables import html, text
from .points import METHODS, Points, points
from .ranges import ranges as checked_ranges

ROUNDING = 1e-7  # relative: a tenth of a run's default tolerance, below which differences are no effect

RESULT = ("sample.json", "sample.csv", "sample.txt", "sample.nc")  # files of a finished sample


@dataclasses.dataclass(frozen=True)
class Sample(RunTable):
    """A sample of runs. Print it for a summary.

    - ``grid``: the `Points` where they lie, n of them over d ranges.
    - ``design``, ``scenario``: what the sampled values were put into.
    - ``columns``: the quantities, (n,) each, by name and attributes too, as of `Sweep`; ``done`` (n,): which runs were
      computed, all unless it was interrupted.

    **Example:**

    >>> ranges = {"impact.stiffness": (1e10, 1e12), "scenario.height": (0.1, 0.2)}  # N/m^e, m
    >>> sample = jb.sample(jb.BarDrop(), jb.BarDropScenario(), ranges, count=16)
    >>> sample.values["scenario.height"].shape, int(sample.solved.sum())
    ((16,), 16)
    """

    grid: Points = None  # type: ignore[assignment] # always given

    @property
    def sweep(self) -> Sweep:
        """Return the same runs as a sweep of designs and scenarios with arrays."""
        swept = self.grid.applied(self.design, self.scenarios)
        return Sweep(self.mechanism, self.columns, *swept, identity=self.identity)

    @property
    def values(self) -> dict[str, np.ndarray]:
        """Return each sampled field's value in every run, (n,), in the field's unit."""
        return self.grid.columns()

    @property
    def succeeded(self) -> Bool[np.ndarray, " n"]:
        """Return which of them ended as the mechanism's runs should; all that were solved, where any end will do."""
        return self.solved & self.mechanism.succeeded(self.code)

    def quantity(self, name: str) -> Float[np.ndarray, " n"]:
        """Return a quantity of every run. **Raises:** `InputError` with the nearest name for one that samples have
        not."""
        mechanism = self.mechanism
        if name not in mechanism.swept:
            raise InputError(f"quantity {name} is unknown{suggest(name, mechanism.swept)}")
        return self.columns[name]

    def check_varies(self, name: str, what: str) -> None:
        """Raise `InputError` for a quantity that is the same in all runs that succeeded, but for what the runs' own
        tolerance leaves open, relative as `Trust.errors` are. ``what``: is made of it."""
        known = self.succeeded & np.isfinite(self.quantity(name))
        values, swept = self.quantity(name)[known], self.mechanism.swept
        # Of all quantities, because what is negligible depends on the largest one of the unit.
        sizes = {it: np.max(np.abs(np.nan_to_num(self.columns[it][known])), initial=0.0) for it in swept}
        if values.size and np.std(values) <= ROUNDING * scales(self.mechanism, sizes)[name]:
            value = self.mechanism.quantities[name].in_words(np.mean(values))
            raise InputError(f"{what} of {name}: it is the same in all runs, {value}, but for rounding: nothing varies")

    def to_xarray(self) -> Dataset:
        """Return the sample as labelled arrays along ``run``; the sampled fields are coordinates, by their dotted
        paths."""
        return self.sweep.to_xarray()

    def to_dataframe(self) -> DataFrame:
        """Return a row for each run that was computed, as in sample.csv, units in the columns' names."""
        return frame(*sweep_rows(self))

    def __repr__(self) -> str:
        return text(*_summary(self))

    def _repr_html_(self) -> str:
        return html(*_summary(self))


def _summary(sample: Sample) -> list[str | Table]:
    """Return the ranges, outcomes, the spread of every quantity, the worst and the best run, and those that failed."""
    points, name = sample.grid, sample.mechanism.view.run_name
    title = f"Sample of {len(points)} {name}s: {points.method.replace('_', ' ')}, seed {points.seed}"
    if points.method == "saltelli":
        title += f", {points.count} rows of {len(points.axes) + 2} runs"
    return summary(sample, title, {axis.path: str(axis) for axis in points.axes}, "sample.csv")


def sample(
    design: Part,
    scenario: Part,
    ranges: Mapping[str, Any],
    count: int = 256,
    method: str = METHODS[0],
    *,
    seed: int = 0,
    duration: Scalar | None = None,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    trust: bool = False,
    executor: Executor | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | bool | None = None,
    folder: str | Path | None = None,
    force: bool = False,
    resume: bool = False,
    save: bool = True,
) -> Sample:
    """Simulate a mechanism at points spread over ranges of its numbers.

    **Arguments:**

    - ``design``, ``scenario``: what the sampled numbers are put into.
    - ``ranges``: by dotted path, "scenario.…" for the scenario's: (low, high), or (low, high, "linear" or "log"), in
      the field's unit. Without a scale, a range of more than a decade is spread on a logarithmic one.
    - ``count``: how many points; a power of two unless ``method`` is "latin_hypercube".
    - ``method``: "sobol", "latin_hypercube", or "saltelli", whose count × (ranges + 2) runs `sobol_indices` reads
      indices off without a response surface.
    - ``seed``: the same one, the same points.
    - ``duration`` [s], ``solver``, ``rtol`` [-]: as for `simulate`.
    - ``trust``, ``executor``, ``workers``, ``progress``, ``folder``, ``force``, ``resume``, ``save``: as for `sweep`;
      the verdicts are ``verdicts``.

    **Returns:** a `Sample`; runs that fail say so in their outcome and leave the others alone.

    **Raises:** `InputError` for ranges that are none, `SweepInterrupted` on Ctrl-C.

    **Source:** scipy.stats.qmc; Owen, *Monte Carlo theory, methods and examples*, chapters 10 and 15 to 17.

    **Example:**

    >>> ranges = {"impact.stiffness": (1e10, 1e12), "scenario.height": (0.1, 0.2)}  # N/m^e, m
    >>> sample = jb.sample(jb.BarDrop(), jb.BarDropScenario(), ranges, count=16)
    >>> sample.grid.axes[0].scale, sample.grid.axes[1].scale
    ('log', 'linear')
    """
    spread = points(checked_ranges(ranges, design, scenario), count, method, seed)
    options: dict[str, Any] = {"solver": solver, "rtol": rtol, "trust": trust, "folder": folder}
    options |= {"force": force, "resume": resume}
    if save and folder is not None and not resume:
        check_vacant(user_path(folder), RESULT, force)
    check_flag("save", save)
    options |= {"executor": executor, "workers": workers, "progress": progress}
    drawn = sample_at(spread, design, scenario, duration, **options)
    if save and folder is not None:
        drawn.save(folder, force=True, figures=False)
    return drawn


def sample_at(points: Points, design: Part, scenario: Part, duration: Scalar | None = None, **options: Any) -> Sample:
    """Do as `sample` at points that are there already, without saving; ``options`` as for `sweep`.

    **Raises:** `SweepInterrupted` on Ctrl-C, with the `Sample` as far as it came.
    """

    def made(swept: Sweep) -> Sample:
        return Sample(swept.mechanism, swept.columns, design, scenario, points, swept.identity)

    try:
        # Not saved as the sweep that it is run as: `sample` saves it as itself.
        return made(sweep(*points.applied(design, scenario), duration, save=False, **options))
    except SweepInterrupted as stop:
        raise SweepInterrupted(made(stop.partial), stop.done) from None
