"""A sweep in words and tables, for people."""

from collections.abc import Mapping

import numpy as np
from rich.table import Table

from ..fields import as_typed, get
from ..labelled.record import heading
from ..mechanisms.mechanism import EndCount
from ..mechanisms.quantity import PEAK_FORCE, PEAK_TIME
from ..tables import table
from ..value_text import percent_text, range_text, unit_text
from .axis import Axis
from .columns import RunTable
from .grid import Grid

SHOWN = 10  # runs that are listed of those that failed
QUANTILES = {"least": 0.0, "10 %": 0.1, "median": 0.5, "90 %": 0.9, "greatest": 1.0}


def sweep_parts(sweep: RunTable) -> list[str | Table]:
    """Return the outcomes and the spread of every quantity; over a grid, also the worst and the best run, and those
    that failed."""
    if not isinstance(sweep.grid, Grid):
        return [sweep_table(sweep)]
    axes = sweep.grid.axes
    title = f"Sweep of {len(sweep)} {sweep.mechanism.view.run_name}s: "
    title += " × ".join(f"{len(axis)} {axis.name}" for axis in axes)
    return summary(sweep, title, {axis.path: _values(axis) for axis in axes}, "sweep.csv")


def sweep_table(sweep: RunTable) -> Table:
    """Return a table of how many runs ended how, and of the range of each quantity."""
    codes, counts = np.unique(sweep.code[sweep.done], return_counts=True)
    ends = ", ".join(
        f"{count} {sweep.mechanism.outcomes(int(code)).reason}" for code, count in zip(codes, counts, strict=True)
    )
    done = int(sweep.done.sum())
    title = f"Sweep of {len(sweep)} {sweep.mechanism.view.run_name}s: {ends}"
    title += "" if done == len(sweep) else f"; interrupted, {done} of them done"
    title += f"; {reached}" if (reached := end_count(sweep)) else ""
    shown = table(title, ("quantity",), ("least", "median", "greatest"))
    for name in sweep.mechanism.swept:
        values, (symbol, factor) = sweep.columns[name], sweep.mechanism.quantities[name].in_figures
        # Failed runs are NaN, and a single one would hide the range of all others.
        known = factor * values[np.isfinite(values)]
        figures = [f"{f(known):.5g}" for f in (np.min, np.median, np.max)] if known.size else ["-"] * 3
        shown.add_row(heading(name, symbol), *figures)
    shown.caption = "\n".join(sweep.sanity_checks("see trust")) or None
    return shown


def end_count(sweep: RunTable) -> EndCount | None:
    """Return in how many of the runs that were computed the strictest end was reached; None where their design can
    have none."""
    # A field that the grid varies counts as set: some of its values may switch the end on.
    moved = set() if sweep.grid is None else {axis.path for axis in sweep.grid.axes}
    designs = sweep.design if sweep.design is not None else sweep.mechanism.design()
    codes, counts = np.unique(sweep.code[sweep.done], return_counts=True)
    named = {sweep.mechanism.outcomes(int(code)).name: int(n) for code, n in zip(codes, counts, strict=True)}
    return sweep.mechanism.end_count(lambda path: True if path in moved else get(designs, path), named)


def _outcomes(sweep: RunTable) -> Table:
    """Return a table of how many runs ended how."""
    mechanism = sweep.mechanism
    codes, counts = np.unique(sweep.code[sweep.done], return_counts=True)
    outcomes = table("Outcomes", ("outcome",), (f"{mechanism.view.run_name}s", "share"))
    for code, count in zip(codes, counts, strict=True):
        share = percent_text(count / int(sweep.done.sum()), ".1f")
        outcomes.add_row(mechanism.outcomes(int(code)).reason, str(count), share)
    return outcomes


def summary(sweep: RunTable, title: str, fields: Mapping[str, str], file: str) -> list[str | Table]:
    """Return what was run, how it ended and what it found, as texts and tables.

    They have the outcomes, the spread of every quantity, the worst and the best run, the limits of validity that runs
    exceed, and the runs that failed.

    ``fields``: what differs between the runs, by its path, in words; ``file``: where all runs can be looked up.
    """
    done = int(sweep.done.sum())
    title = title if done == len(sweep) else f"{title}; interrupted, {done} of them done"
    parts: list[str | Table] = [f"{title}; {reached}" if (reached := end_count(sweep)) else title]
    parts += [*(f"  {path:26} {words}" for path, words in fields.items()), _outcomes(sweep)]
    if sweep.solved.any():
        parts += [_spread(sweep), *_extremes(sweep)]
    return [
        *parts,
        *_beyond_validity(sweep),
        *sweep.sanity_checks(f"see trust in {file}"),
        *_failures(sweep, file),
    ]


def _beyond_validity(sweep: RunTable) -> list[str]:
    """Return a line for each limit of validity that runs exceed: how many do, and the worst of them."""
    mechanism, shares = sweep.mechanism, dict[str, np.ndarray]()
    # Designs that differ in a choice do not go into one design with arrays: each batch has one of each choice.
    for batch in sweep.grid.batches(sweep.design, sweep.scenario):
        places = batch.places
        quantities = {name: sweep.columns[name][places] for name in mechanism.swept}
        for limit in mechanism.view.validity(batch.design, quantities):
            share = shares.setdefault(limit.beyond, np.full(len(sweep), -np.inf))
            share[places] = np.where(limit.passed & sweep.solved[places], limit.share, -np.inf)
    lines = []
    for beyond, share in shares.items():
        if count := int(np.sum(share > -np.inf)):
            worst = int(np.argmax(share))
            furthest = f"by a factor of {share[worst]:.3g} at {sweep.grid.point(worst)}"
            lines.append(f"{beyond}, {count} {mechanism.view.run_name}s; {furthest}")
    return lines


def _spread(sweep: RunTable) -> Table:
    solved = sweep.solved
    mechanism = sweep.mechanism
    what = f"Quantities of the {int(solved.sum())} {mechanism.view.run_name}s that were solved"
    spread = table(what, ("quantity",), tuple(QUANTILES))
    moved = {axis.path for axis in sweep.grid.axes}
    for name in mechanism.meant(lambda path: path in moved or get(sweep.design, path)):
        values, (symbol, factor) = sweep.columns[name][solved], mechanism.quantities[name].in_figures
        known = factor * values[np.isfinite(values)]
        if known.size:
            quantiles = np.quantile(known, list(QUANTILES.values()))
            # Zeros in place of what only rounding leaves.
            figures = (f"{x:.5g}" for x in np.where(np.abs(quantiles) < 1e-12, 0.0, quantiles))
            spread.add_row(heading(name, symbol), *figures)
    return spread


def _extremes(sweep: RunTable) -> list[str]:
    main = sweep.main_quantity
    values = np.where(sweep.solved, sweep.columns[main], np.nan) if main else np.full(len(sweep), np.nan)
    if not np.isfinite(values).any():
        return []
    title = main.replace("_", " ")
    lines = [f"greatest {title} {_run(sweep, int(np.nanargmax(values)))}"]
    least = np.where(sweep.mechanism.succeeded(sweep.code), values, np.nan)
    if np.isfinite(least).any():
        ends = [name for name in sweep.mechanism.successes if np.any(sweep.code == sweep.mechanism.outcomes[name])]
        of = f" of those {' or '.join(ends)}" if ends else ""
        lines.append(f"least {title}{of} {_run(sweep, int(np.nanargmin(least)))}")
    return lines


def _run(sweep: RunTable, index: int) -> str:
    mechanism = sweep.mechanism
    count, main = int(sweep.impact_count[index]), sweep.main_quantity
    largest = int(sweep.columns[f"peak_{mechanism.view.contact}"][index])
    contact, moment = mechanism.view.contact_in_words(sweep.names().contact(largest)), mechanism.name_of(PEAK_TIME)
    after = f" after {sweep.columns[moment][index]:.4g} s" if moment in sweep.columns else ""
    # The contact and the time are those of the largest contact force, which another quantity has nothing to do with.
    of_force = main == mechanism.name_of(PEAK_FORCE)
    place = f"{contact}{after}, " if of_force else ""
    # Of a mechanism without contacts nothing is to be said of impacts.
    met = of_force or bool(np.any(sweep.impact_count > 0))
    impacts = [f"{place}{count} impacts" if count else "no impact"] if met else []
    value = mechanism.quantities[main].in_words(sweep.columns[main][index])
    return f"{value} at {sweep.grid.point(index)}: {', '.join([*impacts, sweep.outcomes[index].name])}"


def _failures(sweep: RunTable, file: str) -> list[str]:
    failed = np.flatnonzero(sweep.done & ~sweep.solved)
    lines = [
        f"  {sweep.grid.point(i)}: {sweep.mechanism.outcomes(int(sweep.code[i])).reason}"
        for i in failed[:SHOWN].tolist()
    ]
    if failed.size > SHOWN:
        lines.append(f"  and {failed.size - SHOWN} more; see the column outcome in {file}")
    return ["failed:", *lines] if lines else []


def _values(axis: Axis) -> str:
    if not axis.unit:
        return axis.spanned()
    typed = [as_typed(value, axis.unit, axis.typed) for value in axis.values.tolist()]
    few, symbol = [f"{value:g}" for value, _ in typed], typed[0][1]
    listed = ", ".join(few) if len(few) <= 3 else f"{few[0]}, {few[1]} … {few[-1]}"
    if symbol == "rad":
        low, high = np.degrees([min(axis.values), max(axis.values)])
        return f"{listed} rad ({range_text(low, high, '°', 3, ' … ')})"
    return f"{listed}{unit_text(symbol)}"
