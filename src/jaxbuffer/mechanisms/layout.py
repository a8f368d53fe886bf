"""Where in an assembled mechanism's state each part's numbers stand, and in which order contacts and switches come."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..basis import AnyBasis
from ..elements import Element, Switch
from ..multibody import Coordinates, Kinematics
from ..multibody.coordinates import Numbers
from ..plane import PLANE

State = Float[Array, " state"]
Closed = Float[Array, " contacts"]
Values = Array | Sequence[Scalar]


class EvaluatedState(NamedTuple):
    """A state looked at once: the bodies' frames, and each element as it is there."""

    state: State
    kin: Kinematics
    elements: tuple[Any, ...]


class Layout(NamedTuple):
    """The order of a mechanism's numbers.

    - ``coordinates``, ``velocities``: how many there are.
    - ``elements``: the parts, in their order.
    - ``losses``: how many energies lost are kept apart.
    - ``held``: whether a run may end as held, for which the first energy is kept.
    - ``basis``: plane or space.
    """

    coordinates: int
    velocities: int
    elements: tuple[Element, ...]
    losses: int
    held: bool
    basis: AnyBasis = PLANE

    @property
    def places(self) -> dict[str, slice]:
        """Return where each part of the state stands: coordinates, velocities, spins of what turns by itself, energy
        lost, the relative energy at t = 0, each element's other numbers, those of contacts that have impacts last, and
        before these the time where a motion over time is prescribed."""
        own = {k: len(it.variables) - len(it.spin_inertias) for k, it in enumerate(self.elements)}
        lengths = {
            "q": self.coordinates,
            "v": self.velocities,
            "spins": len(self.spin_inertias),
            "lost": self.losses,
            "first energy": int(self.held),
            **{f"element {k}": length for k, length in own.items() if k not in self.impacting},
            "time": int(self.driven),
            **{f"element {k}": own[k] for k in self.impacting},
        }
        places, first = {}, 0
        for name, length in lengths.items():
            places[name] = slice(first, first + length)
            first += length
        return places

    def state(
        self, *, q: Array, v: Array, lost: Values, first_energy: Scalar, own: Sequence[Values], time: Scalar
    ) -> State:
        """Return a state, or what has an entry for each of its numbers.

        **Arguments:** ``q``, ``v``: of coordinates and velocities; ``lost``: of each energy lost; ``first_energy``: of
        the relative energy at t = 0; ``own``: of each element's `variables`; ``time``: of the time.
        """
        spins = [len(element.spin_inertias) for element in self.elements]
        parts: dict[str, list[Values]] = {
            "q": [q],
            "v": [v],
            "spins": [mine[:count] for mine, count in zip(own, spins, strict=True)],
            "lost": [lost],
            "first energy": [[first_energy] * self.held],
            "time": [[time] * self.driven],
            **{f"element {k}": [mine[count:]] for k, (mine, count) in enumerate(zip(own, spins, strict=True))},
        }
        return _joined([part for name in self.places for part in parts[name]])

    def own(self, state: State, k: int) -> Float[Array, " variables"]:
        """Return the numbers of an element, by its number: its spins, and then the others."""
        places, count = self.places, len(self.elements[k].spin_inertias)
        others = state[places[f"element {k}"]]
        return jnp.concatenate([state[self._spins(k)], others]) if count else others

    def with_own(self, state: State, k: int, own: Float[Array, " variables"]) -> State:
        """Return the state with other numbers of an element."""
        count = len(self.elements[k].spin_inertias)
        for place, values in ((self._spins(k), own[:count]), (self.places[f"element {k}"], own[count:])):
            if place.stop > place.start:
                state = jnp.concatenate([state[: place.start], values, state[place.stop :]])
        return state

    def _spins(self, k: int) -> slice:
        first = self.places["spins"].start + sum(len(element.spin_inertias) for element in self.elements[:k])
        return slice(first, first + len(self.elements[k].spin_inertias))

    @property
    def driven(self) -> bool:
        """Return whether an element prescribes a motion over time, which therefore stands in the state."""
        return any(element.driving_joint is not None for element in self.elements)

    @property
    def spin_inertias(self) -> tuple[Scalar, ...]:
        """Return the moment of inertia for each spin of what turns by itself, in their order [kg m²]."""
        return tuple(inertia for element in self.elements for inertia in element.spin_inertias)

    def spinning(self, state: State) -> list[tuple[Scalar, Any]]:
        """Return inertia [kg m²] and spin [rad/s], in space a vector, of each part that turns by itself."""
        inertias, each = self.spin_inertias, len(self.basis.unit_turns)
        if not inertias:
            return []
        spins = list(state[self.places["spins"]])
        # A ball has the same inertia about every axis.
        return [(inertias[k], self.basis.turn(*spins[k : k + each])) for k in range(0, len(spins), each)]

    @property
    def switches(self) -> tuple[tuple[int, int], ...]:
        """Return element and number of each switch, in the order of the contacts."""
        places = [(k, i) for k, element in enumerate(self.elements) for i in range(len(element.switches))]
        # Contacts that have impacts come first; the observables begin with the contacts' forces, so that of the others
        # those come first whose force is observed.
        return tuple(sorted(places, key=lambda at: (not self._switch(at).impact, self._switch(at).force is None)))

    def _switch(self, at: tuple[int, int]) -> Switch:
        return self.elements[at[0]].switches[at[1]]

    @property
    def impacts(self) -> int:
        """Return how many switches close by impacts, the first ones."""
        return sum(self._switch(at).impact for at in self.switches)

    @property
    def impacting(self) -> tuple[int, ...]:
        """Return the numbers of the elements that have impacts."""
        return tuple(k for k, element in enumerate(self.elements) if any(it.impact for it in element.switches))

    @property
    def switch_forces(self) -> tuple[str, ...]:
        """Return the observables that are forces of switches, in the order of these."""
        forces = (self._switch(at).force for at in self.switches)
        return tuple(force for force in forces if force is not None)

    @property
    def switch_names(self) -> tuple[str, ...]:
        """Return the names of the switches."""
        return tuple(self._switch(at).name for at in self.switches)

    @property
    def one_way(self) -> tuple[bool, ...]:
        """Return which switches never open again once they are closed; () for none."""
        ways = tuple(self._switch(at).one_way for at in self.switches)
        return ways if any(ways) else ()

    def of_elements(self, active: Closed) -> list[Array]:
        """Return which switches of each element are closed."""
        place = {switch: at for at, switch in enumerate(self.switches)}
        return [
            _entries(active, [place[k, i] for i in range(len(element.switches))])
            for k, element in enumerate(self.elements)
        ]

    def of_switches(self, values: list[list[Scalar]]) -> Closed:
        """Return one row of what the switches of each element have: a number for each, or a row of all of them."""
        parts: list[Values] = []
        for k, i in self.switches:
            if all(jnp.ndim(value) == 0 for value in values[k]):
                parts.append([values[k][i]])
            elif i == 0:
                parts += [jnp.asarray(row) for row in values[k]]
        return _joined(parts)


def _joined(parts: list[Values]) -> Array:
    """Return rows and lists of scalars one after the other; lists that follow each other become one row."""
    rows: list[Array] = []
    scalars: list[Scalar] = []
    for part in parts:
        if isinstance(part, list | tuple):
            scalars += part
        else:
            rows += [*([stacked(scalars)] if scalars else []), jnp.asarray(part)]
            scalars = []
    return row([*rows, *([stacked(scalars)] if scalars else [])])


def _entries(values: Array, places: list[int]) -> Array:
    """Return the entries at some places; a slice of those that follow one another."""
    if not places:
        return jnp.zeros(0)
    first, last = places[0], places[-1]
    if places == list(range(first, last + 1)):
        return values[first : last + 1]
    return jnp.stack([values[place] for place in places])


def positions(states: Float[Numbers, "*axes state"], order: Coordinates) -> Float[Numbers, "*axes coordinates"]:
    """Return the coordinates of states, which begin with them."""
    return states[..., : order.count]


def row(values: list[Array]) -> Float[Array, " n"]:
    """Return rows one after the other, also if there are none."""
    return jnp.concatenate(values) if values else jnp.zeros(0)
