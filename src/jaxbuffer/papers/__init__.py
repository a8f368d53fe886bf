"""The papers' own studies, run again: scenarios as data, figures, and what the texts claim beside what the models say.

A folder a paper; its `PAPER` names its parts, one for each mechanism.
"""

import importlib

from .study import Paper

PAPERS = {
    "docking": "the buffer in a docking mechanism",
    "impact": "a bar dropped on a plate, a slider-crank with play",
    "load": "how hard an impact is, by the energy before it",
    "tank": "a slider falls on a fuel tank that is full",
}


def paper_named(name: str) -> Paper:
    """Return the paper of a name in `PAPERS`."""
    # A paper imports its mechanisms and figures, so that only the one that is asked for is loaded.
    paper = importlib.import_module(f".{name}", __name__).PAPER
    assert isinstance(paper, Paper)
    return paper
