"""Samples, indices, surfaces and safe rectangles in words and tables."""

from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table

from ..fields import as_typed
from ..sweeps.summary import outcomes_table, summary
from ..tables import table, text

if TYPE_CHECKING:
    from ..sweeps.grid import Axis
    from .indices import Indices
    from .rectangle import SafeRectangle
    from .sample import Sample
    from .surface import Surface

MANY = 0.05  # of the runs: more left out than these are warned of


def sample_parts(sample: "Sample") -> list[str | Table]:
    """Ranges, outcomes, the spread of every quantity, the worst and the best run, and those that failed."""
    points, mechanism, done = sample.grid, sample.mechanism, int(sample.done.sum())
    title = f"Sample of {len(points)} {mechanism.run_name}s: {points.method.replace('_', ' ')}, seed {points.seed}"
    if points.method == "saltelli":
        title += f", {points.count} rows of {len(points.axes) + 2} runs"
    parts: list[str | Table] = [title if done == len(points) else f"{title}; interrupted, {done} of them done"]
    parts += [f"  {axis.path:26} {axis}" for axis in points.axes]
    return [*parts, outcomes_table(sample), *summary(sample, "sample.csv")]


def indices_summary(indices: "Indices") -> str:
    """First-order and total index of each number, with their intervals."""
    parts: list = []
    for name, it in indices.estimates.items():
        surface = indices.surfaces.get(name)
        of = f"the response surface of {name}" if surface else name
        shown = table(f"Sobol' indices of {of}, with {100 * indices.confidence:g} % intervals")
        for heading in ("number", "first-order", "interval", "total", "total's interval"):
            shown.add_column(heading, justify="left" if heading == "number" else "right")
        for k in np.argsort(-it.total).tolist():
            (low, high), (least, most) = it.first_interval[:, k], it.total_interval[:, k]
            shown.add_row(
                indices.paths[k], f"{it.first[k]:.3f}", f"{low:.3f} … {high:.3f}",
                f"{it.total[k]:.3f}", f"{least:.3f} … {most:.3f}",
            )  # fmt: skip
        parts.append(shown)
        parts.append(f"  acting alone, the numbers make {100 * float(np.sum(it.first)):.1f} % of the variance")
        if surface:
            parts.append(f"  {_worth(surface)}; the intervals do not hold what it misses")
        elif it.rows < indices.asked:
            parts.append(
                f"  {indices.asked - it.rows} of {indices.asked} rows are left out: a run of theirs failed or ended"
                " otherwise; the indices are those of the rest, whose numbers are no longer quite independent"
            )
    return text(*parts)


def surface_summary(surface: "Surface") -> str:
    """Kind, cross-validated error, range, and where not to trust it."""
    words = surface.kind.replace("_", " ")
    of_log = ", of the logarithm" if surface.logarithmic else ""
    lines = [f"Response surface of {surface.quantity}: {words}{of_log}, fitted to {len(surface.computed)} runs"]
    for kind, error in sorted(surface.errors.items(), key=lambda item: item[1].rms):
        mark = "" if len(surface.errors) == 1 else (" (chosen)" if kind == surface.kind else " (not taken)")
        lines.append(
            f"  cross-validated error of the {kind.replace('_', ' ')}{mark}: {error.rms:.4g} {surface.unit} rms,"
            f" {100 * error.relative:.3g} % of the value, {error.largest:.4g} {surface.unit} at most;"
            f" {100 * error.explained:.2f} % of the variance explained"
        )
    lines += [f"  holds inside {axis.path} {axis}" for axis in surface.axes]
    return text(*lines, *_distrust(surface))


def _worth(surface: "Surface") -> str:
    told = f"the surface misses {100 * surface.error.relative:.3g} % of a value it has not seen (cross-validated)"
    return told if surface.trusted else f"{told} and is not to be trusted"


def _distrust(surface: "Surface") -> list[str]:
    """What to be wary of."""
    lines, total = [], sum(surface.left_out.values())
    for reason, count in surface.left_out.items():
        lines.append(f"  left out: {count} {surface.run_name}s, {reason}")
    if total > MANY * (total + len(surface.computed)):
        lines.append("  do not trust it near those: it is fitted as if they did not exist")
    if not surface.trusted:
        lines.append("  do not trust it at all: it explains less than 90 % of the variance of runs it has not seen")
    return lines


def rectangle_summary(found: "SafeRectangle") -> str:
    """Which runs are safe, and the ranges of the largest rectangle."""
    mechanism = found.swept.mechanism
    count = int(found.safe.sum())
    between = [] if found.between is None else [found.between.words]
    lines = [f"Safe ({found.asked}): {count} of {found.safe.size} {mechanism.run_name}s"]
    if found.first is None or found.second is None:
        return text(*lines, "  no run is safe", *between)
    shape = f"{np.sum(_within(found.values[0], found.first))} × {np.sum(_within(found.values[1], found.second))}"
    lines.append(f"largest rectangle of safe {mechanism.run_name}s, {found.runs} of them ({shape}):")
    lines += [
        f"  {axis.path:26} {ends(axis, part)}"
        for axis, part in zip(found.axes, (found.first, found.second), strict=True)
    ]
    return text(*lines, *between)


def _within(values: np.ndarray, part: tuple[float, float]) -> np.ndarray:
    return (values >= part[0]) & (values <= part[1])


def ends(axis: "Axis", part: tuple[float, float]) -> str:
    """A range in its unit, angles in degrees besides: "-0.05 … 0.05 rad (-2.86° … +2.86°)"."""
    (low, symbol), (high, _) = (as_typed(value + 0.0, axis.unit, axis.typed) for value in part)
    words = f"{low:.4g} … {high:.4g} {symbol}".rstrip(" -")
    return f"{words} ({np.degrees(low):+.3g}° … {np.degrees(high):+.3g}°)" if symbol == "rad" else words
