"""What a sweep found: arrays with an entry a run."""

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ..fields import Part
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.outcome import NotComputed, RunOutcome
from ..run.request import NO_TENTH
from ..run.trust import DOUBTFUL, VERDICTS

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

NO_VERDICT = -1  # on how far a run's numbers can be trusted: not asked, or it has none


@dataclasses.dataclass(frozen=True)
class Sweep:
    """What a sweep found: an array of n entries a quantity, in the order asked; numbers of failed runs are NaN.

    - ``mechanism``: of which these are runs.
    - ``columns``: by name, each of shape (n,) and an attribute too: ``code`` of the outcome, the mechanism's quantities
      that sweeps have (units in its catalogue), the contact with the largest force (``peak_flank`` where contacts are
      flanks), ``impact_count``, ``attempts``, and ``trust``: the index of its verdict in `VERDICTS`, or -1.
    - ``design``, ``scenarios``: what was swept, with arrays (n,) for the numbers that differ.

    **Example:**

    >>> found = jb.sweep(jb.table2(), jb.Scenario(approach_speed=[0.1, 0.2]))
    >>> [outcome.name for outcome in found.outcomes], bool(found.solved.all())
    (['captured', 'captured'], True)
    >>> [f"{1e3 * stroke:.2f} mm" for stroke in found.stroke]
    ['7.50 mm', '15.18 mm']
    """

    mechanism: Mechanism
    columns: dict[str, np.ndarray]
    design: Part | None = None
    scenarios: Part | None = None

    def __getattr__(self, name: str) -> np.ndarray:
        columns = object.__getattribute__(self, "columns")
        if name in columns:
            return columns[name]
        raise AttributeError(f"Sweep has no {name!r}")

    def __len__(self) -> int:
        return len(self.columns["code"])

    @property
    def outcomes(self) -> list[RunOutcome | NotComputed]:
        """The outcome of each run; of one that an interrupted sweep left, `NotComputed`."""
        known = self.mechanism.outcomes
        return [NotComputed() if code < 0 else known(int(code)) for code in self.columns["code"]]

    @property
    def solved(self) -> np.ndarray:
        """Which runs have numbers, shape (n,)."""
        return (self.columns["code"] >= 0) & (self.columns["code"] < self.mechanism.outcomes["failed_steps"])

    @property
    def verdicts(self) -> list[str]:
        """How far the numbers of each run can be trusted, in a word as of `jb.trust`; "" for a run that failed, and
        where it was not asked."""
        return [VERDICTS[index] if index >= 0 else "" for index in self.columns["trust"]]

    def doubts(self, where: str) -> list[str]:
        """How many runs are not trusted, in words; ``where`` they are marked."""
        return doubts(self.mechanism, len(self), tally(self.columns["trust"]), where)

    @staticmethod
    def empty(mechanism: Mechanism, count: int, design: Part | None = None, scenarios: Part | None = None) -> "Sweep":
        """Room for a number of runs, none of them done."""
        whole = whole_numbers(mechanism)
        columns = {
            name: np.full(count, *((-1, int) if name in whole else (np.nan, float)))  # type: ignore[arg-type]
            for name in column_names(mechanism)
        }
        return Sweep(mechanism, columns, design, scenarios)

    def to_xarray(self) -> "xr.Dataset":
        """The sweep as labelled arrays along ``run``, counted from 0, each with its unit in the attribute ``units``.

        The numbers of design and scenario that differ are coordinates by their dotted paths; ``outcome`` is in words.

        **Example:**

        >>> found = jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=[0.1, 0.194]), 0.22)
        >>> data = found.to_xarray()
        >>> data["scenario.height"].values.tolist(), data["scenario.height"].units, data.outcome.values.tolist()
        ([0.1, 0.194], 'm', ['finished', 'finished'])
        """
        from .dataset import sweep_dataset

        return sweep_dataset(self)

    def to_pandas(self) -> "pd.DataFrame":
        """A row a run: the numbers that differ, the outcome and the results, columns named with their units."""
        from ..labelled.arrays import frame
        from .dataset import sweep_rows

        return frame(*sweep_rows(self))

    def __repr__(self) -> str:
        from .summary import sweep_summary

        return sweep_summary(self)

    def _repr_html_(self) -> str:
        from ..tables import html
        from .summary import sweep_table

        return html(sweep_table(self))


def doubts(mechanism: Mechanism, runs: int, verdicts: Mapping[int, int], where: str) -> list[str]:
    """How many of so many ``runs`` are not trusted, in words; ``verdicts``: how often each was given, by its index;
    ``where`` they are marked."""
    of_all, told = f"of {runs} {mechanism.run_name}s", []
    if count := verdicts.get(VERDICTS.index("ill-conditioned")):
        told.append(f"{count} {of_all} are ill-conditioned: little decides what happens, no number is sure")
    if count := verdicts.get(VERDICTS.index("check")):
        told.append(f"{count} {of_all} have numbers that may be off by more than {DOUBTFUL:.0e} of them")
    if count := verdicts.get(VERDICTS.index("unknown")):
        told.append(f"{count} {of_all} have numbers of unknown error: {NO_TENTH}, or they fail at it")
    return [f"{line} ({where})" for line in told]


def tally(values: np.ndarray) -> dict[int, int]:
    """How often each whole number is among them."""
    numbers, counts = np.unique(values, return_counts=True)
    return dict(zip(numbers.tolist(), counts.tolist(), strict=True))


def column_names(mechanism: Mechanism) -> tuple[str, ...]:
    """What a sweep of the mechanism finds, in order."""
    return ("code", *mechanism.swept, *whole_numbers(mechanism)[1:])


def whole_numbers(mechanism: Mechanism) -> tuple[str, ...]:
    """Those of `column_names` that are whole numbers."""
    return ("code", f"peak_{mechanism.contact}", "impact_count", "attempts", "trust")


class SweepInterrupted(KeyboardInterrupt):
    """Ctrl-C during a sweep. ``found`` has what was done until then: a `Sweep`, with ``over`` a `Swept`, of a sample a
    `Sample`; ``done`` (n,) says which runs those are."""

    def __init__(self, found: Any, done: np.ndarray) -> None:
        super().__init__(f"{int(done.sum())} of {done.size} {found.mechanism.run_name}s done")
        self.found, self.done = found, done

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle both arguments: an exception by itself would pickle its message alone."""
        return type(self), (self.found, self.done)
