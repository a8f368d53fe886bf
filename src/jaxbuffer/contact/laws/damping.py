"""Damping factors χ̂(e): how much an author's law damps for the restitution e that it is asked for.

Each comes from an energy argument of its own. A factor goes with any elastic force: the restitution that two free
bodies then get follows from χ̂ alone (M46), whatever the force.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import jax.numpy as jnp

from ..._types import Scalar
from ...errors import check_choice
from .restitution import damping_delivering


def none(restitution: Scalar) -> Scalar:
    """Return χ̂ = 0, no loss (M38), whatever the ``restitution`` e [-]."""
    return 0.0


def hunt_crossley(restitution: Scalar) -> Scalar:
    """Return χ̂ = 3 (1 - e)/2 (M39). ``restitution``: e [-]."""
    return 1.5 * (1.0 - restitution)


def herbert_mcwhannell(restitution: Scalar) -> Scalar:
    """Return χ̂ = 6 (1 - e)/((2 e - 1)² + 3) (M40). ``restitution``: e [-]."""
    return 6.0 * (1.0 - restitution) / ((2.0 * restitution - 1.0) ** 2 + 3.0)


def lankarani_nikravesh(restitution: Scalar) -> Scalar:
    """Return χ̂ = 3 (1 - e²)/4 (M41). ``restitution``: e [-]."""
    return 0.75 * (1.0 - restitution * restitution)


def lee_wang(restitution: Scalar) -> Scalar:
    """Return χ̂ = 3 (1 - e)/4 (M42). ``restitution``: e [-]."""
    return 0.75 * (1.0 - restitution)


def gonthier(restitution: Scalar) -> Scalar:
    """Return χ̂ = (1 - e²)/e (M43). ``restitution``: e [-]."""
    return (1.0 - restitution * restitution) / restitution


def flores(restitution: Scalar) -> Scalar:
    """Return χ̂ = 8 (1 - e)/(5 e) (M44). ``restitution``: e [-]."""
    return 1.6 * (1.0 - restitution) / restitution


def hu_guo(restitution: Scalar) -> Scalar:
    """Return χ̂ = 3 (1 - e)/(2 e) (M45). ``restitution``: e [-]."""
    return 1.5 * (1.0 - restitution) / restitution


def carvalho_martins(restitution: Scalar) -> Scalar:
    """Return χ̂ = 3 (1 - e) (11 - e)/(2 (1 + 9 e)), below e = 1/3 Gonthier's (M93). ``restitution``: e [-]."""
    e = restitution  # at 1/3 both are 8/3
    return jnp.where(3.0 * e < 1.0, gonthier(e), 1.5 * (1.0 - e) * (11.0 - e) / (1.0 + 9.0 * e))


DAMPING_FACTORS: Mapping[str, Callable[[Scalar], Scalar]] = MappingProxyType(
    {
        "lankarani-nikravesh": lankarani_nikravesh,
        "none": none,
        "hunt-crossley": hunt_crossley,
        "herbert-mcwhannell": herbert_mcwhannell,
        "lee-wang": lee_wang,
        "gonthier": gonthier,
        "flores": flores,
        "hu-guo": hu_guo,
        "carvalho-martins": carvalho_martins,
        "exact": damping_delivering,
    }
)
"""χ̂(e) by author, named as the laws are; "exact" solves M46, so that two free bodies part at e times their speed."""


def damping_factor(name: str, restitution: Scalar) -> Scalar:
    """Return χ̂ [-] of an author for a restitution.

    **Arguments:** ``name``: a key of `DAMPING_FACTORS`; ``restitution``: e in (0, 1] that is asked for [-].

    **Raises:** `InputError` for a name that is none of them.

    >>> from jaxbuffer.contact.laws import damping_factor
    >>> f"{damping_factor('lankarani-nikravesh', 0.9):.4f}, {float(damping_factor('exact', 0.9)):.4f}"
    '0.1425, 0.1665'
    """
    check_choice("damping", name, DAMPING_FACTORS)
    return DAMPING_FACTORS[name](restitution)
