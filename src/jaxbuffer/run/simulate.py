"""`simulate`: one run of any mechanism, from a design and a scenario to everything one wants to know of it."""

import dataclasses
import functools
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from .._types import Scalar
from ..compiling.programs import Static, stored
from ..errors import InputError, check_flag, check_single, check_type, check_whole, inside
from ..fields import NON_NEGATIVE, POSITIVE, Part, all_of
from ..hybrid import Diffrax, Log, Options, Result, Solver, Status, Tolerance, solve_at_fixed_times, solver_named
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.outcome import outcome_code
from ..mechanisms.registry import mechanism_of
from ..mechanisms.run import Maxima, Run, Solved
from ..mechanisms.system import ContactSystem
from .conservation import balance
from .history import history as history_of
from .history import trimmed
from .impacts import contact_time, impacts
from .maxima import maxima
from .moving import moving_end, moving_events
from .survey import survey

DEFAULT_TOLERANCE = 1e-6
HISTORY_STEPS = 20_000
ONE_RUN = "simulate takes one {}: use jax.vmap or jb.sweep"
CHECKED, UNCHECKED = Static(False), Static(True)
TOLERANCES = {"low": 1e-13, "high": 1e-2}
LIMITS: dict[str, dict[str, Any]] = {
    "duration": POSITIVE,
    "rtol": TOLERANCES,
    "atol": TOLERANCES,
    "stabilisation": NON_NEGATIVE,
}


def simulate(
    design: Part,
    scenario: Part | None = None,
    duration: Scalar | None = None,
    *,
    solver: Solver | str | None = None,
    rtol: Scalar = DEFAULT_TOLERANCE,
    atol: Scalar | None = None,
    history: bool = False,
    max_steps: int = 200_000,
    max_events: int = 512,
    stabilisation: Scalar = 20.0,
) -> Any:
    """Simulate one run of the mechanism that the design is of. Works under `jit`, `vmap`, `grad`, `jacfwd` and `jvp`.

    **Arguments:**

    - ``design``: of any mechanism, such as ``jb.table2()``.
    - ``scenario`` (default: the mechanism's own).
    - ``duration``: after which a run is over [s] (default: the mechanism's, 8 s for a capture).
    - ``solver``: a name in `hybrid.SOLVER_NAMES` or a `hybrid.Solver` (`jb.Diffrax` takes the smooth contact law).
    - ``rtol``, ``atol``: local error allowed in a step, of a component's size and of its natural scale [-] (``atol``
      defaults to ``rtol``).
    - ``history``: whether to keep time histories.
    - ``max_steps``: limit whose passing is a failed outcome.
    - ``max_events``: room for events in order; of later ones only the maxima, the end and the number of impacts are
      known.
    - ``stabilisation``: Baumgarte's gain [1/s].

    **Returns:** a `Run`; of the probe-cone mechanism a `Capture`. Not converging is an outcome, not an error.

    **Raises:** `InputError` for values out of range, and for a design of no mechanism.

    **Example:**

    >>> capture = jb.simulate(jb.table2(), jb.Scenario(approach_speed=0.1))
    >>> print(f"{capture.outcome.name}: {float(capture.peak_force):.2f} N at {float(capture.peak_time):.4f} s")
    captured: 253.13 N at 0.4881 s
    """
    mechanism = mechanism_of(design)
    scenario = mechanism.scenario() if scenario is None else scenario
    check_pair(mechanism, design, scenario)
    duration = mechanism.defaults.duration if duration is None else duration
    atol = rtol if atol is None else atol
    one = ONE_RUN.format(mechanism.run_name)
    for name, value, unit in (
        ("duration", duration, "s"),
        ("rtol", rtol, "-"),
        ("atol", atol, "-"),
        ("stabilisation", stabilisation, "1/s"),
    ):
        check_single(name, value, unit, one, **LIMITS[name])
    check_flag("history", history)
    check_whole("max_steps", max_steps, 1)
    check_whole("max_events", max_events, 1)
    options = _options(max_steps, max_events, HISTORY_STEPS if history else 0)
    if solver is not None:
        options = dataclasses.replace(options, solver=solver_named(solver))
    if isinstance(options.solver, Diffrax):  # it has no events to set a memory at; the run's design says so
        design = mechanism.smooth(design)
    given = ((design, scenario, stabilisation), duration, (rtol, atol), options)
    leaves, traced = jax.tree.leaves(given), False
    if not all(type(leaf) is float for leaf in leaves):
        traced = any(isinstance(leaf, jax.core.Tracer) for leaf in leaves)
        given = jax.tree.map(_array, given)
        if any(map(np.ndim, jax.tree.leaves(given[0]))):
            _refuse_arrays(design, scenario, one)
    run = _simulate(*given, UNCHECKED if traced else CHECKED)
    if run.history is not None and not isinstance(run.code, jax.core.Tracer):
        run = eqx.tree_at(lambda r: r.history, run, trimmed(run.history, min(int(run.accepted), HISTORY_STEPS)))
    return run


def check_pair(mechanism: Mechanism, design: Any, scenario: Any) -> None:
    """Raise `InputError` where design and scenario are not of one mechanism, or do not fit."""
    kind = mechanism.scenario
    check_type("scenario", scenario, kind, f"the design first, then a scenario, such as {kind.__name__}()")
    mechanism.check_fit(design, scenario)


@functools.cache
def _options(max_steps: int, max_events: int, keep: int) -> Options:
    """The default options with these limits; made once, since building modules takes a while."""
    return Options(max_steps=max_steps, max_events=max_events, keep=keep)


def _refuse_arrays(design: Part, scenario: Part, one: str) -> None:
    for path, leaf in jax.tree_util.tree_leaves_with_path((design, scenario)):
        if np.ndim(leaf):
            name = "".join(str(key) for key in path[1:]).lstrip(".")
            raise InputError(f"{name} has shape {np.shape(leaf)}; {one}")


def _array(value: Any) -> Any:
    """A number as an array; Python's numbers through NumPy, which is ten times quicker than through a device."""
    return jnp.asarray(value, float) if isinstance(value, jax.Array) else np.asarray(value, float)


def _event_time(system: ContactSystem, start: Array, rtol: Array) -> Scalar:
    """How closely steps of a run from ``start`` end on events [s].

    A force that begins τ late with the 3/2 power of time gives an impact of duration T the fraction (τ/T)^{5/2} less
    impulse, which is held to a hundredth of the tolerance; one that begins with a jump τ/T.
    """
    duration = 15.0 * system.impact_step(start)
    return duration * (rtol if system.jumps else (0.01 * rtol) ** 0.4)


def _allowed(
    mechanism: Mechanism, parameters: tuple[Any, Any, Array], duration: Array, tolerances: tuple[Array, Array]
) -> Bool[Array, ""]:
    """Whether all numbers are in range."""
    design, scenario, stabilisation = parameters
    options = {"duration": duration, "rtol": tolerances[0], "atol": tolerances[1], "stabilisation": stabilisation}
    return mechanism.valid(design, scenario) & all_of(inside(x, **LIMITS[name]) for name, x in options.items())


@stored
def _simulate(
    parameters: tuple[Any, Any, Array],
    duration: Float[Array, ""],
    tolerances: tuple[Array, Array],
    options: Options,
    unchecked: Static = CHECKED,
) -> Run:
    """A run. Where its numbers are ``unchecked``, one out of range makes it fail."""
    mechanism = mechanism_of(parameters[0])
    rtol, system = tolerances[0], mechanism.system(*parameters)
    start, active = system.first_posture()
    event_time = jax.lax.stop_gradient(_event_time(system, start.state, rtol))
    allowed = _allowed(mechanism, parameters, duration, tolerances) if unchecked.value else None
    options = dataclasses.replace(options, tolerance=Tolerance(*tolerances), event_time=event_time, shortfall=rtol)
    result = solve_at_fixed_times(mechanism.system, parameters, duration, options, allowed)
    return mechanism.run(system, _read_off(mechanism, system, parameters, duration, (start, active), result, options))


def _read_off(
    mechanism: Mechanism,
    system: ContactSystem,
    parameters: tuple[Any, Any, Array],
    duration: Array,
    start: tuple[Any, Array],
    result: Result,
    options: Options,
) -> Solved:
    """All that every mechanism's runs have, from what the time stepping found."""
    log = moving_end(system, result.log, result.status < Status.TIMEOUT)
    seen = survey(system, log)
    log = moving_events(log, seen)
    code = outcome_code(mechanism.outcomes, mechanism.ends, mechanism.time_is_up, result.status)
    # a factor, so that derivatives are NaN as well
    known = jnp.where(code < mechanism.outcomes["failed_steps"], 1.0, jnp.nan)
    top, hits = maxima(system, log, start), impacts(system, log, seen)
    energy, conserved = balance(system, start, log, seen.drift)
    common = {
        "design": parameters[0],
        "scenario": parameters[1],
        "code": code,
        "peak_force": top.peak_force * known,
        "peak_time": top.peak_time * known,
        "peak_contact": top.peak_contact,
        "peak_impact": _peak_impact(log, top, hits),
        "maxima": {name: value * known for name, value in top.others.items()},
        "penetration": system.penetration(top.peak_force) * known,
        "end_time": log.time[jnp.maximum(log.count - 1, 0)] * known,
        "contact_time": contact_time(system, log) * known,
        "impact_count": hits.count + jnp.sum(log.missed[: system.impact_contacts]),
        "impacts": hits,
        "energy": energy,
        "balance": conserved,
        "history": history_of(system, result.steps) if options.keep else None,
        "attempts": result.attempts,
        "accepted": result.accepted,
        "stabilisation": parameters[2],
        "_located": result.log,
    }
    return Solved(parameters, duration, start[0], result, log, code, known, top, common)


def _peak_impact(log: Log, top: Maxima, hits: Any) -> Array:
    """Which of the listed impacts the largest contact force belongs to, -1 for none of them."""
    slots = hits.time.shape[0]
    earlier = (jnp.arange(slots) < hits.count) & (hits.time <= top.peak_time) & (hits.contact == top.peak_contact)
    listed = ~log.overflown | (top.peak_time <= log.time[log.room - 1])
    return jnp.max(jnp.where(earlier & listed, jnp.arange(slots), -1))
