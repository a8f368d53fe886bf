"""How far a sweep over a scheduler scales: what a task costs here, and a model of it for up to thousands of cores.

    python -m benchmarks scaling_model [--captures 3000] [--tasks 2000]

A model, not a measurement: beyond this machine's cores it assumes that workers are like these, that their store takes
files as this one does, and that the scheduler is as busy with a task of one worker as with a task of another.
"""

from __future__ import annotations

import dataclasses
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import jaxbuffer as jb
from jaxbuffer.block_store import Head
from jaxbuffer.cluster.connect import connected
from jaxbuffer.cluster.spread import spread
from jaxbuffer.cluster.workers import Workers
from jaxbuffer.sweeps import chunk, distributed
from jaxbuffer.sweeps.chunk import SweepSettings
from jaxbuffer.sweeps.columns import column_types
from jaxbuffer.sweeps.cut import Block, GridSweep, Template
from jaxbuffer.sweeps.distributed import Job, Report
from jaxbuffer.sweeps.grid import grid
from jaxbuffer.sweeps.store import SweepStore, begun, identity

from .memory import status

SIZES = (16, 64, 512, 4096)  # captures of a task
CORES = (1, 2, 10, 100, 300, 1000, 3000, 10_000)
TOLERANCE = 1e-3
REPEATS = 20  # of which the quickest counts: others compute here, too
LOOKS = 5  # at the memory
LARGE = 10**8  # captures of a large sweep
WORTH = 0.9  # efficiency that a task size is chosen for, with 1000 cores


@dataclasses.dataclass(frozen=True)
class Costs:
    """What was measured.

    ``capture``: of one, on one core [s]; ``block``, ``number``: of storing a block, and each of its captures [s];
    ``scheduler``: of a task, in the scheduler's and the driver's process [s]; ``files`` of a block.
    """

    capture: float
    block: float
    number: float
    scheduler: float
    files: int

    def task(self, captures: int) -> float:
        """How long a core is busy with a task [s]."""
        return captures * (self.capture + self.number) + self.block

    def most(self, captures: int) -> float:
        """Cores beyond which the scheduler is the limit."""
        return self.task(captures) / self.scheduler

    def rate(self, captures: int, cores: int) -> float:
        """Captures a second."""
        return captures * min(cores / self.task(captures), 1.0 / self.scheduler)

    def efficiency(self, captures: int, cores: int) -> float:
        """That rate over that of so many cores which do nothing but captures."""
        return self.rate(captures, cores) * self.capture / cores


def sweep_of(captures: int, size: int) -> GridSweep:
    """A sweep of the Table-2 buffer in blocks of so many."""
    design, scenario = jb.table2(), jb.Scenario()
    over = {
        "scenario.approach_speed": {"from": 0.1, "to": 0.3, "count": max(1, captures // 100)},
        "buffer.k_A": {"from": 200.0, "to": 900.0, "count": 100},
    }
    return GridSweep(grid(over, design, scenario, in_memory=False), Template(design, scenario, 8.0), size)


def solving(captures: int, processes: int, folder: Path) -> tuple[float, float]:
    """Seconds of a core for a capture, and captures a second of all, over so many processes that have the program."""
    sweep = sweep_of(captures, chunk.TASK)
    over = {axis.path: axis.values for axis in sweep.grid.axes}
    inputs = (jb.table2(), jb.Scenario(), 8.0)
    with connected("processes", processes) as client:
        warm = {"scenario.approach_speed": [0.1], "buffer.k_A": np.linspace(200.0, 900.0, 64 * processes)}
        jb.sweep(*inputs, over=warm, rtol=TOLERANCE, client=client, folder=folder / f"warm-{processes}")
        reports: list[Report] = []
        distributed.spread = lambda *rest: _noted(spread(*rest), reports)
        try:
            begin = time.perf_counter()
            jb.sweep(*inputs, over=over, rtol=TOLERANCE, client=client, folder=folder / f"solving-{processes}")
            seconds = time.perf_counter() - begin
        finally:
            distributed.spread = spread
    return min(it.solving / it.runs for it in reports), captures / seconds


def _noted(source: Iterator[Report], reports: list[Report]) -> Iterator[Report]:
    for it in source:
        reports.append(it)
        yield it


def storing(folder: Path) -> tuple[float, float, int]:
    """Seconds to store a block and each of its captures, and how many files a block has."""
    settings, seconds = SweepSettings(np.asarray(TOLERANCE), np.asarray(20.0), None), list[float]()
    for size in (100, 4000):
        sweep, path = sweep_of(REPEATS * 4000, size), folder / f"storing-{size}.zarr"
        store = begun(path, sweep, settings, {})
        seconds.append(min(_stored(store, sweep.block(k)) for k in range(REPEATS)))
    number = max(0.0, (seconds[1] - seconds[0]) / (4000 - 100))
    return seconds[0] - 100 * number, number, len(store.types) + 1


def _stored(store: SweepStore, block: Block) -> float:
    chance, count = np.random.default_rng(block.number), int(np.prod(block.shape))
    numbers = [chance.random(count) if kind == "<f8" else np.zeros(count, int) for kind in store.types.values()]
    begin = time.perf_counter()
    store.write_columns(block, numbers)
    return time.perf_counter() - begin


def nothing(job: Job, block: Block) -> Report:
    """A task of the sweep's size that takes no time."""
    return Report(1, {0: 1}, {-1: 1}, 0.0)


def scheduling(tasks: int) -> tuple[float, list[float]]:
    """Processor seconds that a task which does nothing costs scheduler and driver, both in this process, and the
    process's memory [MiB] along the way."""
    sweep = sweep_of(100 * tasks, 100)
    settings = SweepSettings(np.asarray(TOLERANCE), np.asarray(20.0), None)
    head = Head(identity(settings, sweep), "")
    store = SweepStore(head, Path("nowhere"), column_types(sweep.mechanism), sweep.cut)
    job = Job(store, True, sweep.template, settings)
    times, memory = [], []
    with connected("processes", 2) as client:
        workers = Workers(client)
        begin = time.process_time()
        for k, _ in enumerate(spread(client, workers, nothing, job, sweep.blocks())):
            if k % (tasks // LOOKS) == tasks // LOOKS - 1:
                times.append((time.process_time() - begin) / (tasks // LOOKS))
                memory.append(status("self", "VmRSS"))
                begin = time.process_time()
    return min(times), memory


def predicted(costs: Costs) -> list[str]:
    """The model as a table, and what limits."""
    lines = ["efficiency predicted, by captures of a task and cores; in brackets: the scheduler is the limit"]
    lines.append("captures  " + "".join(f"{cores:>9}" for cores in CORES) + "   cores at most")
    for size in SIZES:
        shown = []
        for cores in CORES:
            text = f"{costs.efficiency(size, cores):.2f}"
            shown.append(f"({text})" if cores > costs.most(size) else f"{text} ")
        lines.append(f"{size:8}  " + "".join(f"{text:>9}" for text in shown) + f"   {costs.most(size):.0f}")
    enough = [size for size in (2**k for k in range(4, 15)) if costs.efficiency(size, 1000) >= WORTH]
    least = f"{enough[0]} captures" if enough else "none of up to 16384 captures"
    lines.append(f"least task with an efficiency of {WORTH} on 1000 cores: {least}")
    for cores in CORES[2:]:
        size = chunk.task_size(LARGE, cores)
        shown = f"tasks of {size}, efficiency {costs.efficiency(size, cores):.2f}, {costs.task(size):.2f} s each"
        lines.append(
            f"{LARGE} captures on {cores} cores: {shown}, {cores / costs.task(size) * costs.files:.0f} files/s"
        )
    return lines


def main(
    captures: int = 3000,
    tasks: int = 2000,
    cache: Annotated[Path | None, typer.Option(help="folder of compiled programs; default: a new one")] = None,
) -> None:
    """Measure, and print the model."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ["JAXBUFFER_CACHE"] = str(cache or folder / "cache")
        jb.configure(cache=os.environ["JAXBUFFER_CACHE"])
        costs = {processes: solving(captures, processes, folder) for processes in (1, 2)}
        block, number, files = storing(folder)
        scheduler, memory = scheduling(tasks)
    for processes, (capture, rate) in costs.items():
        print(f"processes: {processes}; {rate:.0f} captures/s, {1e3 * capture:.2f} ms of a core each")
    print(f"scaling from 1 to 2 processes: {costs[2][1] / costs[1][1]:.2f}")
    print(f"storing a block: {1e3 * block:.1f} ms in {files} files, and {1e6 * number:.2f} µs a capture")
    print(f"a task: {1e3 * scheduler:.2f} ms of scheduler and driver together")
    print(f"driver's memory along {tasks} tasks: " + ", ".join(f"{it:.0f}" for it in memory) + " MiB")
    print("\n".join(predicted(Costs(costs[1][0], block, number, scheduler, files))))
