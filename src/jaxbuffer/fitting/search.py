"""The staged search: the beginning of the records first, then more and more of them."""

import math
from collections.abc import Callable, Iterator

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.stats import qmc

from .residuals import Block, LeastSquares, Residuals, information, minimum, outliers, smoothed

FIRST, GROWTH = 1.0 / 64.0, 1.3  # share of the records to begin with, and by which it grows
FEWEST = 24  # rows to begin with
WIDTHS = (16.0, 4.0, 0.0)  # rows of a window, from coarse to fine
MET = 3.0  # mean square of the residuals, up to which the next rows are met already
WINDOW = 24  # rows that one missed impact stands out of
ALONE = 6.0  # deviations of a window's mean square that noise may add: there are hundreds of windows
FACTORS = (2.0, 8.0, 32.0, 128.0, 512.0)  # deviations from the point so far, of further points to begin a stage at
STARTS = 8  # more of them, spread over a part of the unknowns' ranges
NEAR = 0.2  # of an unknown's range, how far those lie from the point so far
FAR = 0.4  # of an unknown's range, which none is further away than
SLACK = 1.5  # by which a model that does not meet the noise may miss other rows more
PULL = 3.0  # weight of staying where a short record says nothing [-]
LAST = 1e-9  # relative change of the sum of squares at which the last stage ends
MOST = 60  # evaluations of it
ROUNDS = 3  # times that a lower minimum is looked for near the last one
AWAY = 20.0  # standard deviations from it, where one of the searches for a lower one begins

Report = Callable[[float, float], None]


def shares(rows: int) -> Iterator[float]:
    """Yield shares of the records, from the first rows to all; ``rows``: of the longest record."""
    share = max(FIRST, FEWEST / rows)
    while share < 1.0:
        yield share
        share *= GROWTH
    yield 1.0


def alone(values: np.ndarray) -> np.ndarray:
    """Return which residuals are outliers whose neighbours, and the other columns at that row, are met.

    An impact that is missed shows in several rows or columns; a spike of a sensor does not.
    """
    out = outliers(values)
    beside = np.zeros(out.shape, int)
    beside[:, 1:] += out[:, :-1]
    beside[:, :-1] += out[:, 1:]
    return out & (beside == 0) & (np.sum(out, axis=0) == 1)


class StagedSearch:
    """A search for the least squares of records.

    **Arguments:** ``residuals``; ``rows``: of the longest record; ``report``: is told the share of the records and the
    mean square of the residuals so far; ``check``: looks at a point whose residuals exceed the noise, and raises what
    would be in vain to search on for.
    """

    def __init__(
        self,
        residuals: Residuals,
        rows: int,
        report: Report = lambda share, chi: None,
        check: Callable[[np.ndarray, float], None] = lambda x, share: None,
    ) -> None:
        self.residuals, self.rows, self.report, self.check = residuals, rows, report, check
        # Of a model that does not meet the noise: what it comes to.
        self.level = 1.0

    def __call__(self, x: np.ndarray) -> LeastSquares:
        """Return the least squares of whole records, from scaled unknowns to begin at."""
        before = 0.0
        for share in shares(self.rows):
            x, chi = self._stage(x, share, before or share)
            self.report(share, chi)
            before = share
        return self._settled(minimum(self.residuals, x, 1.0, tolerance=LAST, most=MOST))

    def _settled(self, best: LeastSquares) -> LeastSquares:
        """Return the lowest minimum near one of whole records.

        An impact is over within a few rows: one that falls between others of them than it should makes a minimum of its
        own, hardly higher than the right one.
        """
        # With a fixed seed the same records give the same fit.
        random = np.random.default_rng(0)
        for _ in range(ROUNDS):
            spread = np.linalg.cholesky(np.linalg.inv(information(best.slopes)))
            away = AWAY * spread @ random.normal(size=len(best.x))
            starts = ((best.x, WIDTHS), (np.clip(best.x + away / math.sqrt(len(away)), 0.0, 1.0), WIDTHS[1:]))
            found = [self._descent(start, 1.0, widths) for start, widths in starts]
            others = [minimum(self.residuals, x, 1.0, tolerance=LAST, most=MOST) for x, _ in found]
            other = min(others, key=lambda it: it.chi)
            # A sum of squares that is lower by less than one, a deviation of one unknown, is no better a minimum.
            if other.chi >= best.chi - 1.0 / len(best.slopes):
                break
            best = other
        return best

    def _stage(self, x: np.ndarray, share: float, before: float) -> tuple[np.ndarray, float]:
        """Return the minimum of the records up to a share, from that of a smaller one, the share ``before``."""
        # Where the next rows are met already nothing can have gone wrong, and one descent is enough.
        begin = -1 if self.excess(self.residuals(x, share)) < MET else 0
        best = self._descent(x, share, WIDTHS[begin:])
        enough = SLACK if self.level > 1.0 else 1.0
        if best[1] > enough:
            self.check(best[0], share)
            for start in (x, *self._further(x, before)):
                # By squares first: a loss that forgives spikes also forgives each impact that is missed.
                near = self._descent(start, share, WIDTHS, squares=True)[0]
                best = min(best, self._descent(near, share, WIDTHS[-1:]), key=lambda it: it[1])
                if best[1] <= enough:
                    break
        # Where no start meets the noise the model does not: further stages are held to what it comes to.
        self.level = max(self.level * best[1], 1.0)
        return best

    def _further(self, x: np.ndarray, share: float) -> Iterator[np.ndarray]:
        """Yield further points to begin at: first such as the rows up to a share hardly tell from x."""
        slopes = np.concatenate([smoothed(block, 0.0)[1] for block in self.residuals(x, share)])
        spread, random = np.linalg.cholesky(np.linalg.inv(information(slopes))), np.random.default_rng(0)
        for factor in FACTORS:
            away = factor * spread @ random.normal(size=len(x)) / math.sqrt(len(x))
            # Of what the rows hardly tell, a deviation may exceed the whole range: such steps approach `FAR` only.
            yield np.clip(x + away * FAR / (FAR + np.abs(away)), 0.0, 1.0)
        for k, offset in enumerate(qmc.Sobol(len(x), seed=0).random(STARTS)):
            yield np.clip(x + NEAR * (k + 1) / STARTS * (2.0 * offset - 1.0), 0.0, 1.0)

    def _descent(
        self, x: np.ndarray, share: float, widths: tuple[float, ...], squares: bool = False
    ) -> tuple[np.ndarray, float]:
        """Return the minimum that smaller and smaller windows lead to, and its excess."""
        for width in widths:
            # Over whole records nothing may hold an unknown where it began: a pull would bias its estimate.
            x = minimum(self.residuals, x, share, width, squares=squares, pull=PULL if share < 1.0 else 0.0).x
        return x, self.excess(self.residuals(x, share))

    def excess(self, blocks: list[Block]) -> float:
        """Return the largest mean square of a column's residuals, in all and in a window, over what noise makes of it
        at most."""
        worst = 0.0
        for block in blocks:
            squares, rows = np.where(alone(block.values), 1.0, block.values**2), block.values.shape[1]
            whole = float(np.max(np.mean(squares, axis=1))) / (1.1 + 4.0 * math.sqrt(2.0 / rows))
            window = min(WINDOW, rows)
            means = uniform_filter1d(squares, window, axis=1, mode="reflect")
            worst = max(worst, whole, float(np.max(means)) / (1.1 + ALONE * math.sqrt(2.0 / window)))
        return worst / self.level
