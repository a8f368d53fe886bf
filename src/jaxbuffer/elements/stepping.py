"""What an element lets time stepping know of its forces, beside the equations of motion."""

from typing import Any

import equinox as eqx
from jaxtyping import Array, Float

from .._types import Scalar
from ..hybrid import PassiveOscillators
from ..multibody import Coordinates, SpringDirection, System
from .stiff_terms import ContactTerm

Own = Float[Array, " variables"]
Closed = Float[Array, " switches"]


class SteppingHints(eqx.Module):
    """How stiff, how smooth and how sudden the forces of an element are. Every default says "not at all".

    ``at``, ``own``, ``closed``: as of `Element`.
    """

    def springs(self, at: Any, closed: Closed) -> tuple[SpringDirection, ...]:
        """Return the element's spring-dampers with their directions frozen: what implicit steps take for stiff."""
        return ()

    def contact_term(self, system: System, at: Any, closed: Closed) -> ContactTerm | None:
        """Return a contact's share of the stiff part; None if the element has no contact."""
        return None

    def decays(self, at: Any) -> list[Scalar] | None:
        """Return the rates at which `variables` decay by themselves [1/s]; None if none does."""
        return None

    def scale_limits(self) -> list[Scalar] | None:
        """Return the largest magnitude that an error of each of `variables` may be relative to; None if of all."""
        return None

    def impact_step(self, system: System, own: Own) -> Scalar | None:
        """Return a step that resolves an impact of the element [s]; None if it has none."""
        return None

    def stiff_force(self, at: Any, closed: Closed) -> Scalar:
        """Return the size of the stiff forces [N], of which rounding of positions makes an error in the energy."""
        return 0.0

    def followers(self, first: int, order: Coordinates) -> PassiveOscillators | None:
        """Return the element's oscillators for implicit steps; None if it has none. ``first``: where `variables` stand,
        counted from the end of the velocities; ``order``: of the velocities."""
        return None

    @property
    def has_impulsive_reactions(self) -> bool:
        """Return whether reactions may rise within a step from far below their largest value to above it."""
        return False

    @property
    def reversing(self) -> int:
        """Return how many forces of the element reverse where something passes through zero, as friction does."""
        return 0

    def reversals(self, at: Any, closed: Closed) -> Float[Array, "reversing axes"]:
        """Return x of each, a force ∝ tanh x: of friction the slip over its slip speed, as a vector in the mechanism's
        plane or space; zeros where the force does not act."""
        raise NotImplementedError

    @property
    def tolerance_share(self) -> float:
        """Return the share of a run's tolerance that steps keep to: less where a force is not smooth."""
        return 1.0
