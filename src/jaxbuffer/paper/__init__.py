"""The paper's own studies, run again: scenarios as data, figures, and what its text claims beside what the model says.

*An Efficient Buffering Mechanism for Mechanical Capturing Systems*, sections 7 and 8. Its figures are lost and its text
prints no force, so its statements are all there is to compare with.
"""

from .claims import CLAIMS as CLAIMS
from .claims import Verdict as Verdict
from .claims import judged as judged
from .run import Row as Row
from .run import run as run
from .studies import STUDIES as STUDIES
from .studies import Case as Case
from .studies import Study as Study
