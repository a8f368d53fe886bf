"""What runs on a worker. A scheduler imports this module as well, and unpickles what names it: so it imports nothing
heavy, and work and data come as bytes, which only workers open."""

import functools
import json
from typing import Any, NamedTuple

from distributed import get_worker
from distributed.protocol.pickle import loads


class Refused(NamedTuple):
    """What a worker answers that must not compute."""

    worker: str
    differs: list[str]


def looked_at(cache: str | None, dask_worker: Any) -> dict[str, str]:
    """Return what this worker computes with: `prepared`, as `distributed.Client.run` calls it."""
    from ..programs.process import prepared  # imports JAX, which a scheduler is spared

    return prepared(dask_worker.address, cache)


def checked(expected: str, packed: bytes, task: bytes) -> Any:
    """Return the result of the work on a task, if this worker is of the kind expected; else a `Refused` with what
    differs.

    **Arguments:** ``expected``: kind and folder of compiled programs, as JSON; ``packed``: the work, a function, and
    its first argument; ``task``: its second one.
    """
    from ..block_store import differing  # imports NumPy
    from ..programs.process import prepared  # imports JAX, which a scheduler is spared

    kind, cache = json.loads(expected)
    address = get_worker().address
    # A worker that came after the task was handed out may have got it: each checks itself before it computes.
    differs = differing(kind, prepared(address, cache))
    if differs:
        return Refused(address, differs)
    work, common = _opened(packed)
    return work(common, loads(task))


@functools.lru_cache(maxsize=8)
def _opened(packed: bytes) -> Any:
    """Unpickle the work, and return the same objects to all tasks that share them.

    A program that is made for one task is found again by the next.
    """
    return loads(packed)
