"""Levers of a tuning or a choice, found after all else: with a spinner, and left out where Ctrl-C ends it."""

import time
from collections.abc import Callable
from typing import TypeVar

from ..streams import note
from .progress import working

T = TypeVar("T")

LEFT_OUT = "all but the levers is there"


def find_levers(result: T, find: Callable[[T], T]) -> tuple[T, bool]:
    """Return a result as ``find`` gives it its levers, and whether Ctrl-C has left them out."""
    begun = time.perf_counter()
    try:
        with_levers = working("finding levers among all numbers of the design", lambda: find(result))
    except KeyboardInterrupt:
        return result, True
    note(f"levers took {time.perf_counter() - begun:.1f} s")
    return with_levers, False
