"""The figure of a comparison of contact laws."""

from typing import TYPE_CHECKING

from ..mechanisms.probe_cone.comparison import ASKED, CURVE, Comparison
from .style import label, line, panels, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@styled
def laws_figure(comparison: Comparison) -> "Figure":
    """Force over penetration and over time in one impact, delivered over asked restitution."""
    figure, grid = panels(12.0, 4.6, 1, 3)
    loops, pulses, delivered = grid[0]
    for k, entry in enumerate(comparison.laws):
        drawn = line(k) | {"label": entry.name}
        loops.plot(1e6 * entry.impact.penetration, entry.impact.force, **drawn)
        pulses.plot(1e3 * entry.impact.time, entry.impact.force, **drawn)
        if hasattr(entry.law, "restitution"):
            delivered.plot(CURVE, entry.curve, **drawn)
            delivered.plot(ASKED, entry.delivered, ".", color=drawn["color"])
    label(loops, "Force over penetration", "penetration [µm]", "contact force [N]", False)
    label(pulses, "Force over time", "time from touchdown [ms]", "contact force [N]", False)
    label(delivered, "Restitution", "asked [-]", "delivered [-]", False)
    figure.legend(*loops.get_legend_handles_labels(), loc="outside lower center", ncols=6)
    figure.suptitle(
        f"Contact laws: {comparison.mass:.4g} kg at {comparison.speed:.4g} m/s, "
        f"restitution {comparison.restitution:g} asked for"
    )
    return figure
