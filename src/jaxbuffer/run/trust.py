"""How far a run's numbers can be trusted: what a tenth of the tolerance changes."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import InputError
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.quantity import NEGLIGIBLE
from ..mechanisms.run import Run

SAFETY = 3.0  # an error is estimated as so many times the change; benchmarks/trust.py holds that against tight runs
DOUBTFUL = 1e-4  # relative
HOPELESS = 1e-2  # from here on a run is ill-conditioned even if nothing else changes
VERDICTS = ("trusted", "check", "ill-conditioned", "unknown")
SMALL = 1e-3  # of the largest quantity of the same unit: errors of smaller ones are relative to this


@dataclasses.dataclass(frozen=True)
class Trust:
    """How far the numbers of one run can be trusted. Print it for a sentence.

    - ``errors``: by quantity's name, the estimated error of its value [-], relative to it, or to a thousandth of the
      run's largest quantity of that unit where it is smaller; of one that can change sign, and so may be near zero, to
      the largest such one of that unit. What is `NEGLIGIBLE` counts as zero.
    - ``differs``: what else a tenth of the tolerance changed, in words; "" for nothing.
    - ``unknown``: why nothing is known, in words; "" where something is.

    Of a run that is ill-conditioned no error is sure, also where the estimate is small.

    **Example:**

    >>> run, closer = (jb.simulate(jb.table2(), rtol=rtol) for rtol in (1e-6, 1e-7))
    >>> known = jb.trust(run, closer)
    >>> known.verdict, known.worst[1] < 1e-4
    ('trusted', True)
    """

    errors: dict[str, float]
    differs: str
    unknown: str = ""

    @property
    def worst(self) -> tuple[str, float]:
        """Return the quantity known least, and its error; ("", 0) where a mechanism has no quantities."""
        return max(self.errors.items(), key=lambda item: item[1], default=("", 0.0))

    @property
    def verdict(self) -> str:
        """Return the verdict in a word: "trusted", "check", "ill-conditioned" where little decides what happens, or
        "unknown"."""
        if self.unknown:
            return "unknown"
        return VERDICTS[int(verdicts(self.worst[1], self.differs.startswith("the outcome"), bool(self.differs)))]

    def __str__(self) -> str:
        if self.unknown:
            return f"how far these numbers can be trusted is not known: {self.unknown}"
        name, error = self.worst
        if error == 0.0 and not self.differs:
            return "a tenth of the tolerance changes no number"
        if self.verdict == "trusted":
            return f"a tenth of the tolerance changes no number by more than {error:.0e} of it ({name})"
        doubtful = sorted((item for item in self.errors.items() if item[1] > DOUBTFUL), key=lambda item: -item[1])
        known = ", ".join(f"{name} (by {error:.0e})" for name, error in doubtful)
        if self.verdict == "check":
            return f"some numbers may be off by more than {DOUBTFUL:.0e} of them: {known}"
        why = f"at a tenth of the tolerance {self.differs}" if self.differs else "little decides what happens"
        return f"ill-conditioned: {why}; no number is sure" + (f", least of all {known}" if known else "")


def trust(run: Run, closer: Run) -> Trust:
    """Estimate how far the numbers of a run can be trusted.

    **Arguments:** ``run``; ``closer``: the same design and scenario at a tenth of the tolerance. From rtol 1e-12 on
    there is one: 1e-13 is the least allowed.

    **Returns:** a `Trust`; its verdict is "unknown" where ``closer`` failed.

    **Raises:** `InputError` for runs of two mechanisms, and for one that failed.

    **Example:**

    >>> run, closer = (jb.simulate(jb.table2(), rtol=rtol) for rtol in (1e-6, 1e-7))
    >>> jb.trust(run, closer).verdict
    'trusted'
    """
    mechanism = run.mechanism
    if closer.mechanism is not mechanism:
        raise InputError(
            f"trust compares two runs of one mechanism, not of {mechanism.name} and {closer.mechanism.name}"
        )
    if run.outcome.failed:
        raise InputError(f"this run says nothing: {run.outcome.reason}")
    if closer.outcome.failed:
        return Trust({}, "", f"at a tenth of the tolerance {closer.outcome.reason}")
    return Trust({name: SAFETY * change for name, change in changes(run, closer).items()}, _differs(run, closer))


def changes(run: Run, other: Run) -> dict[str, float]:
    """Return by how much each quantity of a run differs in another run [-], relative as `Trust.errors` are.

    It is infinite where only one of the runs has the quantity.
    """
    catalogue, swept = run.mechanism.quantities, run.mechanism.swept
    values, others = ({name: float(catalogue[name].of(it)) for name in swept} for it in (run, other))
    return {name: float(change) for name, change in relative_changes(run.mechanism, values, others).items()}


def relative_changes(
    mechanism: Mechanism, values: Mapping[str, Any], others: Mapping[str, Any]
) -> dict[str, np.ndarray]:
    """Return `changes` of many runs at once: by quantity's name an array with an entry for each run, of ``values``
    against those of the ``others``."""
    sizes = {name: np.abs(values[name]) for name in mechanism.swept}
    changes = {}
    for name, least in scales(mechanism, sizes).items():
        value, there = np.asarray(values[name]), np.asarray(others[name])
        with np.errstate(invalid="ignore", divide="ignore"):
            change = np.where(least > 0.0, np.abs(value - there) / least, np.inf)
        # NaN in both: neither run has the quantity, which is no difference.
        same = (value == there) | (np.isnan(value) & np.isnan(there))
        changes[name] = np.where(same, 0.0, np.where(np.isnan(change), np.inf, change))
    return changes


def scales(mechanism: Mechanism, sizes: Mapping[str, Any]) -> dict[str, Any]:
    """Return what an error of each quantity is relative to, as `Trust.errors` are; ``sizes``: absolute values, by
    name."""
    largest: dict[tuple[str, bool], Any] = {}  # by unit, and of all or of those alone that can change sign
    for name, size in sizes.items():
        quantity = mechanism.quantities[name]
        for key, share in (((quantity.unit, False), SMALL), ((quantity.unit, True), float(quantity.signed))):
            largest[key] = np.fmax(largest.get(key, 0.0), share * np.nan_to_num(size))
    kinds = {name: (mechanism.quantities[name].unit, mechanism.quantities[name].signed) for name in sizes}
    floor = {name: NEGLIGIBLE.get(unit, 0.0) for name, (unit, _) in kinds.items()}
    return {name: np.fmax(np.fmax(size, largest[kinds[name]]), floor[name]) for name, size in sizes.items()}


def verdicts(error: Any, outcome_differs: Any, differs: Any) -> np.ndarray:
    """Return the index in `VERDICTS`, from the largest estimated ``error`` of a run's quantities [-], whether the
    outcome is another at a tenth of the tolerance, and whether anything is. Numbers, or arrays with an entry for each
    run."""
    hopeless = outcome_differs | (error > HOPELESS) | ((error > DOUBTFUL) & differs)
    return np.where(hopeless, 2, np.where(np.asarray(error) > DOUBTFUL, 1, 0))


def _differs(run: Run, closer: Run) -> str:
    if closer.outcome != run.outcome:
        return f"the outcome is another: {closer.outcome.name} instead of {run.outcome.name}"
    if int(closer.peak_impact) != int(run.peak_impact):
        return "the largest force is another impact's"
    counts = int(run.impact_count), int(closer.impact_count)
    return f"there are {counts[1]} impacts instead of {counts[0]}" if counts[0] != counts[1] else ""
