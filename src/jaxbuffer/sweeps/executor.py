"""Calls handed to an executor: threads of this process by default, or whatever `concurrent.futures` has a class for."""

import functools
import itertools
import os
import uuid
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from ..block_store import differing
from ..errors import InputError
from ..programs.process import Kind, kind, prepared
from ..programs.store import folder

I = TypeVar("I")  # noqa: E741 # an item
R = TypeVar("R")
PROCESS = uuid.uuid4().hex  # differs between machines, on which processes may have the same number


class Where(NamedTuple):
    """Where a sweep is computed and stored, and who watches it; ``executor`` may be a client, the rest is as in
    `sweep`."""

    executor: Any
    workers: int | None
    progress: Callable[[int, int], None] | None
    folder: str | Path | None
    resume: bool


def completed(
    function: Callable[[I], R], items: Iterable[I], workers: int, executor: Executor | None = None
) -> Iterator[R]:
    """Yield what the function returns for each item, whichever is done first, with at most two calls a worker handed
    out. An interrupt leaves the calls under way to themselves and drops those that wait.

    **Arguments:** ``workers``: threads of our own, or how many calls the ``executor`` runs at a time.
    **Raises:** `InputError` where a process of the executor computes other bits, `ConnectionError` where it ended.
    """
    pool, call = (ThreadPoolExecutor(workers), function) if executor is None else (executor, _elsewhere(function))
    waiting, running = iter(items), set[Future[R]]()
    try:
        while True:
            # Two calls a worker: each has its next one at hand, and few are left to drop after an interrupt.
            running |= {_submitted(pool, call, item) for item in itertools.islice(waiting, 2 * workers - len(running))}
            if not running:
                return
            finished, running = wait(running, return_when=FIRST_COMPLETED)
            for future in finished:
                yield future.result()
    except BrokenExecutor as error:
        raise ConnectionError(f"the executor is broken: {error}") from None
    finally:
        for future in running:
            future.cancel()
        if executor is None:
            # Only our own threads: an executor that was given stays open.
            pool.shutdown(wait=False, cancel_futures=True)


def _submitted(pool: Executor, call: Callable[[I], R], item: I) -> Future[R]:
    """Hand out a call to the executor.

    **Raises:** `InputError` where the executor takes none, because it was shut down.
    """
    try:
        return pool.submit(call, item)
    # A broken executor is a `RuntimeError` too, but `completed` has its own message for it.
    except BrokenExecutor:
        raise
    except RuntimeError as error:
        raise InputError(f"the executor takes no calls: {error}; give one that has not been shut down") from None


def check_executor(executor: Any) -> None:
    """Raise `InputError` for what is no executor."""
    if not isinstance(executor, Executor):
        example = "concurrent.futures.ThreadPoolExecutor(), client.get_executor() of a distributed.Client"
        raise InputError(f"executor = {executor!r} is no concurrent.futures.Executor, as in {example}")


def _elsewhere(function: Callable[[I], R]) -> Callable[[I], R]:
    """Return the function with a check of the process that it is called in, for executors that have other processes."""
    cache = folder()
    return functools.partial(_checked, function, _address(), kind(), None if cache is None else str(cache))


def _checked(function: Callable[[I], R], home: str, expected: Kind, cache: str | None, item: I) -> R:
    """Call the function, if this process computes the ``expected`` kind of numbers.

    **Arguments:** ``home``: the address of the process that hands out calls; ``cache``: its folder of programs.
    """
    here = _address()
    if here != home and (names := differing(expected, prepared(here, cache))):
        what = ", ".join(names)
        raise InputError(f"a process of the executor differs from this one in {what}, and so might its bits")
    return function(item)


def _address() -> str:
    """Return an address that differs for each process.

    The process number is read at each call, because a fork copies `PROCESS`.
    """
    return f"{PROCESS}-{os.getpid()}"
