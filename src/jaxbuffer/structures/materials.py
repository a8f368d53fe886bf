"""Materials of plane elements: elastic, orthotropic, and plastic after von Mises (M134 to M137).

Strains are logarithmic, stresses conjugate to them, both in an element's own axes. Under plane strain nothing stretches
across the plane.
"""

from typing import NamedTuple

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .._types import Scalar, stacked


class PlasticHistory(NamedTuple):
    """What integration points remember.

    - ``plastic``: (…, 3) plastic strain (ε11, ε22, ε12) [-].
    - ``equivalent``: (…,) equivalent plastic strain [-].
    """

    plastic: Float[Array, "*points 3"]
    equivalent: Float[Array, " *points"]

    @staticmethod
    def none(*points: int) -> "PlasticHistory":
        """Return the history of points that have never yielded."""
        return PlasticHistory(jnp.zeros((*points, 3)), jnp.zeros(points))


class Stressed(NamedTuple):
    """What a material answers to a strain.

    - ``stress``: (…, 4) σ11, σ22, σ12, σ33 [Pa].
    - ``history``: what is remembered from now on.
    - ``stored``: elastic energy [J/m³].
    """

    stress: Float[Array, "*points 4"]
    history: PlasticHistory
    stored: Float[Array, " *points"]


class Material(eqx.Module):
    """Base of the materials. ``density`` [kg/m³] is every material's."""

    density: Scalar

    def coupling(self) -> Float[Array, " 2"]:
        """Return the strain across over the strain along own axis 1, and 2, where no stress acts across, with its sign
        changed [-]."""
        raise NotImplementedError

    def answer(self, strain: Float[Array, "*points 3"], history: PlasticHistory) -> Stressed:
        """Return the stress and what follows. ``strain``: (ε11, ε22, γ12) [-]."""
        raise NotImplementedError

    def wave_speed(self) -> Float[Array, ""]:
        """Return the speed of the fastest wave [m/s]."""
        raise NotImplementedError

    def plastic_work(self, history: PlasticHistory) -> Float[Array, " *points"]:
        """Return the work that yielding has taken so far [J/m³]."""
        return jnp.zeros(history.equivalent.shape)

    def flowed_across(self, history: PlasticHistory) -> Float[Array, "*points 2"] | None:
        """Return by how much own axis 1, and 2, is strained by what has flowed so far, where no stress acts along it
        and the other axis is held [-]; None where nothing flows."""
        return None

    def failed(self, history: PlasticHistory) -> Bool[Array, " *points"]:
        """Return which points carry nothing any more."""
        return jnp.zeros(history.equivalent.shape, bool)


class Elastic(Material):
    """Isotropic and elastic (M134).

    - ``density``: [kg/m³].
    - ``young``: E [Pa].
    - ``poisson``: ν [-].
    - ``plane``: "strain", nothing stretches across the plane, or "stress", nothing presses across it.
    """

    density: Scalar
    young: Scalar
    poisson: Scalar
    plane: str = eqx.field(default="strain", static=True)

    @property
    def shear_modulus(self) -> Scalar:
        """Return μ [Pa]."""
        return self.young / (2.0 * (1.0 + self.poisson))

    @property
    def lame(self) -> Scalar:
        """Return λ of the plane: of plane stress what follows where σ33 vanishes [Pa]."""
        if self.plane == "stress":
            return self.young * self.poisson / (1.0 - self.poisson**2)
        return self.young * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))

    def coupling(self) -> Float[Array, " 2"]:
        across = self.poisson if self.plane == "stress" else self.poisson / (1.0 - self.poisson)
        return stacked([across, across])

    def answer(self, strain: Float[Array, "*points 3"], history: PlasticHistory) -> Stressed:
        e11, e22, g12 = strain[..., 0], strain[..., 1], strain[..., 2]
        both, twice = self.lame * (e11 + e22), 2.0 * self.shear_modulus
        s33 = jnp.zeros_like(both) if self.plane == "stress" else both
        stress = jnp.stack([both + twice * e11, both + twice * e22, 0.5 * twice * g12, s33], axis=-1)
        stored = 0.5 * jnp.sum(stress[..., :3] * strain, axis=-1)
        return Stressed(stress, history, stored)

    def wave_speed(self) -> Float[Array, ""]:
        return jnp.sqrt((self.lame + 2.0 * self.shear_modulus) / self.density)


class Orthotropic(Material):
    """Orthotropic and elastic, under plane strain (M135); axis 1 along an element's length, 2 across it, 3 across the
    plane.

    - ``density``: [kg/m³].
    - ``young``: (3,) E1, E2, E3 [Pa].
    - ``poisson``: (3,) ν12, ν13, ν23 [-].
    - ``shear``: G12 [Pa].
    """

    density: Scalar
    young: Float[Array, " 3"]
    poisson: Float[Array, " 3"]
    shear: Scalar

    def _compliance(self) -> Float[Array, "3 3"]:
        e1, e2, e3 = (jnp.asarray(self.young, float)[k] for k in range(3))
        v12, v13, v23 = (jnp.asarray(self.poisson, float)[k] for k in range(3))
        rows = [1.0 / e1, -v12 / e1, -v13 / e1, -v12 / e1, 1.0 / e2, -v23 / e2, -v13 / e1, -v23 / e2, 1.0 / e3]
        return stacked(rows).reshape(3, 3)

    def strain_along(self, stress: Float[Array, "*points 4"]) -> Float[Array, " *points"]:
        """Return ε11 [-] from σ11, σ22, σ12, σ33 [Pa]."""
        first = self._compliance()[0]
        return first[0] * stress[..., 0] + first[1] * stress[..., 1] + first[2] * stress[..., 3]

    def _stiffness(self) -> Float[Array, "3 2"]:
        """Return σ11, σ22, σ33 from ε11, ε22 [Pa]."""
        return jnp.linalg.inv(self._compliance())[:, :2]

    def coupling(self) -> Float[Array, " 2"]:
        stiff = self._stiffness()
        return stacked([stiff[1, 0] / stiff[1, 1], stiff[0, 1] / stiff[0, 0]])

    def answer(self, strain: Float[Array, "*points 3"], history: PlasticHistory) -> Stressed:
        stiff = self._stiffness()
        normal = [stiff[k, 0] * strain[..., 0] + stiff[k, 1] * strain[..., 1] for k in range(3)]
        stress = jnp.stack([normal[0], normal[1], self.shear * strain[..., 2], normal[2]], axis=-1)
        stored = 0.5 * jnp.sum(stress[..., :3] * strain, axis=-1)
        return Stressed(stress, history, stored)

    def wave_speed(self) -> Float[Array, ""]:
        stiff = self._stiffness()
        return jnp.sqrt(jnp.maximum(stiff[0, 0], stiff[1, 1]) / self.density)


class Plastic(Material):
    """Plastic after von Mises with linear isotropic hardening, under plane strain (M136, M137); what has strained too
    far fails.

    - ``density``: [kg/m³].
    - ``young``, ``poisson``: E [Pa], ν [-].
    - ``yield_stress``: σ_y at first [Pa].
    - ``hardening``: dσ_y/dε̄ [Pa].
    - ``failure_strain``: the equivalent plastic strain of a point that carries nothing any more [-].
    """

    density: Scalar
    young: Scalar
    poisson: Scalar
    yield_stress: Scalar
    hardening: Scalar
    failure_strain: Scalar

    @property
    def elastic(self) -> Elastic:
        """Return the same material before it yields."""
        return Elastic(self.density, self.young, self.poisson)

    def coupling(self) -> Float[Array, " 2"]:
        return self.elastic.coupling()

    def wave_speed(self) -> Float[Array, ""]:
        return self.elastic.wave_speed()

    def answer(self, strain: Float[Array, "*points 3"], history: PlasticHistory) -> Stressed:
        shear = self.elastic.shear_modulus
        bulk = self.elastic.lame + 2.0 * shear / 3.0
        p11, p22, p12 = (history.plastic[..., k] for k in range(3))
        volume = strain[..., 0] + strain[..., 1]
        # Flow keeps the volume: across the plane -p11 - p22 has flowed, and where nothing is strained the elastic part
        # is minus that.
        elastic = (strain[..., 0] - p11, strain[..., 1] - p22, p11 + p22, 0.5 * strain[..., 2] - p12)  # 11, 22, 33, 12
        trial = [2.0 * shear * (part - volume / 3.0) for part in elastic[:3]] + [2.0 * shear * elastic[3]]
        squared = 1.5 * (trial[0] ** 2 + trial[1] ** 2 + trial[2] ** 2 + 2.0 * trial[3] ** 2)
        # Guarded: a root of zero has no derivative.
        mises = jnp.sqrt(jnp.where(squared > 0.0, squared, 1.0)) * (squared > 0.0)
        limit = self.yield_stress + self.hardening * history.equivalent
        # Radial return: with linear hardening its equation is linear.
        yielded = jnp.maximum(mises - limit, 0.0) / (3.0 * shear + self.hardening)
        flow = 1.5 * yielded / jnp.where(mises > 0.0, mises, 1.0)  # times the trial deviator: what flows
        left = 1.0 - 2.0 * shear * flow
        deviator = [left * part for part in trial]
        pressure = bulk * volume
        stress = jnp.stack(
            [deviator[0] + pressure, deviator[1] + pressure, deviator[3], deviator[2] + pressure], axis=-1
        )
        plastic = jnp.stack([p11 + flow * trial[0], p22 + flow * trial[1], p12 + flow * trial[3]], axis=-1)
        equivalent = history.equivalent + yielded
        stored = (left * mises) ** 2 / (6.0 * shear) + 0.5 * bulk * volume**2
        return Stressed(stress, PlasticHistory(plastic, equivalent), stored)

    def plastic_work(self, history: PlasticHistory) -> Float[Array, " *points"]:
        return (self.yield_stress + 0.5 * self.hardening * history.equivalent) * history.equivalent

    def flowed_across(self, history: PlasticHistory) -> Float[Array, "*points 2"]:
        across = history.plastic[..., :2]
        return jnp.broadcast_to(1.0 - self.coupling(), across.shape) * across

    def failed(self, history: PlasticHistory) -> Bool[Array, " *points"]:
        return history.equivalent >= self.failure_strain


def mises(stress: Float[Array, "*points 4"]) -> Float[Array, " *points"]:
    """Return the equivalent stress after von Mises [Pa], of (σ11, σ22, σ12, σ33)."""
    s11, s22, s12, s33 = (stress[..., k] for k in range(4))
    squared = 0.5 * ((s11 - s22) ** 2 + (s22 - s33) ** 2 + (s33 - s11) ** 2) + 3.0 * s12**2
    # Guarded: a root of zero has no derivative.
    return jnp.sqrt(jnp.where(squared > 0.0, squared, 1.0)) * (squared > 0.0)
