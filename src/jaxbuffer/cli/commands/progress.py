"""Work that takes seconds: shown while it runs, and ended at once by Ctrl-C."""

import concurrent.futures
import contextlib
import functools
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import TypeVar

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from ...programs.cache import Compilation, watched
from ...tuning.search.store import Record, in_words

T = TypeVar("T")

STACK = 64 * 2**20  # bytes; compilers recurse deeply, and some systems give threads little
PERIOD = 5.0  # s between lines where nobody watches
SPINNER, TEXT, CLOCK = SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn()
COMPILING = "compiling {}, which usually takes about {:.0f} s (first run only)…"
SHORT = 1.0  # s: a compilation that usually takes less is not worth a line


def working(text: str, work: Callable[[], T]) -> T:
    """Run ``work`` with a spinner on a terminal, after one plain line elsewhere."""
    with _bar(text, None, TEXT, CLOCK) as update:
        if update is None:
            _line(text)
        return _interruptible(work)


def tuning(work: Callable[[Callable[[Record], None]], T], success: str | None = None, most: int | None = None) -> T:
    """Run ``work``, which reports each evaluation: a spinner on a terminal; elsewhere plain lines with the time
    elapsed, at first one each, later one every few seconds.

    ``success``: how runs should end; ``most`` evaluations that there can be.
    """
    begin = latest = time.monotonic()

    def line(it: Record) -> None:
        nonlocal latest
        now = time.monotonic()
        if now - begin > PERIOD and now - latest < PERIOD:
            return
        latest = now
        minutes, seconds = divmod(int(now - begin), 60)
        _line(f"{minutes}:{seconds:02d}, {in_words(it, success, most)}")

    with _bar("tuning", None, TEXT, CLOCK) as update:
        report = line if update is None else lambda it: update(description=in_words(it, success, most))
        return _interruptible(lambda: work(report))


def fitting(work: Callable[[Callable[[str], None]], T], text: str = "fitting") -> T:
    """Run ``work``, which reports how far it is: a spinner on a terminal, a plain line every few seconds elsewhere."""
    latest = -PERIOD

    def line(text: str) -> None:
        nonlocal latest
        if (now := time.monotonic()) - latest >= PERIOD:
            latest = now
            _line(text)

    with _bar(text, None, TEXT, CLOCK) as update:
        report = line if update is None else lambda text: update(description=text)
        return _interruptible(lambda: work(report))


def counting(total: int, work: Callable[[Callable[[str], None]], T]) -> T:
    """Run ``work``, which reports what it has finished, ``total`` times: a bar on a terminal, plain lines elsewhere."""
    with _bar("", total, BarColumn(), MofNCompleteColumn(), TEXT, CLOCK) as update:
        report = _line if update is None else lambda text: update(advance=1, description=text)
        return _interruptible(lambda: work(report))


def sweeping(
    count: int, work: Callable[[Callable[[int, int], None]], T], doing: str = "sweeping", what: str = "runs"
) -> T:
    """Run ``work``, which reports ``what`` it has done of ``count``: a bar with their rate on a terminal, a plain line
    every few seconds elsewhere. It runs here, in the main thread: its own threads compute, and Ctrl-C reaches it."""
    begin = None  # the first report comes after the compilation, which is no part of the rate
    first, due = 0, time.monotonic() + PERIOD

    def rate(done: int) -> str:
        nonlocal begin, first
        if begin is None:
            begin, first = time.monotonic(), done
        seconds = time.monotonic() - begin
        # The first report has nothing before it to tell a rate from.
        if seconds <= 0.0 or done <= first:
            return ""
        per_second = (done - first) / seconds
        return f"{per_second:.{0 if per_second >= 10.0 else 2}f} {what}/s"

    def line(done: int, count: int) -> None:
        nonlocal due
        text = rate(done)
        # The last report always has its line: a log would else end before all is done.
        if done == count or time.monotonic() >= due:
            due = time.monotonic() + PERIOD
            _line(", ".join(filter(None, (f"{done} of {count} done", text))))

    with _bar("", count, BarColumn(), MofNCompleteColumn(), TEXT, CLOCK, TimeRemainingColumn()) as update:
        if update is None:
            _line(f"{doing} {count} {what}")
            return work(line)
        return work(lambda done, count: update(completed=done, description=rate(done)))


def _line(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


@contextlib.contextmanager
def _bar(text: str, total: int | None, *columns: ProgressColumn) -> Iterator[Callable[..., None] | None]:
    """Show a spinner and ``columns`` on a terminal, and yield what updates them; None elsewhere.

    That a program is being compiled is said in the place of the description for as long as it takes, or once on a line
    of its own.
    """
    # On stderr, so that a result can be piped, --json above all.
    console, before, shown = Console(stderr=True), "", False

    def say(compilation: Compilation | None) -> None:
        nonlocal before
        # Once each, also where several shapes of one program are compiled.
        if compilation is not None and compilation.what != before and compilation.seconds >= SHORT:
            before = compilation.what
            _line(COMPILING.format(*compilation))

    def show(compilation: Compilation | None) -> None:
        nonlocal before, shown
        if compilation is None:
            if shown:
                progress.update(task, description=before)
            return
        shown = compilation.seconds >= SHORT
        if shown:
            before = progress.tasks[0].description
            progress.update(task, description=COMPILING.format(*compilation))

    if not console.is_terminal:
        with watched(say):
            yield None
        return
    # Gone at the end, so that the result alone stays on the terminal.
    with Progress(SPINNER, *columns, console=console, transient=True) as progress:
        task = progress.add_task(text, total=total)
        with watched(show):
            yield functools.partial(progress.update, task)


def _interruptible(work: Callable[[], T]) -> T:
    """Run ``work`` in a thread: Python delivers Ctrl-C to the main one, which must not sit in a compiler meanwhile."""
    future: concurrent.futures.Future[T] = concurrent.futures.Future()

    def run() -> None:
        try:
            future.set_result(work())
        except BaseException as error:  # of any kind: the main thread raises it again
            future.set_exception(error)

    before = threading.stack_size(STACK)
    # A daemon, so that the process may end while a compiler is still at work in it.
    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    # The setting holds for every thread that is started, and others need no such stack.
    threading.stack_size(before)
    while thread.is_alive():
        # Not for good: Python delivers a signal only while the main thread runs.
        thread.join(0.2)
    return future.result()
