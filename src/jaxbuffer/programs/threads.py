"""Threads that call compiled programs, which run outside Python."""

import itertools
import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from typing import TypeVar

I = TypeVar("I")  # noqa: E741 # an item
R = TypeVar("R")


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0))


class Pool:
    """``workers`` threads, one a core by default, until `close`."""

    def __init__(self, workers: int | None = None) -> None:
        self.workers = workers or cores()
        self._threads = ThreadPoolExecutor(self.workers)

    def map(self, function: Callable[[I], R], items: Iterable[I]) -> list[R]:
        """What the function returns for each item, in their order."""
        return list(self._threads.map(function, items))

    def as_completed(self, function: Callable[[I], object], items: Iterable[I]) -> Iterator[None]:
        """Whenever some items are done, with few calls waiting, and close: an interrupt at once leaves the calls under
        way to themselves."""
        todo, running = iter(items), set[Future[object]]()
        try:
            while True:
                fresh = itertools.islice(todo, 2 * self.workers - len(running))
                running |= {self._threads.submit(function, item) for item in fresh}
                if not running:
                    return
                finished, running = wait(running, return_when=FIRST_COMPLETED)
                for future in finished:
                    future.result()
                yield
        finally:
            self.close(wait=False)

    def close(self, wait: bool = True) -> None:
        """End the threads; calls that have not begun are dropped."""
        self._threads.shutdown(wait=wait, cancel_futures=True)
