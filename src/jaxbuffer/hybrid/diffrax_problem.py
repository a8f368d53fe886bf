"""A hybrid system as an ordinary differential equation that `diffrax.diffeqsolve` integrates.

The vector field is that of an index-1 differential-algebraic equation: accelerations and multipliers come from the
augmented system at every evaluation. It is a function of the state alone: whether a contact is closed follows from the
sign of its gap, so the system must have a smooth contact law, one that needs nothing to happen at a touchdown.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import diffrax
import equinox as eqx
import jax.numpy as jnp
import optimistix as optx
from jaxtyping import Array, Float, Int

from .._types import Scalar
from .rungekutta.root_finder import with_root_finder
from .system import Active, HybridSystem, Linearisation, State

Build = Callable[..., HybridSystem]

# How closely the event's time is found on the dense output [-, s]: by bisection. Newton's method from a step's end may
# leave the step where a guard rises and falls within it.
EVENT_RTOL, EVENT_ATOL = 1e-12, 1e-13
IMPLICIT_EXPLICIT = (diffrax.KenCarp3, diffrax.KenCarp4, diffrax.KenCarp5)


def closed(system: HybridSystem, state: State) -> Active:
    """Return 1 for contacts whose gap is negative, 0 for the others."""
    return jnp.where(system.gaps(state) < 0.0, 1.0, 0.0)


class VectorField(eqx.Module):
    """``f(t, y, args) = dy/dt`` of the system ``build(*args)``, its contacts as their gaps say."""

    build: Build = eqx.field(static=True)

    def __call__(self, t: Any, y: State, args: Any) -> State:
        system = self.build(*args)
        return system.derivative(t, y, closed(system, y))

    def linearisation(self, t: Any, y: State, args: Any) -> Linearisation:
        """Return the stiff part of ∂f/∂y."""
        system = self.build(*args)
        return system.linearisation(t, y, closed(system, y))


class HighestTerminal(eqx.Module):
    """The highest terminal guard of the system ``build(*args)`` as the condition of a `diffrax.Event`: the run ends
    where it rises through zero."""

    build: Build = eqx.field(static=True)

    def __call__(self, t: Scalar, y: State, args: Any, **_: Any) -> Float[Array, ""]:
        return jnp.max(self.build(*args).terminals(y))


class DiffraxProblem(NamedTuple):
    """What `diffrax.diffeqsolve` needs to integrate a run, in its words.

    - ``term``: the vector field, a `diffrax.ODETerm`; `term_for` a method that wants two.
    - ``y0``: the state at t = 0, shape (state,): coordinates, velocities, then what else the system integrates.
    - ``args``: the numbers the vector field depends on, a pytree of arrays; differentiate with respect to these (``y0``
      depends on them as well: make the problem inside the differentiated function).
    - ``event``: ends the solve where one of the terminal guards rises through zero; `ended_by` says which one.
    - ``dt0``: a first step [s].
    - ``scales``: magnitude of each component of the state, shape (state,); ``atol=rtol * problem.scales`` suits a
      `diffrax.PIDController`.
    - ``build``: from ``*args`` to the system.
    """

    term: diffrax.ODETerm
    y0: State
    args: Any
    event: diffrax.Event
    dt0: Float[Array, ""]
    scales: State
    build: Build

    def method(self, method: diffrax.AbstractSolver) -> diffrax.AbstractSolver:
        """Give an implicit method of diffrax a root finder that knows the stiff forces (see `LowRankNewton`). Return an
        explicit method, and one with a root finder of the user's, as it is."""
        return with_root_finder(method, self.term.vector_field.linearisation)  # type: ignore[attr-defined]

    def term_for(self, method: diffrax.AbstractSolver) -> diffrax.AbstractTerm:
        """Return the vector field as a method of diffrax takes it: see `terms`."""
        return terms(method, self.term)

    def observe(self, t: Scalar, y: State, args: Any) -> dict[str, Float[Array, ""]]:
        """Return the observables of a state by name, for ``diffrax.SaveAt(..., fn=problem.observe)``."""
        system = self.build(*args)
        return dict(zip(system.observed, self._observables(system, t, y), strict=True))

    def normal_forces(self, t: Scalar, y: State, args: Any) -> Float[Array, " contacts"]:
        """Return the normal force of each contact [N] in a state, for ``diffrax.SaveAt(...,
        fn=problem.normal_forces)``."""
        system = self.build(*args)
        return self._observables(system, t, y)[: system.gaps(y).shape[0]]

    def ended_by(self, y: State, args: Any) -> Int[Array, ""]:
        """Return the index of the terminal guard that ended a solve, from its last state; see the system's
        ``terminals``."""
        return jnp.argmax(self.build(*args).terminals(y))

    @staticmethod
    def _observables(system: HybridSystem, t: Scalar, y: State) -> Float[Array, " observables"]:
        return system.observables_anew(t, y, closed(system, y))


def terms(method: diffrax.AbstractSolver, term: diffrax.ODETerm) -> diffrax.AbstractTerm:
    """Return the ``term``; of an implicit-explicit method it is the implicit half, and the explicit half is zero."""
    if isinstance(method, IMPLICIT_EXPLICIT):
        # The field is not split: its contact forces are stiff, and the implicit half takes all of it.
        return diffrax.MultiTerm(diffrax.ODETerm(lambda t, y, args: jnp.zeros_like(y)), term)
    return term


def event(build: Build) -> diffrax.Event:
    """Return the event that ends a solve where a terminal guard rises through zero."""
    finder: optx.Bisection = optx.Bisection(EVENT_RTOL, EVENT_ATOL)  # type: ignore[call-arg]
    return diffrax.Event(HighestTerminal(build), finder, direction=True)


def diffrax_problem(build: Build, args: tuple[Any, ...]) -> DiffraxProblem:
    """Return the run of ``build(*args)``, a system with a smooth contact law, as a problem for
    `diffrax.diffeqsolve`."""
    system = build(*args)
    start, _ = system.start()
    return DiffraxProblem(
        term=diffrax.ODETerm(VectorField(build)),
        y0=start,
        args=args,
        event=event(build),
        dt0=jnp.asarray(system.impact_step(start)),
        scales=system.scales(),
        build=build,
    )
