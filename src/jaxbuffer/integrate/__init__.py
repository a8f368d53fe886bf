"""Time stepping of any hybrid mechanism: solvers, events, sensitivities."""

from .controller import Controller as Controller, Tolerance as Tolerance
from .lanes import Lanes as Lanes
from .log import Kind as Kind, Log as Log, Steps as Steps
from .run import Options as Options, Result as Result, Status as Status, run as run
from .solve import solve as solve
from .solvers import ExplicitRungeKutta as ExplicitRungeKutta, LinearlyImplicit as LinearlyImplicit, Solver as Solver
