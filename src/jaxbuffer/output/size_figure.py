"""The figure of sized parts: what each quantity costs, over the stiffness that sets it."""

import math

from .._types import Axes, Figure
from ..fields import display_unit, get, unit
from ..mechanisms.sizing import TradeOff
from ..run.sized import Sized
from .layout import legend_below
from .style import BLUE, GREY, ORANGE, RED, label, panels, styled


@styled
def size_figure(sized: Sized) -> Figure:
    """Draw each quantity of the trade-offs over its number: closed form, wish, the sized design, and what its runs
    reach."""
    shown = [(trade, name) for trade in sized.parts.trade_offs for name in trade.quantities]
    columns = min(len(shown), 3)
    rows = math.ceil(len(shown) / columns)
    figure, grid = panels(4.0 * columns, 3.1 * rows + 0.5, rows, columns)
    flat = list(grid.flat)
    for axes, (trade, name) in zip(flat, shown, strict=False):
        _panel(axes, sized, trade, name)
    for axes in flat[len(shown) :]:
        axes.set_visible(False)
    handles, names = flat[0].get_legend_handles_labels()
    for axes in flat[1 : len(shown)]:
        for handle, text in zip(*axes.get_legend_handles_labels(), strict=True):
            if text not in names:
                handles, names = [*handles, handle], [*names, text]
    legend_below(figure, handles, names)
    ends = f"; {sized.ends} runs" if sized.ends else ""
    figure.suptitle(f"Sized by closed forms{ends}")
    return figure


def _panel(axes: Axes, sized: Sized, trade: TradeOff, name: str) -> None:
    from matplotlib.ticker import LogLocator

    quantity, estimate = sized.mechanism.quantities[name], sized.parts.estimates[name]
    symbol, factor = quantity.in_figures
    x_symbol, x_factor = display_unit(unit(sized.design, trade.path))
    chosen = x_factor * float(get(sized.design, trade.path))
    axes.loglog(x_factor * trade.values, factor * trade.quantities[name], color=BLUE, label="closed form")
    if estimate.limit is not None:
        axes.axhline(factor * estimate.limit, color=RED, linestyle="--", label="wished at most")
    axes.axvline(chosen, color=GREY, linewidth=0.8, label="sized")
    values = [factor * float(quantity.of(run)) for run in sized.runs.values()]
    axes.plot([chosen] * len(values), values, "o", color=ORANGE, markersize=5, zorder=3, label="simulated, a scenario")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter("")
    title = quantity.title or name.replace("_", " ")
    label(axes, f"{title[:1].upper()}{title[1:]}", f"{trade.path} [{x_symbol}]", f"[{symbol}]", False)
