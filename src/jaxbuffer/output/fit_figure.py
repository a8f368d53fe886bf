"""The figure of a fit: each column as measured and as fitted, and the residuals over the noise."""

import numpy as np

from .._types import Axes, Figure
from ..fields import as_displayed, display_unit
from ..fitting.fitted import Fitted
from ..fitting.residuals import outliers
from ..value_text import unit_text
from .style import BLUE, GREY, ORANGE, RED, label, panels, styled

MOST = 9  # columns that are drawn
NOISE = 2.0  # deviations on either side, between which noise alone mostly stays


@styled
def fit_figure(fitted: Fitted) -> Figure:
    """Draw a row for each column of the tests, up to nine: measured and fitted on the left, residuals on the right."""
    drawn = [(test, k) for test, record in fitted.records.items() for k in range(len(record.columns))][:MOST]
    figure, grid = panels(10.0, 2.3 * len(drawn) + 0.6, len(drawn), 2)
    for (left, right), (test, k) in zip(grid, drawn, strict=True):
        _column(left, right, fitted, test, k)
    figure.suptitle(f"Fit of {', '.join(fitted.parameters)}: {fitted.verdict}")
    return figure


def _column(left: Axes, right: Axes, fitted: Fitted, test: str, k: int) -> None:
    record = fitted.records[test]
    column, unit = record.columns[k], record.units[k]
    symbol, factor = display_unit(unit)
    time = record.times
    left.plot(time, factor * record.measured[k], ".", color=GREY, markersize=2.0, label="measured")
    if np.any(clipped := record.clipped[k]):
        measured = factor * record.measured[k, clipped]
        left.plot(time[clipped], measured, "x", color=RED, markersize=5.0, label="clipped, left out")
    left.plot(time, factor * record.fitted[k], color=BLUE, linewidth=0.8, label="fitted")
    name = fitted.own_name(test, column)
    label(
        left,
        name,
        "time [s]",
        f"{record.quantities[k].replace('_', ' ')}{unit_text(symbol, ' [')}]",
        legend=k == 0 or bool(np.any(clipped)),
    )
    residual = record.residual(k, fitted.noise[test][column])
    # What sticks out would hide all others' scatter: it stands at the edge.
    out = outliers(np.nan_to_num(residual)[None])[0]
    right.plot(time[~out], residual[~out], ".", color=ORANGE, markersize=1.5)
    edge = max(5.0, 1.05 * float(np.nanmax(np.abs(residual[~out]))))
    for side, marker in ((1.0, "^"), (-1.0, "v")):
        beyond = out & (side * residual > 0.0)
        right.plot(time[beyond], np.full(beyond.sum(), 0.96 * side * edge), marker, color=ORANGE, markersize=3.0)
    for side in (-NOISE, NOISE):
        right.axhline(side, color="black", linewidth=0.6, linestyle="--")
    right.set_ylim(-edge, edge)
    figure = with_figure(fitted.residual[test][column], fitted.noise[test][column], unit)
    label(right, f"residuals: {figure}", "time [s]", "measured - fitted [deviations]", legend=False)


def with_figure(residual: float, noise: float, unit: str) -> str:
    """Return the root mean square of residuals and the noise that it is relative to."""
    shown, symbol = as_displayed(noise, unit)
    return f"{residual:.4g} of a noise of {shown:.3g}{unit_text(symbol)}"
