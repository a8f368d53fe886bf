"""`simulate`: one capture, from a design and a scenario to everything one wants to know of it."""

import dataclasses
import functools
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ._types import Scalar
from .errors import InputError, check_number
from .first_impact import FirstImpact, predict
from .history import History, history, trimmed
from .integrate import Log, Options, Solver, Status, Tolerance, solve
from .ledger import Balance, Energy, balance
from .mechanisms import CaptureMechanism, Design, Scenario, check_fit
from .mechanisms.design import POSITIVE
from .metrics import Impacts, contact_time, impacts, maxima, moving_end, moving_events, survey, throat
from .outcome import Outcome, outcome_code
from .programs import kept

DEFAULT_TOLERANCE = 1e-6
DEFAULT_DURATION = 8.0  # s
HISTORY_STEPS = 20_000


class Capture(eqx.Module):
    """A simulated capture. Print it for a summary.

    Numbers are 0-d arrays, differentiable with respect to design and scenario; in a failed capture they are NaN.
    ``peak_force`` [N] of either flank, with ``peak_time`` [s], ``peak_flank`` (0 lower, 1 upper) and ``peak_impact``
    (index into ``impacts``); ``peak_hinge_force``, ``peak_buffer_force`` [N]; ``stroke`` [m]; ``hinge_angle`` [rad];
    ``end_time`` [s]; ``contact_time`` [s]; ``throat_distance`` [m] of the tip from the capture plane at the end;
    ``capture_margin`` [m]: how far beyond that plane it would be at ``duration``, coasting on from the end of the run
    (positive for a captured one); ``impact_count``; ``first_impact``: its closed form; ``energy`` at the end;
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
    stroke: Float[Array, ""]
    hinge_angle: Float[Array, ""]
    end_time: Float[Array, ""]
    contact_time: Float[Array, ""]
    throat_distance: Float[Array, ""]
    capture_margin: Float[Array, ""]
    impact_count: Int[Array, ""]
    impacts: Impacts
    first_impact: FirstImpact
    energy: Energy
    balance: Balance
    log: Log
    history: History | None
    attempts: Int[Array, ""]
    accepted: Int[Array, ""]

    @property
    def outcome(self) -> Any:
        """`Outcome`; the integer code (an array) inside compiled code or for a batch."""
        if isinstance(self.code, jax.core.Tracer) or np.ndim(self.code):
            return self.code
        return Outcome(int(self.code))

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
    solver: Solver | None = None,
    rtol: Scalar = DEFAULT_TOLERANCE,
    atol: Scalar | None = None,
    history: bool = False,
    max_steps: int = 200_000,
    max_events: int = 512,
    stabilisation: Scalar = 20.0,
) -> Capture:
    """Simulate one capture. Works under `jit`, `vmap`, `grad`, `jacfwd` and `jvp`.

    **Arguments:** ``design``, ``scenario`` (default: Table 2's); ``duration`` [s] after which a run counts as timeout;
    ``solver``: an `integrate.Solver`; ``rtol``, ``atol`` [-]: local error allowed in a step, of a component's size and
    of its natural scale (``atol`` defaults to ``rtol``); ``history``: keep time histories; ``max_steps``,
    ``max_events``: limits whose passing is a failed outcome; ``stabilisation`` [1/s]: Baumgarte's gain.

    **Returns:** a `Capture`. Not converging is an outcome, not an error.

    **Raises:** `InputError` for values out of range.
    """
    scenario = Scenario() if scenario is None else scenario
    check_fit(design, scenario)
    check_number("duration", duration, "s", **POSITIVE)
    check_number("rtol", rtol, "-", low=1e-13, high=1e-2)
    atol = rtol if atol is None else atol
    check_number("atol", atol, "-", low=1e-13, high=1e-2)
    check_number("stabilisation", stabilisation, "1/s", low=0.0)
    options = _options(max_steps, max_events, HISTORY_STEPS if history else 0)
    if solver is not None:
        options = dataclasses.replace(options, solver=solver)
    given = ((design, scenario, stabilisation), duration, (rtol, atol), options)
    if not all(type(leaf) is float for leaf in jax.tree.leaves(given)):
        given = jax.tree.map(_array, given)
        if any(map(np.ndim, jax.tree.leaves(given[0]))):
            _refuse_arrays(design, scenario)
    capture = _simulate(*given)
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
            raise InputError(f"{name} has shape {np.shape(leaf)}; simulate takes one capture: use jax.vmap or jb.sweep")


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


@kept
def _simulate(
    parameters: tuple[Design, Scenario, Array],
    duration: Float[Array, ""],
    tolerances: tuple[Array, Array],
    options: Options,
) -> Capture:
    rtol, mechanism = tolerances[0], CaptureMechanism(*parameters)
    start, active = mechanism.first_posture()
    event_time = _event_time(mechanism, start.state, rtol)
    options = dataclasses.replace(options, tolerance=Tolerance(*tolerances), event_time=event_time, shortfall=rtol)
    result = solve(CaptureMechanism, parameters, duration, options)
    log = moving_end(mechanism, result.log, result.status < Status.TIMEOUT)
    seen = survey(mechanism, log)
    log = moving_events(log, seen)
    code = outcome_code(result.status)
    ok = code < Outcome.failed_steps
    top = maxima(mechanism, log)
    hits = impacts(mechanism, log, seen)
    energy, conserved = balance(mechanism, (start.state, active), log, seen.drift)
    last = jnp.maximum(log.count - 1, 0)
    throat_distance, margin = throat(mechanism, log, duration)
    slots = hits.time.shape[0]
    earlier = (jnp.arange(slots) < hits.count) & (hits.time <= top.peak_time) & (hits.flank == top.peak_flank)
    numbers = {
        "peak_force": top.peak_force,
        "peak_time": top.peak_time,
        "peak_hinge_force": top.hinge_force,
        "peak_buffer_force": top.buffer_force,
        "stroke": top.stroke,
        "hinge_angle": top.hinge_angle,
        "end_time": log.time[last],
        "contact_time": contact_time(log),
        "throat_distance": throat_distance,
        "capture_margin": margin,
    }
    return Capture(
        design=parameters[0],
        scenario=parameters[1],
        code=code,
        peak_flank=top.peak_flank,
        peak_impact=jnp.max(jnp.where(earlier, jnp.arange(slots), -1)),
        impact_count=hits.count,
        impacts=hits,
        first_impact=predict(mechanism, start),
        energy=energy,
        balance=conserved,
        log=log,
        history=history(mechanism, result.steps) if options.keep else None,
        attempts=result.attempts,
        accepted=result.accepted,
        **{name: jnp.where(ok, value, jnp.nan) for name, value in numbers.items()},
    )
