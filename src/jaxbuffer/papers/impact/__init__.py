"""*Impact Dynamics Analysis of Mobile Mechanical Systems* (Mathematics, 2021): a bar dropped on a plate (section 2),
a slider-crank with play in its piston pin (section 3).

A module each for studies, rows, claims and figures of a mechanism; another mechanism is another `PaperPart`.
"""

from ..study import Paper, PaperPart
from . import algorithm, element_studies
from .bar_claims import CLAIMS
from .bar_figures import figure
from .bar_rows import COLUMNS, SHOWN, row
from .bar_studies import STUDIES
from .crank_claims import CLAIMS as CRANK_CLAIMS
from .crank_figures import figure as crank_figure
from .crank_rows import COLUMNS as CRANK_COLUMNS
from .crank_rows import SHOWN as CRANK_SHOWN
from .crank_rows import row as crank_row
from .crank_studies import STUDIES as CRANK_STUDIES

BAR = PaperPart(STUDIES, COLUMNS, SHOWN, row, CLAIMS, figure)
ALGORITHM = PaperPart(
    algorithm.STUDIES, algorithm.COLUMNS, algorithm.SHOWN, algorithm.row, algorithm.CLAIMS, algorithm.figure
)
ELEMENTS = PaperPart(
    element_studies.STUDIES,
    element_studies.COLUMNS,
    element_studies.SHOWN,
    element_studies.row,
    element_studies.CLAIMS,
    element_studies.figure,
    solve=element_studies.solve,
)
CRANK = PaperPart(CRANK_STUDIES, CRANK_COLUMNS, CRANK_SHOWN, crank_row, CRANK_CLAIMS, crank_figure)
PAPER = Paper(
    "impact",
    "Impact Dynamics Analysis of Mobile Mechanical Systems",
    "The paper's numbers contradict one another: its drop height gives another speed and time of contact than it "
    "prints, and its forces for the same data run from 205 to 915 N. Ours stand beside them; no agreement is claimed "
    "that is not there. Density (steel), supports and damping of the modes are assumed. Of the slider-crank no "
    "geometry is printed: what grows and what comes first can be compared, its numbers cannot.",
    (BAR, ALGORITHM, ELEMENTS, CRANK),
)
