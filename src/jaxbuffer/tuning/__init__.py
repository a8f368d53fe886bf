"""Tuning: the design problem as data, and the search for the best design (docs/tuning.md)."""

from .cases import Case as Case
from .cases import Distribution as Distribution
from .cases import Scatter as Scatter
from .cases import grid as grid
from .cases import sample as sample
from .objective import Limits as Limits
from .objective import Objective as Objective
from .objective import Then as Then
from .problem import Problem as Problem
from .problem import Variable as Variable
from .store import Record as Record
