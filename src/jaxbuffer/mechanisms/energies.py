"""Energies and momentum of an assembled mechanism, as sums over its bodies and elements."""

from collections.abc import Mapping

import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..basis import components, turn_array
from ..multibody import System
from .layout import Closed, EvaluatedState, Layout, State


def stored_energies(
    system: System, layout: Layout, at: EvaluatedState, active: Closed, stored_in: str
) -> dict[str, Scalar]:
    """Return the energy in motion, in the system's springs and in elements, by name [J] (M76). ``active``: closed
    contacts and switches; ``stored_in``: the name of what the system's own springs store."""
    kinetic = system.kinetic_energy(at.kin)
    for inertia, spin in layout.spinning(at.state):
        for component in components(spin):
            kinetic = kinetic + 0.5 * inertia * component**2
    stored: dict[str, Scalar] = {"kinetic": kinetic, stored_in: jnp.asarray(system.stored_energy(at.kin))}
    for element, it, closed in zip(layout.elements, at.elements, layout.of_elements(active), strict=True):
        stored = added(stored, element.stored(it, closed))
    return stored


def supplied_energies(layout: Layout, state: State) -> dict[str, Scalar]:
    """Return the energy that elements have put in from outside so far, by name [J]."""
    supplied: dict[str, Scalar] = {}
    for k, element in enumerate(layout.elements):
        supplied = added(supplied, element.supplied(layout.own(state, k)))
    return supplied


def momentum(
    system: System, layout: Layout, at: EvaluatedState
) -> tuple[Float[Array, " dimensions"], Float[Array, "..."]]:
    """Return linear [kg m/s] and angular momentum about the origin [kg m²/s], in space a vector, without what came from
    outside."""
    linear, angular = system.linear_momentum(at.kin), system.angular_momentum(at.kin)
    for inertia, spin in layout.spinning(at.state):
        angular = angular + inertia * turn_array(spin)
    for k, element in enumerate(layout.elements):
        impulse = element.impulse(layout.own(at.state, k))
        if impulse is not None:  # what came from outside is no error
            linear, angular = linear - stacked(impulse[0]), angular - turn_array(impulse[1])
    return linear, angular


def added(energies: Mapping[str, Scalar], more: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """Return energies, or powers, with others added by their names."""
    sums = dict(energies)
    for name, value in more.items():
        sums[name] = sums[name] + value if name in sums else value
    return sums
