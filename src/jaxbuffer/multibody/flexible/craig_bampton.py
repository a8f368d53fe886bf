"""Craig and Bampton's reduction of a finite-element model, and the modes that remain beside rigid-body motion.

NumPy and SciPy: this is done once, outside of a run. Matrices may be dense or SciPy's sparse ones.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigh, qr, solve
from scipy.sparse import csr_array
from scipy.sparse.linalg import eigsh, splu

DENSE = 600  # up to so many unknowns matrices are treated as dense ones


class Reduction(NamedTuple):
    """A reduced model: displacements of all nodes are ``basis`` times the reduced coordinates.

    - ``basis``: (unknowns, interface + modes) T: constraint modes, then fixed-interface modes.
    - ``mass``, ``stiffness``: (interface + modes, interface + modes) Tᵀ M T and Tᵀ K T.
    """

    basis: np.ndarray
    mass: np.ndarray
    stiffness: np.ndarray


class Modes(NamedTuple):
    """Uncoupled modes of a model.

    - ``eigenvalues``: (modes,) squared circular frequencies, ascending.
    - ``shapes``: (unknowns, modes) with shapesᵀ M shapes = 1.
    """

    eigenvalues: np.ndarray
    shapes: np.ndarray


def craig_bampton(mass: Any, stiffness: Any, interface: Any, modes: int) -> Reduction:
    """Reduce to the interface's unknowns and to the lowest modes with the interface fixed (M115).

    **Arguments:**

    - ``mass``, ``stiffness``: (unknowns, unknowns) symmetric, NumPy's or SciPy's sparse.
    - ``interface``: (interface,) indices of the unknowns that are kept.
    - ``modes``: number of fixed-interface modes.
    """
    size = mass.shape[0]
    outer = np.asarray(interface, int)
    inner = np.setdiff1d(np.arange(size), outer)
    if not 0 <= modes <= inner.size:
        raise ValueError(f"modes: {modes} is not between 0 and the {inner.size} unknowns inside the interface")
    mass, stiffness = _as_treated(mass), _as_treated(stiffness)
    basis = np.zeros((size, outer.size + modes))
    basis[outer, np.arange(outer.size)] = 1.0
    coupled = stiffness[inner][:, outer]
    inside = stiffness[inner][:, inner]
    if outer.size and inner.size:
        # Constraint modes: the inside follows a unit displacement of the interface at rest.
        basis[inner, : outer.size] = -_solve(inside, coupled if isinstance(coupled, np.ndarray) else coupled.toarray())
    if modes:
        basis[inner, outer.size :] = _lowest(mass[inner][:, inner], inside, modes)
    return Reduction(basis, *(_symmetric(basis.T @ (matrix @ basis)) for matrix in (mass, stiffness)))


def uncoupled(reduction: Reduction, momenta: np.ndarray | None = None) -> Modes:
    """Return the modes of a reduced model that carry none of the given momenta, uncoupled in mass and stiffness (M115).

    **Arguments:**

    - ``momenta``: (unknowns, rigid) M times the rigid-body motions; modes orthogonal to them are those of mean axes.
      None: the model cannot move as a rigid body.
    """
    basis, mass, stiffness = reduction
    if momenta is not None:
        # The first columns of Q span the momenta, so all others have none.
        complete, _ = qr(basis.T @ momenta)
        rest = complete[:, momenta.shape[1] :]
        basis, mass, stiffness = basis @ rest, _symmetric(rest.T @ mass @ rest), _symmetric(rest.T @ stiffness @ rest)
    eigenvalues, shapes = eigh(stiffness, mass)
    physical = basis @ shapes
    # An eigenvector's sign is arbitrary: it is fixed here, so that modes do not depend on the library.
    large = np.abs(physical) >= 0.4 * np.abs(physical).max(axis=0, keepdims=True)
    signs = np.sign(physical[np.argmax(large, axis=0), np.arange(physical.shape[1])])  # of the first large displacement
    return Modes(eigenvalues, physical * signs[None, :])


def _lowest(mass: Any, stiffness: Any, modes: int) -> np.ndarray:
    """Return the (unknowns, modes) shapes of the lowest modes of a model that is held."""
    if isinstance(mass, np.ndarray):
        return eigh(mass, stiffness)[1][:, ::-1][:, :modes]  # as the largest of the inverse: small ones stay precise
    # A fixed start, since a random one would give other digits each time.
    return eigsh(stiffness, modes, mass, sigma=0.0, v0=np.ones(mass.shape[0]))[1]


def _solve(matrix: Any, right: np.ndarray) -> np.ndarray:
    if isinstance(matrix, np.ndarray):
        return solve(matrix, right, assume_a="pos")
    return splu(matrix.tocsc()).solve(right)


def _as_treated(matrix: Any) -> Any:
    """Return small matrices as dense ones, large ones as SciPy's sparse rows."""
    if matrix.shape[0] <= DENSE:
        return np.asarray(matrix) if isinstance(matrix, np.ndarray) else matrix.toarray()
    return csr_array(matrix)


def _symmetric(matrix: np.ndarray) -> np.ndarray:
    return 0.5 * (matrix + matrix.T)
