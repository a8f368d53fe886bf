"""The figure of a comparison of contact laws."""

from .._types import Figure
from ..mechanisms.probe_cone.comparison import ASKED, CURVE, Comparison
from .layout import legend_below
from .style import GREY, MARKS, label, line, panels, styled


@styled
def laws_figure(comparison: Comparison) -> Figure:
    """Draw force over penetration and over time in one impact, and delivered over asked restitution."""
    figure, grid = panels(13.0, 5.2, 1, 3)
    loops, pulses, delivered = grid[0]
    for k, entry in enumerate(comparison.laws):
        count = len(entry.impact.time)
        marked = {"marker": MARKS[k % len(MARKS)], "markersize": 5, "markerfacecolor": "white"}
        drawn = line(k) | {"label": entry.name, **marked}
        every = {"markevery": (int(count * (0.1 + 0.03 * k)), max(count // 4, 1))}  # each law's at places of its own
        loops.plot(1e6 * entry.impact.penetration, entry.impact.force, **drawn, **every)
        pulses.plot(1e3 * entry.impact.time, entry.impact.force, **drawn, **every)
        # A law without a restitution delivers the same whatever is asked, which no curve needs to show.
        if hasattr(entry.law, "restitution"):
            delivered.plot(CURVE, entry.curve, **line(k))
            delivered.plot(ASKED, entry.delivered, linestyle="", color=drawn["color"], **marked)
    label(loops, "Force over penetration", "penetration [µm]", "contact force [N]", False)
    label(pulses, "Force over time", "time from touchdown [ms]", "contact force [N]", False)
    delivered.plot([0.0, 1.0], [0.0, 1.0], color=GREY, linewidth=0.8, zorder=1)
    delivered.annotate("as asked", (0.8, 0.8), xytext=(0.82, 0.72), color=GREY)
    label(delivered, "Restitution", "restitution asked [-]", "restitution delivered [-]", False)
    legend_below(figure, *loops.get_legend_handles_labels())
    figure.suptitle(
        f"Contact laws: {comparison.mass:.4g} kg at {comparison.speed:.4g} m/s, "
        f"restitution {comparison.restitution:g} asked for"
    )
    return figure
