"""What takes a step: an explicit method, a linearly implicit one, or whichever suits."""

from collections.abc import Callable
from typing import NamedTuple

import diffrax
import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from ..mechanisms.hybrid import Linearisation
from . import methods, stages
from .dop853 import DOP853
from .lanes import Columns
from .stages import Field, Step
from .stride import Stride


class Stiff(NamedTuple):
    """What a solver may ask about stiffness at a step's start: see `HybridSystem`."""

    linearisation: Callable[[], Linearisation]
    decay: Callable[[], Float[Array, ""]]


class Solver(eqx.Module):
    """Base of the steppers."""

    def allowed(self, stiff: Stiff, step: Float[Array, ""]) -> Float[Array, ""]:
        """The length [s] to try where accuracy would allow ``step``."""
        return step

    def step(
        self, field: Field, stiff: Stiff, time: Float[Array, ""], columns: Columns, rate: Columns, stride: Stride
    ) -> Step:
        """Advance columns from ``time`` by a stride; ``rate`` is the field there."""
        raise NotImplementedError


class ExplicitRungeKutta(Solver):
    """Any explicit method of diffrax, stepped without its general machinery.

    **Arguments:** ``method``: an instance such as ``DOP853()`` or ``diffrax.Tsit5()``.
    """

    method: diffrax.AbstractERK = eqx.field(static=True, default_factory=DOP853)

    @property
    def order(self) -> int:
        return int(self.method.order(None))  # type: ignore[arg-type]

    def step(self, field, stiff, time, columns, rate, stride):
        return stages.take(methods.explicit(self.method), field, None, time, columns, rate, stride)


class LinearlyImplicit(Solver):
    """An implicit-explicit method of diffrax turned into a W-method: one matrix a step, no iteration.

    **Arguments:** ``method``: ``diffrax.KenCarp3()``, ``KenCarp4()`` or ``KenCarp5()``.
    """

    method: diffrax.AbstractSolver = eqx.field(static=True, default_factory=diffrax.KenCarp5)

    @property
    def order(self) -> int:
        return int(self.method.order(None))  # type: ignore[arg-type]

    def step(self, field, stiff, time, columns, rate, stride):
        method = methods.linearly_implicit(self.method)
        return stages.take(method, field, stiff.linearisation, time, columns, rate, stride)


class Automatic(Solver):
    """Explicit where steps are short against the fastest decay, linearly implicit where they want to be far longer.

    Ringing must be followed anyway, which the explicit method does more exactly. An implicit step's estimate of its
    error is about the error itself, the explicit one's far above it: so that errors add up alike, the implicit step is
    held to less.

    **Arguments:** ``explicit``, ``implicit``: the two solvers; ``limit``: the largest product of step and rate of decay
    that is stepped explicitly; ``worth``: how many such steps an implicit one must replace to be preferred;
    ``caution``: how many times below the tolerance its error must be.
    """

    explicit: ExplicitRungeKutta = ExplicitRungeKutta()
    implicit: LinearlyImplicit = LinearlyImplicit()
    limit: float = 5.0
    worth: float = 2.5
    caution: float = 20.0

    def _longest(self, stiff: Stiff) -> Float[Array, ""]:
        """The longest explicit step [s]."""
        return self.limit / jnp.maximum(stiff.decay(), 1e-150)

    def allowed(self, stiff, step):
        longest = self._longest(stiff)
        return jnp.where(step > self.worth * longest, step, jnp.minimum(step, longest))

    def step(self, field, stiff, time, columns, rate, stride):
        beyond = stride.length > self._longest(stiff) * (1.0 + 1e-9)
        both = methods.explicit(self.explicit.method), methods.linearly_implicit(self.implicit.method)
        method = methods.one_of(both, beyond.astype(int))
        step = stages.take(method, field, stiff.linearisation, time, columns, rate, stride)
        return step._replace(error=step.error * jnp.where(beyond, self.caution, 1.0))
