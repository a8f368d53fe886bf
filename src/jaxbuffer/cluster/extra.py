"""The extra `cluster`, whose packages may be absent: this module needs none of them."""

from collections.abc import Callable, Iterable
from importlib.util import find_spec
from typing import Any, Protocol, TypeVar

from ..errors import InputError
from ..programs.threads import Pool

I = TypeVar("I")  # noqa: E741 # an item
R = TypeVar("R")
NEEDED = ("distributed", "zarr")


def require() -> None:
    """Raise `InputError` with what to install unless the extra's packages are there."""
    if missing := [name for name in NEEDED if find_spec(name) is None]:
        names = " and ".join(missing)
        raise InputError(f"a scheduler needs {names}, not installed here: pip install 'jaxbuffer[cluster]'")


class AnyPool(Protocol):
    """Threads of this process (`threads.Pool`) or the workers of a cluster (`pool.ClusterPool`)."""

    def map(self, function: Callable[[I], R], items: Iterable[I]) -> list[R]:
        """Return what the function returns for each item, in their order."""
        ...

    def close(self) -> None:
        """End the pool or leave it."""
        ...


def pool_of(client: Any, workers: int | None = None) -> AnyPool:
    """Return threads of this process, or with a ``client`` the workers of its cluster."""
    if client is None:
        return Pool(workers)
    require()
    from .pool import ClusterPool  # imports Dask, an optional package

    return ClusterPool(client, workers)
