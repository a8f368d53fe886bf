"""Where in an assembled mechanism's state each part's numbers stand, and in which order contacts and switches come."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..elements import BallContact, BallState, Element
from ..multibody import Coordinates, Kinematics

State = Float[Array, " state"]
Closed = Float[Array, " contacts"]
Numbers = Array | np.ndarray


class EvaluatedState(NamedTuple):
    """A state looked at once: the bodies' frames, and each contact and each element as it is there."""

    state: State
    kin: Kinematics
    contacts: tuple[BallState, ...]
    elements: tuple[Any, ...]


class Layout(NamedTuple):
    """The order of a mechanism's numbers.

    - ``coordinates``: how many there are.
    - ``contacts``, ``elements``: the parts, in their order.
    - ``losses``: how many energies lost are kept apart.
    - ``held``: whether a run may end as held, for which the first energy is kept.
    """

    coordinates: int
    contacts: tuple[BallContact, ...]
    elements: tuple[Element, ...]
    losses: int
    held: bool

    @property
    def places(self) -> dict[str, slice]:
        """Return where each part of the state stands: coordinates, velocities, spins of balls that spin freely, energy
        lost, the relative energy at t = 0, each element's numbers, the time where a motion over time is prescribed, and
        the contacts' memory."""
        lengths = {
            "q": self.coordinates,
            "v": self.coordinates,
            "spins": len(self.spin_inertias),
            "lost": self.losses,
            "first energy": int(self.held),
            **{f"element {k}": len(element.variables) for k, element in enumerate(self.elements)},
            "time": int(self.driven),
            "memory": self.segments,
        }
        places, first = {}, 0
        for name, length in lengths.items():
            places[name] = slice(first, first + length)
            first += length
        return places

    def joined(self, parts: Mapping[str, Array | list[Scalar]]) -> State:
        """Return a state, or what has an entry for each of its numbers, of its parts by their names in `places`."""
        rows: list[Array] = []
        scalars: list[Scalar] = []
        for name in self.places:
            part = parts[name]
            if isinstance(part, list):
                scalars += part
                continue
            rows += [stacked(scalars)] if scalars else []
            scalars = []
            rows.append(part)
        return jnp.concatenate([*rows, *([stacked(scalars)] if scalars else [])])

    @property
    def driven(self) -> bool:
        """Return whether an element prescribes a motion over time, which therefore stands in the state."""
        return any(element.driving_joint is not None for element in self.elements)

    @property
    def spin_inertias(self) -> dict[int, Scalar]:
        """Return which contacts have a ball that spins freely, each with its ball's inertia [kg m²]."""
        inertias = ((k, contact.spin_inertia) for k, contact in enumerate(self.contacts))
        return {k: inertia for k, inertia in inertias if inertia is not None}

    @property
    def segments(self) -> int:
        """Return how many segments all contacts have, each with impacts of its own."""
        return sum(contact.segments for contact in self.contacts)

    @property
    def switches(self) -> tuple[tuple[int, int], ...]:
        """Return element and number of each switch."""
        all_of = [
            (k, i, switch.force is None)
            for k, element in enumerate(self.elements)
            for i, switch in enumerate(element.switches)
        ]
        # The observables begin with contact forces, so that switches whose force is observed come first.
        return tuple((k, i) for k, i, _ in sorted(all_of, key=lambda it: it[2]))

    @property
    def switch_forces(self) -> tuple[str, ...]:
        """Return the observables that are forces of switches, in the order of these."""
        forces = (self.elements[k].switches[i].force for k, i in self.switches)
        return tuple(force for force in forces if force is not None)

    @property
    def segment_names(self) -> tuple[str, ...]:
        """Return the names of the contacts' segments."""
        names: list[str] = []
        for contact in self.contacts:
            names += contact.names or [f"contact {len(names) + 1}"]
        return tuple(names)

    @property
    def contact_names(self) -> tuple[str, ...]:
        """Return the names of the contacts' segments, and then of the elements' switches."""
        return (*self.segment_names, *(self.elements[k].switches[i].name for k, i in self.switches))

    @property
    def one_way(self) -> tuple[bool, ...]:
        """Return which contacts never open again once they are closed; () for none."""
        ways = [self.elements[k].switches[i].one_way for k, i in self.switches]
        return (*[False] * self.segments, *ways) if any(ways) else ()

    def of_contacts(self, values: Any) -> list[Any]:
        """Split what has an entry for each segment by contacts."""
        parts, first = [], 0
        for contact in self.contacts:
            parts.append(values[first : first + contact.segments])
            first += contact.segments
        return parts

    def of_elements(self, active: Closed) -> list[Array]:
        """Return which switches of each element are closed."""
        place = {switch: self.segments + at for at, switch in enumerate(self.switches)}
        of = [[active[place[k, i]] for i in range(len(element.switches))] for k, element in enumerate(self.elements)]
        return [jnp.stack(switches) if switches else jnp.zeros(0) for switches in of]

    def of_switches(self, segments: list[Array], switches: list[list[Scalar]]) -> Float[Array, " contacts"]:
        """Return one row of what the ``segments`` of each contact and the ``switches`` of each element have."""
        values = [jnp.reshape(jnp.asarray(switches[k][i], float), (1,)) for k, i in self.switches]
        return row([*segments, *values])


def positions(states: Float[Numbers, "*axes state"], order: Coordinates) -> Float[Numbers, "*axes coordinates"]:
    """Return the coordinates of states, which begin with them."""
    return states[..., : order.count]


def row(values: list[Array]) -> Float[Array, " n"]:
    """Return rows one after the other, also if there are none."""
    return jnp.concatenate(values) if values else jnp.zeros(0)
