"""A sweep by any executor: the numbers of threads of this process, stored and resumed alike."""

import multiprocessing
import pickle
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer import InputError
from jaxbuffer.cluster.connect import connected
from jaxbuffer.hybrid import solver_named
from jaxbuffer.sweeps.chunk import SweepSettings
from jaxbuffer.sweeps.result import SweepInterrupted

HEIGHTS = np.linspace(0.1, 0.2, 40)


def swept(executor=None, **options):
    return jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=HEIGHTS), 0.01, executor=executor, **options)


@pytest.fixture(scope="module")
def whole():
    return swept()


def same(one, other):
    return all(np.array_equal(one.columns[name], other.columns[name], equal_nan=True) for name in other.columns)


@pytest.mark.slow
def test_threads_and_processes_find_the_same_bits(whole):
    with ThreadPoolExecutor(2) as threads:
        assert same(swept(threads), whole)
        assert threads.submit(len, "open").result() == 4, "it stays open"
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as processes:
        assert same(swept(processes, trust=True), swept(trust=True))


def test_a_dask_client_gives_its_executor(whole):
    with connected("local", 1) as client:
        assert same(swept(client.get_executor()), whole)


def test_what_was_done_is_not_computed_again(whole, tmp_path):
    def stop(done, count):
        raise KeyboardInterrupt

    with ThreadPoolExecutor(1) as threads:
        with pytest.raises(SweepInterrupted) as interrupted:
            swept(threads, folder=tmp_path, progress=stop, workers=3)
        done = interrupted.value.done
        assert 0 < done.sum() < HEIGHTS.size and np.array_equal(interrupted.value.partial.done, done)
        counts = []
        resumed = swept(None, folder=tmp_path, resume=True, progress=lambda done, count: counts.append(done), workers=3)
    assert same(resumed, whole) and counts[0] == done.sum(), "by other threads than those that began"


class Broken(Executor):
    """Ends at every call."""

    def submit(self, function, *arguments):
        future = Future()
        future.set_exception(BrokenProcessPool("a process ended abruptly"))
        return future


def test_settings_have_one_solver_in_another_process():
    """A solver that differs from the one before would have each call's program compiled anew."""
    for name in ("implicit", "diffrax:Kvaerno5", None):
        solver = solver_named(name)
        sent = pickle.dumps(SweepSettings(np.asarray(1e-6), np.asarray(20.0), solver, trust=True))
        here, again = pickle.loads(sent), pickle.loads(sent)
        assert here.solver is again.solver and type(here.solver) is type(solver)
        assert (float(here.rtol), float(here.stabilisation), here.trust) == (1e-6, 20.0, True)


def test_what_can_not_compute_is_said():
    with pytest.raises(InputError, match=r"executor = 4 is no concurrent.futures.Executor, as in"):
        swept(4)
    with pytest.raises(ConnectionError, match="the executor is broken: a process ended abruptly"):
        swept(Broken())
