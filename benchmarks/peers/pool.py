"""Throughput of a sweep: a pool of processes, each running whole captures by one peer."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from multiprocessing.synchronize import Barrier

from .parameters import Parameters, Vector
from .solvers import PeerCapture, solve


@dataclass(frozen=True)
class Sweep:
    """The captures of a sweep, in order, and the time of all of them with every process warm."""

    captures: list[PeerCapture]
    seconds: float  # [s]
    processes: int

    @property
    def rate(self) -> float:
        """Captures a second [1/s]."""
        return len(self.captures) / self.seconds


def _run(parameters: Parameters, peer: str, rtol: float, atol: float | Vector) -> PeerCapture:
    return solve(peer, parameters, rtol, atol)


def _warm(ready: Barrier, peer: str, parameters: Parameters, rtol: float, atol: float | Vector) -> None:
    solve(peer, parameters, rtol, atol)  # compiles everything a capture needs
    ready.wait()


def sweep(peer: str, cases: Sequence[Parameters], rtol: float, atol: float | Vector, processes: int = 2) -> Sweep:
    """Run all ``cases`` by ``peer``; starting the processes and compiling in them is not timed."""
    if not cases:
        raise ValueError("a sweep needs at least one case")
    context = multiprocessing.get_context("spawn")
    ready = context.Barrier(processes + 1)
    run = partial(_run, peer=peer, rtol=rtol, atol=atol)
    chunk = max(1, len(cases) // (8 * processes))  # captures differ in length: small chunks keep all processes busy
    with context.Pool(processes, _warm, (ready, peer, cases[0], rtol, atol)) as pool:
        ready.wait()
        begin = time.perf_counter()
        captures = pool.map(run, cases, chunk)
        seconds = time.perf_counter() - begin
    return Sweep(captures, seconds, processes)
