"""What explicit dynamics moves: structures, rigid bodies, contacts, a liquid (M126)."""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from .acoustics import Liquid
from .contact.forces import NodeContact, NodeContactForces
from .contact.layer import Layer
from .contact.search import candidates
from .contact.surfaces import Segments
from .gas import Gas
from .materials import PlasticHistory
from .structure import Elements, Resistance

SAFETY = 0.8  # of the critical step


class FiniteElementSystem(eqx.Module):
    """Nodes with masses, and all that acts on them.

    - ``positions``: (nodes, 2) [m]. A rigid body is a node without elements.
    - ``inverse_mass``: (nodes, 2) of each direction, 0 where a node is held [1/kg].
    - ``elements``: groups of one kind and material.
    - ``contacts``, ``layers``: which nodes may touch what.
    - ``gravity``: (2,) [m/s²]; ``load``: (nodes, 2) constant forces besides [N].
    - ``liquid``: or None, with its static pressure (liquid nodes,) [Pa]; ``gas``: shut in, or None.
    """

    positions: Float[Array, "nodes 2"]
    inverse_mass: Float[Array, "nodes 2"]
    elements: tuple[Elements, ...] = ()
    contacts: tuple[NodeContact, ...] = ()
    layers: tuple[Layer, ...] = ()
    gravity: Float[Array, " 2"] = eqx.field(default_factory=lambda: jnp.zeros(2))
    load: Float[Array, "nodes 2"] | None = None
    liquid: Liquid | None = None
    static_pressure: Float[Array, " liquid"] | None = None
    gas: Gas | None = None

    @property
    def mass(self) -> Float[Array, "nodes 2"]:
        """Return the mass of each direction that is not held, 0 where it is [kg]."""
        # A held node has an infinite mass: zero keeps it out of weights and energies.
        free = self.inverse_mass > 0.0
        return jnp.where(free, 1.0 / jnp.where(free, self.inverse_mass, 1.0), 0.0)

    def start(self, velocity: Float[Array, "nodes 2"] | None = None) -> "State":
        """Return the undeformed state with velocities [m/s] (default: at rest), which a liquid has not felt yet."""
        still = jnp.zeros_like(self.positions)
        velocity = still if velocity is None else velocity
        quiet = jnp.zeros(0) if self.liquid is None else jnp.zeros_like(self.liquid.mass)
        plate = None if self.liquid is None else self.liquid.plate
        still_holes = jnp.zeros(0 if plate is None else len(plate.area))
        return State(
            jnp.zeros(()),
            still,
            velocity,
            tuple(group.start() for group in self.elements),
            quiet,
            quiet if self.liquid is None else self.liquid.struck(velocity, still_holes),
            quiet,
            jnp.zeros(0 if self.liquid is None or self.liquid.cover is None else len(self.liquid.cover.surface)),
            still_holes,
            tuple(jnp.zeros(len(contact.slaves)) for contact in self.contacts),
            *(jnp.zeros(()),) * 3,
        )

    def search(self, displacement: Float[Array, "nodes 2"]) -> tuple:
        """Return the candidates of each contact, where it needs any."""
        return tuple(
            candidates(contact.slaves, contact.surface.ends, self.positions + displacement)
            if isinstance(contact.surface, Segments)
            else None
            for contact in self.contacts
        )

    def stable_step(self) -> Float[Array, ""]:
        """Return the critical step [s], found from the fastest element, node on a contact and liquid element, at rest.

        An element's frequency bounds that of any assembly of such (Irons). What a contact or the liquid adds to a node
        adds to the square at most (M128).
        """
        fastest = jnp.max(jnp.stack([jnp.max(group.fastest()) for group in self.elements])) ** 2
        added = [layer.fastest(self.inverse_mass) ** 2 for layer in self.layers]
        for contact in self.contacts:
            # The other methods have no stiffness, so that they do not shorten the step.
            if contact.method == "penalty":
                added.append(self._penalties(contact))
        if self.liquid is not None:
            wet = self.liquid
            coupled = wet.density * jnp.sum(wet.outward**2 * self.inverse_mass[wet.wall], axis=1) / wet.mass[wet.wet]
            most = jnp.max(coupled * wet.free[wet.wet])
            if (cover := wet.cover) is not None:  # its nodes and the wall above them, beside the wall at the surface
                over = jnp.sum((cover.width[:, None] * cover.shares) ** 2 * self.inverse_mass[cover.wall, 1], axis=1)
                over = jnp.max(wet.density * over / wet.mass[cover.surface])
                most = jnp.maximum(most, over + jnp.max(coupled * (1.0 - wet.free[wet.wet]), initial=0.0))
            added.append(most)
            if wet.plate is not None:
                added.append(wet.plate.fastest(wet.mass, wet.free, self.inverse_mass))
            fastest = jnp.maximum(fastest, wet.fastest() ** 2)
        # By Weyl's inequality the largest eigenvalues of all parts add up to a bound of the largest of their sum.
        return 2.0 / jnp.sqrt(fastest + sum(added, jnp.zeros(())))

    def _penalties(self, contact: NodeContact) -> Float[Array, ""]:
        """Return what a contact's penalties add to the square of a frequency, at most [1/s²]: all nodes press on a
        rigid plane together, two at most on a segment."""
        surface = contact.surface
        stiffness = jnp.broadcast_to(jnp.asarray(contact.stiffness, float), (len(contact.slaves),))
        if isinstance(surface, Segments):
            others = 2.0 * jnp.max(stiffness) * jnp.max(self.inverse_mass[surface.ends])
        else:
            others = jnp.sum(stiffness) * jnp.max(self.inverse_mass[surface.node])
        return jnp.max(stiffness[:, None] * self.inverse_mass[contact.slaves]) + others


class State(NamedTuple):
    """Where everything is at an instant t.

    - ``time``: t [s].
    - ``displacement``: (nodes, 2) at t [m]; ``velocity``: (nodes, 2) half a step before [m/s].
    - ``histories``: of the elements' points.
    - ``pressure``: (liquid,) at t, beyond the static one [Pa]; ``pressure_rate``: half a step before [Pa/s];
      ``impulse``: ∫p dt, half a step before [Pa s]; ``raised``: volume that has gone up through a covered surface [m²];
      ``through``: flow through a plate, half a step before [m/s].
    - ``pressed``: each contact's normal forces over the step before [N].
    - ``contact_work``: energy that contacts and layers have taken up so far [J].
    - ``released``: elastic energy of deleted elements, ``lost``: energy lost in a plate's holes [J].
    """

    time: Float[Array, ""]
    displacement: Float[Array, "nodes 2"]
    velocity: Float[Array, "nodes 2"]
    histories: tuple[PlasticHistory, ...]
    pressure: Float[Array, " liquid"]
    pressure_rate: Float[Array, " liquid"]
    impulse: Float[Array, " liquid"]
    raised: Float[Array, " surface"]
    through: Float[Array, " holes"]
    pressed: tuple[Float[Array, " pairs"], ...]
    contact_work: Float[Array, ""]
    released: Float[Array, ""]
    lost: Float[Array, ""]


class Energies(NamedTuple):
    """At an instant, all in [J]; their sum does not change (M127, M149).

    - ``kinetic``: of nodes; ``stored``: elastic; ``plastic``: work; ``contact``: taken up by contacts and cushions;
      ``liquid``: of compression and motion, with a gas above it; ``potential``: of gravity and constant
      loads; ``released``: by deletion; ``holes``: lost where the liquid flows through a plate.
    """

    kinetic: Float[Array, ""]
    stored: Float[Array, ""]
    plastic: Float[Array, ""]
    contact: Float[Array, ""]
    liquid: Float[Array, ""]
    potential: Float[Array, ""]
    released: Float[Array, ""]
    holes: Float[Array, ""]


class Instant(NamedTuple):
    """What is known of an instant once its step is taken.

    - ``time`` [s], ``displacement`` (nodes, 2) [m], ``velocity`` (nodes, 2) [m/s].
    - ``resistances``: of each group of elements.
    - ``contacts``, ``layers``: the forces of each.
    - ``pressure``: (liquid,) beyond the static one [Pa].
    - ``energies``: all of them.
    """

    time: Scalar
    displacement: Float[Array, "nodes 2"]
    velocity: Float[Array, "nodes 2"]
    resistances: tuple[Resistance, ...]
    contacts: tuple[NodeContactForces, ...]
    layers: tuple[NodeContactForces, ...]
    pressure: Float[Array, " liquid"]
    energies: Energies


Near = tuple[np.ndarray | Array | None, ...]
