"""How long a peer takes, and how loosely it may be run: the figures to compare with."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from .course import PeerCapture
from .reference import Reference
from .solvers import solve

RTOLS = tuple(10.0 ** (-9 + k / 2) for k in range(13))  # tight to loose
ATOL_PARTS = (1e-2, 1e-4)  # atol as a part of rtol: [m, rad, m/s, rad/s] of a motion of about 0.1 m and 0.1 m/s


@dataclass(frozen=True)
class Setting:
    """Tolerances, the errors they leave and the time they cost."""

    rtol: float
    atol: float
    peak_error: float  # [-]
    end_error: float  # [-]
    seconds: float  # [s] warm, the best of several runs


def best_of(repeats: int, run: Callable[[], PeerCapture]) -> tuple[PeerCapture, float]:
    """The last result of ``run`` and the shortest of its times [s]: what others do on the machine only adds."""
    shortest = float("inf")
    for _ in range(repeats):
        begin = time.perf_counter()
        result = run()
        shortest = min(shortest, time.perf_counter() - begin)
    return result, shortest


def reliable(peer: str, reference: Reference, tolerance: float = 1e-4, repeats: int = 3) -> Iterator[Setting]:
    """Settings at which, and at all tighter ones, peak force and end time are within ``tolerance`` of the reference.

    A loose setting may hit the mark by luck; that the tighter ones do too is what makes it one to rely on.
    """
    for part in ATOL_PARTS:
        for rtol in RTOLS:
            atol = rtol * part
            capture, seconds = best_of(repeats, lambda: solve(peer, reference.parameters, rtol, atol))  # noqa: B023
            errors = reference.errors(capture)
            if not reference.alike(capture) or max(errors) > tolerance:
                break
            yield Setting(rtol, atol, *errors, seconds)
