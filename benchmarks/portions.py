"""Campaigns in portions: from a run's number on, until some minutes have passed or Ctrl-C is pressed."""

import signal
import time
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import jax

from .optional_parts import Structure


class Case(NamedTuple):
    """One run of a campaign: its ``number`` among all; its ``study``, and which one, ``structure``, of how many; its
    ``label`` in lists; ``design`` and ``scenario``."""

    number: int
    structure: int
    study: Structure
    label: str
    design: Any
    scenario: Any


def cases(studies: list[Structure], count: int, seed: int, first: int = 0) -> Iterator[Case]:
    """The runs of studies, ``count`` in all, from number ``first`` on; always the same for a seed."""
    each = -(-count // len(studies))
    for k, study in enumerate(studies):
        if (k + 1) * each <= first:
            continue
        for number, (design, scenario) in enumerate(study.drawn(each, seed + k)):
            if k * each + number >= first:
                label = f"{number}" if len(studies) == 1 else f"{k}:{number} ({', '.join(study.parts)})"
                yield Case(k * each + number, k, study, label, design, scenario)
        jax.clear_caches()  # the programs of one structure serve no other


class Portion:
    """How long a campaign goes on: ``minutes``, if any, or until Ctrl-C or a request to end.

    The run under way is finished, so that its campaign says what the runs up to it have shown; a second Ctrl-C stops at
    once. ``stopped``: whether it is over; ``following``: the number of the next run, None if there is none.
    """

    def __init__(self, minutes: float | None = None) -> None:
        self.end = float("inf") if minutes is None else time.monotonic() + 60.0 * minutes
        self.stopped = False
        self.following: int | None = None

    def of(self, runs: Iterable[Case]) -> Iterator[Case]:
        """Those runs for which there is time."""
        before = {number: signal.signal(number, self._stop) for number in (signal.SIGINT, signal.SIGTERM)}
        self.following = None
        try:
            for case in runs:
                self.stopped |= time.monotonic() >= self.end
                if self.stopped:
                    self.following = case.number
                    return
                yield case
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    @property
    def remark(self) -> str:
        """How to go on, for a campaign's counts; empty if all runs were made."""
        return "" if self.following is None else f"; stopped: go on with --first {self.following}"

    def _stop(self, *_: Any) -> None:
        if self.stopped:
            raise KeyboardInterrupt
        self.stopped = True
