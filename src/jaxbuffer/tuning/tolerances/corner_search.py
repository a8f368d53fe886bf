"""The worst corners of many tolerances, searched for along the slopes: 2ⁿ of them are too many to run.

A search for each target begins in the corner that the signs of its slopes name. There the slopes are taken again, until
the corner that they name is the one that they were taken in. Then all corners are run that differ from it in one
tolerance, and the search goes on from a worse one. A fraction of all corners is run, too. So it ends in a corner that
no neighbour, and none of the fraction, is worse than: no proof that none is.
"""

import dataclasses
from typing import Any

import numpy as np
from jaxtyping import Float

from ...mechanisms.limit import ROUNDING
from ..problem.cases import Case, corner_signs
from ..problem.problem import Problem
from ..problem.tolerances import moved
from ..search.evaluation import Evaluation, Evaluator
from .targets import Target, targets

CLIMBS = 8  # corners from which each target's search goes on to neighbours
STEPS = 8  # of one search along the slopes, and from a corner to its neighbours
WORSE = 1e-4  # relative, by which an objective must be larger in a corner that a tuning then takes among its cases

Row = tuple[float, ...]
Place = tuple[int, Row]  # a load case as drawn, by its number, and a corner


@dataclasses.dataclass
class CornerSearch:
    """A search for the corners of one design.

    ``problem``, ``evaluator``; ``scaled``: the design's variables; ``rtol`` [-], by default the problem's.
    """

    problem: Problem
    evaluator: Evaluator
    scaled: Float[np.ndarray, " variables"]
    rtol: float | None = None
    values: dict[Place, Float[np.ndarray, " targets"]] = dataclasses.field(default_factory=dict)

    def __post_init__(self) -> None:
        self.targets: list[Target] = targets(self.problem)

    def worst(self) -> dict[int, Place]:
        """Return the worst place of each target, by its number; `values` has what it is there."""
        if not self.targets:
            return {}
        here = self.evaluator.by_tolerances(self.scaled, self.problem.drawn, self.rtol)
        start = [(b, np.ones(len(self.problem.tolerances))) for b in range(len(self.problem.drawn))]
        places = set(self._named(here, start))
        # Corners are run with slopes, and those that these name, until no new one is named.
        for _ in range(STEPS):
            new = sorted(place for place in places if place not in self.values)
            if not new:
                break
            evaluation = self.evaluator.by_tolerances(self.scaled, [self._case(it) for it in new], self.rtol)
            self._keep(new, evaluation)
            places = set(self._named(evaluation, [(b, np.array(row)) for b, row in new]))
        # Corners spread over all of them, so that what no slope tells of is met too.
        spread = corner_signs(len(self.problem.tolerances))
        self._run([(b, tuple(map(float, row))) for b in range(len(self.problem.drawn)) for row in spread])
        return {k: self._climb(k) for k in range(len(self.targets))}

    def known(self, rows: Float[np.ndarray, "corners tolerances"]) -> Float[np.ndarray, " targets"]:
        """Return the largest value of each target as drawn and in some corners, at every load case."""
        every = [np.zeros(len(self.problem.tolerances)), *rows]
        places = [(b, tuple(map(float, row))) for b in range(len(self.problem.drawn)) for row in every]
        self._run(places)
        return np.max([self.values[place] for place in places], axis=0)

    def _named(self, evaluation: Evaluation, at: list[tuple[int, np.ndarray]]) -> list[Place]:
        """Return the corners that the slopes of each target name in the places where they were taken."""
        named = []
        for target in self.targets:
            for (b, row), slope in zip(at, target.slopes(evaluation), strict=True):
                # A tolerance without effect stays as it is.
                signs = np.where(slope > 0.0, 1.0, np.where(slope < 0.0, -1.0, row))
                named.append((b, tuple(map(float, signs))))
        return named

    def _climb(self, k: int) -> Place:
        """Return the worst corner in which a target is no better than in its neighbours, from the worst ones known."""

        def badness(place: Place) -> tuple[float, Place]:
            # The place decides between equals, so that the same corner is found each time.
            return self.values[place][k], place

        ends = []
        for worst_known in sorted(self.values, key=badness)[-CLIMBS:]:
            # From corner to corner, each time to the worst neighbour, until none is worse.
            worst = worst_known
            for _ in range(STEPS):
                b, row = worst
                flips = 1.0 - 2.0 * np.eye(len(row))
                neighbours = [(b, tuple(map(float, np.array(row) * flip))) for flip in flips]
                self._run(neighbours)
                best = max(neighbours, key=badness)
                if not self.values[best][k] > self.values[worst][k]:
                    break
                worst = best
            ends.append(worst)
        return max(ends, key=badness)

    def _run(self, places: list[Place]) -> None:
        """Run places without slopes, those that were not run yet."""
        new = [place for place in dict.fromkeys(places) if place not in self.values]
        if new:
            cases = [self._case(place) for place in new]
            (evaluation,) = self.evaluator([self.scaled], self.rtol, slopes=False, cases=cases)
            self._keep(new, evaluation)

    def _case(self, place: Place) -> Case:
        b, row = place
        return moved(self.problem.drawn[b], self.problem.tolerances, row)

    def _keep(self, places: list[Place], evaluation: Evaluation) -> None:
        values = np.array([target.values(evaluation) for target in self.targets])
        # A number that is not known counts as the worst, where NaN would compare as neither better nor worse.
        values = np.where(np.isnan(values), np.inf, values)
        self.values |= dict(zip(places, values.T, strict=True))


def worse_corners(
    problem: Problem, evaluator: Evaluator, scaled: Float[np.ndarray, " variables"], rtol: float | None = None
) -> tuple[Row, ...]:
    """Search for the worst corners of a design, and return those that are worse than all of the problem's.

    Of a problem without corners these are the worst one of each target; else those in which a limit is broken farther
    than in any corner of the problem, or the objective is larger.
    """
    search = CornerSearch(problem, evaluator, scaled, rtol)
    worst = search.worst()
    if not len(problem.signs):
        return tuple(dict.fromkeys(row for _, row in worst.values()))
    known, rows = search.known(problem.corner_rows), list[Row]()
    for k, place in worst.items():
        value, limited = search.values[place][k], search.targets[k].limited
        least = max(known[k], 0.0) if limited else known[k] + WORSE * abs(known[k])
        # A limit that is kept there too is no reason for another tuning.
        if value > least + (ROUNDING if limited else 0.0):
            rows.append(place[1])
    return tuple(dict.fromkeys(rows))


def with_corners(problem: Problem, rows: Any) -> Problem:
    """Return the problem with some corners among its cases, beside those that it has."""
    every = dict.fromkeys([*problem.signs, *(tuple(map(float, row)) for row in rows)])
    return dataclasses.replace(problem, signs=tuple(every))
