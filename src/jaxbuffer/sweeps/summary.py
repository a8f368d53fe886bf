"""A sweep as a table, for people."""

from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from ..tables import table, text

if TYPE_CHECKING:
    from .found import Sweep


def sweep_summary(result: "Sweep") -> str:
    """The table as text."""
    return text(sweep_table(result))


def sweep_table(result: "Sweep") -> Table:
    """How many runs ended how, and the range of what they found."""
    codes, counts = np.unique(result.code, return_counts=True)
    ends = ", ".join(
        f"{count} {result.mechanism.outcomes(int(code)).reason}" for code, count in zip(codes, counts, strict=True)
    )
    shown = table(f"Sweep of {len(result)} {result.mechanism.run_name}s: {ends}")
    for heading in ("quantity", "least", "median", "greatest"):
        shown.add_column(heading, justify="left" if heading == "quantity" else "right")
    for name in result.mechanism.swept:
        values, (symbol, factor) = result.columns[name], result.mechanism.quantities[name].in_figures
        known = factor * values[np.isfinite(values)]
        figures = [f"{f(known):.5g}" for f in (np.min, np.median, np.max)] if known.size else ["-"] * 3
        shown.add_row(f"{name} [{symbol}]", *figures)
    shown.caption = "\n".join(result.doubts("see trust")) or None
    return shown
