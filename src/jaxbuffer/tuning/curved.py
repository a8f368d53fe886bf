"""A stage's model with smooth maxima and curvature, minimised by optax: no captures are spent here.

Peaks and cases are first-order in the step; the maxima over them are smoothed by a width that the caller lets go to
zero; constraints enter by an augmented Lagrangian; B is the Lagrangian's curvature as learnt so far. Adam with a
projection on the box after each update.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float

from ..programs import kept
from .goal import Goal, Tangent

UPDATES = 250  # of Adam in a round
ROUNDS = 3  # of the augmented Lagrangian
STIFFNESS = 20.0  # its penalty parameter, for an objective of about one and rows relative to their limits
SMALLEST_SHARE = 1e-12  # of a case before levelling, which scales shares up but none from zero
LEVELLING = 6  # passes that bring case weights below their cap


class Setup(NamedTuple):
    """A goal as numbers: ``weights`` of the objective over its scale, ``cap`` of a case's weight, ``limits`` (infinite:
    none), the ceiling's weights over its value and its cap, which rows count, and the peaks' scale [N]."""

    weights: Any
    cap: Any
    limits: Any
    ceiling: Any
    ceiling_cap: Any
    captured: Any
    room: Any
    peak_scale: Any

    @staticmethod
    def of(goal: Goal, scale: float, peak_scale: float, room: float) -> "Setup":
        """From a stage's goal; ``scale`` of the objective and ``peak_scale`` of contact forces [N]."""
        weights, ceiling, cases = goal.objective.vector() / scale, goal.ceiling, len(goal.problem.cases)
        limits = np.full(len(weights), np.inf)
        for quantity, limit in goal.limited():
            limits[quantity] = limit
        return Setup(
            weights,
            goal.objective.cap(cases),
            limits,
            ceiling.objective.vector() / ceiling.value if ceiling else np.zeros_like(weights),
            ceiling.objective.cap(cases) if ceiling else 1.0,
            float(goal.problem.limits.captured),
            room,
            peak_scale,
        )


class Pull(NamedTuple):
    """Weights of every quantity in the Lagrangian's slope at the model's minimum."""

    peaks: Float[np.ndarray, "cases peaks"]
    rest: Float[np.ndarray, "cases rest"]
    margin: Float[np.ndarray, " cases"]

    def slope(self, tangent: Tangent) -> Float[np.ndarray, " variables"]:
        """The Lagrangian's slope at another design with these weights."""
        return (
            np.einsum("ck,ckn->n", self.peaks, tangent.peaks_slope)
            + np.einsum("cq,cqn->n", self.rest, tangent.rest_slope)
            + self.margin @ tangent.margin_slope
        )


def curved_step(
    setup: Setup, tangent: Tangent, curvature: np.ndarray, start: np.ndarray, box: np.ndarray, width: float
) -> tuple[np.ndarray, Pull]:
    """Minimise the model from ``start`` over steps in ``box`` (low and high, a row each); ``width`` [-] of the smooth
    maxima, relative to the objective's and the peaks' scale."""
    numbers = jax.tree.map(lambda x: np.asarray(x, float), (setup, tangent, curvature, start, box, width))
    step, pull = _minimised(*numbers)
    return np.asarray(step), Pull(*map(np.asarray, pull))


@kept
def _minimised(
    setup: Setup, tangent: Tangent, curvature: Array, start: Array, box: Array, width: Array
) -> tuple[Array, tuple[Array, Array, Array]]:
    def moved(step: Array) -> tuple[Array, Array, Array]:
        return (
            tangent.peaks + tangent.peaks_slope @ step,
            tangent.rest + tangent.rest_slope @ step,
            tangent.margin + tangent.margin_slope @ step,
        )

    def model(step: Array, multipliers: tuple[Array, ...]) -> Array:
        return _lagrangian(setup, *moved(step), multipliers, width) + 0.5 * step @ curvature @ step

    rate = 0.2 * jnp.max(box[1] - box[0])
    adam = optax.adam(optax.cosine_decay_schedule(rate, UPDATES), b2=0.99)

    def update(carry: tuple, _: None) -> tuple[tuple, None]:
        step, state, multipliers = carry
        change, state = adam.update(jax.grad(model)(step, multipliers), state)
        return (optax.projections.projection_box(step + change, box[0], box[1]), state, multipliers), None

    def round_(carry: tuple, _: None) -> tuple[tuple, None]:
        step, multipliers = carry
        (step, _, _), _ = jax.lax.scan(update, (step, adam.init(step), multipliers), length=UPDATES)
        rows = _rows(setup, *moved(step), width)
        raised = [jnp.maximum(0.0, m + STIFFNESS * row) for m, row in zip(multipliers, rows, strict=True)]
        return (step, tuple(raised)), None

    none = tuple(jnp.zeros_like(row) for row in _rows(setup, *moved(start), width))
    (step, multipliers), _ = jax.lax.scan(round_, (start, none), length=ROUNDS)
    pull = jax.grad(lambda p, r, m: _lagrangian(setup, p, r, m, multipliers, width), argnums=(0, 1, 2))(*moved(step))
    return step, pull


def _lagrangian(
    setup: Setup, peaks: Array, rest: Array, margin: Array, multipliers: tuple[Array, ...], width: Array
) -> Array:
    """Objective over its scale, plus Σ (max(0, μ + ρ g)² - μ²) / 2ρ (Nocedal and Wright, eq. 17.65)."""
    value = _aggregate(setup.weights, setup.cap, _quantities(setup, peaks, rest, width), width)
    for row, multiplier in zip(_rows(setup, peaks, rest, margin, width), multipliers, strict=True):
        above = jnp.maximum(0.0, multiplier + STIFFNESS * row)
        value += jnp.sum(above**2 - multiplier**2) / (2.0 * STIFFNESS)
    return value


def _quantities(setup: Setup, peaks: Array, rest: Array, width: Array) -> Array:
    """`QUANTITIES` with the smooth maximum over the impacts for the peak force."""
    blur = width * setup.peak_scale
    peak = blur * jax.nn.logsumexp(peaks / blur, axis=1)
    return jnp.concatenate([peak[:, None], rest], axis=1)


def _rows(setup: Setup, peaks: Array, rest: Array, margin: Array, width: Array) -> tuple[Array, ...]:
    quantities = _quantities(setup, peaks, rest, width)
    limited = quantities / setup.limits[None] - 1.0
    ceiling = _aggregate(setup.ceiling, setup.ceiling_cap, quantities, width) - 1.0
    return limited + setup.room, setup.captured * (setup.room - margin), ceiling + setup.room


def _aggregate(weights: Array, cap: Array, quantities: Array, width: Array) -> Array:
    """Max w·f over case weights up to ``cap``: weights of a softmax, levelled, and held while differentiating."""
    values = jnp.sum(quantities * weights[None], axis=1)
    share = jax.nn.softmax(jax.lax.stop_gradient(values) / width) + SMALLEST_SHARE
    for _ in range(LEVELLING):
        kept = jnp.minimum(share, cap)
        free = jnp.where(share < cap, share, 0.0)
        share = kept + free * (1.0 - jnp.sum(kept)) / jnp.maximum(jnp.sum(free), 1e-300)
    return jnp.sum(share * values)
