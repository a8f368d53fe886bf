"""Equal accuracy: from a solver's work-precision curve the cheapest setting that can be relied on.

A loose tolerance may hit the mark by luck. One is relied on where its errors, and those of all tighter ones on the same
curve, are within the target. The product and its peers are chosen by this one rule.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import takewhile
from typing import Any, Protocol, TypeVar

T = TypeVar("T")

RTOLS = tuple(10.0 ** (-9 + k / 2) for k in range(13))  # tight to loose
TARGET = 1e-4  # [-] relative error of peak force and of end time
NOISE = 1.6  # [-] by which one time may be off another of the same run, minutes later
LONG = 2.0  # [s] a run that takes longer is not repeated: it shows no jitter worth the wait


class Numbers(Protocol):
    """What is compared of a capture, whoever made it."""

    @property
    def outcome(self) -> str: ...
    @property
    def impacts(self) -> int: ...
    @property
    def peak_force(self) -> float: ...  # [N]
    @property
    def end_time(self) -> float: ...  # [s]


@dataclass(frozen=True)
class Result:
    """The numbers alone; they serve as reference too."""

    outcome: str
    impacts: int
    peak_force: float  # [N]
    end_time: float  # [s]


def errors(result: Numbers, exact: Numbers) -> dict[str, float]:
    """Relative errors [-] of peak force and end time; infinite where the captures differ in kind."""
    if (result.outcome, result.impacts) != (exact.outcome, exact.impacts):
        return {"peak": float("inf"), "end": float("inf")}
    return {
        "peak": abs(result.peak_force / exact.peak_force - 1.0),
        "end": abs(result.end_time / exact.end_time - 1.0),
    }


@dataclass(frozen=True)
class Setting:
    """A solver with its tolerances, the errors they leave and the time they cost."""

    solver: str
    tolerances: str
    errors: dict[str, float]  # [-] by name
    seconds: float  # [s] warm, the best of several
    run: Callable[[], Any] = field(repr=False, compare=False)
    choice: Mapping[str, Any] = field(default_factory=dict, compare=False)  # by which another process finds it again

    @property
    def error(self) -> float:
        """The largest of the errors [-]."""
        return max(self.errors.values())


def best_of(repeats: int, run: Callable[[], T]) -> tuple[T, float]:
    """The last result of ``run`` and the shortest of its times [s]: what others do on the machine only adds."""
    shortest = float("inf")
    for _ in range(repeats):
        begin = time.perf_counter()
        result = run()
        shortest = min(shortest, time.perf_counter() - begin)
        if shortest > LONG:
            break
    return result, shortest


def measured(
    solver: str,
    tolerances: str,
    run: Callable[[], T],
    errors_of: Callable[[T], dict[str, float]],
    repeats: int = 1,
    **choice: Any,
) -> Setting:
    """The setting that ``run`` has built in, described by ``choice`` too."""
    result, seconds = best_of(repeats, run)
    return Setting(solver, tolerances, errors_of(result), seconds, run, choice)


def reliable(curve: Iterable[Setting], target: float) -> list[Setting]:
    """The settings of a ``curve``, tight to loose, up to the first whose error is above ``target`` [-]."""
    return list(takewhile(lambda setting: setting.error <= target, curve))


def cheapest(curves: Iterable[Sequence[Setting]], target: float, repeats: int = 3) -> Setting | None:
    """The quickest setting to rely on among several curves, or None where no curve has one.

    The machine's speed may have changed along a curve: all settings that may be the quickest run once more in a race.
    """
    settings = [setting for curve in curves for setting in reliable(curve, target)]
    quickest = min((setting.seconds for setting in settings), default=0.0)
    near = race([setting for setting in settings if setting.seconds <= NOISE * quickest], repeats, anew=True)
    return min(near, key=lambda setting: setting.seconds, default=None)


def race(settings: Sequence[Setting], repeats: int, anew: bool = False) -> list[Setting]:
    """The ``settings`` timed, taking turns, so that all of them meet the same state of the machine; ``anew``: without
    regard to how long those took before that are run once more."""
    shortest = [float("inf") if anew and setting.seconds <= LONG else setting.seconds for setting in settings]
    for _ in range(repeats):
        for place, setting in enumerate(settings):
            if setting.seconds <= LONG:
                shortest[place] = min(shortest[place], best_of(1, setting.run)[1])
    return [replace(setting, seconds=seconds) for setting, seconds in zip(settings, shortest, strict=True)]
