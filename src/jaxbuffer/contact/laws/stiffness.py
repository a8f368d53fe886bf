"""Hertz's stiffness from materials and radii (M53, M54).

It is valid while the contact's radius √(R δ) is small against every radius, which a socket that fits closely violates
first.
"""

from ..._types import Scalar
from ...errors import InputError, concrete

YOUNG, POISSON = 71.7e9, 0.3  # Pa, -: aluminium, the paper's section 7


def hertz_stiffness(
    radius: Scalar,
    young_1: Scalar = YOUNG,
    poisson_1: Scalar = POISSON,
    young_2: Scalar = YOUNG,
    poisson_2: Scalar = POISSON,
) -> Scalar:
    """Return K of a ball on a plane [N/m^1.5] (M53).

    **Arguments:**

    - ``radius``: of the ball [m].
    - ``young_1``, ``young_2``: Young's moduli of ball and plane [Pa].
    - ``poisson_1``, ``poisson_2``: their Poisson's ratios [-].
    """
    return ball_stiffness(radius, contact_compliance(young_1, poisson_1, young_2, poisson_2))


def ball_stiffness(radius: Scalar, compliance: Scalar) -> Scalar:
    """Return K of a ball on a plane [N/m^1.5] (M53).

    **Arguments:** ``radius``: of the ball, or what M54 puts in its place [m]; ``compliance``: 1/E* = σ₁ + σ₂ [1/Pa].
    """
    return 4.0 * radius**0.5 / (3.0 * compliance)


def contact_compliance(
    young_1: Scalar = YOUNG, poisson_1: Scalar = POISSON, young_2: Scalar = YOUNG, poisson_2: Scalar = POISSON
) -> Scalar:
    """Return 1/E* = σ₁ + σ₂ of two bodies [1/Pa] (M53).

    **Arguments:** ``young_1``, ``young_2``: Young's moduli [Pa]; ``poisson_1``, ``poisson_2``: Poisson's ratios [-].
    """
    return (1.0 - poisson_1**2) / young_1 + (1.0 - poisson_2**2) / young_2


def contact_modulus(
    young_1: Scalar = YOUNG, poisson_1: Scalar = POISSON, young_2: Scalar = YOUNG, poisson_2: Scalar = POISSON
) -> Scalar:
    """Return E* of two bodies [Pa], Young's modulus over 1 - ν² of both in series (M95).

    **Arguments:** ``young_1``, ``young_2``: Young's moduli [Pa]; ``poisson_1``, ``poisson_2``: Poisson's ratios [-].

    >>> from jaxbuffer.contact.laws import contact_modulus
    >>> f"{contact_modulus(207e9, 0.3, 207e9, 0.3):.6g} Pa"
    '1.13736e+11 Pa'
    """
    return 1.0 / contact_compliance(young_1, poisson_1, young_2, poisson_2)


def two_spheres_stiffness(radius_1: Scalar, radius_2: Scalar, *materials: Scalar) -> Scalar:
    """Return K of two balls [N/m^1.5] (M54).

    **Arguments:** ``radius_1``, ``radius_2``: of the balls [m]; ``materials``: as for `hertz_stiffness`.
    """
    return hertz_stiffness(radius_1 * radius_2 / (radius_1 + radius_2), *materials)


def socket_stiffness(radius: Scalar, socket_radius: Scalar, *materials: Scalar) -> Scalar:
    """Return K of a ball in a spherical socket [N/m^1.5] (M54).

    **Arguments:** ``radius``, ``socket_radius``: of ball and socket [m]; ``materials``: as for `hertz_stiffness`.

    **Raises:** `InputError` unless the socket is the larger.
    """
    # Traced numbers have no value yet to compare.
    ball, socket = concrete(radius), concrete(socket_radius)
    if ball is not None and socket is not None and not (ball < socket).all():
        raise InputError(f"socket_radius = {socket_radius:g} m must be above the ball's radius, {radius:g} m")
    return hertz_stiffness(radius * socket_radius / (socket_radius - radius), *materials)
