"""Tuning: the design problem as data, and the search for the best design (docs/tuning.md).

Of these modules each imports from those before it: cases, tolerances, custom_quantity, objective, variable,
problem, settings, own_quantities, measurement, evaluation, goal, targets, corners, spread, corner_search, model_step,
search, store, message, checks, tuned, front, assessment, rounds, descent, tune, pareto.
"""

from .cases import Case as Case
from .cases import Distribution as Distribution
from .cases import Scatter as Scatter
from .cases import grid as grid
from .objective import Limits as Limits
from .objective import Objective as Objective
from .objective import SecondObjective as SecondObjective
from .problem import Problem as Problem
from .tolerances import Tolerance as Tolerance
from .variable import Variable as Variable
