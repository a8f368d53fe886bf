"""Differences that choose their step, on functions whose derivatives are known."""

import numpy as np
import pytest

from jaxbuffer.sensitivities.differences import COARSEST, FIRST, STEPS, balanced_direction, difference, side_by_side

SETTLED = np.full(3, 1e-9)


def differentiated(evaluate, inside, settled, noise):
    """One difference, of a function of the move."""
    (result,) = side_by_side([difference(inside, settled, noise)], lambda moves: [evaluate(move) for _, move in moves])
    return result


def smooth(move):
    return np.array([np.exp(3.0 * move), np.sin(move + 1.0), 5.0 + move**3])


EXACT = np.array([3.0, np.cos(1.0), 0.0])


@pytest.mark.parametrize(
    ("inside", "sided"),
    [(lambda move: True, False), (lambda move: move >= 0.0, True), (lambda move: move <= 0.0, True)],
    ids=["central", "at the low bound", "at the high bound"],
)
def test_smooth_functions(inside, sided):
    """The uncertainty covers the error, whatever side the bounds leave."""

    def evaluate(move):
        assert inside(move)
        return smooth(move)

    estimate = differentiated(evaluate, inside, SETTLED, noise=1e-15)
    assert np.all(np.abs(estimate.value - EXACT) <= estimate.uncertainty + 1e-12)
    assert np.all(estimate.uncertainty < (1e-7 if sided else 1e-9))


def test_two_extrapolations_are_compared_at_least():
    """Of a straight line, whose differences are all the same; an extrapolation takes two steps, the next one more."""
    estimate = differentiated(lambda move: 2.0 * move + np.zeros(3), lambda move: True, SETTLED, noise=1e-15)
    np.testing.assert_allclose(estimate.value, 2.0, rtol=1e-12)
    assert estimate.steps == 3


def test_noise_stops_the_halving_where_it_takes_over():
    """Values good to 1e-8 give differences good to 1e-8 over the step; the uncertainty says so, and no luck helps."""
    draw = np.random.default_rng(1)
    for _ in range(20):
        estimate = differentiated(
            lambda move: smooth(move) * (1.0 + 1e-8 * draw.uniform(-1.0, 1.0, 3)), lambda move: True, SETTLED, 2e-8
        )
        assert np.all(np.abs(estimate.value - EXACT) < 3.0 * estimate.uncertainty)
        assert np.all(estimate.uncertainty > 2e-8 * np.abs(smooth(0.0)) / COARSEST / 2)
        assert estimate.steps == STEPS


def test_a_jump_and_a_bend_are_uncertain():
    """A function that bends at one of the steps, one that jumps next to zero, and one that can't be compared."""

    def evaluate(move):
        return np.array([abs(move - 0.7e-3), 1.0 + (move > 1e-5), 1.0 if move <= 0.0 else np.nan])

    estimate = differentiated(evaluate, lambda move: True, SETTLED, noise=1e-15)
    assert np.all(estimate.uncertainty[1:] > 1.0) and np.isinf(estimate.uncertainty[2])
    # The bend lies between two steps: the finer ones see one side of it only, and agree.
    np.testing.assert_allclose(estimate.value[0], -1.0, rtol=1e-9)


def test_nothing_is_evaluated_where_no_move_is_inside():
    estimate = differentiated(lambda move: pytest.fail("evaluated"), lambda move: False, SETTLED, noise=1e-15)
    assert np.all(np.isnan(estimate.value)) and np.all(np.isinf(estimate.uncertainty)) and estimate.steps == 0


def test_a_balanced_direction_weighs_every_parameter_the_same():
    elasticities = np.array([0.34, -0.046, 0.0042, 1e-5, 0.0])
    direction = balanced_direction(elasticities[None], 1e-3)
    assert np.max(np.abs(direction)) == 1.0
    share = direction * elasticities
    np.testing.assert_allclose(share[:3], share[0])
    assert 0.0 <= share[4] <= share[3] < share[0]


def test_a_direction_balanced_for_several_quantities_favours_none():
    elasticities = np.array([[-0.5, 0.02, 1e-3], [1e-3, 0.08, 0.5]])
    direction = balanced_direction(elasticities, 1e-3)
    changes = np.abs(direction * elasticities)
    np.testing.assert_allclose(changes[0] * changes[1], changes[0, 0] * changes[1, 0])
    np.testing.assert_array_equal(np.sign(direction), [-1.0, 1.0, 1.0])
    assert np.max(np.abs(direction)) == 1.0


def test_bounds_are_asked_for_as_far_as_one_sided_steps_reach():
    calls = []
    differentiated(np.exp, lambda move: calls.append(move) is None, np.zeros(()), 0.0)
    assert sorted(calls) == [-2.0 * COARSEST, 2.0 * COARSEST]


def test_several_are_halved_side_by_side():
    """All moves of the first steps at once, then those of the one that goes on; each as it is alone."""
    noisy = np.random.default_rng(2).uniform(-1.0, 1.0, 100)

    def rough(move):
        return smooth(move) * (1.0 + 1e-6 * noisy[int(1e6 * abs(move)) % 97])

    functions, rounds = (smooth, rough), []

    def evaluate(moves):
        rounds.append([k for k, _ in moves])
        return [functions[k](move) for k, move in moves]

    anywhere = lambda move: True  # noqa: E731
    result = side_by_side([difference(anywhere, SETTLED, 1e-15) for _ in functions], evaluate)
    pairs = [2 * (one.steps - FIRST) for one in result]
    assert rounds[0] == [0] * 2 * FIRST + [1] * 2 * FIRST
    assert result[1].steps == STEPS > result[0].steps
    assert [sum(moves.count(k) for moves in rounds[1:]) for k in (0, 1)] == pairs
    for function, one in zip(functions, result, strict=True):
        alone = differentiated(function, anywhere, SETTLED, 1e-15)
        assert np.array_equal(one.value, alone.value) and np.array_equal(one.uncertainty, alone.uncertainty)
