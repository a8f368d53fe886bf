"""Tuning: the design problem as data, and the search for the best design (docs/tuning.md).

Each folder imports from those before it: ``problem`` (load cases, variables, objective, limits, tolerances),
``search`` (runs, constraints, steps), ``tolerances`` (worst corners, which tolerance matters), ``report`` (what is
told). The modules beside them carry a tuning out.
"""

from .problem.cases import Case as Case
from .problem.cases import Distribution as Distribution
from .problem.cases import Scatter as Scatter
from .problem.cases import grid as grid
from .problem.objective import Limits as Limits
from .problem.objective import Objective as Objective
from .problem.objective import SecondObjective as SecondObjective
from .problem.problem import Problem as Problem
from .problem.tolerances import Tolerance as Tolerance
from .problem.variable import Variable as Variable
