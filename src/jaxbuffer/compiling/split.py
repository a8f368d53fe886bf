"""A program in two parts, compiled side by side.

XLA compiles most of a program on one core, and a loop that is one kernel cannot be taken apart (see `process`). What is
computed from the loop's results need not wait for that: it is traced and compiled meanwhile.
"""

import contextlib
import gc
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import jax
from jax.stages import Compiled


@contextlib.contextmanager
def _uncollected() -> Iterator[None]:
    """Without garbage collections, which go through everything that is being traced again and again."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


@_uncollected()
def compiled(
    function: Callable[..., list[Any]], arguments: Sequence[Any], first: Callable[..., list[Any]] | None = None
) -> list[Compiled]:
    """A function of arrays compiled for arguments like these, for `run`; with ``first``, whose results it takes after
    the arguments, in two parts."""
    if first is None:
        return [jax.jit(function).lower(*arguments).compile()]
    beginning = jax.jit(first).lower(*arguments)
    with ThreadPoolExecutor(1) as beside:
        begun = beside.submit(beginning.compile)
        found = jax.tree.leaves(beginning.out_info)
        rest = jax.jit(function).lower(*arguments, *found).compile()
        return [begun.result(), rest]


def run(parts: Sequence[Compiled], arguments: Sequence[Any]) -> list[Any]:
    """What the function returns: a second part gets the arguments and what the first one found."""
    found = parts[0](*arguments)
    return parts[1](*arguments, *found) if len(parts) > 1 else found
