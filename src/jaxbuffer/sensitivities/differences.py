"""Derivatives by differences of tight solves, with a step chosen by their own convergence and their own uncertainty.

They share nothing with the derivative rule: values of captures only. Steps are halved from a coarse one; where the
extrapolated differences of two successive pairs agree best, rounding and curvature are balanced, and how far they agree
is the uncertainty.
"""

import itertools
from collections.abc import Callable, Generator, Sequence
from typing import Any, NamedTuple

import numpy as np

COARSEST = 2e-3  # relative step
STEPS = 6
FIRST = 3  # steps that are always taken: two successive pairs


class Difference(NamedTuple):
    """For each quantity its derivative by the relative move, its uncertainty (infinite where no two steps could be
    compared), and the steps taken."""

    value: np.ndarray
    uncertainty: np.ndarray
    steps: int


Halving = Generator[list[float], dict[float, np.ndarray], Difference]


def difference(inside: Callable[[float], bool], settled: np.ndarray, noise: float) -> Halving:
    """Differentiate at zero.

    **Arguments:** ``inside``: whether a move stays within bounds (differences are one-sided where it doesn't);
    ``settled``: the uncertainty of each quantity that is small enough to stop; ``noise``: relative error of the values,
    so that no two differences may agree by luck.

    **Yields:** relative moves, to be sent the quantities after each of them, NaN for a move that can't be compared with
    the unmoved ones. **Returns:** the derivatives.
    """
    best, uncertainty = np.full(settled.shape, np.nan), np.full(settled.shape, np.inf)
    up, down = inside(2.0 * COARSEST), inside(-2.0 * COARSEST)
    if not (up or down):
        return Difference(best, uncertainty, 0)
    central, sign = up and down, 1.0 if up else -1.0
    steps = [sign * COARSEST / 2**count for count in range(STEPS)]
    pairs = [(step, -step if central else 2.0 * step) for step in steps]
    # What is needed in any case is asked for at once, so that it is solved side by side.
    after = yield [*([] if central else [0.0]), *itertools.chain(*pairs[:FIRST])]
    plain: list[np.ndarray] = []
    for count, (near, other) in enumerate(pairs):
        if count >= FIRST:
            after |= yield [near, other]
        if central:
            plain.append((after[near] - after[other]) / (2.0 * near))
        else:
            plain.append((4.0 * after[near] - after[other] - 3.0 * after[0.0]) / (2.0 * near))
        if count < FIRST - 1:
            continue
        # Both stencils are off by a multiple of the step's square, which this takes out.
        older, newer = ((4.0 * plain[i] - plain[i - 1]) / 3.0 for i in (count - 1, count))
        # Two differences may agree by luck, but both hold the noise of the values, over the step.
        apart = np.maximum(np.abs(newer - older), np.abs(noise * after[near] / near))
        better = apart < uncertainty
        best, uncertainty = np.where(better, newer, best), np.where(better, apart, uncertainty)
        if np.all(uncertainty <= settled):
            break
    return Difference(best, uncertainty, len(plain))


def side_by_side(
    halvings: Sequence[Halving], evaluate: Callable[[list[tuple[int, float]]], list[np.ndarray]]
) -> list[Difference]:
    """Take several differences whose steps are halved together.

    **Arguments:** ``evaluate``: the quantities after each of some moves, which are given with the numbers of the
    differences that ask for them.
    """
    differences = dict[int, Difference]()
    answers: dict[int, Any] = dict.fromkeys(range(len(halvings)))
    while answers:
        moves = list[tuple[int, float]]()
        for k, answer in answers.items():
            try:
                moves += [(k, move) for move in halvings[k].send(answer)]
            except StopIteration as end:
                differences[k] = end.value
        answers = {k: {} for k, _ in moves}
        for (k, move), quantities in zip(moves, evaluate(moves), strict=True):
            answers[k][move] = quantities
    return [differences[k] for k in range(len(halvings))]


def balanced_direction(elasticities: np.ndarray, floor: float) -> np.ndarray:
    """Return a relative move in which the parameters change the quantities about alike, so that an error in any of the
    elasticities shows; the largest component is 1.

    **Arguments:** ``elasticities`` (quantities, parameters); ``floor``: below which they count as large as this. Of one
    quantity all changes are the same, and in the same sense; of several, their products over all quantities are.
    """
    mean = np.exp(np.mean(np.log(np.maximum(np.abs(elasticities), floor)), axis=0))
    move = np.where(elasticities[0] < 0.0, -1.0, 1.0) / mean
    return move / np.max(np.abs(move))
