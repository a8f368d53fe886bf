"""Who may compute, what is done about a worker that must not or that ends, and who can reach a cluster of our own."""

import os
import warnings

import psutil
import pytest

from jaxbuffer import InputError
from jaxbuffer.block_store import differing
from jaxbuffer.cluster import spread as module
from jaxbuffer.cluster.connect import LOOPBACK, connected
from jaxbuffer.cluster.pool import ClusterPool
from jaxbuffer.cluster.spread import TaskEndsWorkers, spread
from jaxbuffer.cluster.workers import Workers
from jaxbuffer.hybrid import SOLVER_NAMES, name_of, solver_named
from jaxbuffer.hybrid.rungekutta.solvers import Automatic
from jaxbuffer.programs import process
from jaxbuffer.programs.process import HOST, kind


def squared(_, task):
    return task * task


def where(_, task):
    from distributed import get_worker

    return get_worker().address


def failing(_, task):
    raise OSError(28, "No space left on device", "a.zarr")


@pytest.fixture(scope="module")
def pair():
    """Two workers, a thread each."""
    from distributed import Client, LocalCluster

    address = f"{LOOPBACK}:0"
    options = {"dashboard_address": None, "scheduler_kwargs": {"dashboard_address": address}}
    with (
        LocalCluster(
            n_workers=2, processes=False, threads_per_worker=1, worker_dashboard_address=address, **options
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        yield client


def strange(monkeypatch, addresses, **what):
    """Let workers at these addresses say that they are of another kind."""
    prepared = process.prepared

    def said(address, cache):
        found = prepared(address, cache)
        return {**found, **what} if address in addresses else found

    monkeypatch.setattr(process, "prepared", said)


def test_all_tasks_are_done_once_by_workers_alike(pair):
    workers = Workers(pair)
    assert workers.fit and workers.allowed is None and workers.threads == 2
    assert sorted(spread(pair, workers, squared, None, iter(range(30)))) == [k * k for k in range(30)]


@pytest.mark.parametrize("what", ["jaxbuffer", "jaxlib", "XLA"])
def test_a_worker_that_differs_is_left_out(pair, monkeypatch, what):
    good, bad = pair.scheduler_info()["workers"]
    strange(monkeypatch, [bad], **{what: "another"})
    with pytest.warns(UserWarning, match=f"worker {bad} is left out: it differs in {what}, and so might its bits"):
        workers = Workers(pair)
    assert set(spread(pair, workers, where, None, iter(range(20)))) == {good}


def test_one_that_is_found_out_at_work_is_left_out(pair, monkeypatch):
    """As one that came between two looks: it refuses its tasks, and another one does them."""
    good, bad = pair.scheduler_info()["workers"]
    workers = Workers(pair)
    strange(monkeypatch, [bad], processor="another")
    with pytest.warns(UserWarning, match=f"worker {bad} is left out: it differs in processor"):
        found = list(spread(pair, workers, where, None, iter(range(20))))
    assert found == [good] * 20


def test_without_a_worker_that_fits_nothing_is_done(pair, monkeypatch):
    addresses = list(pair.scheduler_info()["workers"])
    workers = Workers(pair)
    strange(monkeypatch, addresses, numpy="another")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        with pytest.raises(InputError, match=r"no worker can be used: all differ from this process: .* in numpy"):
            Workers(pair)
        with pytest.raises(InputError, match=r"no worker is left that can be used; .* differs in numpy"):
            list(spread(pair, workers, squared, None, iter(range(3))))


def test_a_store_of_another_machine_is_refused(pair):
    theirs = {**kind(), "processor": "another"}
    with pytest.warns(UserWarning, match="is left out"), pytest.raises(InputError, match=r"and its store: .*processor"):
        Workers(pair, theirs)


def test_the_machine_of_most_workers_counts(pair, monkeypatch):
    """The driver's may be another one: a login node."""
    addresses = list(pair.scheduler_info()["workers"])
    strange(monkeypatch, addresses, processor="of the nodes", XLA="theirs")
    workers = Workers(pair)
    assert workers.kind["processor"] == "of the nodes" and len(workers.fit) == 2
    assert {name for name in kind() if workers.kind[name] != kind()[name]} == {"processor", "XLA"} <= set(HOST)


def test_what_the_work_raises_ends_it(pair):
    with pytest.raises(OSError, match=r"No space left on device: 'a\.zarr'"):
        list(spread(pair, Workers(pair), failing, None, iter(range(5))))


def test_a_task_at_which_workers_end_is_tried_some_times(pair, monkeypatch):
    """The scheduler gives up after some; so do we, after more."""
    from distributed import KilledWorker

    tried = []

    class Ending:
        def __init__(self):
            self.futures = []

        def add(self, future):
            self.futures.append(future)

        def next_batch(self):
            future = self.futures.pop()
            tried.append(future)
            yield future, (KilledWorker, KilledWorker("task", None, 3), None)

    class Future:
        status = "error"

    monkeypatch.setattr(module, "as_completed", lambda **options: Ending())
    monkeypatch.setattr(pair, "submit", lambda *arguments, **options: Future())
    monkeypatch.setattr(pair, "cancel", lambda *arguments, **options: None)
    with pytest.raises(TaskEndsWorkers, match="10 times the workers ended that were at 7"):
        list(spread(pair, Workers(pair), squared, None, iter([7])))
    assert len(tried) == module.ENDED


def test_differing_names_what_one_side_lacks():
    assert differing({"a": "1", "b": "2"}, {"a": "1", "c": "3"}) == ["b", "c"]


@pytest.mark.parametrize("name", [*SOLVER_NAMES[:3], "diffrax:Kvaerno5"])
def test_a_named_solver_is_sent_by_its_name(name):
    assert name_of(solver_named(name)) == name


def test_another_solver_is_refused():
    assert name_of(None) is None
    with pytest.raises(InputError, match="cannot be sent to another process; name one of automatic"):
        name_of(Automatic(worth=3.0))


def test_a_pool_keeps_the_order():
    import functools

    pool = ClusterPool("local", 2)
    try:
        assert pool.map(functools.partial(squared, None), range(9)) == [k * k for k in range(9)]
    finally:
        pool.close()


def listening(processes):
    """Addresses at which processes listen."""
    connections = [it for one in processes for it in psutil.Process(one).net_connections()]
    return {it.laddr.ip for it in connections if it.status == psutil.CONN_LISTEN}


@pytest.mark.parametrize("where", ["local", pytest.param("processes", marks=pytest.mark.slow)])
def test_a_cluster_of_our_own_is_not_to_be_reached_from_outside(where):
    """Whoever reaches Dask's ports runs code: they are on the loopback device only."""
    before = listening([os.getpid()])
    with connected(where, 1) as client:
        processes = {os.getpid(), *client.run(os.getpid).values()}
        assert listening(processes) - before <= {LOOPBACK}
        assert listening(processes), "there are some"
