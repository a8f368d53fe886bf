"""Steps of `diffrax` that end on predicted touchdowns, as `diffrax.ClipStepSizeController` has them end on known times.

A smooth law lets its memory go while the gap passes through 1e-8 m, within 1e-7 s. No stage of a longer step need fall
into that, and then no error estimate sees what it does to the tangents: those of Table 2's peak force were off by 6 %.
"""

from collections.abc import Callable
from typing import Any

import diffrax
import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

NEAR = 1e-9  # m, a gap below which no touchdown is foreseen


class OntoTouchdowns(diffrax.PIDController):
    """A `diffrax.PIDController` whose steps go no further than the next touchdown; ``gaps``: from state and ``args`` to
    the gap of each contact [m] and how fast it closes [m/s]; ``first``: length of the first step [s].

    `diffeqsolve` checks a first step that it is given by a callback, and a program with callbacks can not be exported.
    """

    gaps: Callable[[Any, Any], tuple[Float[Array, " contacts"], Float[Array, " contacts"]]] = eqx.field(kw_only=True)

    first: Float[Array, ""] = eqx.field(kw_only=True)

    def init(self, terms, t0, t1, y0, dt0, args, func, error_order):
        return super().init(terms, t0, t1, y0, self.first, args, func, error_order)

    def adapt_step_size(self, t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state):
        keep, start, end, jumped, state, result = super().adapt_step_size(
            t0, t1, y0, y1_candidate, args, y_error, error_order, controller_state
        )
        gap, closing = self.gaps(jnp.where(keep, y1_candidate, y0), args)
        coming = (gap > NEAR) & (closing > 0.0)
        ahead = jnp.min(jnp.where(coming, gap / jnp.where(coming, closing, 1.0), jnp.inf), initial=jnp.inf)
        return keep, start, jnp.minimum(end, start + ahead), jumped, state, result
