"""Many turns of the reference design: ``python -m benchmarks peers.slider_crank.statistics``.

The motion is chaotic: single peaks mean nothing after some dozens of impacts, averages do. Their standard errors are by
means of batches of whole turns, the first ten turns left out. Printed too: how many impacts it takes until the peaks of
two runs whose clearances differ by 1e-12 of it differ by 1e-3.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from .compiled import njit
from .model import FORCE, STATES, evaluate
from .parameters import SliderCrank, completed
from .run import Run, simulate

SETTLING = 10  # turns left out
BATCHES = 20


@njit
def forces(course, p):
    """The larger of both contact forces [N] at the start of each step."""
    force, slope, joints = np.zeros(course.shape[0]), np.empty(STATES), np.zeros((2, 6))
    for row in range(course.shape[0]):
        at = course[row]
        evaluate(at[1 : STATES + 1], at[STATES + 1 : STATES + 3], at[STATES + 3 : STATES + 5], p, slope, joints)
        force[row] = max(joints[0, FORCE], joints[1, FORCE])
    return force


def by_turn(run: Run, turns: int) -> Mapping[str, np.ndarray]:
    """Numbers of each turn after the settling: an impact belongs to the turn it begins in.

    The largest force of a turn is that of its impacts' peaks and of the steps' ends within long contacts.
    """
    period = 2.0 * math.pi / run.crank.speed
    touch, peak, release = run.log[:, 1], run.log[:, 4], run.log[:, 6]
    release = np.where(np.isfinite(release), release, turns * period)
    time, force = run.course[:, 0], forces(run.course, run.crank)
    columns: dict[str, list[float]] = {
        name: [] for name in ("impacts", "sum of peaks", "largest force", "contact share")
    }
    for turn in range(SETTLING, turns):
        begin, end = turn * period, (turn + 1) * period
        own = (touch >= begin) & (touch < end)
        columns["impacts"].append(float(np.sum(own)))
        columns["sum of peaks"].append(float(np.sum(peak[own])))
        within = slice(*np.searchsorted(time, (begin, end)))
        columns["largest force"].append(max(np.max(force[within]), np.max(peak[own], initial=0.0)))
        shared = np.clip(np.minimum(release, end) - np.maximum(touch, begin), 0.0, None)
        columns["contact share"].append(float(np.sum(shared)) / period)
    return {name: np.array(values) for name, values in columns.items()}


def mean_and_error(values: np.ndarray, weights: np.ndarray | None = None) -> tuple[float, float]:
    """Mean over the turns, or ratio of the sums where ``weights`` are given, and standard error by batch means."""
    over = np.ones_like(values) if weights is None else weights
    batches = np.array_split(np.arange(len(values)), BATCHES)
    mean = float(np.sum(values) / np.sum(over))
    ratios = np.array([np.sum(values[b]) / np.sum(over[b]) for b in batches])
    return mean, float(np.std(ratios, ddof=1) / math.sqrt(BATCHES))


def statistics(crank: SliderCrank, turns: int, rtol: float = 1e-10) -> dict[str, tuple[float, float]]:
    """Mean and standard error of each quantity."""
    run = simulate(crank, turns * 2.0 * math.pi / crank.speed, rtol, impacts=200 * turns, rows=4000 * turns)
    if run.log.shape[0] == 200 * turns or run.course.shape[0] == 4000 * turns:
        raise RuntimeError("log or course is full")
    per_turn = by_turn(run, turns)
    means = {name: mean_and_error(per_turn[name]) for name in ("impacts", "largest force", "contact share")}
    if np.sum(per_turn["impacts"]) > 0.0:
        means["peak force"] = mean_and_error(per_turn["sum of peaks"], per_turn["impacts"])
    return means


def parting(crank: SliderCrank, shift: float = 1e-12, apart: float = 1e-3, rtol: float = 1e-13) -> int:
    """The impact (from 1) at which a relative ``shift`` of the clearance has moved the peak by ``apart``; 0: none."""
    crank = completed(crank)
    runs = [
        simulate(crank._replace(clearance=crank.clearance * (1.0 + part)), 0.2, rtol, impacts=150).log[:, 4]
        for part in (0.0, shift)
    ]
    both = min(len(runs[0]), len(runs[1]))
    far = np.abs(runs[1][:both] / runs[0][:both] - 1.0) > apart
    return int(np.argmax(far)) + 1 if np.any(far) else 0


def main(turns: int = 200) -> None:
    """Print both."""
    designs = {"reference": SliderCrank(), "friction 0.03": SliderCrank(friction=0.03)}
    for name, crank in designs.items():
        print(f"{name}, {turns} turns")
        for quantity, (mean, error) in statistics(crank, turns).items():
            print(f"  {quantity}: {mean:.6g} ± {error:.2g}")
        firsts = [parting(crank, 1e-12 * k) for k in (1.0, -1.0, 2.0, -2.0, 3.0)]
        print(f"  runs 1e-12, -1e-12, 2e-12, -2e-12, 3e-12 of the clearance apart differ by 1e-3 at impact {firsts}")
