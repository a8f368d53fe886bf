"""What a user may choose about how a run is stepped."""

import equinox as eqx

from .._types import Scalar
from .rungekutta.controller import Controller, StepTolerance
from .rungekutta.solvers import AUTOMATIC, Solver


class Options(eqx.Module):
    """How to step.

    **Arguments:** ``solver``; ``tolerance``; ``controller``; ``max_steps``: attempts before giving up; ``max_events``:
    room in the log (of later events it keeps the maxima and the end); ``event_time`` [s]: how closely events are
    located; ``shortfall`` [-]: of its height, by how much a maximum may be missed before a step of second order onto
    it; ``keep``: accepted steps to store for a history, 0 for none.
    """

    solver: Solver = AUTOMATIC
    tolerance: StepTolerance = StepTolerance()
    controller: Controller = Controller()
    event_time: Scalar = 1e-9
    shortfall: Scalar = 1e-9
    max_steps: int = eqx.field(static=True, default=200_000)
    max_events: int = eqx.field(static=True, default=512)
    keep: int = eqx.field(static=True, default=0)
