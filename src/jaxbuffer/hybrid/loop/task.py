"""What one run works with and never changes."""

import dataclasses
from collections.abc import Callable
from typing import Generic, TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from ..._types import Scalar
from ..options import Options
from ..sensitivity.augmented_state import Rows, Tangents
from ..system import Active, HybridSystem
from .log import Kind

P = TypeVar("P")


@dataclasses.dataclass(frozen=True)
class Task(Generic[P]):
    """What is to be stepped, and how.

    ``build``: from parameters to the system; ``tangents``: the parameters and the directions in which derivatives are
    wanted; ``system``: the one of these parameters; ``start``: its state, with tangents, and which contacts are closed;
    ``duration`` of the run [s]; ``options``, and of these ``event_time`` [s] and ``shortfall`` [-] where they leave
    them to the system; number of ``contacts``, of ``terminals`` (guards of the run's end) and of ``observables``.
    """

    build: Callable[[P], HybridSystem]
    tangents: Tangents[P]
    system: HybridSystem
    start: tuple[Rows, Active]
    duration: Float[Array, ""]
    options: Options
    event_time: Scalar
    shortfall: Scalar
    contacts: int
    terminals: int
    observables: int

    @staticmethod
    def of(
        build: Callable[[P], HybridSystem], tangents: Tangents[P], duration: Float[Array, ""], options: Options
    ) -> "Task[P]":
        """Build the system, evaluate its start, and count its guards."""
        system = build(tangents.primal)
        rows, active = start = tangents.start(lambda parameters: build(parameters).start())
        options = options.shared(system)
        rtol = options.tolerance.rtol
        event_time = system.event_time(rows[0], rtol) if options.event_time is None else options.event_time
        shortfall = rtol if options.shortfall is None else options.shortfall
        # Only the shapes are wanted, so nothing is computed.
        terminal, value = jax.eval_shape(
            lambda y, open: (system.terminals(y), system.observables(y, y, open)), rows[0], active
        )
        sizes = (active.shape[0], terminal.shape[0], value.shape[0])
        return Task(build, tangents, system, start, duration, options, event_time, shortfall, *sizes)

    @property
    def rated(self) -> int:
        """Return how many guards have exact rates: those of contacts and of the end, which come before those of
        maxima."""
        return self.contacts + self.terminals

    @property
    def each_contact(self) -> Int[Array, " contacts"]:
        """Return the contacts' numbers."""
        return jnp.arange(self.contacts)

    @property
    def each_observable(self) -> Int[Array, " observables"]:
        """Return the observables' numbers."""
        return jnp.arange(self.observables)

    def observable_of(self, guard: Int[Array, ""]) -> Bool[Array, " observables"]:
        """Return which observable's maxima a guard stands for, if any's."""
        return self.each_observable == guard - self.rated

    def sudden(self, kind: Int[Array, ""]) -> Bool[Array, ""]:
        """Return whether an event of this `Kind` changes observables at once: a touchdown with a jump; a release, onto
        which a step ends a little beside, where the contact still pushes. What is largest right after it has no
        maximum that could be located."""
        at_release = self.contacts > 0 and self.system.observes_rate
        return (kind == Kind.TOUCHDOWN) & self.system.jumps | (kind == Kind.RELEASE) & at_release

    @property
    def of_rate(self) -> Bool[Array, " observables"]:
        """Return which observables depend on the state's rate."""
        return jnp.asarray(self.system.rate_observables(), bool)
