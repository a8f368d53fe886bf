"""Ends of profile intervals: the sum of squares, in closed form, has risen by 3.84 there, or the bound is met."""

import numpy as np
import pytest
from scipy.optimize import brentq, lsq_linear

from jaxbuffer.fitting.intervals import SURE, uncertainty
from jaxbuffer.fitting.residuals import Block, LeastSquares

RISE = SURE**2


def known_of(values, slopes, best):
    """The intervals of scaled unknowns, from residuals and their slopes as functions of these."""
    block = lambda x: Block(values(x)[None, :], slopes(x)[None, :, :])  # noqa: E731
    best = np.asarray(best, float)
    return uncertainty(lambda x, share: [block(x)], LeastSquares(best, 0.0, slopes(best), True))


@pytest.mark.parametrize("size", [0.3, 1.0, 3.0, 10.0])
@pytest.mark.parametrize("best", [0.02, 0.2, 0.7])
def test_a_side_that_is_flat_is_followed_until_the_sum_has_risen(size, best):
    """The residual is that of a damper seen by what it lets through: it goes with 1/(x + 0.05)."""
    seen = lambda x: size * np.array([1.0 / (x[0] + 0.05) - 1.0 / (best + 0.05)])  # noqa: E731
    known = known_of(seen, lambda x: np.array([[-size / (x[0] + 0.05) ** 2]]), [best])
    for end, bound in ((known.low[0], 0.0), (known.high[0], 1.0)):
        rise, at_bound = float(seen([end])[0] ** 2), float(seen([bound])[0] ** 2)
        assert (end == bound and at_bound <= RISE) or rise == pytest.approx(RISE, rel=0.06)
    assert known.closed[0]


@pytest.mark.parametrize("best", [(0.5, 0.5), (0.03, 0.9), (0.5, 1.0), (0.0, 0.0)])
def test_an_unknown_at_its_bound_holds_the_others_back(best):
    """Two unknowns that the data hardly tell apart: the profile between the bounds by SciPy's bounded least squares."""
    matrix = np.array([[20.0, 19.0], [19.0, 20.0], [1.0, -1.0]])
    known = known_of(lambda x: matrix @ (x - np.asarray(best)), lambda x: matrix, best)

    def rise(place):
        other = lsq_linear(matrix[:, 1:], matrix @ np.asarray(best) - matrix[:, 0] * place, (0.0, 1.0))
        return 2.0 * other.cost - RISE

    for end, bound in ((known.low[0], 0.0), (known.high[0], 1.0)):
        # Of a sum that may be off by a twentieth at an end, the end may be off by half as much of its distance.
        expected = bound if rise(bound) < 0.0 else brentq(rise, best[0], bound)
        assert end == pytest.approx(expected, abs=0.04 * abs(expected - best[0]) + 1e-12)
    assert known.closed[0]


def test_an_end_that_is_not_established_is_said():
    """The sum jumps over the rise that is asked for, as where an impact more comes: no place has it."""
    jump = lambda x: np.array([100.0 if x[0] > 0.6 else 0.0, 0.1 * (x[0] - 0.5)])  # noqa: E731
    known = known_of(jump, lambda x: np.array([[0.0], [10.0]]), [0.5])
    assert not known.closed[0] and known.high[0] >= 0.6


def test_runs_that_fail_on_the_way_leave_finite_ends():
    """Beyond 0.8 every run fails, and its residuals are infinite."""
    matrix = np.array([[3.0, 1.0], [1.0, 3.0]])
    failing = lambda x: np.full(2, np.inf) if x[0] > 0.8 else matrix @ (x - 0.5)  # noqa: E731
    known = known_of(failing, lambda x: matrix, [0.5, 0.5])
    assert np.all(np.isfinite([known.low, known.high])) and not known.closed[0]
    assert 0.75 < known.high[0] <= 0.8
