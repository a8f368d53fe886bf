"""The drop onto a tank as a stepper: explicit steps of finite elements."""

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
from jaxtyping import Array, Bool

from ...hybrid import StepTolerance
from ..mechanism import Request, Stepper
from .run import rows_of, run_of
from .stepping import TIGHT, TOLERANCE, Dropped, dropped
from .tank_run import TankRun


@dataclasses.dataclass(frozen=True)
class ExplicitElements(Stepper):
    """The stepper of finite elements, in steps as long as they can be stable; it is differentiated as a whole."""

    difference_tolerance = TOLERANCE
    tight = TIGHT

    def step(self, request: Request, unchecked: bool, enabled: Bool[Array, ""] | bool) -> Dropped:
        """See `Stepper`."""
        options = dataclasses.replace(request.options, tolerance=StepTolerance(*request.tolerances))
        allowed = enabled & request.allowed
        # Runs whose numbers are unchecked need have reverse derivatives only (see `Stepper.step`).
        return dropped(request.parameters, request.duration, options, allowed, backwards=unchecked)

    def many(self, one: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that takes runs one after the other: lanes of a loop over many nodes would wait for the
        slowest."""
        return lambda *numbers: jax.lax.map(lambda run: one(*run), numbers)

    def read(self, request: Request, result: Dropped) -> TankRun:
        """See `Stepper`."""
        return run_of(request.parameters, request.duration, result)

    def rows(self, run: TankRun) -> int:
        """See `Stepper`."""
        return rows_of(run)
