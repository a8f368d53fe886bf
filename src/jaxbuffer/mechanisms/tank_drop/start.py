"""How a drop onto a tank starts: the tank at rest under its weight and the liquid's, the slider falling (M167)."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from ...structures import State
from .assembly import TankModel
from .design import TankDropScenario
from .node_sets import mirrors

ITERATIONS = 20  # of Newton's method, and one for each node that may leave the baffle


class Unknowns(NamedTuple):
    """Which displacements of the wall are unknown.

    - ``places``: (unknowns,) where they stand among all displacements, node by node.
    - ``bottom``: (bottom,) which of them are those of the flat bottom's outside, upwards.
    - ``nodes``: how many nodes there are.
    """

    places: np.ndarray
    bottom: np.ndarray
    nodes: int

    @staticmethod
    def of(parts: TankModel) -> "Unknowns":
        """Return all unknowns of the wall, without those sideways in the middle of the section."""
        numbers, nodes = parts.section.numbers, len(parts.system.positions)
        free = np.ones((nodes, 2), bool)
        # Slider and baffle, the last two nodes, do not take part.
        free[parts.slider :] = False
        free[numbers.middle, 0] = False
        places = np.flatnonzero(free.ravel())
        return Unknowns(places, np.searchsorted(places, 2 * numbers.outer[: numbers.flat + 1] + 1), nodes)

    def displacement(self, values: Float[Array, " unknowns"]) -> Float[Array, "nodes 2"]:
        """Return the displacement of all nodes [m]."""
        return jnp.zeros(2 * self.nodes).at[self.places].set(values).reshape(-1, 2)


def falling(parts: TankModel, scenario: TankDropScenario) -> State:
    """Return the tank at rest and the slider at the speed of its fall."""
    state = at_rest(parts)
    speed = jnp.sqrt(2.0 * scenario.gravity * scenario.height)
    return state._replace(velocity=state.velocity.at[parts.slider, 1].set(-speed))


def at_rest(parts: TankModel) -> State:
    """Return the tank in equilibrium with gravity and the liquid's static pressure, its flat bottom on the baffle where
    it presses on it, or as deep in it as a penalty lets it; the slider is where the cushion would just touch the tank
    undeformed. Newton's method finds it; derivatives are those of the equilibrium. The whole section stands as its half
    does and as that one's image: nothing holds it sideways, so that its own matrix is singular."""
    if parts.half is not None:
        half = at_rest(parts.half).displacement[: parts.half.slider]
        of_wall, _ = mirrors(parts.section.numbers)
        return parts.system.start()._replace(displacement=jnp.concatenate([of_wall.vectors(half), jnp.zeros((2, 2))]))
    unknowns = Unknowns.of(parts)
    count = len(unknowns.bottom)
    # The whole bottom stands at first.
    first = jnp.zeros(len(unknowns.places)), jnp.ones(count, bool)
    solution, stands = jax.lax.fori_loop(0, ITERATIONS + count, lambda _, at: _better(parts, unknowns, *at), first)
    # A last step of Newton's method from the solution keeps it, and has the derivative of the equilibrium.
    values, _ = _better(parts, unknowns, jax.lax.stop_gradient(solution), stands)
    return parts.system.start()._replace(displacement=unknowns.displacement(values))


def _better(parts: TankModel, unknowns: Unknowns, values: Array, stands: Array) -> tuple[Array, Bool[Array, " bottom"]]:
    """Return the values after a step of Newton's method where these of the bottom's nodes stand, and which stand then:
    those that press, or are below the baffle."""
    contact = parts.system.contacts[0]
    matrix, left = _linearised(parts, unknowns, values)
    bottom, unknown = unknowns.bottom, len(unknowns.places)
    if contact.method == "penalty":
        stiffness = jnp.asarray(contact.stiffness)[: len(bottom)]
        bed = jnp.zeros(unknown).at[bottom].set(jnp.where(stands, stiffness, 0.0))
        after = values - jnp.linalg.solve(matrix + jnp.diag(bed), left + bed * values)
        # The baffle presses and never pulls: a node that lifts off it stands no more.
        return after, after[bottom] < 0.0
    # Where a node stands, its equation says that it is on the baffle; what is then out of balance presses.
    fixed = jnp.zeros(unknown, bool).at[bottom].set(stands)
    change = jnp.linalg.solve(jnp.where(fixed[:, None], jnp.eye(unknown), matrix), -jnp.where(fixed, values, left))
    after, pressed = values + change, (left + matrix @ change)[bottom]
    return after, jnp.where(stands, pressed > 0.0, after[bottom] < 0.0)


def _linearised(parts: TankModel, unknowns: Unknowns, values: Array) -> tuple[Array, Array]:
    """Return the wall's stiffness (unknowns, unknowns) [N/m] and what is not in balance there (unknowns,) [N], without
    the baffle."""
    system, wall, displacement = parts.system, parts.wall, unknowns.displacement(values)
    load = system.mass * system.gravity[None]
    if system.liquid is not None:
        assert system.static_pressure is not None
        load = load + system.liquid.push(system.static_pressure, unknowns.nodes)
    left = (wall.resist(displacement, wall.start()).forces - load).ravel()
    rows = (2 * wall.quads.incidence.corners[:, :, None] + np.arange(2)).reshape(-1, 8)
    size = 2 * unknowns.nodes
    whole = jnp.zeros((size, size)).at[rows[:, :, None], rows[:, None]].add(wall.stiffness(displacement))
    return whole[np.ix_(unknowns.places, unknowns.places)], left[unknowns.places]
