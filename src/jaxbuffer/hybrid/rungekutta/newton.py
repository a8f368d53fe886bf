"""The matrix of Newton's method in an implicit stage: I - shift J, where J holds the stiff forces alone.

The stiff forces are few, so J is of low rank plus q̇ = N w, and solving takes the inverse of one small matrix
(Woodbury's identity) instead of a factorisation in a library, which would split the loop's kernel.
"""

from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from ...plane import inverse
from ..sensitivity.augmented_state import Columns
from ..system import Linearisation

TERMS = 6


class NewtonMatrix(NamedTuple):
    """I - shift J, ready to be solved with.

    ``stiff``: the stiff part of the velocities' equation, ẇ ≈ -X (K B_qᵀ δq + C Bᵀ δw) (see `Linearisation`);
    ``shift`` [s]: the method's γ times the step; ``response`` [-]: C + shift K, how the forces answer to a change of
    the velocities; ``mobility``: Bᵀ X; ``inner``: the inverse of I + shift · mobility · response.
    """

    stiff: Linearisation
    shift: Float[Array, ""]
    response: Float[Array, "rank rank"]
    mobility: Float[Array, "rank rank"]
    inner: Float[Array, "rank rank"]

    @staticmethod
    def of(stiff: Linearisation, shift: Float[Array, ""]) -> "NewtonMatrix":
        """Prepare the matrix: one small inverse is taken."""
        mobility = _product(stiff.directions.T, stiff.response)
        response = stiff.damping + shift * stiff.stiffness
        inner = inverse(jnp.eye(len(mobility)) + shift * _product(mobility, response))
        return NewtonMatrix(stiff, shift, response, mobility, inner)

    def solve(self, right: Columns) -> Columns:
        """Solve (I - shift J) u = ``right`` for each column."""
        stiff, shift, n = self.stiff, self.shift, self.stiff.coordinates
        velocities, own = len(stiff.directions), n - stiff.position_rate.surplus
        r_q, r_w, rest = right[:n], right[n : n + velocities], right[n + velocities :]
        spring = _product(stiff.stiffness, _product(stiff.directions[:own].T, stiff.position_rate.velocity(r_q)))
        z = _product(self.inner, _product(stiff.directions.T, r_w) - shift * _product(self.mobility, spring))
        w = r_w - shift * _product(stiff.response, spring + _product(self.response, z))
        # What follows the velocities decays by itself, so its part of the matrix is diagonal.
        if stiff.decay is not None:
            rest = rest / (1.0 + shift * stiff.decay)[:, None]
        if stiff.followers is not None:
            rest = stiff.followers.solve(rest, w, shift)
        return jnp.concatenate([r_q + shift * stiff.position_rate.of(w[:own]), w, rest])


def _product(a: Array, b: Array) -> Array:
    """Multiply two matrices by a sum, since a call into a library would split the loop's kernel."""
    return summed(jnp.swapaxes(a, 0, 1)[:, :, None] * b[:, None])


def summed(terms: Float[Array, "terms *shape"]) -> Float[Array, "*shape"]:
    """Sum over the first axis, in sums of `TERMS` terms at most: LLVM writes out one that is so short and evaluates it
    in vector instructions, a longer one number by number (see `process`)."""
    sums = [jnp.sum(terms[k : k + TERMS], axis=0) for k in range(0, max(len(terms), 1), TERMS)]
    return sum(sums[1:], sums[0])
