"""Mode shapes of a uniform bar without dimension, and their integrals: constants, made once for each choice of modes.

Lateral shapes φ and axial shapes ψ are functions of the station ξ = 0…1. A bar's length, mass and stiffness scale their
integrals (`bars`), so that gradients flow through those.
"""

from collections.abc import Callable
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np

from .bar_elements import (
    Stations,
    axial_matrices,
    axial_shapes,
    bending_matrices,
    bending_shapes,
    gram,
    quadrature,
)

ELEMENTS = 60  # at least; the table of docs/flexible.md has its digits with so many

Shapes = Callable[[Stations, int], np.ndarray]
"""(stations, modes) values at the stations, or a derivative to ξ of the given order."""


class ShapeIntegrals(NamedTuple):
    """Integrals over ξ = 0…1 of a lateral shapes φ and b axial shapes ψ.

    - ``mass``: (a, a) ∫ φ_k φ_l dξ; ``bending``: (a, a) ∫ φ_k″ φ_l″ dξ.
    - ``mean``: (a,) ∫ φ dξ; ``moment``: (a,) ∫ ξ φ dξ.
    - ``slopes``: (3, a, a) ∫ ξⁿ φ_k′ φ_l′ dξ for n = 0, 1, 2.
    - ``axial_mass``: (b, b) ∫ ψ_k ψ_l dξ; ``stretching``: (b, b) ∫ ψ_k′ ψ_l′ dξ.
    - ``axial_mean``: (b,) ∫ ψ dξ; ``axial_moment``: (b,) ∫ ξ ψ dξ.
    - ``coupling``: (b, a) ∫ ψ_k φ_l dξ.
    """

    mass: np.ndarray
    bending: np.ndarray
    mean: np.ndarray
    moment: np.ndarray
    slopes: np.ndarray
    axial_mass: np.ndarray
    stretching: np.ndarray
    axial_mean: np.ndarray
    axial_moment: np.ndarray
    coupling: np.ndarray


class BarShapes:
    """Lateral and axial mode shapes of a uniform bar. Two are equal only if they are the same object.

    - ``lateral``, ``axial``: functions of stations and of the derivative's order.
    - ``cells``, ``points``: of the quadrature that integrates their products.
    - ``orthogonal_axial``: axial shapes are uncoupled in mass and stiffness, as the lateral ones always are.
    """

    def __init__(self, lateral: Shapes, axial: Shapes, cells: int, points: int, orthogonal_axial: bool = True):
        self.lateral, self.axial, self.cells, self.points = lateral, axial, cells, points
        self.orthogonal_axial = orthogonal_axial

    @cached_property
    def integrals(self) -> ShapeIntegrals:
        """Return all integrals, by Gauss's rule in each cell."""
        xi, weights = quadrature(self.cells, self.points)
        lateral, slopes, curvatures = (self.lateral(xi, order) for order in range(3))
        axial, strains = (self.axial(xi, order) for order in range(2))
        along = _diagonal if self.orthogonal_axial else gram
        return ShapeIntegrals(
            mass=_diagonal(lateral, lateral, weights),
            bending=_diagonal(curvatures, curvatures, weights),
            mean=weights @ lateral,
            moment=(weights * xi) @ lateral,
            slopes=np.stack([gram(slopes, slopes, weights * xi**power) for power in range(3)]),
            axial_mass=along(axial, axial, weights),
            stretching=along(strains, strains, weights),
            axial_mean=weights @ axial,
            axial_moment=(weights * xi) @ axial,
            coupling=gram(axial, lateral, weights),
        )


def _diagonal(left: np.ndarray, right: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return `gram` of orthogonal functions: what is zero but for rounding is zero."""
    return np.diag(weights @ (left * right))


def no_shapes(xi: Stations, derivative: int) -> np.ndarray:
    """Return no shapes at all: those of a bar that does not stretch."""
    return np.zeros((len(xi), 0))


# Cached, because shapes are equal only if they are the same object: with new ones a program would be compiled anew.
@cache
def free_shapes(interior: int, axial_interior: int | None) -> BarShapes:
    """Return the mean-axis modes of a free bar, by Craig and Bampton with both end nodes kept (M115).

    **Arguments:** ``interior``: number of fixed-interface modes in bending; there are interior + 2 modes in all.
    ``axial_interior``: the same along the bar, where there are axial_interior + 1 modes. None: it does not stretch.
    """
    from .craig_bampton import craig_bampton, uncoupled  # with SciPy, which a run without bars is spared

    elements = _elements(interior)
    mass, stiffness = bending_matrices(elements)
    xi = np.linspace(0.0, 1.0, elements + 1)
    rigid = np.stack([np.stack([np.ones_like(xi), np.zeros_like(xi)], 1), np.stack([xi, np.ones_like(xi)], 1)], -1)
    ends = [0, 1, 2 * elements, 2 * elements + 1]
    lateral = uncoupled(craig_bampton(mass, stiffness, ends, interior), mass @ rigid.reshape(-1, 2))
    if axial_interior is None:
        return _of_elements(elements, lateral.shapes, None)
    mass, stiffness = axial_matrices(elements)
    reduction = craig_bampton(mass, stiffness, [0, 2 * elements], axial_interior)
    return _of_elements(elements, lateral.shapes, uncoupled(reduction, mass @ np.ones((2 * elements + 1, 1))).shapes)


@cache
def cantilever_shapes(interior: int, axial_interior: int | None) -> BarShapes:
    """Return the modes of a bar that is clamped at ξ = 0, by Craig and Bampton with the node at ξ = 1 kept (M115).

    **Arguments:** as `free_shapes` has them; there are interior + 2 modes in bending, axial_interior + 1 along the bar.
    """
    elements = _elements(interior)
    mass, stiffness = bending_matrices(elements)
    lateral = _reduced(mass, stiffness, 2, [2 * elements - 2, 2 * elements - 1], interior)
    if axial_interior is None:
        return _of_elements(elements, lateral, None)
    return _of_elements(elements, lateral, _reduced(*axial_matrices(elements), 1, [2 * elements - 1], axial_interior))


@cache
def sine_shapes(modes: int, axial_nodes: bool) -> BarShapes:
    """Return the shapes sin(kπξ), k = 1…modes, and along the bar the quadratic shapes of nodes at ξ = ½ and 1, held at
    ξ = 0."""
    waves = np.pi * np.arange(1, modes + 1)

    def axial(xi: Stations, derivative: int) -> np.ndarray:
        return axial_shapes(1, xi, derivative)[:, 1:]

    return BarShapes(_sines(waves, 1.0), axial if axial_nodes else no_shapes, 2 * modes + 2, 8, False)


@cache
def supported_shapes(modes: tuple[int, ...]) -> BarShapes:
    """Return the modes √2 sin(iπξ) of a bar on two simple supports. ``modes``: which i."""
    return BarShapes(_sines(np.pi * np.array(modes), np.sqrt(2.0)), no_shapes, 2 * max(modes) + 2, 8)


@cache
def clamped_shapes(modes: tuple[int, ...]) -> BarShapes:
    """Return the modes of a bar that is clamped at both ends, ∫ φ² dξ = 1. ``modes``: which, from 1."""
    return BarShapes(_clamped(clamped_wave_numbers(max(modes))[np.array(modes) - 1]), no_shapes, 2 * max(modes) + 4, 8)


def clamped_wave_numbers(count: int) -> np.ndarray:
    """Return the (count,) roots β of cos β cosh β = 1, by Newton's method: those of a clamped or a free bar."""
    beta = np.pi * (np.arange(1, count + 1) + 0.5)
    for _ in range(20):
        # Written as cos β = 1/cosh β, which does not overflow for high modes.
        beta = beta - (np.cos(beta) - 1.0 / np.cosh(beta)) / (-np.sin(beta) + np.tanh(beta) / np.cosh(beta))
    return beta


def _clamped(beta: np.ndarray) -> Shapes:
    """Return cosh βξ - cos βξ - σ (sinh βξ - sin βξ), written with decaying exponentials, so that no digits cancel."""
    scale = 1.0 - np.exp(-2.0 * beta) - 2.0 * np.exp(-beta) * np.sin(beta)
    sigma = (1.0 + np.exp(-2.0 * beta) - 2.0 * np.exp(-beta) * np.cos(beta)) / scale
    rising = (np.cos(beta) - np.sin(beta) - np.exp(-beta)) / scale

    def shapes(xi: Stations, derivative: int) -> np.ndarray:
        phase, quarter = beta[None, :] * np.asarray(xi)[:, None], 0.5 * np.pi * derivative
        falling = 0.5 * (1.0 + sigma)[None, :] * np.exp(-phase) * (-1.0) ** derivative
        growing = rising[None, :] * np.exp(phase - beta[None, :])
        waves = sigma[None, :] * np.sin(phase + quarter) - np.cos(phase + quarter)
        return (falling + growing + waves) * beta[None, :] ** derivative

    return shapes


def _sines(waves: np.ndarray, size: float) -> Shapes:
    def shapes(xi: Stations, derivative: int) -> np.ndarray:
        phase = waves[None, :] * np.asarray(xi)[:, None] + 0.5 * np.pi * derivative
        return size * np.sin(phase) * waves[None, :] ** derivative

    return shapes


def _elements(interior: int) -> int:
    return max(ELEMENTS, 6 * interior)


def _reduced(mass: np.ndarray, stiffness: np.ndarray, fixed: int, interface: list[int], interior: int) -> np.ndarray:
    """Return the (unknowns, modes) modes of elements whose first ``fixed`` unknowns are fixed; ``interface`` counts the
    others."""
    from .craig_bampton import craig_bampton, uncoupled  # with SciPy, see above

    reduction = craig_bampton(mass[fixed:, fixed:], stiffness[fixed:, fixed:], interface, interior)
    shapes = uncoupled(reduction).shapes
    return np.concatenate([np.zeros((fixed, shapes.shape[1])), shapes])


def _of_elements(elements: int, lateral: np.ndarray, axial: np.ndarray | None) -> BarShapes:
    """Return the shapes of nodal displacements."""

    def bending(xi: Stations, derivative: int) -> np.ndarray:
        return bending_shapes(elements, xi, derivative) @ lateral

    def stretching(xi: Stations, derivative: int) -> np.ndarray:
        return axial_shapes(elements, xi, derivative) @ axial

    return BarShapes(bending, no_shapes if axial is None else stretching, elements, 4)
