"""Failure criteria of a ply in plane stress, each as a reserve factor, by which the stress may grow (M152 to M155)."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

import jax.numpy as jnp
from jaxtyping import Array, Bool, Float

from .._types import Scalar

PlyStress = Float[Array, "*plies 3"]
"""σ1 along the fibres, σ2 across them, τ12 [Pa]."""


class Strength(NamedTuple):
    """The strengths of a ply, all positive [Pa].

    - ``along_tension``, ``along_compression``: X_t, X_c along the fibres.
    - ``across_tension``, ``across_compression``: Y_t, Y_c across them.
    - ``shear``: S.
    """

    along_tension: Scalar
    along_compression: Scalar
    across_tension: Scalar
    across_compression: Scalar
    shear: Scalar


def maximum_stress(stress: PlyStress, strength: Strength) -> Float[Array, "*plies"]:
    """Return the reserve factor by maximum stress (M152): no part of the stress knows of another.

    **Arguments:** ``stress``: (…, 3) σ1, σ2, τ12 [Pa]; ``strength``: of the ply.

    **Returns:** (…,) the factor by which the stress may grow [-]; infinite without stress.

    **Example:**

    >>> steel_like = Strength(400e6, 400e6, 400e6, 400e6, 231e6)
    >>> f"{float(maximum_stress(jnp.array([200e6, -100e6, 0.0]), steel_like)):.2f}"
    '2.00'
    """
    along, across, shear = _parts(stress)
    x, y = _by_sign(stress, strength)
    return 1.0 / jnp.maximum(jnp.maximum(jnp.abs(along) / x, jnp.abs(across) / y), jnp.abs(shear) / strength.shear)


def tsai_hill(stress: PlyStress, strength: Strength) -> Float[Array, "*plies"]:
    """Return the reserve factor by Tsai and Hill (M153), the strengths chosen by the signs of σ1 and σ2.

    **Arguments:** ``stress``: (…, 3) σ1, σ2, τ12 [Pa]; ``strength``: of the ply.

    **Returns:** (…,) the factor by which the stress may grow [-]; infinite without stress.

    **Example:** a 60° ply of graphite and epoxy under 2, -3 and 4 MPa.

    >>> graphite = Strength(1500e6, 1500e6, 40e6, 246e6, 68e6)
    >>> f"{float(tsai_hill(jnp.array([1.714102e6, -2.714102e6, -4.165064e6]), graphite)):.4f}"
    '16.0607'
    """
    along, across, shear = _parts(stress)
    x, y = _by_sign(stress, strength)
    index = (along / x) ** 2 - along * across / x**2 + (across / y) ** 2 + (shear / strength.shear) ** 2
    return 1.0 / jnp.sqrt(index)


def hoffman(stress: PlyStress, strength: Strength) -> Float[Array, "*plies"]:
    """Return the reserve factor by Hoffman (M154): `tsai_wu` with another interaction of σ1 and σ2, -1/(X_t X_c).

    **Arguments:** ``stress``: (…, 3) σ1, σ2, τ12 [Pa]; ``strength``: of the ply, `is_bounded` or the criterion allows
    some stresses without limit.

    **Returns:** (…,) the factor by which the stress may grow [-]; infinite without stress.
    """
    return _quadratic(stress, strength, _hoffman_interaction(strength))


def tsai_wu(stress: PlyStress, strength: Strength, interaction: Scalar = -0.5) -> Float[Array, "*plies"]:
    """Return the reserve factor by Tsai and Wu (M155).

    **Arguments:** ``stress``: (…, 3) σ1, σ2, τ12 [Pa]; ``strength``: of the ply; ``interaction``: F12/√(F11 F22), whose
    size must be below 1 [-].

    **Returns:** (…,) the factor by which the stress may grow [-]; infinite without stress.
    """
    return _quadratic(stress, strength, 2.0 * interaction * jnp.sqrt(_f11(strength) * _f22(strength)))


def is_bounded(strength: Strength) -> Bool[Array, ""]:
    """Return whether Hoffman's criterion limits every plane stress: F12² < F11 F22, where it is an ellipse."""
    return jnp.asarray((_hoffman_interaction(strength) / 2.0) ** 2 < _f11(strength) * _f22(strength))


Criterion = Callable[[PlyStress, Strength], Float[Array, "*plies"]]
CRITERIA: Mapping[str, Criterion] = MappingProxyType(
    {"tsai-hill": tsai_hill, "hoffman": hoffman, "tsai-wu": tsai_wu, "maximum-stress": maximum_stress}
)
"""The criteria by name."""


def _quadratic(stress: PlyStress, strength: Strength, twice_f12: Scalar) -> Float[Array, "*plies"]:
    """Return the positive root RF of A RF² + B RF = 1, where A holds the quadratic terms and B the linear ones."""
    along, across, shear = _parts(stress)
    x_t, x_c, y_t, y_c, s = strength
    linear = (1.0 / x_t - 1.0 / x_c) * along + (1.0 / y_t - 1.0 / y_c) * across
    quadratic = _f11(strength) * along**2 + _f22(strength) * across**2 + twice_f12 * along * across + (shear / s) ** 2
    return 2.0 / (
        linear + jnp.sqrt(linear**2 + 4.0 * quadratic)
    )  # without a difference of equal numbers where A is small


def _f11(strength: Strength) -> Scalar:
    return 1.0 / (strength.along_tension * strength.along_compression)


def _f22(strength: Strength) -> Scalar:
    return 1.0 / (strength.across_tension * strength.across_compression)


def _hoffman_interaction(strength: Strength) -> Scalar:
    return -_f11(strength)


def _parts(stress: PlyStress) -> tuple[Array, Array, Array]:
    return stress[..., 0], stress[..., 1], stress[..., 2]


def _by_sign(stress: PlyStress, strength: Strength) -> tuple[Array, Array]:
    """Return X and Y, of tension or of compression."""
    along, across, _ = _parts(stress)
    # Fibres and matrix fail at other stresses when they are pressed than when they are pulled.
    x = jnp.where(along < 0.0, strength.along_compression, strength.along_tension)
    return x, jnp.where(across < 0.0, strength.across_compression, strength.across_tension)
