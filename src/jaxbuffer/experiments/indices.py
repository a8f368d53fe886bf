"""Sobol' indices: which share of a quantity's variance each sampled number makes, alone and together with others."""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy
from jaxtyping import Float

from ..errors import InputError, check_names, check_number, check_whole
from ..tables import table, text
from ..value_text import percent_text
from .points import points
from .sample import ROUNDING, Sample
from .surface import Surface, response_surface

THROUGH = 2**12  # points at which a response surface is asked
LEAST = 16  # rows without which nothing can be said


class Estimate(NamedTuple):
    """Indices [-] of one quantity by d numbers: ``first``-order and ``total``, and their confidence intervals.

    ``first``, ``total`` (d,); ``first_interval``, ``total_interval`` (2, d): lower and upper end; ``rows``: of how many
    rows of the scheme.
    """

    first: Float[np.ndarray, " d"]
    total: Float[np.ndarray, " d"]
    first_interval: Float[np.ndarray, "2 d"]
    total_interval: Float[np.ndarray, "2 d"]
    rows: int


@dataclasses.dataclass(frozen=True)
class Indices:
    """Sobol' indices of some quantities. Print it for a table.

    - ``paths``: the d numbers that were sampled.
    - ``estimates``: an `Estimate` a quantity, by name.
    - ``confidence`` [-] of the intervals; ``requested_rows``: rows of the scheme, those with runs left out included.
    - ``surfaces``: the response surface behind each quantity's indices, by name; none where they come from runs.

    **Example:**

    >>> ranges = {"impact.stiffness": (1e10, 1e12), "scenario.height": (0.1, 0.2)}  # N/m^e, m
    >>> sample = jb.sample(jb.BarDrop(), jb.BarDropScenario(), ranges, count=16, method="saltelli")
    >>> indices = jb.sobol_indices(sample, ["contact_time"])
    >>> indices.paths, indices.requested_rows
    (('impact.stiffness', 'scenario.height'), 16)
    """

    paths: tuple[str, ...]
    estimates: dict[str, Estimate]
    confidence: float
    requested_rows: int
    surfaces: dict[str, Surface]

    def __repr__(self) -> str:
        parts: list = []
        for name, it in self.estimates.items():
            surface = self.surfaces.get(name)
            of = f"the response surface of {name}" if surface else name
            title = f"Sobol' indices of {of}, with {percent_text(self.confidence, 'g')} intervals"
            shown = table(title, ("number",), ("first-order", "interval", "total", "total's interval"))
            for k in np.argsort(-it.total).tolist():
                (low, high), (least, most) = it.first_interval[:, k], it.total_interval[:, k]
                shown.add_row(
                    self.paths[k], f"{it.first[k]:.3f}", f"{low:.3f} … {high:.3f}",
                    f"{it.total[k]:.3f}", f"{least:.3f} … {most:.3f}",
                )  # fmt: skip
            parts.append(shown)
            alone = percent_text(float(np.sum(it.first)), ".1f")
            parts.append(f"  acting alone, the numbers make {alone} of the variance")
            if surface:
                parts.append(f"  {surface.worth}; the intervals do not hold what it misses")
            elif it.rows < self.requested_rows:
                parts.append(
                    f"  {self.requested_rows - it.rows} of {self.requested_rows} rows are left out: a run of theirs"
                    " failed, ended otherwise or was not computed; the indices are those of the rest, whose numbers"
                    " are no longer quite independent"
                )
        return text(*parts)


def sobol_indices(
    sample: Sample,
    quantities: Sequence[str] | None = None,
    *,
    confidence: float = 0.95,
    resamples: int = 999,
    seed: int = 0,
) -> Indices:
    """Find which share of a quantity's variance each sampled number makes: alone (first-order), and with all that it
    does together with others (total).

    From a sample of the method "saltelli" they are read off its runs; a row of which any run failed, or ended
    otherwise than it should, is left out and counted. From any other sample they are those of its response surface.

    **Arguments:**

    - ``sample``: its numbers count as independent, each evenly spread over its range on its scale.
    - ``quantities``: names of quantities that samples have (default: the mechanism's main one).
    - ``confidence`` [-] of the intervals, by ``resamples`` of the rows (percentile bootstrap), drawn with ``seed``.

    **Returns:** `Indices`. An interval tells of the sample's size, not of what a response surface misses.

    **Source:** Saltelli et al. 2010, doi:10.1016/j.cpc.2009.09.018, table 2, (b) and (f): `scipy.stats.sobol_indices`
    has the same estimators, which want a power of two of rows, none of them missing, and take no seed.

    **Example:** this contact's damper makes the peak, whatever the stiffness.

    >>> ranges = {"impact.stiffness": (1e10, 1e12), "scenario.height": (0.1, 0.2)}  # N/m^e, m
    >>> sample = jb.sample(jb.BarDrop(), jb.BarDropScenario(), ranges, count=16, method="saltelli")
    >>> stiffness, height = jb.sobol_indices(sample, ["peak_force"]).estimates["peak_force"].total
    >>> bool(height > 10 * stiffness)
    True
    """
    check_number("confidence", confidence, "", low=0.0, high=1.0, low_open=True, high_open=True)
    check_whole("resamples", resamples, 99)
    main, axes = sample.main_quantity, sample.grid.axes
    names = check_names("quantities", (main,) if quantities is None else quantities, main)
    for name in names:
        sample.check_varies(name, "indices")
    how = (confidence, resamples, seed)
    if sample.grid.method == "saltelli":
        values = {name: np.where(sample.succeeded, sample.quantity(name), np.nan) for name in names}
        rows, surfaces = sample.grid.count, {}
    else:
        surfaces = {name: response_surface(sample, name) for name in names}
        spread = points(axes, THROUGH, "saltelli", seed)
        # A surface costs next to nothing to ask, so it is asked at the points of the scheme itself.
        values = {name: surface.predict(spread.columns()) for name, surface in surfaces.items()}
        rows = THROUGH
    estimates = {name: estimated(values[name], len(axes), *how, name=name) for name in names}
    return Indices(tuple(axis.path for axis in axes), estimates, confidence, rows, surfaces)


def estimated(
    values: Float[np.ndarray, " n"],
    d: int,
    confidence: float = 0.95,
    resamples: int = 999,
    seed: int = 0,
    name: str = "",
) -> Estimate:
    """Estimate indices from a quantity's values at `points` of the method "saltelli", NaN where there is none.

    **Arguments:** ``values``: d + 2 blocks; ``name``: the quantity, for a message.

    **Raises:** `InputError` where too few rows are complete, or nothing varies.
    """
    blocks = values.reshape(d + 2, -1)
    # A row counts whole or not at all, because the estimators subtract its runs from each other.
    blocks = blocks[:, np.all(np.isfinite(blocks), axis=0)]
    rows = blocks.shape[1]
    if rows < LEAST:
        raise InputError(f"indices of {name}: {rows} rows of the sample have all their runs; at least {LEAST} must")
    size = float(np.max(np.abs(blocks)))
    blocks = blocks - np.mean(blocks[:2])  # a multiplier of the variance less [Sobol' and Levitan 1999]
    # Written so that NaN is refused too.
    if not np.std(blocks[:2]) > ROUNDING * size:
        raise InputError(
            f"indices of {name}: it is the same in all runs but for rounding, so that it has no variance to share out"
        )

    def of_rows(chosen: np.ndarray) -> np.ndarray:
        return estimators(blocks[:, chosen])

    first, total = of_rows(np.arange(rows))
    # Rows are drawn by their number, as the runs of a row belong together.
    drawn = scipy.stats.bootstrap(
        (np.arange(rows),),
        of_rows,
        n_resamples=resamples,
        confidence_level=confidence,
        method="percentile",
        vectorized=False,
        rng=np.random.default_rng(seed),
    ).confidence_interval
    ends = np.stack([drawn.low, drawn.high])
    return Estimate(first, total, ends[:, 0], ends[:, 1], rows)


def estimators(blocks: Float[np.ndarray, "d_and_2 rows"]) -> Float[np.ndarray, "2 d"]:
    """Return the first-order and total indices: with f_A, f_B and f_ABi the blocks and V the variance of the first two,
    S_i = mean(f_B (f_ABi - f_A)) / V and T_i = mean((f_A - f_ABi)²) / 2 V."""
    a, b, mixed = blocks[0], blocks[1], blocks[2:]
    # Of the first two blocks alone: the mixed ones have their numbers from these, and would count them again.
    variance = np.var(blocks[:2])
    first = np.mean(b * (mixed - a), axis=1) / variance
    total = 0.5 * np.mean((a - mixed) ** 2, axis=1) / variance
    return np.stack([first, total])
