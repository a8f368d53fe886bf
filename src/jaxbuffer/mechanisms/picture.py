"""What to draw of a run, as data: panels, and meshes at an instant."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..elements.picture import Level as Level
from ..elements.picture import Panel as Panel
from ..elements.picture import PanelCurve as PanelCurve
from ..value_text import with_unit


class Meshed(NamedTuple):
    """A mesh at an instant, and what its cells have.

    - ``title``: of the instant; ``name``: of its file.
    - ``nodes``: (nodes, 2) where they are then [m]; ``cells``: (cells, 4) their nodes.
    - ``values``: by name with unit, a number for each cell, NaN where it has none.
    """

    title: str
    name: str
    nodes: np.ndarray
    cells: np.ndarray
    values: Mapping[str, np.ndarray]


def reach(values: np.ndarray, largest: float, unit: str) -> str:
    """Return what a title says of a curve that can change sign: its ends with their signs, the larger one to be the
    run's ``largest`` size, which lies between two steps."""
    low, high = float(np.min(values, initial=0.0)), float(np.max(values, initial=0.0))
    low, high = (-largest, high) if -low > high else (low, largest)
    return f", from {low:.3g} to {with_unit(high, unit, 3)}"
