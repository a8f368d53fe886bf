"""Tasks handed to a cluster, few at a time, until all are done."""

import json
import time
import uuid
from collections.abc import Callable, Generator, Iterator
from typing import Any, TypeVar

from distributed import Client, Future, KilledWorker, as_completed
from distributed.protocol.pickle import dumps

from ..errors import InputError
from .connect import SchedulerGone
from .remote import Refused, checked
from .workers import Workers

R = TypeVar("R")

AHEAD = 2  # tasks a thread that are under way or waiting
ENDED = 10  # workers that may end while they are at one task
PERIOD = 1.0  # s between looks at which workers there are


class TaskEndsWorkers(OSError):
    """Worker after worker ended at the same task."""


def spread(
    client: Client, workers: Workers, work: Callable[[Any, Any], R], common: Any, tasks: Iterator[Any]
) -> Generator[R, None, None]:
    """Yield the result of the work on each task, as they are done; no result is kept here.

    **Arguments:** ``work``: a function of ``common`` and a task, all of which are pickled for the workers; it may be
    called again for a task that it has done, if its worker ends before it could tell.
    **Raises:** what the work does; `SchedulerGone`; `TaskEndsWorkers`; `InputError` where no worker is left that fits.
    """
    under_way = _UnderWay(client, workers, work, common)
    try:
        under_way.fill(tasks)
        while under_way:
            yield from under_way.finished()
            under_way.fill(tasks)
    finally:
        under_way.cancel()


class _UnderWay:
    """Tasks that a cluster has."""

    def __init__(self, client: Client, workers: Workers, work: Callable[[Any, Any], Any], common: Any) -> None:
        self.client, self.workers, self.packed = client, workers, dumps((work, common))
        self.expected = json.dumps([workers.kind, workers.cache])
        self.tasks = dict[Future, tuple[Any, int]]()  # and how many workers have ended at each
        self.watch = as_completed(loop=client.loop, with_results=True, raise_errors=False)
        self.room, self.due = 0, 0.0
        self.name, self.count = f"{work.__name__}-{uuid.uuid4().hex}", 0

    def __bool__(self) -> bool:
        return bool(self.tasks)

    def fill(self, tasks: Iterator[Any]) -> None:
        """Hand out as many tasks as are good to have waiting."""
        if time.monotonic() >= self.due:
            # Workers may come and go during a sweep: room and differences are those of the workers there are now.
            self.workers.look()
            self.room, self.due = AHEAD * max(1, self.workers.threads), time.monotonic() + PERIOD
        while len(self.tasks) < self.room and (task := next(tasks, None)) is not None:
            self.submit(task, 0)

    def submit(self, task: Any, ended: int) -> None:
        """Hand out a task at which so many workers have ended."""
        confined = self.workers.allowed
        arguments = (self.expected, self.packed, dumps(task))
        self.count += 1
        if self.client.status != "running":
            raise SchedulerGone
        key = (self.name, self.count)  # one group of tasks for the scheduler, which has a record of each group
        # Other workers are allowed: one that comes later may fit, and `checked` refuses on one that does not.
        future = self.client.submit(
            checked, *arguments, key=key, pure=False, workers=confined, allow_other_workers=confined is not None
        )
        self.tasks[future] = task, ended
        self.watch.add(future)

    def finished(self) -> Iterator[Any]:
        """Yield the results of the tasks that are done, and hand out again those that have to be done again."""
        for future, result in self.watch.next_batch():
            task, ended = self.tasks.pop(future)
            if future.status == "error":
                self.submit(task, self._after(result[1], task, ended))
            elif future.status != "finished":
                raise SchedulerGone
            elif isinstance(result, Refused):
                self._refuse(result)
                self.submit(task, ended)
            else:
                yield result

    def cancel(self) -> None:
        if self.tasks and self.client.status == "running":
            self.client.cancel([*self.tasks], force=True)

    def _after(self, error: BaseException, task: Any, ended: int) -> int:
        """Return how many workers have ended at the task by now.

        **Raises:** any error but that of a worker which ended, or which does not fit and was not known.
        """
        if isinstance(error, KilledWorker):
            if ended + 1 >= ENDED:
                raise TaskEndsWorkers(f"{ENDED} times the workers ended that were at {task}") from None
            return ended + 1
        unfit = len(self.workers.unfit)
        self.workers.look()
        if len(self.workers.unfit) == unfit:
            raise error
        return ended

    def _refuse(self, refusal: Refused) -> None:
        self.workers.refuse(refusal.worker, refusal.differs)
        self.workers.look()
        if not self.workers.fit:
            names = ", ".join(refusal.differs)
            raise InputError(f"no worker is left that can be used; {refusal.worker} differs in {names}")
