"""Runs at places that someone chose, and how they are summed up."""

import dataclasses
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from rich.table import Table

from ..fields import Part, get
from ..mechanisms.mechanism import Mechanism
from ..tables import table
from .found import Sweep
from .grid import Batch

SHOWN = 10  # runs that are listed of those that failed
QUANTILES = {"least": 0.0, "10 %": 0.1, "median": 0.5, "90 %": 0.9, "greatest": 1.0}


class Places(Protocol):
    """Where runs lie: a grid, or points spread over ranges."""

    @property
    def axes(self) -> Sequence[Any]:
        """The fields that differ, each with its ``path``, ``unit``, ``name`` and ``heading``."""
        ...

    def __len__(self) -> int: ...

    def columns(self) -> dict[str, np.ndarray]:
        """Each field's value in every run, shape (n,), by its path."""
        ...

    def point(self, index: int) -> str:
        """One run's values in words."""
        ...

    def batches(self, design: Part, scenario: Part) -> list[Batch]:
        """All runs, those of one program together."""
        ...


@dataclasses.dataclass(frozen=True)
class Computed:
    """Runs at places: what `Swept` and a sample have in common. Fields as of `Swept`."""

    grid: Places
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
    return [
        *parts,
        *_beyond_validity(swept),
        *_rising(swept),
        *swept.found.doubts(f"see trust in {file}"),
        *_failures(swept, file),
    ]


def _rising(swept: Computed) -> list[str]:
    """In how many runs that succeeded a largest value is the last one, and would go on to rise."""
    found, mechanism, lines = swept.found, swept.mechanism, list[str]()
    good = swept.solved if mechanism.success is None else found.code == mechanism.outcomes[mechanism.success]
    for name, quantity in mechanism.quantities.items():
        if quantity.rising and (count := int(np.sum(good & (found.columns[quantity.rising] > 0.0)))):
            runs = f"{count} of {int(good.sum())} {mechanism.run_name}s that ended {mechanism.success or 'solved'}"
            lines.append(f"{name} is still rising where the run ends, in {runs}: it is the largest up to there only")
    return lines


def _beyond_validity(swept: Computed) -> list[str]:
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


def _spread(swept: Computed) -> Table:
    solved = swept.solved
    mechanism = swept.found.mechanism
    what = f"Quantities of the {int(solved.sum())} {mechanism.run_name}s that were solved"
    spread = table(what, ("quantity",), tuple(QUANTILES))
    moved = {axis.path for axis in swept.grid.axes}
    for name in mechanism.meant(lambda path: path in moved or get(swept.design, path)):
        values, (symbol, factor) = swept.found.columns[name][solved], mechanism.quantities[name].in_figures
        known = factor * values[np.isfinite(values)]
        if known.size:
            spread.add_row(
                f"{name} [{symbol}]",
                *(f"{x:.5g}" for x in _without_rounding(np.quantile(known, list(QUANTILES.values())))),
            )
    return spread


def _without_rounding(values: np.ndarray) -> np.ndarray:
    """Values with zeros in place of what only rounding leaves."""
    return np.where(np.abs(values) < 1e-12, 0.0, values)


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
    largest = int(found.columns[f"peak_{found.mechanism.contact}"][index])
    contact = found.mechanism.contact_in_words(names.contacts[largest])
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
