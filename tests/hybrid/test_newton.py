"""The matrix of an implicit stage, of low rank, against the whole one solved by NumPy."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.hybrid import Linearisation
from jaxbuffer.hybrid.rungekutta.newton import NewtonMatrix


@jax.jit
def solution(linearisation, shift, right):
    return NewtonMatrix.of(linearisation, shift).solve(right)


@pytest.mark.parametrize(("velocities", "rank"), [(3, 2), (4, 2), (4, 7)])
def test_solution_is_that_of_the_whole_matrix(velocities, rank):
    """J has q̇ = w and ẇ = -X (K B_qᵀ q + C Bᵀ w); a memory beside them stays as it is. The last force is friction: it
    alone answers to nothing but velocities, and so may act on those beyond the coordinates' own."""
    coordinates, shift, draw = 3, 0.3, np.random.default_rng(velocities * rank)
    directions, response = draw.normal(size=(2, velocities, rank))
    stiffness, damping = draw.normal(size=(2, rank, rank))
    directions[coordinates:, :-1] = 0.0
    stiffness[:, -1] = 0.0
    q, w = slice(0, coordinates), slice(coordinates, coordinates + velocities)
    jacobian = np.zeros((coordinates + velocities + 1,) * 2)
    jacobian[q, w] = np.eye(coordinates, velocities)
    jacobian[w, q] = -response @ stiffness @ directions[:coordinates].T
    jacobian[w, w] = -response @ damping @ directions.T
    right = draw.normal(size=(len(jacobian), 2))
    stiff = Linearisation(*map(jnp.asarray, (directions, response, stiffness, damping)), coordinates)
    expected = np.linalg.solve(np.eye(len(jacobian)) - shift * jacobian, right)
    np.testing.assert_allclose(solution(stiff, shift, right), expected, rtol=1e-9)
