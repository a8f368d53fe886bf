"""Calls handed to an executor: who may compute, what is done about a process that must not, who can reach Dask."""

import os
import threading
import warnings
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import psutil
import pytest

from jaxbuffer import InputError
from jaxbuffer.block_store import differing
from jaxbuffer.cluster import connect
from jaxbuffer.cluster import pool as module
from jaxbuffer.cluster.connect import LOOPBACK, connected, executor_of
from jaxbuffer.cluster.pool import Pool
from jaxbuffer.hybrid import SOLVER_NAMES, name_of, solver_named
from jaxbuffer.hybrid.rungekutta.solvers import Automatic
from jaxbuffer.programs.process import HOST, kind


class Processes(Executor):
    """Stands in for other processes, of the kinds that are given, which take turns; ``calls``: whose turn it was."""

    def __init__(self, *kinds):
        self.kinds, self.calls = [{**kind(), **it} for it in kinds], []

    def submit(self, function, home, *arguments):
        future, number = Future(), len(self.calls) % len(self.kinds)
        self.calls.append(number)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(module, "_address", lambda: f"process {number}")
            patch.setattr(module, "prepared", lambda address, cache: self.kinds[number])
            patch.setattr(os, "getpid", lambda: number)
            try:
                future.set_result(function(home, *arguments))
            except Exception as error:
                future.set_exception(error)
        return future


def squared(task):
    return task * task


def failing(task):
    raise OSError(28, "No space left on device", "a.zarr")


OTHER = {"jaxbuffer": "another"}


@pytest.fixture(autouse=True)
def refused_at_once(monkeypatch):
    monkeypatch.setattr(module, "PAUSE", 0.0)


@pytest.mark.quick
@pytest.mark.parametrize("executor", [None, Processes({}, {}), ThreadPoolExecutor(2)])
def test_all_calls_are_made_once_and_map_keeps_their_order(executor):
    with Pool(executor, 2) as pool:
        assert sorted(pool.completed(squared, iter(range(30)))) == [k * k for k in range(30)]
        assert pool.map(squared, range(9)) == [k * k for k in range(9)]
    if executor is not None:
        assert executor.submit(str, "it stays open").result()


@pytest.mark.quick
@pytest.mark.parametrize("what", ["jaxbuffer", "jaxlib", "XLA"])
def test_a_process_that_differs_is_left_out_and_another_makes_its_calls(what):
    processes = Processes({}, {what: "another"})
    with pytest.warns(UserWarning, match=rf"process 1 of .* is left out: it differs in {what}, and so might its bits"):
        assert Pool(processes, 1).map(squared, range(40)) == [k * k for k in range(40)]


def test_a_call_that_is_alone_goes_to_others_too():
    """Dask gives it to the first process that is free: to the one that has just refused it."""

    class First(Processes):
        """Two processes; the second one has a turn where several calls are handed out at once."""

        def submit(self, function, *arguments):
            asked.append(function)
            self.kinds = [kind() | (OTHER if len(asked) in (2, 3) else {})]
            return super().submit(function, *arguments)

    asked = []
    with pytest.warns(UserWarning, match="is left out"):
        assert Pool(First({}), 1).map(squared, [7]) == [49]
    assert asked == [module._probe, *[module._called] * 3]


def test_without_a_process_that_fits_nothing_is_done():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        with pytest.raises(InputError, match="no process of the executor can be used: it differs in numpy"):
            Pool(Processes({"numpy": "another"})).map(squared, range(3))
        processes = Processes({})
        pool = Pool(processes, 1)
        assert pool.map(squared, range(3)) == [0, 1, 4]
        processes.kinds = [{**kind(), **OTHER}]
        with pytest.raises(InputError, match="no process of the executor is left that can be used: it differs in jaxb"):
            pool.map(squared, range(30))


def test_results_of_another_machine_are_not_gone_on_with():
    pool = Pool(Processes({}))
    pool.made_on = {**kind(), "processor": "another"}
    with pytest.warns(UserWarning, match="left out"), pytest.raises(InputError, match=r"can be used: .*processor"):
        pool.map(squared, range(3))


def test_the_machine_of_the_first_process_counts():
    """The driver's may be another one: a login node."""
    theirs = {"processor": "of the nodes", "XLA": "theirs"}
    pool = Pool(Processes(theirs))
    assert pool.map(squared, range(3)) == [0, 1, 4]
    assert {name for name in kind() if pool.kind[name] != kind()[name]} == set(theirs) <= set(HOST)


@pytest.mark.quick
def test_what_a_call_raises_ends_it():
    with pytest.raises(OSError, match=r"No space left on device: 'a\.zarr'"):
        Pool(Processes({})).map(failing, range(5))


class Ended(Processes):
    """Ends after its first answers, in the way that is given."""

    def __init__(self, end):
        super().__init__({})
        self.end = end

    def submit(self, *arguments):
        if len(self.calls) < 3:
            return super().submit(*arguments)
        future = Future()
        if isinstance(self.end, Exception):
            future.set_exception(self.end)
        else:
            future.cancel()
            future.set_running_or_notify_cancel()
        return future


@pytest.mark.parametrize(
    ("end", "message"),
    [
        (BrokenProcessPool("a process ended abruptly"), "the executor is broken: a process ended abruptly"),
        (None, "the executor has dropped its calls: its scheduler is gone or it was shut down"),
    ],
)
def test_an_executor_that_ends(end, message):
    """Dask cancels its futures where the scheduler is gone."""
    with pytest.raises(ConnectionError, match=message):
        Pool(Ended(end), 1).map(squared, range(9))


def test_one_that_does_not_answer_is_waited_for(monkeypatch):
    class Late(Processes):
        def submit(self, function, *arguments):
            answer = super().submit(function, *arguments)
            if function is not module._probe:
                return answer
            late = Future()
            threading.Timer(0.2, late.set_result, [answer.result()]).start()
            return late

    monkeypatch.setattr(module, "PATIENCE", 0.15)
    with pytest.warns(UserWarning, match="no process of the executor has answered yet; waiting for one"):
        assert Pool(Late({}), 1).map(squared, range(2)) == [0, 1]


def test_differing_names_what_one_side_lacks():
    assert differing({"a": "1", "b": "2"}, {"a": "1", "c": "3"}) == ["b", "c"]


@pytest.mark.parametrize("name", [*SOLVER_NAMES[:3], "diffrax:Kvaerno5"])
def test_a_named_solver_is_sent_by_its_name(name):
    assert name_of(solver_named(name)) == name


def test_another_solver_is_refused():
    assert name_of(solver_named(None)) == "automatic"
    with pytest.raises(InputError, match="cannot be sent to another process; name one of automatic"):
        name_of(Automatic(worth=3.0))


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


@pytest.mark.quick
@pytest.mark.parametrize(
    ("where", "message"),
    [
        ("lokal", "scheduler lokal is unknown; expected local, processes or an address"),
        ("tcp://127.0.0.1:9", "no scheduler answers at tcp://127.0.0.1:9"),
    ],
)
def test_schedulers_that_are_none(monkeypatch, where, message):
    monkeypatch.setattr(connect, "PATIENCE", 0.5)
    with pytest.raises(InputError, match=message), executor_of(where):
        pass


def test_a_task_at_which_workers_end_is_given_up():
    """The scheduler tries it on some others first."""
    from distributed import KilledWorker

    with pytest.raises(ConnectionError, match="4 workers have ended, one after the other, at"), executor_of("local"):
        raise KilledWorker("task", None, 3)


@pytest.mark.slow
def test_a_worker_that_ends_costs_nothing(tmp_path):
    """Dask starts another one, which makes its call again."""
    with connected("processes", 1) as client, Pool(client.get_executor(), 1) as pool:
        assert pool.map(_ending_once, [str(tmp_path / "ended")] * 2) == ["made"] * 2
    assert (tmp_path / "ended").exists()


def _ending_once(file):
    if not os.path.exists(file):
        open(file, "w").close()
        os._exit(1)
    return "made"
