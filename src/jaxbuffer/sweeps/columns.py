"""The numbers of many runs: an array with an entry a run for each quantity."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from ..fields import Part
from ..labelled.saved import Saved
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.outcome import NotComputed, RunOutcome
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
    identity: Mapping[str, str] | None = None  # see `store.identity`

    def __getattr__(self, name: str) -> np.ndarray:
        columns = object.__getattribute__(self, "columns")
        if name in columns:
            return columns[name]
        raise AttributeError(f"{type(self).__name__} has no {name!r}")

    def __len__(self) -> int:
        return len(self.columns["code"])

    @property
    def scenario(self) -> Part:
        """The scenario that the values were put into."""
        return self.scenarios

    @property
    def outcomes(self) -> list[RunOutcome | NotComputed]:
        """The outcome of each run; of one that an interrupted sweep left, `NotComputed`."""
        known = self.mechanism.outcomes
        return [NotComputed() if code < 0 else known(int(code)) for code in self.columns["code"]]

    @property
    def done(self) -> np.ndarray:
        """Which runs were computed, shape (n,): all of them unless the sweep was interrupted."""
        return self.columns["code"] >= 0

    @property
    def solved(self) -> np.ndarray:
        """Which runs have numbers, shape (n,): done, and not failed."""
        return self.done & (self.columns["code"] < self.mechanism.outcomes["failed_steps"])

    @property
    def verdicts(self) -> list[str]:
        """How far the numbers of each run can be trusted, in a word as of `jb.trust`; "" for a run that failed, and
        where it was not asked."""
        return [VERDICTS[index] if index >= 0 else "" for index in self.columns["trust"]]

    def doubts(self, where: str) -> list[str]:
        """How many runs are not trusted, in words; ``where`` they are marked."""
        return doubts(self.mechanism, len(self), tally(self.columns["trust"]), where)

    def contacts(self) -> tuple[str, ...]:
        """The names of the contacts, by their numbers."""
        design = self.mechanism.design() if self.design is None else self.design
        return self.mechanism.view.names(design).contacts


def doubts(mechanism: Mechanism, runs: int, verdicts: Mapping[int, int], where: str) -> list[str]:
    """How many of so many ``runs`` are not trusted, in words; ``verdicts``: how often each was given, by its index;
    ``where`` they are marked."""
    of_all, lines = f"of {runs} {mechanism.view.run_name}s", []
    if count := verdicts.get(VERDICTS.index("ill-conditioned")):
        lines.append(f"{count} {of_all} are ill-conditioned: little decides what happens, no number is sure")
    if count := verdicts.get(VERDICTS.index("check")):
        lines.append(f"{count} {of_all} have numbers that may be off by more than {DOUBTFUL:.0e} of them")
    if count := verdicts.get(VERDICTS.index("unknown")):
        lines.append(f"{count} {of_all} have numbers of unknown error: {NO_TENTH}, or they fail at it")
    return [f"{line} ({where})" for line in lines]


def tally(values: np.ndarray) -> dict[int, int]:
    """How often each whole number is among them."""
    numbers, counts = np.unique(values, return_counts=True)
    return dict(zip(numbers.tolist(), counts.tolist(), strict=True))


def column_names(mechanism: Mechanism) -> tuple[str, ...]:
    """The names of a sweep's columns, in order."""
    return tuple(column_types(mechanism))


def column_types(mechanism: Mechanism) -> dict[str, str]:
    """The type of each column by name: whole numbers or others."""
    whole = (f"peak_{mechanism.view.contact}", "impact_count", "attempts", "trust")
    return {"code": "<i8"} | dict.fromkeys(mechanism.swept, "<f8") | dict.fromkeys(whole, "<i8")


def empty_columns(mechanism: Mechanism, count: int) -> dict[str, np.ndarray]:
    """Room for a number of runs, none of them done."""
    return {name: np.full(count, EMPTY[kind], kind) for name, kind in column_types(mechanism).items()}
