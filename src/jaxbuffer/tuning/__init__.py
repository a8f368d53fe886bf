"""Tuning: the design problem as data, and the search for the best design (docs/tuning.md)."""

from .cases import Distribution as Distribution
from .cases import grid as grid
from .cases import sample as sample
from .problem import Case as Case
from .problem import Limits as Limits
from .problem import Objective as Objective
from .problem import Problem as Problem
from .problem import Then as Then
from .problem import Variable as Variable
from .store import Record as Record
from .tune import tune as tune
from .tuned import Tuned as Tuned
