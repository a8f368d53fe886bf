"""Guards: the functions of the state whose zeros are events.

There is one for each contact (its gap), one for each way in which the run may end, and one for each observable (minus
its rate: zero where the observable is largest), numbered in this order. Signed guards go from negative to positive at
their event.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from ..system import HybridSystem

NEAR_LARGEST = 0.2  # of its extent: so near its largest value an observable of the state's rate is followed closely
RISING = 1e-300  # the rate of an observable whose rate is not known: it counts as rising, not as having a maximum


class Guards(NamedTuple):
    """What is watched of a state, with time derivatives.

    ``gap`` of each contact [m], ``gap_rate`` [m/s], ``gap_acceleration`` [m/s²]; ``terminal``: guards of the run's
    end, and their rates; ``value`` of each observable, and its rate; ``reversals``, ``invariant`` and how
    much of it may be rounding: see `HybridSystem`.
    """

    gap: Float[Array, " contacts"]
    gap_rate: Float[Array, " contacts"]
    gap_acceleration: Float[Array, " contacts"]
    terminal: Float[Array, " terminals"]
    terminal_rate: Float[Array, " terminals"]
    value: Float[Array, " observables"]
    value_rate: Float[Array, " observables"]
    reversals: Float[Array, "reversing axes"]
    invariant: Float[Array, ""]
    invariant_rounding: Float[Array, ""]

    def falling(self, located: Bool[Array, " observables"]) -> "Guards":
        """Set the rates of observables whose maximum has just been ``located`` here to zero: the step that ends on a
        maximum leaves a rate of either sign, and a small positive one would let the same maximum be found again."""
        return self._replace(value_rate=jnp.where(located, 0.0, self.value_rate))


class Extremes(NamedTuple):
    """The ``largest`` and the ``smallest`` value of each observable so far.

    What is near the largest value is measured by the ``extent``: the range between them, as an observable's zero is
    arbitrary, or the size of the largest one where that is less, as of a depth, which far from contact is minus a gap.
    """

    largest: Float[Array, " observables"]
    smallest: Float[Array, " observables"]

    @staticmethod
    def none(observables: int) -> "Extremes":
        """Return the extremes of no value at all."""
        return Extremes(jnp.full(observables, -jnp.inf), jnp.full(observables, jnp.inf))

    @property
    def extent(self) -> Float[Array, " observables"]:
        """Return the size that differences of an observable are compared with; zero before the first value."""
        return jnp.maximum(jnp.minimum(self.largest - self.smallest, jnp.abs(self.largest)), 0.0)

    def below_largest(self, share: float) -> Float[Array, " observables"]:
        """Return the values that lie a ``share`` of the extent below the largest ones; -∞ before the first value."""
        return self.largest - share * self.extent

    def including(self, value: Float[Array, " observables"]) -> "Extremes":
        """Return the extremes with one more value of each observable."""
        return Extremes(jnp.maximum(self.largest, value), jnp.minimum(self.smallest, value))


class SignedGuards(NamedTuple):
    """All guards, negative before their event, with their first and second time derivatives as far as they are known:
    zero are both of an observable's guard, and the second one of the run's end."""

    value: Float[Array, " guards"]
    rate: Float[Array, " guards"]
    acceleration: Float[Array, " guards"]


def signed(guards: Guards, active: Float[Array, " contacts"]) -> SignedGuards:
    """Return the guards of contacts, of the run's end and of maxima with their signs: an open contact closes where its
    gap falls through zero, a closed one (``active``) opens where it rises through zero."""
    # One guard serves both events of a contact: its sign says which one can come next.
    sign, none = jnp.where(active > 0.5, 1.0, -1.0), jnp.zeros_like(guards.value_rate)
    value = jnp.concatenate([sign * guards.gap, guards.terminal, -guards.value_rate])
    rate = jnp.concatenate([sign * guards.gap_rate, guards.terminal_rate, none])
    acceleration = jnp.concatenate([sign * guards.gap_acceleration, jnp.zeros_like(guards.terminal), none])
    return SignedGuards(value, rate, acceleration)


def near_largest(
    system: HybridSystem, state: Array, rate: Array, active: Array, before: Array, extremes: Extremes
) -> Bool[Array, ""]:
    """Return whether an observable of the state's rate is near its largest value so far at a step's end or was at its
    start (its values there: ``before``), or may be so at any time. Its own rate takes the state's second derivative,
    which costs two right-hand sides."""
    if system.has_impulsive_reactions:
        return jnp.asarray(True)
    value, near = system.observables(state, rate, active), extremes.below_largest(NEAR_LARGEST)
    # One by one, so that the other observables are not evaluated. A step may lead from the top far down, as where
    # friction reverses: its end is then not near the largest value, and its start is.
    of_rate = [k for k, depends in enumerate(system.rate_observables()) if depends]
    return jnp.any(jnp.stack([jnp.maximum(value[k], before[k]) > near[k] for k in of_rate]))


def observe(system: HybridSystem, state: Array, rate: Array, second: Array, active: Array) -> Guards:
    """Return guards and observables with their rates, from the state and its first and ``second`` derivative.
    Observables of the state's rate count as rising where the second derivative is not known (zeros: see
    `near_largest`)."""
    look = lambda y, r: system.watched(y, r, active)  # noqa: E731
    # One push-forward along the motion gives the rates of all that is watched.
    at, moves = jax.jvp(look, (state, rate), (rate, second))
    of_rate = jnp.asarray(system.rate_observables(), bool)
    value_rate = jnp.where(of_rate & ~jnp.any(second != 0.0), RISING, moves.value)
    terminal, gap = (at.terminal, moves.terminal), (at.gap, at.gap_rate, moves.gap_rate)
    return Guards(*gap, *terminal, at.value, value_rate, at.reversals, *at.invariant)
