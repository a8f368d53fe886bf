"""Tuning a buffer: optax on the peak contact force over several scenarios, inside bounds."""

import dataclasses
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float

from .capture import DEFAULT_DURATION, DEFAULT_TOLERANCE, Capture, simulate
from .errors import InputError, check_number
from .mechanisms import Design, Scenario, get, replace, unit
from .outcome import Outcome
from .sensitivity import CHECK_TOLERANCE, QUANTITIES, Sensitivity, linearised, sensitivity

SHARPNESS = 40.0  # of the smooth maximum over local peaks, relative to the start's highest
STROKE_WEIGHT = 50.0
LEARNING_RATE = 0.15  # in ln of a variable
SETTLED = 1e-3  # largest change of any ln variable in an iteration that counts as converged


@dataclasses.dataclass(frozen=True)
class Variable:
    """A number in the design to tune: its dotted path and bounds, in its own unit."""

    path: str
    low: float
    high: float


@dataclasses.dataclass(frozen=True)
class Problem:
    """What to tune and for what.

    **Arguments:** ``design`` to start from; ``scenarios`` to serve; ``variables``; ``stroke_limit`` [m] in every
    scenario; ``duration`` [s], ``rtol`` [-] as for `simulate`.
    """

    design: Design
    scenarios: tuple[Scenario, ...]
    variables: tuple[Variable, ...]
    stroke_limit: float
    duration: float = DEFAULT_DURATION
    rtol: float = DEFAULT_TOLERANCE

    def __post_init__(self) -> None:
        if not self.scenarios:
            raise InputError("scenarios is empty; tuning needs at least one")
        if not self.variables:
            raise InputError("variables is empty; tuning needs at least one")
        check_number("stroke_limit", self.stroke_limit, "m", low=0.0, low_open=True)
        for variable in self.variables:
            value, name = get(self.design, variable.path), unit(self.design, variable.path)
            if value is None or isinstance(value, (str, bool)):
                raise InputError(f"{variable.path} = {value!r} is not a number that can be tuned")
            check_number(f"{variable.path} lower bound", variable.low, name, low=0.0, low_open=True)
            check_number(f"{variable.path} upper bound", variable.high, name, low=variable.low, low_open=True)
            check_number(variable.path, value, name, low=variable.low, high=variable.high)


@dataclasses.dataclass(frozen=True)
class Iteration:
    """One evaluation: the ``objective`` [-], each scenario's peak force [N] and stroke [m], whether all were captured,
    the variables' ``values``, and the largest change of any ln variable since the last accepted one."""

    number: int
    objective: float
    worst_peak: float
    peaks: tuple[float, ...]
    strokes: tuple[float, ...]
    captured: bool
    values: dict[str, float]
    step_norm: float


@dataclasses.dataclass(frozen=True)
class Tuned:
    """A finished tuning. ``before`` and ``after`` are re-evaluated at tight tolerance, with histories, a capture a
    scenario; ``verification``: the tuned design's gradient in its worst scenario, against differences."""

    problem: Problem
    design: Design
    iterations: list[Iteration]
    before: tuple[Capture, ...]
    after: tuple[Capture, ...]
    verification: Sensitivity
    converged: bool
    message: str

    def __repr__(self) -> str:
        from .report import tuned_table

        return tuned_table(self)


def tune(problem: Problem, *, iterations: int = 40, report: Callable[[Iteration], None] | None = None) -> Tuned:
    """Lower the mean over scenarios of the peak contact force, each relative to its value at the start.

    Adam in the logarithms of the variables, projected on the bounds. The peak is a smooth maximum over the *local*
    peaks of all impacts, so that the gradient sees the runner-up before it takes over; the stroke limit is a quadratic
    penalty; a step after which a scenario is not captured is undone and halved. The best design that meets every
    condition is kept, and judged by its true peaks at tight tolerance.

    **Arguments:** ``iterations``: evaluations at most; ``report``: called after each.
    **Raises:** `InputError` if the start itself is not captured in every scenario.
    """
    paths = tuple(v.path for v in problem.variables)
    low, high = (jnp.log(jnp.array([getattr(v, side) for v in problem.variables])) for side in ("low", "high"))
    x = jnp.log(jnp.array([float(get(problem.design, path)) for path in paths]))
    start = [simulate(problem.design, s, problem.duration, rtol=problem.rtol) for s in problem.scenarios]
    for k, capture in enumerate(start):
        if capture.outcome != Outcome.captured:
            raise InputError(
                f"scenario {k + 1}: the start is not captured ({capture.outcome.reason}); start from a design that is"
            )
    reference = np.array([float(capture.peak_force) for capture in start])

    optimiser = optax.adam(LEARNING_RATE)
    state = optimiser.init(x)
    records: list[Iteration] = []
    best, best_value = x, np.inf
    good, scale, step_norm, message, converged = None, 1.0, 0.0, "stopped at the iteration limit", False
    for number in range(iterations):
        objective, gradient, captures = _evaluate(problem, paths, x, reference)
        captured = all(c.outcome == Outcome.captured for c in captures)
        peaks = np.array([float(c.peak_force) for c in captures])
        strokes = np.array([float(c.stroke) for c in captures])
        values = {path: float(value) for path, value in zip(paths, np.exp(np.asarray(x)), strict=True)}
        records.append(
            Iteration(number, objective, float(peaks.max()), tuple(peaks), tuple(strokes), captured, values, step_norm)
        )
        if report is not None:
            report(records[-1])
        usable = captured and bool(np.all(np.isfinite(np.asarray(gradient))))
        true_value = float(np.mean(peaks / reference))
        if usable:
            good = (x, state, gradient)
            if np.all(strokes <= problem.stroke_limit) and true_value < best_value:
                best, best_value = x, true_value
        elif good is None:
            message = "the gradient at the start is not finite; nothing was tuned"
            break
        else:
            x, state, gradient = good
            scale *= 0.5
        decay = 0.5 * (1.0 + np.cos(np.pi * number / iterations))
        updates, state = optimiser.update(gradient, state)
        moved = optax.projections.projection_box(x + scale * decay * updates, low, high)
        step_norm = float(jnp.max(jnp.abs(moved - x)))
        x = moved
        if step_norm < SETTLED and usable and number > 0:
            converged, message = True, f"converged: no variable moves by more than {SETTLED:.0e} in its logarithm"
            break
    design = replace(problem.design, {p: float(v) for p, v in zip(paths, np.exp(np.asarray(best)), strict=True)})
    if not np.isfinite(best_value):
        message = "no design met the stroke limit in every scenario; the start is returned"

    def tight(which: Design) -> tuple[Capture, ...]:
        return tuple(
            simulate(which, s, problem.duration, rtol=CHECK_TOLERANCE, history=True) for s in problem.scenarios
        )

    before, after = tight(problem.design), tight(design)
    worst = int(np.argmax([float(c.peak_force) for c in after]))
    check = sensitivity(design, problem.scenarios[worst], paths, problem.duration, rtol=problem.rtol)
    return Tuned(problem, design, records, before, after, check, converged, message)


def _evaluate(
    problem: Problem, paths: tuple[str, ...], x: Float[Array, " variables"], reference: np.ndarray
) -> tuple[float, Float[Array, " variables"], list[Capture]]:
    """Objective, its gradient in ln variables, and the captures."""
    values = np.exp(np.asarray(x))
    objective, gradient, captures = 0.0, np.zeros(len(paths)), []
    for scenario, scale in zip(problem.scenarios, reference, strict=True):
        linear = linearised(problem.design, scenario, paths, values, problem.duration, rtol=problem.rtol)
        value, (by_peak, by_stroke) = _CONTRIBUTION(
            (linear.capture.impacts.peak_force, linear.capture.stroke), scale, problem.stroke_limit
        )
        stroke_gradient = linear.gradients[QUANTITIES.index("stroke")]
        slope = np.asarray(by_peak @ linear.impact_gradients + by_stroke * stroke_gradient)
        objective += float(value) / len(reference)
        gradient += slope * values / len(reference)
        captures.append(linear.capture)
    return objective, jnp.asarray(gradient), captures


def _contribution(
    seen: tuple[Float[Array, " slots"], Float[Array, ""]], scale: float, stroke_limit: float
) -> Float[Array, ""]:
    """One scenario's share of the objective: smooth maximum of its local peaks, and the stroke's penalty."""
    peaks, stroke = seen
    smooth = jax.nn.logsumexp(SHARPNESS * peaks / scale) / SHARPNESS
    return smooth + STROKE_WEIGHT * jnp.maximum(stroke / stroke_limit - 1.0, 0.0) ** 2


_CONTRIBUTION = jax.jit(jax.value_and_grad(_contribution))
