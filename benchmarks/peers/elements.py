"""Four-node elements, plastic after von Mises, under central differences: a loop in numba over elements and points.

Written from the equations, apart from the product: logarithmic strain by principal stretches, forces by the derivative
of C, plastic flow narrowing a bent element by columns and layers of points, one element after the other.
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
POINT = 1.0 / math.sqrt(3.0)


def geometry(x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Of an element with corners ``x`` (4, 2): own axes, mean gradient, γ, gradient of ξη and area of each point."""
    along = x[1] + x[2] - x[0] - x[3]
    e1 = along / np.hypot(*along)
    axes = np.array([e1, [-e1[1], e1[0]]])
    own = x @ axes.T
    mean, twist, weight = np.zeros((4, 2)), np.zeros((4, 2)), np.zeros(4)
    for p, (r, s) in enumerate(POINT * CORNERS):
        slopes = 0.25 * np.stack([CORNERS[:, 0] * (1 + s * CORNERS[:, 1]), CORNERS[:, 1] * (1 + r * CORNERS[:, 0])], 1)
        jacobian = own.T @ slopes
        weight[p] = np.linalg.det(jacobian)
        back = np.linalg.inv(jacobian)
        mean += weight[p] * slopes @ back
        twist[p] = np.array([s, r]) @ back
    mean /= weight.sum()
    sign = CORNERS[:, 0] * CORNERS[:, 1]
    return axes, mean, 0.25 * (sign - mean @ (sign @ own)), twist, weight


class Peer:
    """A mesh and its material (E [Pa], ν, yield stress [Pa], hardening [Pa]), under gravity [m/s²] in -y.

    ``threads``: one, or how many share the elements.
    """

    def __init__(
        self,
        positions: np.ndarray,
        corners: np.ndarray,
        inverse: np.ndarray,
        material: tuple[float, ...],
        gravity: float,
        threads: int,
    ) -> None:
        geometries = [geometry(positions[cell]) for cell in corners]
        self.shape = [np.array([one[k] for one in geometries]) for k in range(5)]
        self.corners, self.inverse, self.material = corners, inverse, np.array(material)
        self.gravity, self.threads = gravity, threads
        meeting: list[list[int]] = [[] for _ in positions]
        for place, node in enumerate(corners.ravel()):
            meeting[node].append(place)
        self.first = np.cumsum([0, *map(len, meeting)])
        self.places = np.array([place for places in meeting for place in places])

    def run(self, step: float, steps: int) -> Any:
        """Displacements (nodes, 2) after so many steps from rest."""
        numba.set_num_threads(self.threads)
        march = _march if self.threads == 1 else _march_together
        return march(
            step,
            steps,
            self.corners,
            self.inverse,
            self.first,
            self.places,
            self.material,
            self.gravity,
            *self.shape,
        )


@numba.njit(inline="always")
def _strain(c11: float, c22: float, c12: float) -> Any:
    """½ ln C (ε11, ε22, ε12), and what turns a stress conjugate to it into one conjugate to ½ C."""
    mean, half = 0.5 * (c11 + c22), 0.5 * (c11 - c22)
    radius = math.sqrt(half * half + c12 * c12)
    cosine, sine = (half / radius, c12 / radius) if radius > 0.0 else (1.0, 0.0)
    large, small = mean + radius, mean - radius
    log_large, log_small = 0.5 * math.log(large), 0.5 * math.log(small)
    ratio = radius / mean  # of the shear: (ε1 - ε2)/(λ1 - λ2), by its series where they are close
    square = ratio * ratio
    if square < 1e-4:
        shear = 0.5 / mean * (1.0 + square * (1.0 / 3.0 + square * (0.2 + square / 7.0)))
    else:
        shear = (log_large - log_small) / (large - small)
    middle, part = 0.5 * (log_large + log_small), shear * radius
    return middle + part * cosine, middle - part * cosine, part * sine, cosine, sine, large, small, shear


@numba.njit(inline="always")
def _pulled(s11: float, s22: float, s12: float, cosine: float, sine: float, large: float, small: float, shear: float):
    """∂(σ:ε)/∂C: (11, 22, 12), the last with both of its places together."""
    first = 0.5 * (s11 + s22) + 0.5 * (s11 - s22) * cosine + s12 * sine  # σ in the principal axes of C
    second = s11 + s22 - first
    across = s12 * cosine - 0.5 * (s11 - s22) * sine
    first, second, across = 0.5 * first / large, 0.5 * second / small, across * shear
    mean, half = 0.5 * (first + second), 0.5 * (first - second)
    return (
        mean + half * cosine - across * sine,
        mean - half * cosine + across * sine,
        2.0 * (half * sine + across * cosine),
    )


@numba.njit(inline="always")
def _narrowed(plastic, weight, flowed):
    """What plastic flow adds to the strains, along in the left and the right column of points, across in the lower and
    the upper layer; its means over the element are zero."""
    w0, w1, w2, w3 = weight[0], weight[1], weight[2], weight[3]
    area = w0 + w1 + w2 + w3
    left = flowed * (w0 * plastic[0, 0] + w3 * plastic[3, 0]) / (w0 + w3)
    right = flowed * (w1 * plastic[1, 0] + w2 * plastic[2, 0]) / (w1 + w2)
    lower = flowed * (w0 * plastic[0, 1] + w1 * plastic[1, 1]) / (w0 + w1)
    upper = flowed * (w3 * plastic[3, 1] + w2 * plastic[2, 1]) / (w3 + w2)
    along = ((w0 + w3) * left + (w1 + w2) * right) / area
    across = ((w0 + w1) * lower + (w3 + w2) * upper) / area
    return left - along, right - along, lower - across, upper - across


@numba.njit(inline="always")
def _stress(e11, e22, e12, material, plastic, equivalent):
    """σ11, σ22, σ12 of one point by radial return; what it remembers is brought up to date."""
    young, poisson, limit, hardening = material[0], material[1], material[2], material[3]
    shear_modulus = 0.5 * young / (1.0 + poisson)
    bulk = young / (3.0 * (1.0 - 2.0 * poisson))
    q11, q22, q12 = plastic[0], plastic[1], plastic[2]
    third = (e11 + e22) / 3.0
    d11, d22 = 2.0 * shear_modulus * (e11 - q11 - third), 2.0 * shear_modulus * (e22 - q22 - third)
    d33, d12 = 2.0 * shear_modulus * (q11 + q22 - third), 2.0 * shear_modulus * (e12 - q12)
    size = math.sqrt(1.5 * (d11 * d11 + d22 * d22 + d33 * d33 + 2.0 * d12 * d12))
    over = size - limit - hardening * equivalent[0]
    if over > 0.0:
        grown = over / (3.0 * shear_modulus + hardening)
        flow = 1.5 * grown / size
        plastic[0], plastic[1], plastic[2] = q11 + flow * d11, q22 + flow * d22, q12 + flow * d12
        equivalent[0] += grown
        share = 1.0 - 2.0 * shear_modulus * flow
        d11, d22, d12 = share * d11, share * d22, share * d12
    pressure = 3.0 * bulk * third
    return d11 + pressure, d22 + pressure, d12


@numba.njit(inline="always")
def _element(e, corners, axes, mean, gamma, twist, weight, material, u, plastic, equivalent, forces):
    """Forces at the corners of one element; what its points remember is brought up to date."""
    poisson = material[1]
    narrow = poisson / (1.0 - poisson)
    m00, m10, m01, m11 = axes[e, 0, 0], axes[e, 0, 1], axes[e, 1, 0], axes[e, 1, 1]
    h0 = h1 = 0.0
    for c in range(4):
        x, y, node = mean[e, c, 0], mean[e, c, 1], corners[e, c]
        ux, uy = u[node, 0], u[node, 1]
        m00 += ux * x
        m01 += ux * y
        m10 += uy * x
        m11 += uy * y
        h0 += ux * gamma[e, c]
        h1 += uy * gamma[e, c]
    a11, a22, a12 = m00 * m00 + m10 * m10, m01 * m01 + m11 * m11, m00 * m01 + m10 * m11
    bent0, bent1 = m00 * h0 + m10 * h1, m01 * h0 + m11 * h1
    left, right, lower, upper = _narrowed(plastic[e], weight[e], 1.0 - narrow)
    p11 = p22 = p12 = b0 = b1 = 0.0  # ∂(energy)/∂ of a11, a22, a12, bent0, bent1
    for p in range(4):
        t0, t1, w = twist[e, p, 0], twist[e, p, 1], weight[e, p]
        strain = _strain(
            a11 + 2.0 * (bent0 * t0 - narrow * bent1 * t1), a22 + 2.0 * (bent1 * t1 - narrow * bent0 * t0), a12
        )
        e11 = strain[0] + (right if 0 < p < 3 else left)
        e22 = strain[1] + (lower if p < 2 else upper)
        s11, s22, s12 = _stress(e11, e22, strain[2], material, plastic[e, p], equivalent[e, p : p + 1])
        g11, g22, g12 = _pulled(w * s11, w * s22, w * s12, strain[3], strain[4], strain[5], strain[6], strain[7])
        p11 += g11
        p22 += g22
        p12 += g12
        b0 += 2.0 * t0 * (g11 - narrow * g22)
        b1 += 2.0 * t1 * (g22 - narrow * g11)
    # of the mean deformation gradient, and of the hourglass displacement
    r00 = 2.0 * p11 * m00 + p12 * m01 + b0 * h0
    r10 = 2.0 * p11 * m10 + p12 * m11 + b0 * h1
    r01 = 2.0 * p22 * m01 + p12 * m00 + b1 * h0
    r11 = 2.0 * p22 * m11 + p12 * m10 + b1 * h1
    k0, k1 = b0 * m00 + b1 * m01, b0 * m10 + b1 * m11
    for c in range(4):
        x, y, g = mean[e, c, 0], mean[e, c, 1], gamma[e, c]
        forces[4 * e + c, 0] = r00 * x + r01 * y + k0 * g
        forces[4 * e + c, 1] = r10 * x + r11 * y + k1 * g


def _marching(step, steps, corners, inverse, first, places, material, gravity, axes, mean, gamma, twist, weight):
    elements, nodes = len(corners), len(inverse)
    u, v = np.zeros((nodes, 2)), np.zeros((nodes, 2))
    plastic, equivalent = np.zeros((elements, 4, 3)), np.zeros((elements, 4))
    forces = np.zeros((4 * elements, 2))
    for _ in range(steps):
        for e in numba.prange(elements):
            _element(e, corners, axes, mean, gamma, twist, weight, material, u, plastic, equivalent, forces)
        for n in numba.prange(nodes):
            x = y = 0.0
            for k in range(first[n], first[n + 1]):
                x += forces[places[k], 0]
                y += forces[places[k], 1]
            v[n, 0] -= step * inverse[n, 0] * x
            if inverse[n, 1] > 0.0:
                v[n, 1] -= step * (inverse[n, 1] * y + gravity)
            u[n, 0] += step * v[n, 0]
            u[n, 1] += step * v[n, 1]
    return u


_march = numba.njit(_marching)
_march_together = numba.njit(parallel=True)(_marching)
