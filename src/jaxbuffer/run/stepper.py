"""A run stepped through time and read off: from event to event, unless its mechanism has a stepper of its own."""

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool

from .._types import Scalar
from ..hybrid import (
    HybridSystem,
    Options,
    Result,
    StepTolerance,
    differentiable,
    solve_at_fixed_times,
    solve_with_tangents,
)
from ..mechanisms.mechanism import TOLERANCES, Mechanism, Request, Stepper
from ..mechanisms.run import Run
from ..mechanisms.system import ContactSystem
from ..programs.cache import Static
from .read_off import read_off

CHECKED, UNCHECKED = Static(False), Static(True)
HISTORY_STEPS = 20_000


class Events:
    """The stepper of hybrid systems, which locates events."""

    difference_tolerance = 1e-11
    tight = 1e-9

    def step(self, request: Request, unchecked: bool, enabled: Bool[Array, ""] | bool) -> Result:
        """See `Stepper`."""
        allowed = enabled & request.allowed if unchecked else None
        build, options = request.mechanism.system, with_tolerances(request)
        return solve_at_fixed_times(build, request.parameters, request.duration, options, allowed)

    def step_with_tangents(
        self, make: Callable[[list[Array], Any], Request], values: list[Array], others: Any
    ) -> Result:
        """See `Stepper`."""
        request = make(values, others)

        def assembled(values: list[Array], others: Any) -> HybridSystem:
            return make(values, others).system

        allowed, options = request.allowed, with_tolerances(request)
        return solve_with_tangents(assembled, values, others, request.duration, options, allowed)

    def differentiable(self, request: Request, result: Result, values: list[Array]) -> Result:
        """See `Stepper`."""
        return differentiable(result, values)

    def many(self, one: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that steps runs one after the other, though it is mapped: see `solve_at_fixed_times`."""
        return jax.vmap(one)

    def read(self, request: Request, result: Result) -> Run:
        """See `Stepper`."""
        return read_off(request, result)

    def rows(self, run: Run) -> int:
        """See `Stepper`."""
        return min(int(run.accepted), run.history.time.size) if run.history is not None else 0


EVENTS = Events()


def stepper_of(mechanism: Mechanism) -> Stepper:
    """Return the mechanism's own stepper, or that of hybrid systems."""
    return mechanism.stepper or EVENTS


def stepped(request: Request, unchecked: Static = UNCHECKED, enabled: Bool[Array, ""] | bool = True) -> Any:
    """Step a run through time, with arguments as of `Stepper.step`: a program's first part; `run_of` is the second."""
    return stepper_of(request.mechanism).step(request, unchecked.value, enabled)


def run_of(request: Request, result: Any) -> Run:
    """Return the run that was `stepped`."""
    return stepper_of(request.mechanism).read(request, result)


def with_tolerances(request: Request) -> Options:
    """Return the options with a run's tolerances, and how closely its events are located at these."""
    system, (rtol, atol) = request.system, request.tolerances
    if (share := system.tolerance_share) < 1.0:
        rtol, atol = jnp.maximum(share * rtol, TOLERANCES["low"]), jnp.maximum(share * atol, TOLERANCES["low"])
    # It depends on the design, but is a setting: its derivative would be refused as one by the tolerance.
    event_time = jax.lax.stop_gradient(_event_time(system, system.first_evaluation()[0].state, rtol))
    return dataclasses.replace(
        request.options, tolerance=StepTolerance(rtol, atol), event_time=event_time, shortfall=rtol
    )


def _event_time(system: ContactSystem, start: Array, rtol: Scalar) -> Scalar:
    """Return how closely steps of a run from ``start`` end on events [s].

    A force that begins τ late with the 3/2 power of time gives an impact of duration T the fraction (τ/T)^{5/2} less
    impulse, which is held to a hundredth of the tolerance; one that begins with a jump τ/T.
    """
    duration = 15.0 * system.impact_step(start)
    return duration * (rtol if system.jumps else (0.01 * rtol) ** 0.4)
