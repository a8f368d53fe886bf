"""Threads that call compiled programs, which run outside Python."""

import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

I = TypeVar("I")  # noqa: E741 # an item
R = TypeVar("R")


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0))


class Pool:
    """``workers`` threads, one a core by default, until `close`."""

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or cores()
        self._threads = ThreadPoolExecutor(self.workers)

    def map(self, function: Callable[[I], R], items: Iterable[I]) -> list[R]:
        """Return what the function returns for each item, in their order."""
        return list(self._threads.map(function, items))

    def close(self) -> None:
        """End the threads; calls that have not begun are dropped."""
        self._threads.shutdown(cancel_futures=True)
