"""A figure a mechanism: peak force over effective energy, an impact a dot, a panel a contact."""

import numpy as np

from ..._types import Figure
from ...output.style import COLOURS, drawing, label, panels
from ..study import Studied


def figure(studied: Studied) -> Figure:
    """Draw the study's figure, with logarithmic axes; the line is the power law through the first impacts."""
    with drawing():
        drawn, grid = panels(12.0, 4.5, 1, len(studied.captures))
        for axes, capture, row in zip(np.ravel(grid), studied.captures, studied.rows, strict=True):
            for first, name, colour in ((0.0, "later impacts", COLOURS[4]), (1.0, "first impacts", COLOURS[0])):
                # Logarithmic axes have no place for zeros.
                chosen = (capture.first == first) & (capture.peak > 0.0) & (capture.energy > 0.0)
                axes.plot(capture.energy[chosen], capture.peak[chosen], ".", markersize=4, color=colour, label=name)
            energy = np.sort(capture.energy[capture.first > 0.0])[[0, -1]]
            middle = np.exp(np.mean(np.log(capture.peak[capture.first > 0.0])))
            line = middle * (energy / float(row["mean_energy"])) ** float(row["exponent"])
            axes.plot(energy, line, color=COLOURS[1], label=f"$T_c^{{{float(row['exponent']):.3f}}}$")
            axes.set(xscale="log", yscale="log")
            ranks = f"rank correlation: first {float(row['rank_first']):.4f}, all {float(row['rank_all']):.4f}"
            label(axes, f"{row['case']}\n{ranks}", "effective energy before the impact [J]", "peak force [N]")
        drawn.suptitle(studied.study.title)
        return drawn
