"""`simulate`: one capture, from a design and a scenario to everything one wants to know of it."""

import dataclasses
import functools
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ._types import Scalar
from .errors import InputError, check_flag, check_single, check_whole, inside
from .first_impact import FirstImpact, predict
from .history import History, history, trimmed
from .integrate import Log, Options, Solver, Status, Tolerance, moving, solve_at_fixed_times, solver_named
from .ledger import Balance, Energy, balance
from .mechanisms import CaptureMechanism, Design, Scenario, check_fit
from .mechanisms.assembly import FLANKS
from .mechanisms.design import NON_NEGATIVE, POSITIVE
from .mechanisms.validity import all_of, valid
from .metrics import (
    Impacts,
    contact_time,
    impacts,
    maxima,
    moving_end,
    moving_events,
    stroke_margin,
    survey,
    throat,
)
from .outcome import Outcome, outcome_code
from .programs import Static, kept

DEFAULT_TOLERANCE = 1e-6
DEFAULT_DURATION = 8.0  # s
HISTORY_STEPS = 20_000
ONE_CAPTURE = "simulate takes one capture: use jax.vmap or jb.sweep"
CHECKED, UNCHECKED = Static(False), Static(True)
TOLERANCES = {"low": 1e-13, "high": 1e-2}
LIMITS: dict[str, dict[str, Any]] = {
    "duration": POSITIVE,
    "rtol": TOLERANCES,
    "atol": TOLERANCES,
    "stabilisation": NON_NEGATIVE,
}


class Capture(eqx.Module):
    """A simulated capture. Print it for a summary.

    Numbers are 0-d arrays, differentiable with respect to design and scenario; in a failed capture they are NaN.
    ``peak_force`` [N] of either flank, with ``peak_time`` [s], ``peak_flank`` (0 lower, 1 upper) and ``peak_impact``
    (index into ``impacts``, -1 if it is not listed there); ``peak_hinge_force``, ``peak_buffer_force``,
    ``peak_stop_force`` [N] (of the end stop, 0 without one); ``stroke`` [m]; ``stroke_margin`` [m]: stroke left before
    the buffer's end, of a bottomed run minus how much is missing; ``hinge_angle`` [rad]; ``penetration`` [m]: the depth
    at which the contact's spring alone exerts the peak force, which the deepest penetration does not exceed;
    ``end_time`` [s]; ``contact_time`` [s]; ``throat_distance`` [m] of the tip from the capture plane at the end;
    ``capture_margin`` [m]: how far beyond that plane the tip would be at ``duration``, coasting on from the end of the
    run, or ``stroke_margin`` if that is less (positive exactly for a captured run); ``impact_count``;
    ``first_impact``: its closed form; ``energy`` at the end;
    ``balance``: what numerical error did to conserved quantities; ``attempts``, ``accepted``: steps taken.
    """

    design: Design
    scenario: Scenario
    code: Int[Array, ""]
    peak_force: Float[Array, ""]
    peak_time: Float[Array, ""]
    peak_flank: Int[Array, ""]
    peak_impact: Int[Array, ""]
    peak_hinge_force: Float[Array, ""]
    peak_buffer_force: Float[Array, ""]
    peak_stop_force: Float[Array, ""]
    stroke: Float[Array, ""]
    stroke_margin: Float[Array, ""]
    hinge_angle: Float[Array, ""]
    penetration: Float[Array, ""]
    end_time: Float[Array, ""]
    contact_time: Float[Array, ""]
    throat_distance: Float[Array, ""]
    capture_margin: Float[Array, ""]
    impact_count: Int[Array, ""]
    impacts: Impacts
    first_impact: FirstImpact
    energy: Energy
    balance: Balance
    history: History | None
    attempts: Int[Array, ""]
    accepted: Int[Array, ""]
    stabilisation: Float[Array, ""]
    _located: Log  # `log` with derivatives at fixed times

    @property
    def outcome(self) -> Any:
        """`Outcome`; the integer code (an array) inside compiled code or for a batch."""
        if isinstance(self.code, jax.core.Tracer) or np.ndim(self.code):
            return self.code
        return Outcome(int(self.code))

    @property
    def log(self) -> Log:
        """Located events, differentiable as they move with design and scenario: see `integrate.moving`."""
        return moving(self._located, (self.design, self.scenario, self.stabilisation), CaptureMechanism)

    def __repr__(self) -> str:
        if isinstance(self.code, jax.core.Tracer) or np.ndim(self.code):
            return f"Capture(batch or traced, code={self.code})"
        from .report import summary

        return summary(self)


def simulate(
    design: Design,
    scenario: Scenario | None = None,
    duration: Scalar = DEFAULT_DURATION,
    *,
    solver: Solver | str | None = None,
    rtol: Scalar = DEFAULT_TOLERANCE,
    atol: Scalar | None = None,
    history: bool = False,
    max_steps: int = 200_000,
    max_events: int = 512,
    stabilisation: Scalar = 20.0,
) -> Capture:
    """Simulate one capture. Works under `jit`, `vmap`, `grad`, `jacfwd` and `jvp`.

    **Arguments:** ``design``, ``scenario`` (default: Table 2's); ``duration`` [s] after which a run counts as timeout;
    ``solver``: a name in `integrate.SOLVERS` or an `integrate.Solver`; ``rtol``, ``atol`` [-]: local error allowed in a
    step, of a component's size and of its natural scale (``atol`` defaults to ``rtol``); ``history``: keep time
    histories; ``max_steps``: limit whose passing is a failed outcome; ``max_events``: room for events in order, of
    later ones only the maxima, the end and the number of impacts are known; ``stabilisation`` [1/s]: Baumgarte's gain.

    **Returns:** a `Capture`. Not converging is an outcome, not an error.

    **Raises:** `InputError` for values out of range.
    """
    scenario = Scenario() if scenario is None else scenario
    check_fit(design, scenario)
    atol = rtol if atol is None else atol
    check_single("duration", duration, "s", ONE_CAPTURE, **LIMITS["duration"])
    check_single("rtol", rtol, "-", ONE_CAPTURE, **LIMITS["rtol"])
    check_single("atol", atol, "-", ONE_CAPTURE, **LIMITS["atol"])
    check_single("stabilisation", stabilisation, "1/s", ONE_CAPTURE, **LIMITS["stabilisation"])
    check_flag("history", history)
    check_whole("max_steps", max_steps, 1)
    check_whole("max_events", max_events, 1)
    options = _options(max_steps, max_events, HISTORY_STEPS if history else 0)
    if solver is not None:
        options = dataclasses.replace(options, solver=solver_named(solver))
    given = ((design, scenario, stabilisation), duration, (rtol, atol), options)
    leaves, traced = jax.tree.leaves(given), False
    if not all(type(leaf) is float for leaf in leaves):
        traced = any(isinstance(leaf, jax.core.Tracer) for leaf in leaves)
        given = jax.tree.map(_array, given)
        if any(map(np.ndim, jax.tree.leaves(given[0]))):
            _refuse_arrays(design, scenario)
    capture = _simulate(*given, UNCHECKED if traced else CHECKED)
    if history and not isinstance(capture.code, jax.core.Tracer):
        capture = eqx.tree_at(lambda c: c.history, capture, _trim(capture))
    return capture


@functools.cache
def _options(max_steps: int, max_events: int, keep: int) -> Options:
    """The default options with these limits; made once, since building modules takes a while."""
    return Options(max_steps=max_steps, max_events=max_events, keep=keep)


def _refuse_arrays(design: Design, scenario: Scenario) -> None:
    for path, leaf in jax.tree_util.tree_leaves_with_path((design, scenario)):
        if np.ndim(leaf):
            name = "".join(str(key) for key in path[1:]).lstrip(".")
            raise InputError(f"{name} has shape {np.shape(leaf)}; {ONE_CAPTURE}")


def _trim(capture: Capture) -> History:
    assert capture.history is not None
    return trimmed(capture.history, min(int(capture.accepted), HISTORY_STEPS))


def _array(value: Any) -> Any:
    """A number as an array; Python's numbers through NumPy, which is ten times quicker than through a device."""
    return jnp.asarray(value, float) if isinstance(value, jax.Array) else np.asarray(value, float)


def _event_time(mechanism: CaptureMechanism, start: Array, rtol: Array) -> Scalar:
    """How closely steps of a run from ``start`` land on events [s].

    A force that begins τ late with the 3/2 power of time gives an impact of duration T the fraction (τ/T)^{5/2} less
    impulse, which is held to a hundredth of the tolerance; one that begins with a jump τ/T.
    """
    duration = 15.0 * mechanism.impact_step(start)
    return duration * (rtol if mechanism.jumps else (0.01 * rtol) ** 0.4)


def _allowed(
    parameters: tuple[Design, Scenario, Array], duration: Array, tolerances: tuple[Array, Array]
) -> Bool[Array, ""]:
    """Whether all numbers are in range."""
    design, scenario, stabilisation = parameters
    options = {"duration": duration, "rtol": tolerances[0], "atol": tolerances[1], "stabilisation": stabilisation}
    return valid(design, scenario) & all_of(inside(x, **LIMITS[name]) for name, x in options.items())


@kept
def _simulate(
    parameters: tuple[Design, Scenario, Array],
    duration: Float[Array, ""],
    tolerances: tuple[Array, Array],
    options: Options,
    unchecked: Static = CHECKED,
) -> Capture:
    """A capture. Where its numbers are ``unchecked``, one out of range makes it fail."""
    rtol, mechanism = tolerances[0], CaptureMechanism(*parameters)
    start, active = mechanism.first_posture()
    event_time = jax.lax.stop_gradient(_event_time(mechanism, start.state, rtol))
    allowed = _allowed(parameters, duration, tolerances) if unchecked.value else None
    options = dataclasses.replace(options, tolerance=Tolerance(*tolerances), event_time=event_time, shortfall=rtol)
    result = solve_at_fixed_times(CaptureMechanism, parameters, duration, options, allowed)
    log = moving_end(mechanism, result.log, result.status < Status.TIMEOUT)
    seen = survey(mechanism, log)
    log = moving_events(log, seen)
    code = outcome_code(result.status)
    told = jnp.where(code < Outcome.failed_steps, 1.0, jnp.nan)  # a factor, so that derivatives are NaN as well
    top = maxima(mechanism, log)
    hits = impacts(mechanism, log, seen)
    energy, conserved = balance(mechanism, (start.state, active), log, seen.drift)
    last = jnp.maximum(log.count - 1, 0)
    throat_distance, beyond = throat(mechanism, log, duration)
    reserve = stroke_margin(mechanism, log, top.stroke, code == Outcome.bottomed)
    slots = hits.time.shape[0]
    earlier = (jnp.arange(slots) < hits.count) & (hits.time <= top.peak_time) & (hits.flank == top.peak_flank)
    listed = ~log.overflown | (top.peak_time <= log.time[log.room - 1])
    numbers = {
        "peak_force": top.peak_force,
        "peak_time": top.peak_time,
        "peak_hinge_force": top.hinge_force,
        "peak_buffer_force": top.buffer_force,
        "peak_stop_force": top.stop_force,
        "stroke": top.stroke,
        "stroke_margin": reserve,
        "hinge_angle": top.hinge_angle,
        "penetration": mechanism.pair.law.depth(top.peak_force),
        "end_time": log.time[last],
        "contact_time": contact_time(log),
        "throat_distance": throat_distance,
        "capture_margin": jnp.minimum(beyond, reserve),
    }
    return Capture(
        design=parameters[0],
        scenario=parameters[1],
        code=code,
        peak_flank=top.peak_flank,
        peak_impact=jnp.max(jnp.where(earlier & listed, jnp.arange(slots), -1)),
        impact_count=hits.count + jnp.sum(log.missed[:FLANKS]),
        impacts=hits,
        first_impact=predict(mechanism, start),
        energy=energy,
        balance=conserved,
        history=history(mechanism, result.steps) if options.keep else None,
        attempts=result.attempts,
        accepted=result.accepted,
        stabilisation=parameters[2],
        _located=result.log,
        **{name: value * told for name, value in numbers.items()},
    )
