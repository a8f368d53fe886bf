"""What to draw of a run over time, as data: the drawing itself is output's."""

from typing import NamedTuple

import numpy as np
from jax import Array


class PanelCurve(NamedTuple):
    """Values over the history's time, or over ``along``, with their name in the legend; ``dashed``."""

    label: str
    values: np.ndarray | Array
    dashed: bool = False
    along: np.ndarray | Array | None = None


class Level(NamedTuple):
    """A horizontal line at a value, with its name in the legend; ``limit``: something not to be passed."""

    label: str
    value: float
    limit: bool = False


class Panel(NamedTuple):
    """Curves in one panel: its title, the vertical axis' label with its unit; ``stacked``: whether they add up;
    ``path``: the horizontal axis' label of curves in a plane, "" of curves over time; ``whole``: shown from the start
    of the run on, also where the contacts begin late; ``to_end``: shown to its end, also where they end early."""

    title: str
    axis: str
    curves: tuple[PanelCurve, ...]
    levels: tuple[Level, ...] = ()
    stacked: bool = False
    path: str = ""
    whole: bool = False
    to_end: bool = False
