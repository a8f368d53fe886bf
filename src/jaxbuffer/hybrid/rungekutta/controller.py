"""Error norm and step size."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from ..._types import Scalar
from ..sensitivity.augmented_state import Rows
from ..system import HybridSystem

LEAST_TOLERANCE = 1e-13
FINEST = 1e-5  # the relative tolerance below which limited errors become no smaller


class StepTolerance(eqx.Module):
    """Local error allowed in one step: ``rtol`` of a component's size plus ``atol`` of the system's scale for it.

    Sensitivity rows are held to the same, component by component: taking a row's size as a whole spared 12 % of the
    steps and made elasticities ten times worse.
    """

    rtol: Scalar = 1e-7
    atol: Scalar = 1e-7

    def shared(self, share: float) -> "StepTolerance":
        """Return a share of the tolerance, not less than the least that a run may have."""
        if share >= 1.0:
            return self
        return StepTolerance(*(jnp.maximum(share * it, LEAST_TOLERANCE) for it in (self.rtol, self.atol)))

    def norms(self, error: Rows, rows: Rows, end: Rows, system: HybridSystem) -> Float[Array, " rows"]:
        """Return each row's root mean square of error over allowance; 1 is just allowed."""
        ratio = error / self.allowance(jnp.maximum(jnp.abs(rows), jnp.abs(end)), system)
        return jnp.sqrt(jnp.mean(ratio * ratio, axis=-1))

    def first_step(self, sensitivities: int) -> Scalar:
        """Return how long a first step after a touchdown may be, over what suits rtol 1e-6 without sensitivities.

        Its error, which no estimate sees, goes with the fifth power of its length; two and a half times as long at
        most. That of sensitivities is seen, and would be refused: it goes with the power 2.6, from 0.6 times the length
        at rtol 1e-6; no longer than that without them there, or peaks are off by 4e-5 instead of 4e-7.
        """
        looser = jnp.asarray(self.rtol) / 1e-6
        return jnp.clip(0.6 * looser**0.38, 0.0, 1.0) if sensitivities else jnp.clip(looser**0.2, 0.0, 2.5)

    def allowance(self, rows: Rows, system: HybridSystem) -> Rows:
        """Return the error allowed in each number of rows, of which the first is the state."""
        allowed = self.atol * system.scales()[None] + self.rtol * jnp.abs(rows)
        limits = system.scale_limits()
        if limits is None:
            return allowed
        # At `FINEST` a force is accurate enough; a limit that went on with the tolerance would double the steps.
        # Tangents have other units, and no force depends on them.
        limited = jnp.minimum(allowed, jnp.maximum(self.rtol, FINEST) * limits[None])
        return jnp.where(np.arange(len(rows))[:, None] == 0, limited, allowed)


class StepSizes(NamedTuple):
    """The controller's state: for each method the step it proposes [s], and the norm of its last accepted step."""

    steps: Float[Array, " methods"]
    norms: Float[Array, " methods"]

    @staticmethod
    def of(step: Float[Array, ""], methods: int) -> "StepSizes":
        """Give each of so many methods the same step [s]."""
        return StepSizes(jnp.full(methods, step), jnp.ones(methods))


class Controller(eqx.Module):
    """Proportional-integral step size control (Söderlind 2003; Hairer & Wanner II, IV.8) of several methods at once.

    **Arguments**, all dimensionless: ``safety``: factor on the step that the error estimate suggests; ``shrink``,
    ``grow``: least and greatest ratio of successive steps; ``proportional``, ``integral``: gains;
    ``recovery``: by how much the step of a method that is not in use grows with each accepted step; ``least``: the
    least step it keeps, as a fraction of the accepted one.
    """

    safety: float = 0.9
    shrink: float = 0.2
    grow: float = 8.0
    proportional: float = 0.3
    integral: float = 0.4
    recovery: float = 1.1
    least: float = 0.5

    def factor(self, norm: Float[Array, ""], previous: Float[Array, ""], order: Float[Array, ""]) -> Float[Array, ""]:
        """Return the ratio of the next step to this one. Only the present error counts after a rejection (norm > 1).

        **Arguments:** ``norm`` of this step's error over what is allowed; ``previous``: that of the last accepted step;
        ``order`` of the estimate.
        """
        # The error may be zero, as of uniform motion.
        norm = jnp.maximum(norm, 1e-10)
        steady = norm ** (-(self.integral + self.proportional) / order) * previous ** (self.proportional / order)
        factor = self.safety * jnp.where(norm > 1.0, norm ** (-1.0 / order), steady)
        return jnp.clip(factor, self.shrink, self.grow)

    def adapt(
        self,
        step_sizes: StepSizes,
        method: Int[Array, ""],
        length: Float[Array, ""],
        norm: Float[Array, ""],
        order: Float[Array, ""],
        accepted: Bool[Array, ""],
    ) -> StepSizes:
        """Return the step sizes after a trial step.

        **Arguments:** ``step_sizes`` before it; ``method`` that took it; its ``length`` [s]; ``norm`` of its error,
        NaN or infinite where there is none: the step is then cut to a tenth; ``order`` of the error estimate; whether
        it was ``accepted``: only then do the methods not in use recover.
        """
        steps, norms = step_sizes
        finite = jnp.isfinite(norm)
        resized = length * jnp.where(finite, self.factor(norm, norms[method], order), 0.1)
        # A method at rest grows back slowly and stays near the accepted step, so that it is tried again in time.
        resting = jnp.where(accepted, jnp.maximum(self.recovery * steps, self.least * length), steps)
        mine = jnp.arange(steps.shape[0]) == method
        # The lower bound keeps one step of no error from shrinking the next (see `factor`).
        return StepSizes(jnp.where(mine, resized, resting), jnp.where(mine & accepted, jnp.maximum(norm, 1e-4), norms))
