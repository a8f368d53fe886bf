"""Calls handed to threads of this process, or to any executor of `concurrent.futures`."""

import functools
import itertools
import os
import platform
import time
import uuid
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from typing import Any, NamedTuple, TypeVar

from ..block_store import differing
from ..errors import InputError
from ..programs.process import HOST, Kind, check_ready, kind, prepared
from ..programs.store import folder
from ..programs.threads import cores

I = TypeVar("I")  # noqa: E741 # an item
R = TypeVar("R")
PROCESS = uuid.uuid4().hex  # differs between machines, on which processes may have the same number
WAITING = 1000  # calls handed to a given executor at a time, so that it may have many processes, and get more
REFUSALS = 10  # in a row, with no other call under way, after which no process is expected to fit
PAUSE = 0.5  # s that a process waits before it refuses: free at once, it would be given all calls while others compute
PATIENCE = 20.0  # s until it is said that no process answers


class Answer(NamedTuple):
    """What a process answers: the ``value`` of a call, or in what it ``differs``, so that it must not compute.

    ``process``: its name for people; ``kind``: what its numbers depend on, None in the process that asks.
    """

    process: str
    kind: Kind | None
    differs: list[str]
    value: Any = None


class Pool:
    """Threads of this process, or the processes of an executor, to which calls are handed until `close`.

    **Arguments:** ``executor``: None for threads of this process; one that is given stays open; ``workers``: threads,
    or about how many calls the executor runs at a time, by default one a core.
    """

    def __init__(self, executor: Executor | None = None, workers: int | None = None) -> None:
        if executor is not None and not isinstance(executor, Executor):
            example = "concurrent.futures.ThreadPoolExecutor(), client.get_executor() of a distributed.Client"
            raise InputError(f"executor = {executor!r} is no concurrent.futures.Executor, as in {example}")
        self.workers, self.given = workers or cores(), executor is not None
        self.made_on: Mapping[str, str] | None = None  # the kind of process that results were found by before
        self._executor = executor or ThreadPoolExecutor(self.workers)
        self._name, self._calls, self._unfit = uuid.uuid4().hex, itertools.count(), set[str]()

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End threads of our own; calls that have not begun are dropped, those under way are left to themselves."""
        if not self.given:
            self._executor.shutdown(wait=False, cancel_futures=True)

    @functools.cached_property
    def kind(self) -> Kind:
        """Return what all processes that compute agree in.

        It is ``made_on`` where that is known. Else the installation is that of this process and the machine that of
        the first process that answers, because this one may run on a login node.

        **Raises:** `InputError` where no process fits, `ConnectionError` where the executor has ended.
        """
        mine, unfit = dict(kind()), list[Answer]()
        probes = {self._submitted(_probe) for _ in range(self.workers if self.given else 0)}
        while probes:
            finished, probes = wait(probes, PATIENCE, FIRST_COMPLETED)
            if not finished:
                warnings.warn("no process of the executor has answered yet; waiting for one", stacklevel=2)
            for answer in map(_result, finished):
                theirs = answer.kind or mine
                expected = dict(self.made_on or mine | {name: theirs[name] for name in HOST})
                if not (differs := differing(expected, theirs)):
                    return expected
                unfit.append(answer._replace(differs=differs))
                self._leave_out(unfit[-1])
        if unfit:
            raise InputError(f"no process of the executor can be used: {_in_words(unfit[-1])}")
        return mine

    def map(self, function: Callable[[I], R], items: Iterable[I]) -> list[R]:
        """Return what the function returns for each item, in their order."""
        results = self.completed(functools.partial(_numbered, function), enumerate(items))
        return [result for _, result in sorted(results, key=lambda it: it[0])]

    def completed(self, function: Callable[[I], R], items: Iterable[I]) -> Iterator[R]:
        """Yield what the function returns for each item, whichever is done first.

        An interrupt leaves the calls under way to themselves and drops those that wait. The executor pickles function
        and items.

        **Raises:** what the function does; `InputError` where no process of the executor fits; `ConnectionError` where
        the executor has ended.
        """
        # Two calls a thread of our own: each has its next one at hand, and few are left to drop after an interrupt.
        most = max(2 * self.workers, WAITING if self.given else 0)
        expected = self.kind if self.given else None
        waiting, refused, refusals = enumerate(items), list[int](), 0
        pending, running = dict[int, I](), dict[Future[Answer], int]()
        try:
            while True:
                # A scheduler may give a call that is alone to the process that has just refused it, again and again.
                copies = 1 if running else max(2, self.workers)
                again = [number for number in refused for _ in range(copies)]
                new = dict(itertools.islice(waiting, most - len(pending)))
                pending |= new
                for number in (*again, *new):
                    running[self._submitted(_called, expected, function, pending[number])] = number
                if not pending:
                    return
                refused = []
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    number, answer = running.pop(future), _result(future)
                    if number not in pending:  # a copy was quicker
                        continue
                    if not answer.differs:
                        del pending[number]
                        refusals = 0
                        yield answer.value
                        continue
                    self._leave_out(answer)
                    refusals += 1
                    if number not in running.values():
                        refused.append(number)
                if refusals >= REFUSALS and not running:
                    raise InputError(f"no process of the executor is left that can be used: {_in_words(answer)}")
        finally:
            for future in running:
                future.cancel()

    def _submitted(self, function: Callable[..., Answer], *arguments: Any) -> Future[Answer]:
        """Hand out a call to the executor.

        **Raises:** `InputError` where the executor takes none, because it was shut down.
        """
        programs = folder()
        # Dask takes calls with equal arguments for one call, whose result it has already: so each has a number.
        number = f"{self._name}-{next(self._calls)}"
        try:
            return self._executor.submit(
                function, _address(), None if programs is None else str(programs), number, *arguments
            )
        except BrokenExecutor as error:
            raise _broken(error) from None
        except RuntimeError as error:
            raise InputError(f"the executor takes no calls: {error}; give one that has not been shut down") from None

    def _leave_out(self, answer: Answer) -> None:
        """Say, once for each process, that it computes nothing."""
        if answer.process not in self._unfit:
            self._unfit.add(answer.process)
            warnings.warn(f"{answer.process} is left out: {_in_words(answer)}", stacklevel=3)


def _result(future: Future[Answer]) -> Answer:
    """Return what a process has answered. **Raises:** `ConnectionError` where the executor has ended."""
    try:
        return future.result()
    except BrokenExecutor as error:
        raise _broken(error) from None
    except CancelledError:
        raise ConnectionError("the executor has dropped its calls: its scheduler is gone or it was shut down") from None


def _broken(error: BrokenExecutor) -> ConnectionError:
    return ConnectionError(f"the executor is broken: {error}")


def _in_words(answer: Answer) -> str:
    return f"it differs in {', '.join(answer.differs)}, and so might its bits"


def _probe(home: str, cache: str | None, number: str) -> Answer:
    """Answer what this process computes with.

    **Arguments:** ``home``: the address of the process that asks; ``cache``: its folder of programs; ``number``: of
    the call.
    """
    here = _address()
    theirs = None if here == home else prepared(here, cache)
    return Answer(f"process {os.getpid()} of {platform.node()}", theirs, [])


def _called(
    home: str, cache: str | None, number: str, expected: Kind | None, function: Callable[[Any], Any], item: Any
) -> Answer:
    """Call the function, if this process is the one that asks or computes the ``expected`` kind of numbers.

    Processes may come at any time, so that each checks itself before it computes.
    """
    answer = _probe(home, cache, number)
    if answer.kind is not None:
        if differs := differing(expected or {}, answer.kind):
            time.sleep(PAUSE)
            return answer._replace(differs=differs)
        check_ready()  # a process that was forked would hang
    return answer._replace(value=function(item))


def _address() -> str:
    """Return an address that differs for each process.

    The process number is read at each call, because a fork copies `PROCESS`.
    """
    return f"{PROCESS}-{os.getpid()}"


def _numbered(function: Callable[[I], R], item: tuple[int, I]) -> tuple[int, R]:
    return item[0], function(item[1])
