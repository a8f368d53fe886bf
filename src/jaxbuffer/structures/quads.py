"""Plane four-node elements in a total Lagrangian description, with an assumed strain that neither locks nor lets
hourglasses go (M130 to M133)."""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from .._types import Scalar
from ..errors import InputError, concrete
from .incidence import Incidence
from .mapping import SIGNS, Mapping, Rule
from .strain import logarithmic

HOURGLASS = SIGNS[:, 0] * SIGNS[:, 1]  # ξη at the corners


class Quads(NamedTuple):
    """Four-node elements of one unit of depth, corners counter-clockwise.

    Strains are in each element's own axes: the first goes from the middle of its side 4-1 to that of its side 2-3.

    - ``incidence``: which nodes the corners are.
    - ``axes``: (elements, 2, 2) the own axes as rows [-].
    - ``gradient``: (elements, 4, 2) the mean of ∂N/∂X in own axes [1/m].
    - ``hourglass``: (elements, 4) γ: how much of ξη is in the corners' displacements [-].
    - ``hourglass_gradient``: (elements, points, 2) ∂(ξη)/∂X at the integration points [1/m].
    - ``weight``: (elements, points) area of each integration point [m²].
    """

    incidence: Incidence
    axes: Float[Array, "elements 2 2"]
    gradient: Float[Array, "elements 4 2"]
    hourglass: Float[Array, "elements 4"]
    hourglass_gradient: Float[Array, "elements points 2"]
    weight: Float[Array, "elements points"]

    @staticmethod
    def of(positions: Float[Array, "nodes 2"], corners: np.ndarray, across: int = 2) -> "Quads":
        """Make elements from the nodes' positions [m] and the corners' nodes (elements, 4); differentiable by the
        positions.

        ``across``: integration points from side 1-2 to side 3-4. Two are enough where nothing yields; four see a wall
        of one element yield from its faces inwards, and carry 1.62 times the moment at which that begins when all of it
        has (exactly: 1.5; two: 1.73 times, and it begins only then).

        Raises `InputError` where corners are not counter-clockwise.
        """
        rule = Rule.of(across)
        incidence = Incidence.of(corners, len(positions))
        at = incidence.to_corners(jnp.asarray(positions, float))
        along = at[:, 1] + at[:, 2] - at[:, 0] - at[:, 3]
        first = along / jnp.linalg.norm(along, axis=1, keepdims=True)
        axes = jnp.stack([first, jnp.stack([-first[:, 1], first[:, 0]], axis=1)], axis=1)
        own = jnp.einsum("eij,ecj->eci", axes, at)
        weight, inverse, at_points = Mapping.of(own, rule)
        # Traced positions have no values yet to check.
        if (known := concrete(weight)) is not None and (turned := known.min(axis=1) <= 0.0).any():
            raise InputError(f"corners of element {turned.argmax()} are not counter-clockwise, or it is folded")
        gradient = jnp.einsum("ep,epci->eci", weight, at_points) / jnp.sum(weight, axis=1)[:, None, None]
        linear = jnp.einsum("c,eci->ei", HOURGLASS, own)
        hourglass = 0.25 * (HOURGLASS[None] - jnp.einsum("ei,eci->ec", linear, gradient))
        # Of the shape functions only ξη is not linear: its gradient is all that varies over an element.
        turned = jnp.einsum("pk,epki->epi", rule.points[:, ::-1], inverse)  # ∂(ξη)/∂(ξ, η) = (η, ξ)
        return Quads(incidence, axes, gradient, hourglass, turned, weight)

    @property
    def area(self) -> Float[Array, " elements"]:
        """Return the area of each element [m²]."""
        return jnp.sum(self.weight, axis=1)

    def strains(
        self, displacements: Float[Array, "elements 4 2"], coupling: Float[Array, " 2"]
    ) -> Float[Array, "elements points 3"]:
        """Return the logarithmic strains (ε11, ε22, γ12) at the integration points, in own axes.

        The mean deformation gradient gives the constant part. In bending the element stretches along its length as it
        should, narrows across it by ``coupling`` of that, so that no stress across stands against it, and is not
        sheared (Belytschko and Bindeman 1991, there of small strains; here of C; M131).

        **Arguments:** ``displacements``: (elements, 4, 2) of the corners [m]; ``coupling``: strain across over strain
        along the first and the second own axis where no stress acts across [-].
        """
        mean = jnp.swapaxes(self.axes, 1, 2) + jnp.einsum("eci,eck->eik", displacements, self.gradient)
        metric = jnp.einsum("eik,eil->ekl", mean, mean)  # C
        bent = jnp.einsum("eik,eci,ec->ek", mean, displacements, self.hourglass)
        stretch = 2.0 * bent[:, None, :] * self.hourglass_gradient
        c11 = metric[:, 0, 0, None] + stretch[..., 0] - coupling[1] * stretch[..., 1]
        c22 = metric[:, 1, 1, None] + stretch[..., 1] - coupling[0] * stretch[..., 0]
        return logarithmic(c11, c22, jnp.broadcast_to(metric[:, 0, 1, None], c11.shape))

    def varying(self, strain: Float[Array, "elements points 2"]) -> Float[Array, "elements points 3"]:
        """Return what varies of (ε11, ε22) along the own axis of each, as a strain; its mean over an element is
        zero."""
        by_axis = strain.reshape(len(strain), -1, 2, 2)  # element, along axis 2, along axis 1, component
        weight = self.weight.reshape(by_axis.shape[:3])
        columns = jnp.sum(weight * by_axis[..., 0], axis=1, keepdims=True) / jnp.sum(weight, axis=1, keepdims=True)
        layers = jnp.sum(weight * by_axis[..., 1], axis=2, keepdims=True) / jnp.sum(weight, axis=2, keepdims=True)
        both = [jnp.broadcast_to(part, weight.shape).reshape(self.weight.shape) for part in (columns, layers)]
        apart = [part - (jnp.sum(self.weight * part, axis=1) / self.area)[:, None] for part in both]
        return jnp.stack([*apart, jnp.zeros_like(self.weight)], axis=-1)

    def lumped_mass(self, density: Scalar) -> Float[Array, " nodes"]:
        """Return the (nodes,) lumped masses, a quarter of each element's mass at each of its corners [kg] (M129).
        ``density``: [kg/m³], one or one an element; times one metre of depth."""
        quarter = jnp.broadcast_to(0.25 * density * self.area, self.area.shape)
        return self.incidence.to_nodes(jnp.repeat(quarter[:, None], 4, axis=1))

    def in_own_axes(self, stress: Float[Array, "elements points 3"]) -> Float[Array, "elements points 3"]:
        """Turn the stresses (σ11, σ22, σ12), given in own axes, into those of the plane: σxx, σyy, σxy."""
        c, s = self.axes[:, 0, 0, None], self.axes[:, 0, 1, None]
        s11, s22, s12 = stress[..., 0], stress[..., 1], stress[..., 2]
        return jnp.stack(
            [
                c * c * s11 + s * s * s22 - 2.0 * c * s * s12,
                s * s * s11 + c * c * s22 + 2.0 * c * s * s12,
                c * s * (s11 - s22) + (c * c - s * s) * s12,
            ],
            axis=-1,
        )


def at_faces(values: Float[Array, "elements points *rest"]) -> Float[Array, "elements 4 *rest"]:
    """Return the values on the faces of a wall that is one element thick: two values on the side 1-2, then two on 3-4.
    More than two points across have some there; what two have is followed in straight lines."""
    first, last = values[:, :2], values[:, -2:]
    if values.shape[1] == 4:
        # Gauss's two points lie at ±1/√3 of the way to the faces.
        mean, half = 0.5 * (first + last), 0.5 * np.sqrt(3.0) * (last - first)
        first, last = mean - half, mean + half
    return jnp.concatenate([first, last], axis=1)


T = TypeVar("T")


def nodal_forces(
    quads: Quads,
    displacements: Float[Array, "elements 4 2"],
    coupling: Float[Array, " 2"],
    stress_of: Callable[[Array], tuple[Array, T]],
) -> tuple[Float[Array, "elements 4 2"], T]:
    """Return the forces with which the elements resist, at their corners, by the principle of virtual work (M133).

    **Arguments:** ``quads``; ``displacements``: of the corners [m]; ``coupling``: as of `Quads.strains`; ``stress_of``:
    strains (elements, points, 3) → stresses (σ11, σ22, σ12) [Pa], conjugate to the logarithmic strain, and more.

    **Returns:** forces (elements, 4, 2) [N per metre of depth], and that.
    """
    # Virtual work: forces are the transpose of the strain's derivative times the stresses, which is what reverse mode
    # does.
    strain, pull_back = jax.vjp(lambda u: quads.strains(u, coupling), displacements)
    stress, answer = stress_of(strain)
    return pull_back(stress * quads.weight[..., None])[0], answer
