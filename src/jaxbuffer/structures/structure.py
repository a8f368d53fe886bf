"""A structure of elements: its lumped masses, and the forces with which it resists."""

from typing import NamedTuple, Protocol

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar
from .bars import Bars
from .materials import Material, PlasticHistory, Stressed
from .quads import Quads, nodal_forces


class Resistance(NamedTuple):
    """What elements answer to displacements.

    - ``forces``: (nodes, 2) with which they resist [N].
    - ``history``: what their points remember from now on.
    - ``stress``: (elements, points, 4) σ11, σ22, σ12, σ33 in own axes [Pa].
    - ``stored``, ``plastic``: elastic energy and plastic work so far [J]; ``released``: elastic energy of elements that
      carry nothing from now on [J].
    """

    forces: Float[Array, "nodes 2"]
    history: PlasticHistory
    stress: Float[Array, "elements points 4"]
    stored: Float[Array, ""]
    plastic: Float[Array, ""]
    released: Float[Array, ""]


class Elements(Protocol):
    """A group of elements of one kind and one material."""

    def start(self) -> PlasticHistory:
        """Return what they remember at first."""

    def resist(self, displacement: Float[Array, "nodes 2"], history: PlasticHistory) -> Resistance:
        """Return their answer."""

    def mass(self) -> Float[Array, " nodes"]:
        """Return the (nodes,) lumped masses [kg]."""

    def fastest(self) -> Float[Array, " elements"]:
        """Return the (elements,) highest natural frequencies of each alone, free [rad/s]."""


class Plane(eqx.Module):
    """Four-node elements of one material, a metre deep.

    - ``quads``: the elements.
    - ``material``: theirs.
    """

    quads: Quads
    material: Material

    def start(self) -> PlasticHistory:
        return PlasticHistory.none(*self.quads.weight.shape)

    def resist(self, displacement: Float[Array, "nodes 2"], history: PlasticHistory) -> Resistance:
        """Return the elements' answer. One whose points have all failed is deleted: it carries nothing and remembers no
        more."""
        alive = 1.0 - jnp.all(self.material.failed(history), axis=1)
        # A deleted element may turn inside out, which has no strain: nothing times NaN would be NaN.
        here = jnp.where(alive[:, None, None] > 0.0, self.quads.incidence.to_corners(displacement), 0.0)
        flowed = self.material.flowed_across(history)

        def stress_of(strain: Array) -> tuple[Array, Stressed]:
            strain = strain if flowed is None else strain + self.quads.varying(flowed)
            answer = self.material.answer(strain, history)
            return alive[:, None, None] * answer.stress[..., :3], answer

        forces, answer = nodal_forces(self.quads, here, self.material.coupling(), stress_of)
        # A deleted element stands undeformed here: it would flow backwards, and its plastic work would go on growing.
        since = PlasticHistory(
            *(jnp.where(_beside(alive, new) > 0.0, new, old) for new, old in zip(answer.history, history, strict=True))
        )
        lost = alive * jnp.all(self.material.failed(since), axis=1)
        energy = jnp.sum(self.quads.weight * answer.stored, axis=1)
        return Resistance(
            self.quads.incidence.to_nodes(forces),
            since,
            alive[:, None, None] * answer.stress,
            jnp.sum(alive * energy),
            jnp.sum(self.quads.weight * self.material.plastic_work(since)),
            jnp.sum(lost * energy),
        )

    def mass(self) -> Float[Array, " nodes"]:
        return self.quads.lumped_mass(self.material.density)

    def stiffness(self, displacement: Float[Array, "nodes 2"]) -> Float[Array, "elements 8 8"]:
        """Return the stiffness of each element as it is before it yields [N/m]: forces at its corners from their
        displacements."""
        history, coupling = self.start(), self.material.coupling()
        here = self.quads.incidence.to_corners(displacement)

        def forces(u: Array) -> Array:
            return nodal_forces(
                self.quads, u, coupling, lambda e: (self.material.answer(e, history).stress[..., :3], 0)
            )[0]

        def column(direction: Array) -> Array:
            return jax.jvp(forces, (here,), (jnp.broadcast_to(direction[None], here.shape),))[1]

        # Eight push-forwards for all elements together, since none answers to the corners of another.
        columns = jax.vmap(column)(jnp.eye(8).reshape(8, 4, 2))
        return jnp.moveaxis(columns, 0, -1).reshape(-1, 8, 8)

    def fastest(self) -> Float[Array, " elements"]:
        still = jnp.zeros((len(self.quads.incidence.places), 2))
        quarter = 0.25 * self.material.density * self.quads.area
        # One by one: many at once share XLA's threads, and programs on all of these would wait for each other.
        highest = jax.lax.map(lambda matrix: jnp.linalg.eigvalsh(matrix)[-1], self.stiffness(still))
        return jnp.sqrt(highest / quarter)


class Rods(eqx.Module):
    """Bars of one elastic material.

    - ``bars``: the elements.
    - ``young``, ``density``: E [Pa], [kg/m³].
    """

    bars: Bars
    young: Scalar
    density: Scalar

    def start(self) -> PlasticHistory:
        return PlasticHistory.none(self.bars.length.shape[0], 1)

    def resist(self, displacement: Float[Array, "nodes 2"], history: PlasticHistory) -> Resistance:
        strain = self.bars.strains(self.bars.incidence.to_corners(displacement))
        stress = self.young * strain
        stored = 0.5 * jnp.sum(stress * strain * self.bars.length) * self.bars.section
        along = jnp.zeros((*stress.shape, 1, 4)).at[:, 0, 0].set(stress)
        return Resistance(
            self.bars.incidence.to_nodes(self.bars.forces(stress)), history, along, stored, *(jnp.zeros(()),) * 2
        )

    def mass(self) -> Float[Array, " nodes"]:
        return self.bars.lumped_mass(self.density)

    def fastest(self) -> Float[Array, " elements"]:
        return 2.0 * jnp.sqrt(self.young / self.density) / self.bars.length


def _beside(alive: Array, values: Array) -> Array:
    """Return one number an element, in the shape of its points' numbers."""
    return alive.reshape(-1, *[1] * (values.ndim - 1))
