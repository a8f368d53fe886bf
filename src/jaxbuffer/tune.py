"""Tuning a buffer: optax on the peak contact force over several scenarios, inside bounds."""

import dataclasses
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float

from .capture import DEFAULT_DURATION, DEFAULT_TOLERANCE, Capture, simulate
from .errors import InputError, check_number
from .mechanisms import Design, Scenario, get, replace, unit
from .outcome import Outcome
from .sensitivity import CHECK_TOLERANCE, Sensitivity, sensitivity

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


def tune(
    problem: Problem, *, iterations: int = 40, report: Callable[[Iteration], None] | None = None
) -> Tuned:
    """Lower the mean over scenarios of the peak contact force, each relative to its value at the start.

    Adam in the logarithms of the variables, projected on the bounds. The peak is a smooth maximum over the *local* peaks
    of all impacts, so that the gradient sees the runner-up before it takes over; the stroke limit is a quadratic
    penalty; a step after which a scenario is not captured is undone and halved. The best design that meets every
    condition is kept, and judged by its true peaks at tight tolerance.

    **Arguments:** ``iterations``: evaluations at most; ``report``: called after each.
    **Raises:** `InputError` if the start itself is not captured in every scenario.
    """
    paths = [v.path for v in problem.variables]
    low, high = (jnp.log(jnp.array([getattr(v, side) for v in problem.variables])) for side in ("low", "high"))
    x = jnp.log(jnp.array([float(get(problem.design, path)) for path in paths]))
    scenarios = jax.tree.map(lambda *leaves: jnp.array(leaves, float), *problem.scenarios)
    reference = jnp.ones(len(problem.scenarios))
    evaluate = eqx.Partial(_evaluate, problem.design, scenarios, tuple(paths), problem.duration, problem.rtol)
    start = evaluate(x, reference, problem.stroke_limit)[1]
    lost = [k for k, code in enumerate(np.asarray(start.code)) if code != Outcome.captured]
    if lost:
        how = Outcome(int(start.code[lost[0]])).reason
        raise InputError(f"scenarios[{lost[0]}]: the design to start from is not captured ({how}); start from one that is")
    reference = start.peak_force

    optimiser = optax.adam(LEARNING_RATE)
    state = optimiser.init(x)
    records: list[Iteration] = []
    best, best_value = x, np.inf
    good, scale, step_norm, message, converged = None, 1.0, 0.0, "stopped at the iteration limit", False
    for number in range(iterations):
        (objective, seen), gradient = evaluate(x, reference, problem.stroke_limit, True)
        captured = bool(np.all(np.asarray(seen.code) == Outcome.captured))
        peaks, strokes = np.asarray(seen.peak_force), np.asarray(seen.stroke)
        values = {path: float(value) for path, value in zip(paths, np.exp(np.asarray(x)), strict=True)}
        records.append(
            Iteration(number, float(objective), float(peaks.max()), tuple(peaks), tuple(strokes), captured, values, step_norm)
        )
        if report is not None:
            report(records[-1])
        usable = captured and bool(np.all(np.isfinite(np.asarray(gradient))))
        true_value = float(np.mean(peaks / np.asarray(reference)))
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


class _Seen(eqx.Module):
    """What one evaluation shows, an entry a scenario."""

    code: Array
    peak_force: Float[Array, " scenarios"]
    stroke: Float[Array, " scenarios"]


@eqx.filter_jit
def _evaluate(
    design: Design,
    scenarios: Scenario,
    paths: tuple[str, ...],
    duration: float,
    rtol: float,
    x: Float[Array, " variables"],
    reference: Float[Array, " scenarios"],
    stroke_limit: float,
    with_gradient: bool = False,
):
    def objective(x: list[Array]) -> tuple[Array, _Seen]:
        moved = replace(design, {path: jnp.exp(value) for path, value in zip(paths, x, strict=True)})

        def one(scenario: Scenario) -> tuple[_Seen, Array]:
            capture = simulate(moved, scenario, duration, rtol=rtol)
            return _Seen(capture.code, capture.peak_force, capture.stroke), capture.impacts.peak_force

        seen, local = jax.vmap(one)(scenarios)
        smooth = jax.nn.logsumexp(SHARPNESS * local / reference[:, None], axis=1) / SHARPNESS
        excess = jnp.maximum(seen.stroke / stroke_limit - 1.0, 0.0)
        return jnp.mean(smooth) + STROKE_WEIGHT * jnp.sum(excess**2), seen

    variables = [x[k] for k in range(len(paths))]
    if not with_gradient:
        return objective(variables)
    value, gradient = jax.value_and_grad(objective, has_aux=True)(variables)
    return value, jnp.stack(gradient)
