"""Where searches begin, and whether more of them are called for: rounds of designs screened without derivatives.

Slopes do not see a cliff, so what lies beyond one is found by trying. A round screens a sample of the bounds, which
costs a fraction of as many gradients, and follows the best of it. Rounds after the first also screen around the best
design so far, on all sides of its cliffs.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from .search import BEHIND, Branch, Search
from .settings import Settings

AGREE = 0.01  # relative difference of objectives below which two searches found the same
WIDEST, NARROWEST = 0.5, 0.01  # half-widths of the boxes around the best design, of each variable's range

Scaled = Float[np.ndarray, " variables"]


def anywhere(settings: Settings, round_: int, size: int, count: int) -> list[Scaled]:
    """A Latin hypercube of the bounds, another one in each round."""
    return list(_hypercube((settings.seed, round_, 0), size, count))


def around(best: Scaled, settings: Settings, round_: int, count: int) -> list[Scaled]:
    """A sample of boxes around a design, each narrower than the one before, cut off at the bounds."""
    widths = np.geomspace(WIDEST, NARROWEST, count)[:, None]
    shares = _hypercube((settings.seed, round_, 1), len(best), count)
    return list(np.clip(best + widths * (2.0 * shares - 1.0), 0.0, 1.0))


def _hypercube(seed: tuple[int, ...], size: int, count: int) -> np.ndarray:
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(size, rng=np.random.default_rng(seed)).random(count))


class Standing(NamedTuple):
    """How well the searches agree. ``families``: the best objective [N] of each independent search that kept to all
    constraints, rising; searches that began around another's design belong to its family. ``apart`` [-]: relative
    difference of the best two, infinite where there are none; ``cliffs``: whether a search met one; ``gain`` [-]: by
    how much the last round lowered the best objective, infinite where nothing feasible was known before."""

    families: tuple[float, ...]
    apart: float
    cliffs: bool
    gain: float

    @staticmethod
    def of(search: Search, branches: tuple[Branch, ...]) -> "Standing":
        """Of all searches of a stage."""
        latest = max(branch.round for branch in branches)
        families = _families(search, branches)
        earlier = _families(search, tuple(branch for branch in branches if branch.round < latest))
        return Standing(
            tuple(families),
            _above(families[1], families[0]) if len(families) > 1 else np.inf,
            any(bool(np.any(np.isfinite(branch.cliffs))) for branch in branches),
            _above(earlier[0], families[0]) if earlier else np.inf,
        )

    def settled(self, stage: int) -> bool:
        """Whether nothing tells of a better design elsewhere: no search met a cliff, or the last round gained nothing
        more; and in the first stage independent searches agree."""
        if not self.families:
            return False
        agree = stage > 0 or self.apart <= AGREE
        return (agree or len(self.families) == 1) if not self.cliffs else (agree and self.gain <= AGREE)


def _above(value: float, lowest: float) -> float:
    """By how much an objective is above the lowest, relative to that one's size [-]."""
    if value == lowest:
        return 0.0
    return value / abs(lowest) - float(np.sign(lowest)) if lowest else np.inf


def _families(search: Search, branches: tuple[Branch, ...]) -> list[float]:
    """The best of each family; of a search that was given up before its end, only what agrees with the best."""
    kept = [(search.goal.value(b.best), b) for b in branches if search.goal.feasible(b.best)]
    lowest = min((value for value, _ in kept), default=np.inf)
    best: dict[int, float] = {}
    for value, branch in kept:
        if branch.status != BEHIND or _above(value, lowest) <= AGREE:
            best[branch.family] = min(best.get(branch.family, np.inf), value)
    return sorted(best.values())
