"""What a user may choose about how a run is stepped."""

import dataclasses

import equinox as eqx

from .._types import Scalar
from .rungekutta.controller import Controller, StepTolerance
from .rungekutta.solvers import AUTOMATIC, Solver
from .system import HybridSystem


class Options(eqx.Module):
    """How to step.

    **Arguments:** ``solver``; ``tolerance``; ``controller``; ``max_steps``: attempts before giving up; ``max_events``:
    room in the log (of later events it keeps the maxima and the end); ``event_time`` [s]: how closely events are
    located, None for what the system asks for at this tolerance; ``shortfall`` [-]: of its height, by how much a
    maximum may be missed before a step of second order onto it, None for the relative tolerance; ``keep``: accepted
    steps to store for a history, 0 for none.
    """

    solver: Solver = AUTOMATIC
    tolerance: StepTolerance = StepTolerance()
    controller: Controller = Controller()
    event_time: Scalar | None = 1e-9
    shortfall: Scalar | None = 1e-9
    max_steps: int = eqx.field(static=True, default=200_000)
    max_events: int = eqx.field(static=True, default=512)
    keep: int = eqx.field(static=True, default=0)

    def shared(self, system: HybridSystem) -> "Options":
        """Return the options with the share of the tolerance that the steps of a system keep to."""
        return dataclasses.replace(self, tolerance=self.tolerance.shared(system.tolerance_share))
