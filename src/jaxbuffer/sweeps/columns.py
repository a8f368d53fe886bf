"""The numbers of many runs: an array with an entry a run for each quantity."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from ..fields import Part
from ..labelled.saved import Saved
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.outcome import NotComputed, RunOutcome
from ..mechanisms.view import Names
from ..run.request import NO_TENTH
from ..run.trust import DOUBTFUL, VERDICTS
from .grid import Places

EMPTY = {"<i8": -1, "<f8": np.nan}  # what is in the place of runs that are not computed, by the column's type
NO_VERDICT = -1  # on how far a run's numbers can be trusted: not asked, or it has none


@dataclasses.dataclass(frozen=True)
class RunTable(Saved):
    """The numbers of n runs, which `Sweep` and `Sample` show and convert; fields as of `Sweep`."""

    mechanism: Mechanism
    columns: dict[str, np.ndarray]
    design: Part = None  # type: ignore[assignment] # not known, as of `scenarios`
    scenarios: Part = None  # type: ignore[assignment]
    grid: Places = None  # type: ignore[assignment] # the runs were given one by one
    identity: Mapping[str, str] | None = None  # see `SweepSpec.identity`

    def __getattr__(self, name: str) -> np.ndarray:
        # Ordinary access would come back here without end while an object that is being unpickled has no columns yet.
        columns = object.__getattribute__(self, "columns")
        if name in columns:
            return columns[name]
        raise AttributeError(f"{type(self).__name__} has no {name!r}")

    def __len__(self) -> int:
        return len(self.columns["code"])

    @property
    def scenario(self) -> Part:
        """Return the scenario that the values were put into."""
        return self.scenarios

    @property
    def outcomes(self) -> list[RunOutcome | NotComputed]:
        """Return the outcome of each run; `NotComputed` for a run that an interrupted sweep left out."""
        known = self.mechanism.outcomes
        return [NotComputed() if code < 0 else known(int(code)) for code in self.columns["code"]]

    @property
    def done(self) -> np.ndarray:
        """Return which runs were computed, shape (n,): all of them unless the sweep was interrupted."""
        return self.columns["code"] >= 0

    @property
    def solved(self) -> np.ndarray:
        """Return which runs have numbers, shape (n,): those that are done and did not fail."""
        # Codes of failures begin at "failed_steps".
        return self.done & (self.columns["code"] < self.mechanism.outcomes["failed_steps"])

    @property
    def verdicts(self) -> list[str]:
        """Return how far the numbers of each run can be trusted, in a word as of `jb.trust`.

        It is "" for a run that failed, and where no verdict was asked for.
        """
        return [VERDICTS[index] if index >= 0 else "" for index in self.columns["trust"]]

    def sanity_checks(self, where: str) -> list[str]:
        """Return how many runs are not trusted, in words; ``where`` they are marked."""
        return sanity_checks(self.mechanism, len(self), tally(self.columns["trust"]), where)

    @property
    def main_quantity(self) -> str:
        """Return the quantity that stands for a run where nothing is said."""
        return self.mechanism.main_quantity(self.mechanism.swept, self.design)

    def names(self) -> Names:
        """Return what the mechanism's parts are called."""
        design = self.mechanism.design() if self.design is None else self.design
        return self.mechanism.view.names(design)


def sanity_checks(mechanism: Mechanism, runs: int, verdicts: Mapping[int, int], where: str) -> list[str]:
    """Return how many of the ``runs`` are not trusted, in words.

    - ``mechanism``: of which these are runs; ``runs``: how many there are.
    - ``verdicts``: how often each verdict was given, by its index.
    - ``where``: the place at which such runs are marked.
    """
    of_all, lines = f"of {runs} {mechanism.view.run_name}s", []
    if count := verdicts.get(VERDICTS.index("ill-conditioned")):
        lines.append(f"{count} {of_all} are ill-conditioned: little decides what happens, no number is sure")
    if count := verdicts.get(VERDICTS.index("check")):
        lines.append(f"{count} {of_all} have numbers that may be off by more than {DOUBTFUL:.0e} of them")
    if count := verdicts.get(VERDICTS.index("unknown")):
        lines.append(f"{count} {of_all} have numbers of unknown error: {NO_TENTH}, or they fail at it")
    return [f"{line} ({where})" for line in lines]


def tally(values: np.ndarray) -> dict[int, int]:
    """Return how often each whole number is among the ``values``."""
    numbers, counts = np.unique(values, return_counts=True)
    return dict(zip(numbers.tolist(), counts.tolist(), strict=True))


def column_names(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the names of a sweep's columns, in order."""
    return tuple(column_types(mechanism))


def column_types(mechanism: Mechanism) -> dict[str, str]:
    """Return the type of each column by name: whole numbers, or floating-point ones."""
    whole = (f"peak_{mechanism.view.contact}", "impact_count", "attempts", "trust")
    return {"code": "<i8"} | dict.fromkeys(mechanism.swept, "<f8") | dict.fromkeys(whole, "<i8")


def empty_columns(mechanism: Mechanism, count: int) -> dict[str, np.ndarray]:
    """Return columns for ``count`` runs, none of which is done."""
    return {name: np.full(count, EMPTY[kind], kind) for name, kind in column_types(mechanism).items()}
