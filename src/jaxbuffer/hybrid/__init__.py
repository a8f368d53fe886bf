"""Time stepping of any hybrid mechanism: solvers, events, sensitivities."""

from .diffrax_problem import DiffraxProblem as DiffraxProblem
from .diffrax_problem import diffrax_problem as diffrax_problem
from .event_times import moving as moving
from .loop.log import Kind as Kind
from .loop.log import Log as Log
from .loop.log import Steps as Steps
from .loop.loop import Result as Result
from .loop.loop import run as run
from .loop.state import Status as Status
from .options import Options as Options
from .rungekutta.controller import Controller as Controller
from .rungekutta.controller import Tolerance as Tolerance
from .rungekutta.diffrax_solver import Diffrax as Diffrax
from .rungekutta.named_solvers import SOLVER_NAMES as SOLVER_NAMES
from .rungekutta.named_solvers import SOLVERS as SOLVERS
from .rungekutta.named_solvers import solver_named as solver_named
from .rungekutta.solvers import Automatic as Automatic
from .rungekutta.solvers import DiagonallyImplicit as DiagonallyImplicit
from .rungekutta.solvers import ExplicitRungeKutta as ExplicitRungeKutta
from .rungekutta.solvers import Solver as Solver
from .sensitivity.augmented_state import Tangents as Tangents
from .solve import solve as solve
from .solve import solve_at_fixed_times as solve_at_fixed_times
from .system import HybridSystem as HybridSystem
from .system import Linearisation as Linearisation
from .system import Watched as Watched
