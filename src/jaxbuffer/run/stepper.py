"""A run stepped through time and read off: from event to event, unless its mechanism has a stepper of its own."""

import dataclasses
import functools
from collections.abc import Callable
from typing import Any, TypeVar

import jax
from jaxtyping import Array, Bool

from ..hybrid import (
    HybridSystem,
    Options,
    Result,
    StepTolerance,
    solve_and_read,
    solve_at_fixed_times,
    solve_with_tangents,
    with_derivatives,
)
from ..mechanisms.mechanism import Mechanism, Request, Stepper
from ..mechanisms.run import Run
from ..programs.cache import Static
from .read_off import read_off

T = TypeVar("T")
CHECKED, UNCHECKED = Static(False), Static(True)
HISTORY_STEPS = 20_000


class Events:
    """The stepper of hybrid systems, which locates events."""

    difference_tolerance = 1e-11
    tight = 1e-9

    def step(self, request: Request, unchecked: bool, enabled: Bool[Array, ""] | bool) -> Result:
        """See `Stepper`."""
        allowed = enabled & request.allowed if unchecked else None
        build, options = request.mechanism.system, events_options(request)
        return solve_at_fixed_times(build, request.parameters, request.duration, options, allowed)

    def run(self, request: Request) -> Run:
        """See `Stepper`."""
        mechanism, options = request.mechanism, events_options(request)
        read = functools.partial(_read, mechanism)
        return solve_and_read(mechanism.system, read, request.parameters, request.duration, options, request.allowed)

    def step_with_tangents(
        self, make: Callable[[list[Array], Any], Request], values: list[Array], others: Any
    ) -> Result:
        """See `Stepper`."""
        request = make(values, others)

        def assembled(values: list[Array], others: Any) -> HybridSystem:
            return make(values, others).system

        allowed, options = request.allowed, events_options(request)
        return solve_with_tangents(assembled, values, others, request.duration, options, allowed)

    def with_derivatives(
        self, read: Callable[[list[Array], Result], T], make: Any, values: list[Array], result: Result
    ) -> tuple[T, T]:
        """See `Stepper`."""
        return with_derivatives(read, values, result)

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


def _read(mechanism: Mechanism, parameters: Any, duration: Array, options: Options, result: Result) -> Run:
    assert options.tolerance is not None
    tolerances = (options.tolerance.rtol, options.tolerance.atol)
    return read_off(Request(mechanism, parameters, duration, tolerances, options), result)


def stepper_of(mechanism: Mechanism) -> Stepper:
    """Return the mechanism's own stepper, or that of hybrid systems."""
    return mechanism.stepper or EVENTS


def stepped(request: Request, unchecked: Static = UNCHECKED, enabled: Bool[Array, ""] | bool = True) -> Any:
    """Step a run through time, with arguments as of `Stepper.step`: a program's first part; `run_of` is the second."""
    return stepper_of(request.mechanism).step(request, unchecked.value, enabled)


def run_of(request: Request, result: Any) -> Run:
    """Return the run that was `stepped`."""
    return stepper_of(request.mechanism).read(request, result)


def events_options(request: Request) -> Options:
    """Return the options with a run's tolerances; the system says how closely its events are located at these."""
    tolerance = StepTolerance(*request.tolerances)
    return dataclasses.replace(request.options, tolerance=tolerance, event_time=None, shortfall=None)
