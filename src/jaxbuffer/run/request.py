"""A request for one run, and the run stepped through time."""

import dataclasses
import functools
from typing import Any, NamedTuple

import jax
from jaxtyping import Array, Bool

from .._types import Scalar
from ..errors import check_type, inside
from ..fields import NON_NEGATIVE, POSITIVE, Part, all_of
from ..hybrid import Diffrax, Options, Solver, Tolerance, solve_at_fixed_times
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.system import ContactSystem
from ..programs.cache import Static

DEFAULT_TOLERANCE = 1e-6
CHECKED, UNCHECKED = Static(False), Static(True)
TOLERANCES = {"low": 1e-13, "high": 1e-2}
NO_TENTH = "a tenth of rtol is below 1e-13, the least allowed"
LIMITS: dict[str, dict[str, Any]] = {
    "duration": POSITIVE,
    "rtol": TOLERANCES,
    "atol": TOLERANCES,
    "stabilisation": NON_NEGATIVE,
}
Parameters = tuple[Any, Any, Scalar]  # design, scenario, Baumgarte's gain [1/s]
Tolerances = tuple[Scalar, Scalar]  # rtol and atol [-]
ONE_RUN = "simulate takes one {}: use jax.vmap or jb.sweep"


@functools.cache
def options_of(max_steps: int = 200_000, max_events: int = 512, keep: int = 0) -> Options:
    """The default options with these limits; made once, since building modules takes a while."""
    return Options(max_steps=max_steps, max_events=max_events, keep=keep)


class Request(NamedTuple):
    """A request for one run: what `stepped` and `run_of` need of it. It is a tree of numbers, made for one mechanism.

    ``mechanism``; ``parameters``: design, scenario and Baumgarte's gain [1/s]; ``duration`` [s]; ``tolerances``: rtol
    and atol [-]; ``options``: how it is stepped, whose own tolerances `with_tolerances` replaces.
    """

    mechanism: Mechanism
    parameters: Parameters
    duration: Scalar
    tolerances: Tolerances
    options: Options

    @property
    def system(self) -> ContactSystem:
        """The equations of motion, ready to be stepped."""
        return self.mechanism.system(*self.parameters)

    @property
    def allowed(self) -> Bool[Array, ""]:
        """Whether all numbers are in range."""
        design, scenario, stabilisation = self.parameters
        numbers = (self.duration, *self.tolerances, stabilisation)
        within = (inside(x, **limits) for x, limits in zip(numbers, LIMITS.values(), strict=True))
        return self.mechanism.valid(design, scenario) & all_of(within)


def request(
    mechanism: Mechanism,
    design: Part,
    scenario: Part,
    duration: Scalar,
    solver: Solver | None = None,
    tolerances: Tolerances = (DEFAULT_TOLERANCE, DEFAULT_TOLERANCE),
    stabilisation: Scalar = 20.0,
    options: Options | None = None,
) -> Request:
    """Make a request of unchecked numbers; ``tolerances``: rtol and atol [-]; the rest as for `simulate`."""
    options = options_of() if options is None else options
    options = options if solver is None else dataclasses.replace(options, solver=solver)
    if isinstance(options.solver, Diffrax):  # it has no events to set a memory at; the run's design says so
        design = mechanism.smooth(design)
    return Request(mechanism, (design, scenario, stabilisation), duration, tolerances, options)


def check_pair(mechanism: Mechanism, design: Any, scenario: Any) -> None:
    """Raise `InputError` where design and scenario are not of one mechanism, or do not fit."""
    kind = mechanism.scenario
    check_type("scenario", scenario, kind, f"the design first, then a scenario, such as {kind.__name__}()")
    mechanism.check_fit(design, scenario)


def tenth(rtol: float) -> float | None:
    """A tenth of a tolerance [-]; None where that is below the least allowed."""
    return None if rtol < 10.0 * TOLERANCES["low"] else 0.1 * rtol


def with_tolerances(request: Request) -> Options:
    """The options with a run's tolerances, and how closely its events are located at these."""
    system, (rtol, atol) = request.system, request.tolerances
    event_time = jax.lax.stop_gradient(_event_time(system, system.first_posture()[0].state, rtol))
    return dataclasses.replace(request.options, tolerance=Tolerance(rtol, atol), event_time=event_time, shortfall=rtol)


def _event_time(system: ContactSystem, start: Array, rtol: Scalar) -> Scalar:
    """How closely steps of a run from ``start`` end on events [s].

    A force that begins τ late with the 3/2 power of time gives an impact of duration T the fraction (τ/T)^{5/2} less
    impulse, which is held to a hundredth of the tolerance; one that begins with a jump τ/T.
    """
    duration = 15.0 * system.impact_step(start)
    return duration * (rtol if system.jumps else (0.01 * rtol) ** 0.4)


def stepped(request: Request, unchecked: Static = UNCHECKED, wanted: Bool[Array, ""] | bool = True) -> Any:
    """Step a run through time: the result is a `Result`, or what the mechanism's own `Stepping` has.

    ``unchecked``: whether its numbers may be out of range, or the run not ``wanted``; it then fails without a step.
    """
    mechanism, parameters, duration, tolerances, options = request
    if mechanism.stepping is not None:
        options = dataclasses.replace(options, tolerance=Tolerance(*tolerances))
        return mechanism.stepping.step(
            parameters, duration, options, wanted & request.allowed, backwards=unchecked.value
        )
    allowed = wanted & request.allowed if unchecked.value else None
    return solve_at_fixed_times(mechanism.system, parameters, duration, with_tolerances(request), allowed)
