"""Time stepping of any hybrid mechanism: solvers, events, sensitivities."""

from .controller import Controller as Controller
from .controller import Tolerance as Tolerance
from .lanes import Lanes as Lanes
from .log import Kind as Kind
from .log import Log as Log
from .log import Steps as Steps
from .moving import moving as moving
from .options import Options as Options
from .progress import Status as Status
from .run import Result as Result
from .run import run as run
from .solve import solve as solve
from .solve import solve_at_fixed_times as solve_at_fixed_times
from .solvers import SOLVERS as SOLVERS
from .solvers import Automatic as Automatic
from .solvers import DiagonallyImplicit as DiagonallyImplicit
from .solvers import ExplicitRungeKutta as ExplicitRungeKutta
from .solvers import Solver as Solver
from .solvers import solver_named as solver_named
