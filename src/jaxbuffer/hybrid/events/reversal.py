"""Forces that reverse within a step, as friction does where a slip passes through zero: their slope is a spike there.

Between two stages of a step that goes far past on both sides nothing is seen of the spike. The state then lacks little,
but sensitivities lack all of it. So such a step is taken again, to end where the force reverses; there the error says
how short steps must be.
"""

import jax.numpy as jnp
from jaxtyping import Array, Float

from .guards import Guards

WIDTH = 1.0  # of x, where a force goes with tanh x: a step that begins or ends within it evaluates the spike
PASSING_RATIO = 2.0  # of |x| at both ends to the least |x| in between: above it, x has turned about


def reversal_in_step(before: Guards, after: Guards) -> Float[Array, ""]:
    """Return the fraction of a step at which a force reverses that neither end of the step is near, 1 if none does."""
    start, end = before.reversals, after.reversals
    change = end - start
    squared = lambda x: jnp.sum(x * x, axis=1)  # noqa: E731
    # Where x, taken to change evenly, is smallest: zero in the plane, in space it may pass beside zero.
    closest = -jnp.sum(start * change, axis=1) / jnp.maximum(squared(change), 1e-300)
    least = start + closest[:, None] * change
    threshold = jnp.maximum(WIDTH**2, PASSING_RATIO**2 * squared(least))
    passes = (jnp.sum(start * end, axis=1) < 0.0) & (jnp.minimum(squared(start), squared(end)) > threshold)
    return jnp.min(jnp.where(passes, closest, 1.0), initial=1.0)
