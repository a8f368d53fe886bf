"""The extra `cluster`, whose packages may be absent: this module needs none of them."""

import contextlib
from collections.abc import Iterator
from concurrent.futures import Executor
from importlib.util import find_spec

from ..errors import InputError

NEEDED = ("distributed", "zarr")


def require() -> None:
    """Raise `InputError` with what to install unless the extra's packages are there."""
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        names = " and ".join(missing)
        raise InputError(f"a scheduler needs {names}, not installed here: pip install 'jaxbuffer[cluster]'")


@contextlib.contextmanager
def executor_at(scheduler: str | None) -> Iterator[tuple[Executor | None, int | None]]:
    """Connect to a scheduler until the end of the block, and yield its executor and how many calls that runs at a time.

    Both are None without a scheduler. **Raises:** `InputError` as `connect.connected`, and where Dask is missing.
    """
    if scheduler is None:
        yield None, None
        return
    require()
    from .connect import executor_of  # imports Dask, an optional package

    with executor_of(scheduler) as executor_and_calls:
        yield executor_and_calls
