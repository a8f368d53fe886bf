"""What is read off a run at one instant."""

from collections.abc import Callable
from typing import Any, NamedTuple

from jaxtyping import Array, Float, Int

from .energy import Energy


class Reading(NamedTuple):
    """What a mechanism shows at one instant of a run.

    - ``state``: with the derivative that it has at an instant that moves with the parameters.
    - ``observables``: all of them, in the mechanism's units.
    - ``energy``: stored and lost [J].
    - ``momentum``: linear [kg m/s] and angular about the origin [kg m²/s], in space a vector, without derivatives; None
      where the ground takes part.
    - ``own``: what the mechanism's `Reader` looks at, None without one.
    """

    state: Float[Array, " state"]
    observables: Float[Array, " observables"]
    energy: Energy
    momentum: tuple[Float[Array, " dimensions"], Float[Array, "..."]] | None
    own: Any


class Reader(NamedTuple):
    """What a mechanism's `run` reads off besides what every run has.

    - ``look``: from the system, an evaluated state, its closed contacts and the effective masses along the directions
      to a tree of numbers, for each `Reading`.
    - ``directions``: from the system and an evaluated state to what effective masses are wanted along, a column each;
      None for none.
    - ``slot``: from the system and a run's log to the entry of the one event that the mechanism looks at, beside start
      and end of a run; None for no such event.
    """

    look: Callable[[Any, Any, Array, Any], Any]
    slot: Callable[[Any, Any], Int[Array, ""] | None]
    directions: Callable[[Any, Any], Float[Array, "coordinates rank"]] | None = None
