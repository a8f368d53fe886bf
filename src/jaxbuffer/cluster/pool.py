"""A pool whose workers are those of a cluster, in the place of `threads.Pool`."""

import contextlib
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

from .connect import connected
from .spread import spread
from .workers import Workers

R = TypeVar("R")


class ClusterPool:
    """The workers of a client, or of a scheduler by its address, until `close`."""

    def __init__(self, where: Any, workers: int | None = None) -> None:
        # The client is closed where no worker fits, and stays open otherwise.
        with contextlib.ExitStack() as stack:
            self.client = stack.enter_context(connected(where, workers))
            self.workers = Workers(self.client)
            self._open = stack.pop_all()

    def map(self, function: Callable[[Any], R], items: Iterable[Any]) -> list[R]:
        """Return what the function returns for each item, in their order.

        Both are sent: a function by its name, or a `functools.partial` of one.
        """
        # Results come as they are done; the numbers bring them back into the order of the items.
        results = spread(self.client, self.workers, _numbered, function, iter([*enumerate(items)]))
        return [result for _, result in sorted(results, key=lambda it: it[0])]

    def close(self) -> None:
        """Leave the cluster, or end it if it is our own."""
        self._open.close()


def _numbered(function: Callable[[Any], R], item: tuple[int, Any]) -> tuple[int, R]:
    return item[0], function(item[1])
