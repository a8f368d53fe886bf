"""Points spread over ranges: Sobol' sequence, Latin hypercube, and the scheme that Sobol' indices are read off."""

import dataclasses
from collections.abc import Sequence

import numpy as np
import scipy
from jaxtyping import Float

from ..errors import InputError, check_choice, check_whole
from ..fields import Part, as_typed, with_values
from ..mechanisms.registry import mechanism_of
from ..run.request import check_pair
from ..sweeps.grid import Batch
from ..value_text import with_unit
from .ranges import Range

METHODS = ("sobol", "latin_hypercube", "saltelli")
MOST = 2**20  # points


@dataclasses.dataclass(frozen=True)
class Points:
    """Where a sample's runs lie.

    - ``axes``: the d ranges;
    - ``shares`` (n, d) [-]: each point's place in each range, 0 low and 1 high;
    - ``method``: "sobol", "latin_hypercube" or "saltelli"; ``count``: what was asked, n but for "saltelli", which has
      n = count (d + 2); ``seed`` of the scrambling.
    """

    axes: tuple[Range, ...]
    shares: Float[np.ndarray, "n d"]
    method: str
    count: int
    seed: int

    def __len__(self) -> int:
        return len(self.shares)

    def columns(self) -> dict[str, np.ndarray]:
        """Return each path's value in every run, shape (n,)."""
        return {axis.path: axis.at(self.shares[:, k]) for k, axis in enumerate(self.axes)}

    def point(self, index: int) -> str:
        """Say one run's values in words: "k_A 640 N/m, misalignment 0.02 rad"."""
        parts = []
        for k, axis in enumerate(self.axes):
            value = float(axis.at(self.shares[index, k]))
            parts.append(f"{axis.name} {with_unit(*as_typed(value, axis.unit, axis.typed))}")
        return ", ".join(parts)

    def batches(self, design: Part, scenario: Part) -> list[Batch]:
        """Return all runs, with an array (n,) for each field that is sampled."""
        spread = with_values(design, scenario, self.columns())
        # All runs at once: what no field alone can say is wrong with some of them.
        check_pair(mechanism_of(design), *spread)
        return [Batch(np.arange(len(self)), *spread)]

    def applied(self, design: Part, scenario: Part) -> tuple[Part, Part]:
        """Return the design and scenario with an array (n,) for each field that is sampled, the others as they are."""
        (batch,) = self.batches(design, scenario)
        return batch.design, batch.scenarios


def points(axes: Sequence[Range], count: int, method: str = METHODS[0], seed: int = 0) -> Points:
    """Spread points over ranges.

    - "sobol": a scrambled Sobol' sequence, ``count`` a power of two [scipy.stats.qmc.Sobol].
    - "latin_hypercube": each of ``count`` equal slices of each range has one point [scipy.stats.qmc.LatinHypercube].
    - "saltelli": two Sobol' samples A and B of ``count`` points each, and for each range A with that range's values
      taken from B: d + 2 blocks, one after the other [Saltelli et al. 2010, doi:10.1016/j.cpc.2009.09.018].

    **Raises:** `InputError` for counts and methods that are not these.
    """
    check_choice("sample.method", method, METHODS)
    check_whole("sample.count", count, 1)
    check_whole("sample.seed", seed, 0)
    d, qmc = len(axes), scipy.stats.qmc
    total = count * (d + 2) if method == "saltelli" else count
    if total > MOST:
        raise InputError(f"sample.count = {count} makes {total} runs; at most {MOST} are allowed")
    if method == "latin_hypercube":
        return Points(tuple(axes), qmc.LatinHypercube(d, rng=seed).random(count), method, count, seed)
    # A Sobol' sequence is balanced at powers of two only.
    if count & (count - 1):
        near = 1 << (count - 1).bit_length()
        raise InputError(
            f"sample.count = {count} is not a power of two, which {method} needs to be balanced; take {near // 2} or"
            f" {near}, or the method latin_hypercube"
        )
    if method == "sobol":
        return Points(tuple(axes), qmc.Sobol(d, rng=seed).random(count), method, count, seed)
    # One sequence in twice the dimensions: its halves are independent, as two sequences would not be.
    both = qmc.Sobol(2 * d, rng=seed).random(count)
    first, second = both[:, :d], both[:, d:]
    mixed = [np.where(np.arange(d) == k, second, first) for k in range(d)]
    return Points(tuple(axes), np.concatenate([first, second, *mixed]), method, count, seed)
