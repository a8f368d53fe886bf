"""Damping matrices of a flexible body's modes."""

import jax.numpy as jnp

from ..._types import Scalar
from .modes import Modal, ModalMatrix


def rayleigh_damping(mass_matrix: ModalMatrix, stiffness: ModalMatrix, alpha: Scalar, beta: Scalar) -> ModalMatrix:
    """Return the (modes, modes) matrix C = α M + β K [N s/m] (M117).

    **Arguments:** ``mass_matrix``, ``stiffness``: (modes, modes) M [kg] and K [N/m]; ``alpha``: [1/s]; ``beta``: [s].

    Rayleigh 1877.

    >>> import jax.numpy as jnp
    >>> float(rayleigh_damping(jnp.array([[2.0]]), jnp.array([[300.0]]), 0.5, 0.01)[0, 0])
    4.0
    """
    return alpha * mass_matrix + beta * stiffness


def modal_damping(mass_matrix: ModalMatrix, stiffness: ModalMatrix, ratio: Scalar | Modal) -> ModalMatrix:
    """Return the (modes, modes) C that gives each natural mode of M and K its ratio of critical damping [N s/m] (M117).

    LAPACK solves the eigenproblem: not for use inside a run.

    **Arguments:** ``mass_matrix``, ``stiffness``: (modes, modes) M [kg] and K [N/m]; ``ratio``: ζ of all modes, or
    (modes,) in ascending order of the frequencies [-].

    >>> import jax.numpy as jnp
    >>> round(float(modal_damping(jnp.array([[2.0]]), jnp.array([[200.0]]), 0.01)[0, 0]), 12)  # 2 ζ √(k m)
    0.4
    """
    # By the Cholesky factor the general eigenproblem becomes a symmetric one.
    lower = jnp.linalg.cholesky(mass_matrix)
    half = jnp.linalg.solve(lower, stiffness)
    values, vectors = jnp.linalg.eigh(jnp.linalg.solve(lower, half.T))
    momenta = lower @ vectors  # M times the mass-normalised modes
    return momenta @ jnp.diag(2.0 * ratio * jnp.sqrt(values)) @ momenta.T


def uncoupled_damping(mass: Modal, stiffness: Modal, ratio: Scalar | Modal) -> ModalMatrix:
    """Return the (modes, modes) matrix of `modal_damping` for diagonal M and K, without an eigenproblem (M117).

    **Arguments:** ``mass``, ``stiffness``: (modes,) the diagonals [kg], [N/m]; ``ratio``: ζ, one or (modes,) [-].
    """
    return jnp.diag(2.0 * ratio * jnp.sqrt(mass * stiffness))
