"""*An Efficient Buffering Mechanism for Mechanical Capturing Systems*, sections 7 and 8.

Its figures are lost and its text prints no force, so its statements are all there is to compare with.
"""

from ..study import Paper, PaperPart
from .claims import CLAIMS
from .figures import figure
from .published import as_published
from .readings import PART as READINGS
from .rows import COLUMNS, SHOWN, row
from .studies import STUDIES

CAPTURES = PaperPart(STUDIES, COLUMNS, SHOWN, row, CLAIMS, figure)
PAPER = Paper(
    "docking",
    "An Efficient Buffering Mechanism for Mechanical Capturing Systems",
    "The paper's figures are lost and its text prints no force: its statements are all there is to compare with. "
    "Values its text leaves open are assumed, as said under each study.",
    (CAPTURES,),
    (as_published(CAPTURES), READINGS),
)
