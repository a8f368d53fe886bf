"""A client of Dask's scheduler: somebody's cluster by its address, or one of our own on this machine."""

import contextlib
import logging
from collections.abc import Iterator
from concurrent.futures import Executor

import dask
from distributed import Client, KilledWorker, LocalCluster

from ..errors import InputError
from ..programs.threads import cores

LOCAL, PROCESSES = "local", "processes"
LOOPBACK = "127.0.0.1"
PATIENCE = 60.0  # s until a scheduler answers
EXAMPLE = "tcp://host:8786"
ENDED = 10  # workers of our own cluster that may end while they are at one task
RETRIES = 10  # of a task that fails


@contextlib.contextmanager
def executor_of(where: str) -> Iterator[tuple[Executor, int]]:
    """Connect as `connected` does, and yield an executor and how many threads its workers have now.

    **Raises:** `ConnectionError` where worker after worker ends at the same task.
    """
    with connected(where) as client:
        threads = sum(client.nthreads().values()) or cores()
        try:
            # Each call is a task of its own: Dask need not look whether it knows its result.
            yield client.get_executor(retries=RETRIES, pure=False), threads
        except KilledWorker as error:
            ended = error.allowed_failures + 1
            raise ConnectionError(f"{ended} workers have ended, one after the other, at the same task") from None


@contextlib.contextmanager
def connected(where: str, workers: int | None = None) -> Iterator[Client]:
    """Connect a client until the end of the block, and so long keep the cluster, if it is one of our own.

    **Arguments:**

    - ``where``: "local", threads of this process; "processes", one process a core; both listen on 127.0.0.1 only; an
      address, as in "tcp://host:8786".
    - ``workers``: threads or processes of a cluster of our own, by default one a core.

    **Raises:** `InputError` where no scheduler answers.
    """
    if where in (LOCAL, PROCESSES):
        with _own(where == PROCESSES, workers or cores()) as client:
            yield client
        return
    if "://" not in where:
        raise InputError(f"scheduler {where} is unknown; expected {LOCAL}, {PROCESSES} or an address as in {EXAMPLE}")
    with _remote(where) as client:
        yield client


@contextlib.contextmanager
def _own(processes: bool, count: int) -> Iterator[Client]:
    settings = {
        "distributed.scheduler.allowed-failures": ENDED,
        "distributed.scheduler.http.routes": [],
        "distributed.worker.http.routes": [],
        "distributed.worker.daemon": True,
        "distributed.worker.memory.terminate": False,
        "distributed.admin.tick.limit": "1h",  # a compilation holds Python for a while
    }
    size = {"n_workers": count, "threads_per_worker": 1} if processes else {"n_workers": 1, "threads_per_worker": count}
    with (
        dask.config.set(settings),
        LocalCluster(
            processes=processes,
            host=LOOPBACK if processes else None,
            dashboard_address=None,
            scheduler_kwargs={"dashboard_address": f"{LOOPBACK}:0"},  # else its page is everybody's to read
            worker_dashboard_address=f"{LOOPBACK}:0",
            silence_logs=logging.CRITICAL,
            memory_limit=0,
            **size,
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


@contextlib.contextmanager
def _remote(address: str) -> Iterator[Client]:
    # What Dask and Tornado have to say of a connection that ends, we say in a line.
    for name in [name for name in logging.root.manager.loggerDict if name.startswith(("distributed", "tornado"))]:
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        # Dask's default client stays what it is: the user may have one of their own.
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(f"no scheduler answers at {address}: {error}") from None
    try:
        yield client
    finally:
        # A scheduler that is gone must not hide the error that its end has caused.
        with contextlib.suppress(OSError, TimeoutError):
            client.close(timeout=5)
