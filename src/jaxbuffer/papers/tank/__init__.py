"""*Analysis of fuel tank collision structure based on defense point method* (2021): a slider of 348 kg falls from
2.04 m on a fuel tank that is filled with liquid and stands on a rigid baffle."""

from ..study import Paper, PaperPart
from .claims import CLAIMS
from .figures import figure
from .rows import COLUMNS, SHOWN, row
from .studies import STUDIES

PAPER = Paper(
    "tank",
    "Analysis of fuel tank collision structure based on defense point method",
    "The paper prints the slider's mass, its height and that the tank is full; it prints no dimension, no material and "
    "no number of any result. The tank is assumed (docs/tank_drop.md), so that orders and mechanisms can be compared, "
    "values cannot. Its x, the direction of the impact, is ours downwards.",
    (PaperPart(STUDIES, COLUMNS, SHOWN, row, CLAIMS, figure),),
)
