"""Progress bars of Python and notebooks: text by tqdm, which needs no extension of a notebook."""

import contextlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any

Record = Mapping[str, Any]  # of an evaluation
Counted = Callable[[int, int], None]  # of runs done and asked for
Reported = Callable[[Any], None]


def counted(progress: Counted | bool | None, unit: str) -> Counted | None:
    """Return what to call with runs done and asked for: ``progress`` itself, or a bar for True.

    ``unit``: what is counted."""
    if not isinstance(progress, bool):
        return progress
    return _bar(unit) if progress else None


def _bar(unit: str) -> Counted:
    from tqdm import tqdm

    bar: Any = None

    def advance(done: int, count: int) -> None:
        nonlocal bar
        if bar is None:
            bar = tqdm(total=count, initial=done, unit=f" {unit}")
        bar.update(done - bar.n)
        if done >= count:
            bar.close()

    return advance


@contextlib.contextmanager
def reported(report: Reported | bool | None, in_words: Callable[[Record], str]) -> Iterator[Reported | None]:
    """Yield what to call with each evaluation's record: ``report`` itself, or for True a line that counts the
    evaluations and says the last one ``in_words``."""
    if report is not True:
        yield report or None
        return
    from tqdm import tqdm

    with tqdm(bar_format="{n_fmt} evaluations in {elapsed}{postfix}") as line:

        def advance(record: Record) -> None:
            line.set_postfix_str(in_words(record), refresh=False)
            line.update()

        yield advance
