"""One run as it is asked for, and stepped through time."""

import dataclasses
import functools
from typing import Any

import jax
from jaxtyping import Array, Bool

from .._types import Scalar
from ..errors import check_type, inside
from ..fields import NON_NEGATIVE, POSITIVE, Part, all_of
from ..hybrid import Diffrax, Options, Solver, Tolerance, solve_at_fixed_times
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.registry import mechanism_of
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
Request = tuple[Parameters, Scalar, Tolerances, Options]  # with the duration [s]


@functools.cache
def options_of(max_steps: int = 200_000, max_events: int = 512, keep: int = 0) -> Options:
    """The default options with these limits; made once, since building modules takes a while."""
    return Options(max_steps=max_steps, max_events=max_events, keep=keep)


def request(
    design: Part,
    scenario: Part,
    duration: Scalar,
    solver: Solver | None = None,
    tolerances: Tolerances = (DEFAULT_TOLERANCE, DEFAULT_TOLERANCE),
    stabilisation: Scalar = 20.0,
    options: Options | None = None,
) -> Request:
    """What `stepped` and `run_of` need of a run, unchecked; ``tolerances``: rtol and atol [-]; the rest as for
    `simulate`."""
    options = options_of() if options is None else options
    options = options if solver is None else dataclasses.replace(options, solver=solver)
    if isinstance(options.solver, Diffrax):  # it has no events to set a memory at; the run's design says so
        design = mechanism_of(design).smooth(design)
    return (design, scenario, stabilisation), duration, tolerances, options


def check_pair(mechanism: Mechanism, design: Any, scenario: Any) -> None:
    """Raise `InputError` where design and scenario are not of one mechanism, or do not fit."""
    kind = mechanism.scenario
    check_type("scenario", scenario, kind, f"the design first, then a scenario, such as {kind.__name__}()")
    mechanism.check_fit(design, scenario)


def allowed_of(
    mechanism: Mechanism, parameters: Parameters, duration: Scalar, tolerances: Tolerances
) -> Bool[Array, ""]:
    """Whether all numbers are in range."""
    design, scenario, stabilisation = parameters
    options = {"duration": duration, "rtol": tolerances[0], "atol": tolerances[1], "stabilisation": stabilisation}
    return mechanism.valid(design, scenario) & all_of(inside(x, **LIMITS[name]) for name, x in options.items())


def tenth(rtol: float) -> float | None:
    """A tenth of a tolerance [-]; None where that is below the least allowed."""
    return None if rtol < 10.0 * TOLERANCES["low"] else 0.1 * rtol


def with_tolerances(options: Options, parameters: Parameters, tolerances: Tolerances) -> Options:
    """The options with a run's tolerances, and how closely its events are located at these."""
    system = mechanism_of(parameters[0]).system(*parameters)
    event_time = jax.lax.stop_gradient(_event_time(system, system.first_posture()[0].state, tolerances[0]))
    return dataclasses.replace(
        options, tolerance=Tolerance(*tolerances), event_time=event_time, shortfall=tolerances[0]
    )


def _event_time(system: ContactSystem, start: Array, rtol: Scalar) -> Scalar:
    """How closely steps of a run from ``start`` end on events [s].

    A force that begins τ late with the 3/2 power of time gives an impact of duration T the fraction (τ/T)^{5/2} less
    impulse, which is held to a hundredth of the tolerance; one that begins with a jump τ/T.
    """
    duration = 15.0 * system.impact_step(start)
    return duration * (rtol if system.jumps else (0.01 * rtol) ** 0.4)


def stepped(
    parameters: Parameters,
    duration: Scalar,
    tolerances: Tolerances,
    options: Options,
    unchecked: Static = UNCHECKED,
    wanted: Bool[Array, ""] | bool = True,
) -> Any:
    """What time stepping finds of a run: a `Result`, or what the mechanism's own `Stepping` has.

    ``unchecked``: whether its numbers may be out of range, or the run not ``wanted``; it then fails without a step.
    """
    mechanism = mechanism_of(parameters[0])
    if mechanism.stepping is not None:
        may = wanted & allowed_of(mechanism, parameters, duration, tolerances)
        options = dataclasses.replace(options, tolerance=Tolerance(*tolerances))
        return mechanism.stepping.step(parameters, duration, options, may, backwards=unchecked.value)
    allowed = wanted & allowed_of(mechanism, parameters, duration, tolerances) if unchecked.value else None
    options = with_tolerances(options, parameters, tolerances)
    return solve_at_fixed_times(mechanism.system, parameters, duration, options, allowed)
