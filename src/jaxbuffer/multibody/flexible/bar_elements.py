"""Finite elements of a straight bar of unit length, mass and stiffness: cubic in bending, quadratic along the bar.

Everything here is NumPy and has no dimension: a station ξ runs from 0 to 1, and a bar's length, mass and stiffness
scale the results (`bars`). Eigenvalues β⁴ of bending and κ² along the bar converge with the fourth power of the
element's length.
"""

import numpy as np

Stations = np.ndarray
"""(stations,) places ξ between 0 and 1."""

_CUBIC = np.array([[1, 0, -3, 2], [0, 1, -2, 1], [0, 0, 3, -2], [0, 0, -1, 1]], float)
_QUADRATIC = np.array([[1, -3, 2], [0, 4, -4], [0, -1, 2]], float)


def quadrature(cells: int, points: int = 4) -> tuple[Stations, np.ndarray]:
    """Return stations and weights of Gauss's rule in each of equal cells: exact to the degree 2 points - 1 there.

    **Arguments:** ``cells``: number of equal parts of the bar; ``points``: stations in each of them.
    """
    places, weights = np.polynomial.legendre.leggauss(points)
    starts = np.arange(cells)[:, None]
    return ((starts + 0.5 * (places[None, :] + 1.0)) / cells).ravel(), np.tile(0.5 * weights / cells, cells)


def bending_shapes(elements: int, stations: Stations, derivative: int = 0) -> np.ndarray:
    """Return the (stations, 2 (elements + 1)) Hermite's cubic shapes of (w, dw/dξ) at each node, or a derivative of
    them to ξ.

    **Arguments:** ``elements``: number of equal elements; ``stations``: (stations,) ξ; ``derivative``: its order.
    """
    first, values = _polynomials(_CUBIC, elements, stations, derivative)
    values[:, 1::2] /= elements  # slopes are to ξ, not to the element's own coordinate
    return _scattered(2 * first, values, 2 * (elements + 1))


def axial_shapes(elements: int, stations: Stations, derivative: int = 0) -> np.ndarray:
    """Return the (stations, 2 elements + 1) quadratic shapes of the nodes at ends and middles, or a derivative of them
    to ξ.

    **Arguments:** as `bending_shapes` has them.
    """
    first, values = _polynomials(_QUADRATIC, elements, stations, derivative)
    return _scattered(2 * first, values, 2 * elements + 1)


def gram(left: np.ndarray, right: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the (m, n) integrals of the products of two sets of functions: (stations, m) and (stations, n) values."""
    return left.T @ (weights[:, None] * right)


def bending_matrices(elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the consistent mass ∫ w v dξ and stiffness ∫ w″ v″ dξ of all nodes' (w, dw/dξ) (M116)."""
    stations, weights = quadrature(elements)
    shapes, curvatures = (bending_shapes(elements, stations, order) for order in (0, 2))
    return gram(shapes, shapes, weights), gram(curvatures, curvatures, weights)


def axial_matrices(elements: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the consistent mass ∫ u v dξ and stiffness ∫ u′ v′ dξ of all nodes' u (M116)."""
    stations, weights = quadrature(elements)
    shapes, strains = (axial_shapes(elements, stations, order) for order in (0, 1))
    return gram(shapes, shapes, weights), gram(strains, strains, weights)


def geometric_matrix(elements: int, tension) -> np.ndarray:
    """Return the geometric stiffness ∫ N w′ v′ dξ of all nodes' (w, dw/dξ) under the tension N(ξ) (M114).

    **Arguments:** ``tension``: function of (stations,) ξ; integrated exactly up to the third degree.
    """
    stations, weights = quadrature(elements)
    slopes = bending_shapes(elements, stations, 1)
    return gram(slopes, slopes, weights * tension(stations))


def _polynomials(table: np.ndarray, elements: int, stations: Stations, derivative: int):
    """Return which element each station lies in, and (stations, shapes) of that element's polynomials or a
    derivative."""
    stations = np.asarray(stations, float)
    first = np.clip((stations * elements).astype(int), 0, elements - 1)
    local = stations * elements - first
    rows = np.polynomial.polynomial.polyder(table, derivative, axis=1) if derivative else table
    return first, np.polynomial.polynomial.polyval(local, rows.T).T * float(elements) ** derivative


def _scattered(first: np.ndarray, values: np.ndarray, size: int) -> np.ndarray:
    """Put each row's values at its column ``first`` and after, in an array (stations, size)."""
    full = np.zeros((values.shape[0], size))
    np.put_along_axis(full, first[:, None] + np.arange(values.shape[1])[None, :], values, axis=1)
    return full
