"""What takes a step: an explicit method, an implicit one, or whichever gets further for its cost."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..._types import AbstractERK, AbstractSolver, Scalar
from ..sensitivity.augmented_state import Columns
from ..system import Linearisation
from . import dop853, stages
from . import tableaus as methods
from .stages import Field, SecondDerivative, Step
from .time_transform import TimeTransform


class Solver(eqx.Module):
    """Base of the steppers. A stepper has one or several methods, each with its own idea of how far a step may go."""

    @property
    def methods(self) -> tuple[methods.Method, ...]:
        """Return the methods to choose from."""
        raise NotImplementedError

    @property
    def safety_factor(self) -> Scalar:
        """Return how many times below the tolerance the estimated error of an implicit step must be."""
        return 1.0

    def choose(self, stiff: Linearisation, steps: Float[Array, " methods"]) -> tuple[Int[Array, ""], Float[Array, ""]]:
        """Choose the method of the next step and its length [s], where accuracy would allow ``steps``."""
        return jnp.asarray(0), steps[0]

    def is_implicit(self, which: Int[Array, ""]) -> Bool[Array, ""]:
        """Return whether a method is implicit; its steps are then even in time, with one matrix for all stages."""
        return jnp.asarray([method.gamma > 0.0 for method in self.methods])[which]

    def method_for(self, stiff: Linearisation, step: Float[Array, ""]) -> Int[Array, ""]:
        """Return which method takes a step of a given length [s]."""
        return jnp.asarray(0)

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
        """Take one step by a method.

        **Arguments:** ``which`` method; the ``field`` (time [s], columns) → derivative; its ``stiff`` part at the
        start; ``time`` [s], ``columns`` and their ``rate`` there; ``transform``: the step's length and how time passes
        in it; ``allowance``: the error allowed in each number; ``second``: when the second derivative at the end is
        wanted, None for never.
        """
        method = self.methods[0] if len(self.methods) == 1 else methods.one_of(self.methods, which)
        explicit = not any(method.gamma for method in self.methods)
        step = stages.take_step(
            method, field, None if explicit else stiff, time, columns, rate, transform, allowance, second
        )
        return step._replace(error=step.error * jnp.where(self.is_implicit(which), self.safety_factor, 1.0))


class ExplicitRungeKutta(Solver):
    """DOP853 or any explicit method of diffrax, stepped without its general machinery.

    **Arguments:** ``method``: an instance such as ``diffrax.Tsit5()``; None for DOP853.
    """

    method: AbstractERK | None = eqx.field(static=True, default=None)

    @property
    def methods(self):
        return (dop853.METHOD if self.method is None else methods.explicit(self.method),)


class DiagonallyImplicit(Solver):
    """A singly diagonally implicit method of diffrax, its stages solved by Newton's method with a small matrix.

    An estimate of the error that a stiffly accurate method gives is about the error itself, an explicit one's far above
    it: so that errors add up alike, implicit steps are held to less.

    **Arguments:** ``method``: ``diffrax.KenCarp3()``, ``KenCarp4()``, ``KenCarp5()``, ``Kvaerno4()``, ``Kvaerno5()``…,
    None for ``KenCarp4()``; ``safety_factor``: how many times below the tolerance its estimated error must be.
    """

    method: AbstractSolver | None = eqx.field(static=True, default=None)
    safety_factor: float = 20.0

    @property
    def methods(self):
        # Imported only where a run is compiled: diffrax takes a fifth of a second start.
        from diffrax import KenCarp4

        return (methods.diagonally_implicit(KenCarp4() if self.method is None else self.method),)


class Automatic(Solver):
    """Explicit steps or implicit ones, whichever get further for their cost.

    Both controllers go on: the one whose method rests lets its step grow slowly, so that it has its turn again.

    **Arguments:** ``explicit``, ``implicit``: the two solvers; ``limit``: the largest product of an explicit step and
    the fastest rate of the stiff forces, which stability sets; ``worth``: how many explicit steps an implicit one must
    replace to be preferred.
    """

    explicit: ExplicitRungeKutta = ExplicitRungeKutta()
    implicit: DiagonallyImplicit = DiagonallyImplicit()
    limit: float = 5.0
    worth: float = 2.0

    @property
    def safety_factor(self):
        return self.implicit.safety_factor

    @property
    def methods(self):
        return (*self.explicit.methods, *self.implicit.methods)

    def _longest(self, stiff: Linearisation) -> Float[Array, ""]:
        """Return the longest explicit step [s]."""
        # No stiff force may act at all: then there is no limit, but a finite number.
        return self.limit / jnp.maximum(stiff.fastest(), 1e-150)

    def choose(self, stiff, steps):
        if not stiff.rank:  # then Newton's method would be a mere iteration, and no step worth it
            return super().choose(stiff, steps)
        explicit = jnp.minimum(steps[0], self._longest(stiff))
        which = (steps[1] > self.worth * explicit).astype(int)
        return which, jnp.where(which == 1, steps[1], explicit)

    def method_for(self, stiff, step):
        if not stiff.rank:
            return super().method_for(stiff, step)
        # A step that `choose` cut to just this length stays explicit in spite of rounding.
        return (step > self._longest(stiff) * (1.0 + 1e-9)).astype(int)


AUTOMATIC = Automatic()
"""The solver of whoever names none: one object, which a request recognises, so that it need not copy its options."""
