"""Steps of several runs side by side: whatever method each has chosen, all evaluate their fields at once.

`rungekutta.stages` iterates an implicit stage until it has converged, which takes as long as it takes. Here each method
has a fixed schedule of equally many evaluations, so that no lane of a vector register waits for another.
"""

from collections.abc import Sequence
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import lax
from jaxtyping import Array, Bool, Float, Int

from jaxbuffer.hybrid.rungekutta.newton import NewtonMatrix
from jaxbuffer.hybrid.rungekutta.solvers import Automatic
from jaxbuffer.hybrid.rungekutta.stages import CONVERGED, Field, SecondDerivative, Step, put
from jaxbuffer.hybrid.rungekutta.tableaus import Method
from jaxbuffer.hybrid.rungekutta.time_transform import TimeTransform
from jaxbuffer.hybrid.sensitivity.augmented_state import Columns
from jaxbuffer.hybrid.system import Linearisation

from .transform import anywhere

ITERATIONS = (3, 2, 2, 2, 2)  # of Newton's method in each implicit stage: as many evaluations as DOP853 makes


class Schedule(NamedTuple):
    """What a method does at each of its evaluations of the field.

    Each evaluation has a gain, its slope times the step; number 0 is that at the step's start. ``weights`` of the gains
    in the argument of each evaluation; ``nodes``: its time as a fraction of the step; ``iterates``: whether it is one
    of Newton's iterations, ``begins`` and ``ends``: the first or last one of a stage; ``errors``: weights of the gains
    in both error estimates.
    """

    weights: Float[np.ndarray, "evaluations gains"]
    nodes: Float[np.ndarray, " evaluations"]
    iterates: Bool[np.ndarray, " evaluations"]
    begins: Bool[np.ndarray, " evaluations"]
    ends: Bool[np.ndarray, " evaluations"]
    errors: Float[np.ndarray, "2 gains"]

    @staticmethod
    def of(method: Method, iterations: Sequence[int]) -> "Schedule":
        """A method with so many evaluations in each stage between its first and its last."""
        stages = [0, *(stage for stage, count in enumerate(iterations, 1) for _ in range(count)), method.stages - 1]
        final = [max(k for k, at in enumerate(stages) if at == stage) for stage in range(method.stages)]
        weights, errors = np.zeros((len(stages), len(stages))), np.zeros((2, len(stages)))
        for k, stage in enumerate(stages):
            weights[k, final[:stage]] = method.weights[stage, :stage]
        errors[:, final] = method.errors
        inner = np.array(stages[1:]) < method.stages - 1
        begins = np.diff(stages) > 0
        return Schedule(
            weights[1:],
            np.asarray(method.nodes)[stages[1:]],
            inner & bool(method.gamma),
            begins,
            np.append(begins[1:], True),
            errors,
        )


class _State(NamedTuple):
    """What the loop over evaluations carries.

    ``evaluation`` to make; ``known``: the start plus the weighted sum of the earlier gains; ``increment``: what an
    implicit stage adds to that; ``weights`` of the gains in the next one's ``known``; ``gains`` so far;
    ``first_change``: the size of the first change in the present stage; ``unconverged``: what Newton's method leaves
    open, over what is allowed; ``rate`` at the step's end; ``wanted``: whether its derivative is; ``count`` of
    evaluations.
    """

    evaluation: Int[Array, ""]
    known: Columns
    increment: Columns
    weights: Float[Array, " gains"]
    gains: Float[Array, "gains state columns"]
    first_change: Float[Array, ""]
    unconverged: Float[Array, ""]
    rate: Columns
    wanted: Bool[Array, ""]
    count: Int[Array, ""]


class SideBySide(Automatic):
    """`Automatic` for runs that are stepped side by side."""

    def step(
        self,
        which: Int[Array, ""],
        field: Field,
        stiff: Linearisation,
        time: Float[Array, ""],
        columns: Columns,
        rate: Columns,
        transform: TimeTransform,
        allowance: Columns,
        second: SecondDerivative | None = None,
    ) -> Step:
        assert second is not None
        explicit, implicit = self.methods
        schedules = Schedule.of(explicit, [1] * (explicit.stages - 2)), Schedule.of(implicit, ITERATIONS)
        is_implicit = self.is_implicit(which)
        gamma, end = implicit.gamma, len(schedules[0].nodes) - 1
        newton = NewtonMatrix.of(stiff, jnp.where(is_implicit, gamma * transform.length, 0.0))

        def of_method(name: str, k: Array) -> Array:
            a, b = (jnp.asarray(getattr(schedule, name))[k] for schedule in schedules)
            return jnp.where(is_implicit, b, a)

        def iterate(s: _State) -> _State:
            k, now, following = s.evaluation, jnp.minimum(s.evaluation, end), jnp.minimum(s.evaluation + 1, end)
            node, iterates = of_method("nodes", now), of_method("iterates", now)
            beside = jnp.where(k > end, second.spacing * (1 + 2 * (end + 1 - k)), 0.0)
            slope = field(time + transform.elapsed(node) + beside, s.known + s.increment)
            change = jnp.where(iterates, newton.solve(newton.shift * slope - s.increment), 0.0)
            gain = jnp.where(k < end, transform.derivative(node), 1.0) * slope
            gain = jnp.where(iterates, (s.increment + change) * (1.0 / gamma), gain)
            gains = put(s.gains, gain, k + 1, 0)
            size = jnp.sqrt(jnp.max(jnp.mean((change / allowance) ** 2, axis=0)))
            first_change = jnp.where(of_method("begins", now), size, s.first_change)
            left = jnp.where(of_method("ends", now), _left(size, first_change), 0.0)
            guess = jnp.where(of_method("begins", following), gamma * gain, s.increment + change)
            increment = jnp.where(of_method("iterates", following), guess, 0.0)
            wanted = jnp.where(k == end, second.wanted(s.known[:, 0], slope[:, 0]), s.wanted)
            return _State(
                evaluation=k + 1,
                known=jnp.where(k < end, columns + _weighted(s.weights, gains), s.known),
                increment=jnp.where(k < end, increment, jnp.where(k == end, second.spacing * slope, -s.increment)),
                weights=of_method("weights", jnp.minimum(k + 2, end)),
                gains=gains,
                first_change=first_change,
                unconverged=jnp.maximum(s.unconverged, jnp.where(left > CONVERGED, left / CONVERGED, 0.0)),
                rate=jnp.where(k == end, slope, s.rate),
                wanted=wanted,
                count=jnp.where(anywhere(wanted), end + 3, s.count),
            )

        first, zero, none = transform.start * rate, jnp.zeros(()), jnp.zeros_like(columns)
        s = _State(
            evaluation=jnp.asarray(0),
            known=columns + of_method("weights", jnp.asarray(0))[0] * first,
            increment=jnp.where(is_implicit, gamma * first, 0.0),
            weights=of_method("weights", jnp.asarray(1)),
            gains=put(jnp.zeros((end + 4, *columns.shape)), first, 0, 0),
            first_change=zero,
            unconverged=zero,
            rate=none,
            wanted=jnp.asarray(False),
            count=jnp.asarray(end + 1),
        )
        s = lax.while_loop(lambda s: s.evaluation < s.count, iterate, s)
        last = transform.derivative(1.0)  # type: ignore[arg-type]
        fine, coarse = (_weighted(of_method("errors", jnp.asarray(k)), s.gains, last) for k in range(2))
        error = fine**2 / jnp.sqrt(fine**2 + 0.01 * coarse**2 + 1e-300) + s.unconverged * allowance
        return Step(
            end=s.known,
            rate=s.rate,
            error=error * jnp.where(is_implicit, self.safety_factor, 1.0),
            order=jnp.where(is_implicit, implicit.order, explicit.order),
            second=jnp.where(s.wanted, (s.gains[end + 2] - s.gains[end + 3]) / (2.0 * second.spacing), 0.0),
        )


def _left(size: Array, first: Array) -> Float[Array, ""]:
    """What Newton's method leaves open in a stage, given the sizes of its last and its ``first`` change: it converges
    by one ratio."""
    ratio = size / jnp.maximum(first, 1e-300)
    return size * ratio / jnp.maximum(1.0 - ratio, 1e-3)


def _weighted(weights: Array, gains: Array, last: Array | float = 1.0) -> Columns:
    """The sum of the gains by their weights; the last one is a slope, to be multiplied by ``last`` first."""
    count = len(weights)
    total = weights[0] * gains[0]
    for k in range(1, count):
        total = total + (weights[k] * last if k == count - 1 else weights[k]) * gains[k]
    return total
