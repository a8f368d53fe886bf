"""The figure of a sensitivity: elasticities as bars with their estimated errors, a panel a quantity."""

from collections.abc import Sequence

import numpy as np

from .._types import Axes, Figure
from ..sensitivities.certificate import Verdict
from ..sensitivities.evidence import FLOOR
from ..sensitivities.result import Sensitivity
from .style import BLUE, GREY, RED, blank, label, styled

COLUMNS = 2
LOOK = {Verdict.trusted: (BLUE, ""), Verdict.check: (GREY, "////"), Verdict.refused: (RED, "xxxx")}


def drawn(result: Sensitivity) -> list[int]:
    """Return the numbers of the quantities that have elasticities: those that can change sign have none."""
    return [i for i in range(len(result.quantities)) if np.any(np.isfinite(result.elasticities[i]))]


@styled
def sensitivity_figure(result: Sensitivity) -> Figure:
    """Draw a panel for each quantity, a bar for each parameter, the longest above; hatched where it is not trusted."""
    which = drawn(result)
    columns = min(COLUMNS, max(len(which), 1))
    rows = -(-max(len(which), 1) // columns)
    figure = blank(6.0 * columns, (0.28 * len(result.paths) + 1.3) * rows + 0.6)
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes, i in zip(grid.flat, which, strict=False):
        _bars(axes, result, i)
    for axes in grid.flat[len(which) :]:
        axes.remove()
    view = result.run.mechanism.view
    figure.suptitle(f"Elasticities at {view.label(result.run.scenario)}; lines: estimated error")
    return figure


def _bars(axes: Axes, result: Sensitivity, i: int) -> None:
    values, certificate = result.elasticities[i], result.certificate
    order = np.argsort(np.abs(np.nan_to_num(values)), kind="stable")
    places, sizes = np.arange(len(order)), np.nan_to_num(values)[order]
    verdict = None if certificate is None else certificate.verdicts[i]
    colour, hatch = (GREY, "") if verdict is None else LOOK[verdict]
    axes.barh(places, sizes, 0.7, color=colour, hatch=hatch, edgecolor="white", linewidth=0.0)
    if certificate is not None:
        # Errors are relative to the elasticity, and to `FLOOR` where that is smaller.
        reach = np.nan_to_num(certificate.error[i][order]) * np.maximum(np.abs(sizes), FLOOR)
        axes.errorbar(sizes, places, xerr=reach, fmt="none", ecolor="black", elinewidth=1.0, capsize=2.5)
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.set_yticks(places, _names(result.paths, order, values))
    catalogue, name = result.run.mechanism.quantities, result.quantities[i]
    known = catalogue.get(name)
    value = f"{result.results[i]:.4g}" if known is None else known.in_words(float(result.results[i]), 4)
    word = "not certified" if verdict is None else verdict.name
    title = name.replace("_", " ") if known is None else known.title or name.replace("_", " ")
    label(axes, f"{title}, {value}: {word}", "% for 1 % more [-]", "", legend=False)


def _names(paths: Sequence[str], order: np.ndarray, values: np.ndarray) -> list[str]:
    """Return the parameters in the bars' order; "(none)" follows one without an elasticity."""
    return [paths[k] if np.isfinite(values[k]) else f"{paths[k]} (none)" for k in order]
