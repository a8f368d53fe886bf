"""How far to trust a gradient: estimated errors from independent evidence, what the peak is and what comes next.

An adaptive solve bounds the error of the state; a gradient that looks fine can still be wrong, and the maximum over
impacts has kinks. So every gradient is compared with one at another tolerance and with differences of tight solves.
"""

from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import numpy as np

from .._types import Code
from ..mechanisms.quantity import PEAK_FORCE, PEAK_TIME
from ..mechanisms.run import Run
from ..value_text import percent_text
from .evidence import FLOOR, TRUSTED, Evidence

HOPELESS = 0.5  # beyond, not even the sign is established
KINK = 1e-2  # relative change of one parameter that may swap active peak and runner-up without a word


class Verdict(Code):
    """What a certificate says of a gradient, from good to bad.

    - ``trusted``: estimated errors up to 0.3 %.
    - ``check``: larger ones, no differences to compare with, or a kink nearby.
    - ``refused``: not even the sign is sure, or there is no gradient.

    **Example:**

    >>> found = jb.sensitivity(jb.table2(), wrt=["buffer.k_A"], quantities=["peak_force"])
    >>> found.certificate.verdict is jb.Verdict.trusted
    True
    """

    trusted = 0
    check = 1
    refused = 2


class Peaks(NamedTuple):
    """The active peak: ``force`` [N], ``time`` [s], ``contact`` (its number) and ``impact`` (from 0); the highest peak
    of another impact, ``runner_up_impact`` (-1: none) and ``runner_up_force`` [N], its ``margin`` [-] relative to the
    active one; with elasticities that stay as they are, the two swap after a relative change ``swap_change`` [-] of
    ``swap_path`` alone, the parameter that does it soonest (infinite, "" where nothing does)."""

    force: float
    time: float
    contact: int
    impact: int
    runner_up_impact: int
    runner_up_force: float
    margin: float
    swap_path: str
    swap_change: float


class Certificate(eqx.Module):
    """What the evidence says of a sensitivity result.

    - ``error``: estimated error relative to the elasticity, or to `FLOOR` where it is smaller, shape (quantities,
      paths) [-].
    - ``by_tolerance``: change with the tolerance, of the same shape and likewise relative [-].
    - ``by_differences``: distance from differences of tight solves, likewise [-].
    - ``uncertainty``: of these differences themselves, likewise [-]. ``error`` is the largest of the three.
    - ``peaks``: active peak and runner-up, None for a run without an impact.
    - ``verdicts``: one a quantity.
    - ``verdict``: the worst of them.
    - ``reason``: for it, in a sentence.
    - ``thorough``: whether differences were taken by each path rather than by all together.
    - ``solves``: tight solves spent.

    **Example:**

    >>> found = jb.sensitivity(jb.table2(), wrt=["buffer.k_A"], quantities=["peak_force"])
    >>> peaks = found.certificate.peaks
    >>> print(f"impact {peaks.impact + 1}; impact {peaks.runner_up_impact + 1} is {peaks.margin:.1%} below")
    impact 14; impact 1 is 44.1% below
    """

    error: np.ndarray
    by_tolerance: np.ndarray
    by_differences: np.ndarray
    uncertainty: np.ndarray
    peaks: Peaks | None
    verdicts: tuple[Verdict, ...]
    verdict: Verdict
    reason: str
    thorough: bool
    solves: int

    def __repr__(self) -> str:
        lines = [f"Certificate: {self.verdict.name.upper()}: {self.reason}"]
        lines.append(f"  {'verdicts':20} {', '.join(verdict.name for verdict in self.verdicts)}")
        if np.any(np.isfinite(self.error)):
            lines.append(f"  {'largest error':20} {np.nanmax(self.error):.1e} of the elasticity, estimated")
        if (peaks := self.peaks) is not None:
            lines.append(f"  {'active peak':20} {peaks.force:.6g} N at {peaks.time:.6g} s, impact {peaks.impact + 1}")
        if peaks is not None and peaks.runner_up_impact >= 0:
            below = f"impact {peaks.runner_up_impact + 1}, {percent_text(peaks.margin, '.3g')} below"
            lines.append(f"  {'runner-up':20} {peaks.runner_up_force:.6g} N, {below}")
        return "\n".join(lines)


def peak_report(run: Run, slopes: np.ndarray, paths: Sequence[str]) -> Peaks | None:
    """Return the active peak and the runner-up; None for a run without an impact.

    **Arguments:** ``slopes`` (slots, paths): change of each impact's peak force by a relative change of a path [N].
    """
    hits, active = run.impacts, int(run.peak_impact)
    if run.outcome.failed or active < 0:
        return None
    forces = np.array(hits.peak_force)[: int(hits.count)]
    others = np.where(np.arange(forces.size) == active, -np.inf, forces)
    second = int(np.argmax(others))
    peak = (float(run.peak_force), float(run.peak_time), int(run.peak_contact), active)
    if forces.size < 2 or forces[second] <= 0.0:
        return Peaks(*peak, -1, 0.0, 1.0, "", np.inf)
    # With constant elasticities the logarithms of both peaks are straight lines over that of the parameter.
    closing = slopes[second] / forces[second] - slopes[active] / forces[active]
    with np.errstate(divide="ignore", invalid="ignore"):  # peaks that stay as far apart never swap, equal ones neither
        change = np.log(forces[active] / forces[second]) / closing
    change = np.where(np.isfinite(change), change, np.inf)
    soonest = int(np.argmin(np.abs(change)))
    margin = float(1.0 - forces[second] / forces[active])
    path = paths[soonest] if np.isfinite(change[soonest]) else ""
    return Peaks(*peak, second, float(forces[second]), margin, path, float(np.expm1(change[soonest])))


def judge(
    run: Run,
    names: Sequence[str],
    paths: Sequence[str],
    elasticities: np.ndarray,
    evidence: Evidence | None,
    peaks: Peaks | None,
) -> Certificate:
    """Return the certificate of elasticities (quantities, paths), from the evidence (None for a failed run)."""
    unknown = np.full(elasticities.shape, np.nan)
    if evidence is None:
        refused = (Verdict.refused,) * len(names)
        reason = run.outcome.reason
        return Certificate(unknown, unknown, unknown, unknown, peaks, refused, Verdict.refused, reason, False, 0)
    size = np.maximum(np.abs(elasticities), FLOOR)
    by_tolerance, by_differences, uncertainty = (part / size for part in evidence[:3])
    parts = (by_tolerance, by_differences, uncertainty)
    error = np.max(np.stack(parts), axis=0)  # NaN if any is
    findings = [
        _judged(k, run, names, paths, elasticities, error, parts, peaks, evidence.thorough) for k in range(len(names))
    ]
    verdicts = tuple(verdict for verdict, _ in findings)
    worst = max(verdicts)
    # The first of the worst ones stands for all: quantities come in the order asked for.
    reason = next(finding for verdict, finding in findings if verdict == worst)
    if worst == Verdict.trusted:
        reason = f"two tolerances and differences of tight solves agree within {np.max(error):.1g} of each elasticity"
    return Certificate(error, *parts, peaks, verdicts, worst, reason, evidence.thorough, evidence.solves)


def _judged(
    k: int,
    run: Run,
    names: Sequence[str],
    paths: Sequence[str],
    elasticities: np.ndarray,
    error: np.ndarray,
    parts: Sequence[np.ndarray],
    peaks: Peaks | None,
    thorough: bool,
) -> tuple[Verdict, str]:
    """Return the verdict on one quantity, and why."""
    name = names[k]
    if not np.all(np.isfinite(elasticities[k])):
        return Verdict.refused, f"{name} or its gradient is not finite; the run has {int(run.impact_count)} impacts"
    if not np.all(np.isfinite(error[k])):
        return Verdict.check, f"{name}: no differences could be taken, so only the two tolerances speak for it"
    worst = int(np.argmax(error[k]))
    share = percent_text(error[k, worst]) if error[k, worst] < 1.0 else "more than itself"
    loudest = int(np.argmax([part[k, worst] for part in parts]))
    source = ("by its change with the tolerance", "by differences of tight solves", "as far as differences can tell")
    # A difference along all parameters accuses none of them in particular.
    whose = f"{name} by {paths[worst]}" if thorough or loudest == 0 else f"an elasticity of {name}"
    finding = f"{whose} may be off by {share}, {source[loudest]}"
    if error[k, worst] > HOPELESS:
        return Verdict.refused, finding
    if error[k, worst] > TRUSTED:
        return Verdict.check, finding
    kinked = {run.mechanism.name_of(common) for common in (PEAK_FORCE, PEAK_TIME)}
    if name in kinked and peaks is not None and abs(peaks.swap_change) < KINK:
        return Verdict.check, (
            f"{name} has a kink nearby: impact {peaks.runner_up_impact + 1} comes within"
            f" {percent_text(peaks.margin)} of the peak, and"
            f" {percent_text(peaks.swap_change, '+.2g')} of {peaks.swap_path} would swap them"
        )
    return Verdict.trusted, ""
