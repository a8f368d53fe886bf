"""Work that takes seconds: shown while it runs, and ended at once by Ctrl-C."""

import concurrent.futures
import sys
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

if TYPE_CHECKING:
    from ..tune import Iteration

T = TypeVar("T")

STACK = 64 * 2**20  # bytes; compilers recurse deeply, and some systems give threads little
SPINNER, TEXT, CLOCK = SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn()
COMPILING = "compiling (first run only)…"


def working(text: str, work: Callable[[], T]) -> T:
    """Run ``work`` with a spinner on a terminal, after one plain line elsewhere."""
    console = Console(stderr=True)
    if not console.is_terminal:
        print(text, file=sys.stderr, flush=True)
        return _interruptible(work)
    with Progress(SPINNER, TEXT, CLOCK, console=console, transient=True) as progress:
        progress.add_task(text, total=None)
        return _interruptible(work)


def tuning(iterations: int, work: "Callable[[Callable[[Iteration], None]], T]") -> T:
    """Run ``work``, which reports each iteration: a bar on a terminal, a plain line each elsewhere."""
    console = Console(stderr=True)
    if not console.is_terminal:
        print(COMPILING, file=sys.stderr, flush=True)

        def line(it: "Iteration") -> None:
            print(f"iteration {it.number + 1} of {iterations}: {_state(it)}", file=sys.stderr, flush=True)

        return _interruptible(lambda: work(line))
    with Progress(SPINNER, BarColumn(), MofNCompleteColumn(), TEXT, CLOCK, console=console, transient=True) as progress:
        task = progress.add_task(COMPILING, total=iterations)

        def advance(it: "Iteration") -> None:
            last = it.number + 1 == iterations
            text = "verifying the tuned design…" if last else _state(it)
            progress.update(task, completed=it.number + 1, description=text)

        return _interruptible(lambda: work(advance))


def counting(total: int, work: "Callable[[Callable[[str], None]], T]") -> T:
    """Run ``work``, which reports what it has finished, ``total`` times: a bar on a terminal, plain lines elsewhere."""
    console = Console(stderr=True)
    if not console.is_terminal:
        print(COMPILING, file=sys.stderr, flush=True)
        return _interruptible(lambda: work(lambda text: print(text, file=sys.stderr, flush=True)))
    with Progress(SPINNER, BarColumn(), MofNCompleteColumn(), TEXT, CLOCK, console=console, transient=True) as progress:
        task = progress.add_task(COMPILING, total=total)
        return _interruptible(lambda: work(lambda text: progress.update(task, advance=1, description=text)))


def _state(iteration: "Iteration") -> str:
    return f"worst peak {iteration.worst_peak:.4g} N" + ("" if iteration.captured else ", not captured")


def _interruptible(work: Callable[[], T]) -> T:
    """Run ``work`` in a thread: Python delivers Ctrl-C to the main one, which must not sit in a compiler meanwhile."""
    future: concurrent.futures.Future[T] = concurrent.futures.Future()

    def run() -> None:
        try:
            future.set_result(work())
        except BaseException as error:  # of any kind: the main thread raises it again
            future.set_exception(error)

    before = threading.stack_size(STACK)
    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    threading.stack_size(before)
    while thread.is_alive():
        thread.join(0.2)
    return future.result()
