"""How far a sweep over a scheduler scales: what a call costs here, and a model of it for up to thousands of cores.

    python -m benchmarks scaling_model [--captures 3000] [--calls 2000]

A model, not a measurement: beyond this machine's cores it assumes that workers are like these, that their store takes
files as this one does, and that the scheduler is as busy with a task of one worker as with a task of another.
"""

from __future__ import annotations

import dataclasses
import os
import tempfile
import time
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

import jaxbuffer as jb
from jaxbuffer.cluster.connect import connected
from jaxbuffer.cluster.pool import Pool
from jaxbuffer.hybrid import AUTOMATIC
from jaxbuffer.sweeps import chunk
from jaxbuffer.sweeps.chunk import CHUNK, SweepSettings, columns_of_chunk
from jaxbuffer.sweeps.grid import Batch, grid
from jaxbuffer.sweeps.spec import SweepSpec
from jaxbuffer.sweeps.store import SweepStore, begun

from .memory import status

SIZES = (16, 64, 512, 4096)  # captures of a call
CORES = (1, 2, 10, 100, 300, 1000, 3000, 10_000)
TOLERANCE = 1e-3
REPEATS = 20  # of which the quickest counts: others compute here, too
LOOKS = 5  # at the memory
LARGE = 10**7  # captures of a large sweep
WORTH = 0.9  # efficiency that a call's size is chosen for, with 1000 cores


@dataclasses.dataclass(frozen=True)
class Costs:
    """What was measured.

    ``capture``: of one, on one core [s]; ``block``, ``number``: of storing a block, and each of its captures, in the
    driver's process [s]; ``scheduler``: of a call, in the scheduler's and the driver's process [s]; ``files`` of a
    block.
    """

    capture: float
    block: float
    number: float
    scheduler: float
    files: int

    def call(self, captures: int) -> float:
        """Return how long a core is busy with a call [s]."""
        return captures * self.capture

    def driver(self, captures: int) -> float:
        """Return how long driver and scheduler are busy with a call and with storing it [s]."""
        return self.scheduler + self.block + captures * self.number

    def most(self, captures: int) -> float:
        """Return how many cores there are beyond which the driver is the limit."""
        return self.call(captures) / self.driver(captures)

    def rate(self, captures: int, cores: int) -> float:
        """Return how many captures are computed in a second."""
        return captures * min(cores / self.call(captures), 1.0 / self.driver(captures))

    def efficiency(self, captures: int, cores: int) -> float:
        """Return that rate over that of so many cores which do nothing but captures."""
        return self.rate(captures, cores) * self.capture / cores


def sweep_of(captures: int) -> SweepSpec:
    """Return a sweep of the Table-2 buffer."""
    design, scenario = jb.table2(), jb.Scenario()
    over = {
        "scenario.approach_speed": {"from": 0.1, "to": 0.3, "count": max(1, captures // 100)},
        "buffer.k_A": {"from": 200.0, "to": 900.0, "count": 100},
    }
    settings = SweepSettings(np.asarray(TOLERANCE), np.asarray(20.0), AUTOMATIC)
    return SweepSpec(design, scenario, 8.0, grid(over, design, scenario), settings)


def solving(captures: int) -> float:
    """Return how many seconds of a core a capture takes."""
    spec, seconds = sweep_of(captures), list[float]()
    for batch in spec.batches[0].parts(CHUNK):
        begin = time.perf_counter()
        columns_of_chunk(*batch.chunk(0, CHUNK), spec.settings)
        seconds.append((time.perf_counter() - begin) / batch.places.size)
    return min(seconds)


def rate(captures: int, processes: int, folder: Path) -> float:
    """Return how many captures a second so many processes compute together, once they have the program."""
    over = {axis.path: axis.values for axis in sweep_of(captures).grid.axes}  # type: ignore[union-attr]
    warm = {"scenario.approach_speed": [0.1], "buffer.k_A": np.linspace(200.0, 900.0, 64 * processes)}
    inputs, options = (jb.table2(), jb.Scenario(), 8.0), {"rtol": TOLERANCE, "workers": processes, "save": False}
    with connected("processes", processes) as client:
        executor = client.get_executor(pure=False)
        jb.sweep(*inputs, over=warm, executor=executor, **options)
        begin = time.perf_counter()
        jb.sweep(*inputs, over=over, executor=executor, folder=folder / f"solving-{processes}", **options)
        return captures / (time.perf_counter() - begin)


def storing(folder: Path) -> tuple[float, float, int]:
    """Return the seconds to store a block and each of its captures, and how many files a block has."""
    seconds = list[float]()
    for size in (100, 4000):
        store = begun(folder / f"storing-{size}.zarr", sweep_of(REPEATS * 4000), size, {})
        seconds.append(min(_stored(store, k) for k in range(REPEATS)))
    number = max(0.0, (seconds[1] - seconds[0]) / (4000 - 100))
    return seconds[0] - 100 * number, number, len(store.types) + 1


def _stored(store: SweepStore, block: int) -> float:
    chance, count = np.random.default_rng(block), int(np.prod(store.cut.shape(block)))
    numbers = [chance.random(count) if kind == "<f8" else np.zeros(count, int) for kind in store.types.values()]
    begin = time.perf_counter()
    store.write_columns(block, numbers)
    return time.perf_counter() - begin


def nothing(call: tuple[Batch, int]) -> list[np.ndarray]:
    """Answer as a sweep's call does, in no time."""
    batch, _ = call
    return [batch.places.astype(float)] * 30


def scheduling(calls: int) -> tuple[float, list[float]]:
    """Return the processor seconds that a call which does nothing costs scheduler and driver, both in this process, and
    the process's memory [MiB] along the way."""
    (batch,) = sweep_of(512 * calls).batches
    times, memory = [], []
    with connected("processes", 2) as client, Pool(client.get_executor(pure=False), 2) as pool:
        begin = time.process_time()
        for k, _ in enumerate(pool.completed(nothing, ((part, CHUNK) for part in batch.parts(512)))):
            if k % (calls // LOOKS) == calls // LOOKS - 1:
                times.append((time.process_time() - begin) / (calls // LOOKS))
                memory.append(status("self", "VmRSS"))
                begin = time.process_time()
    return min(times), memory


def predicted(costs: Costs) -> list[str]:
    """The model as a table, and what limits."""
    lines = ["efficiency predicted, by captures of a call and cores; in brackets: the driver is the limit"]
    lines.append("captures  " + "".join(f"{cores:>9}" for cores in CORES) + "   cores at most")
    for size in SIZES:
        shown = []
        for cores in CORES:
            text = f"{costs.efficiency(size, cores):.2f}"
            shown.append(f"({text})" if cores > costs.most(size) else f"{text} ")
        lines.append(f"{size:8}  " + "".join(f"{text:>9}" for text in shown) + f"   {costs.most(size):.0f}")
    enough = [size for size in (2**k for k in range(4, 15)) if costs.efficiency(size, 1000) >= WORTH]
    least = f"{enough[0]} captures" if enough else "none of up to 16384 captures"
    lines.append(f"least call with an efficiency of {WORTH} on 1000 cores: {least}")
    for cores in CORES[2:]:
        size = chunk.task_size(LARGE, cores)
        shown = f"calls of {size}, efficiency {costs.efficiency(size, cores):.2f}, {costs.call(size):.2f} s each"
        lines.append(
            f"{LARGE} captures on {cores} cores: {shown}, {costs.rate(size, cores) / size * costs.files:.0f} files/s"
        )
    return lines


def main(
    captures: int = 3000,
    calls: int = 2000,
    cache: Annotated[Path | None, typer.Option(help="folder of compiled programs; default: a new one")] = None,
) -> None:
    """Measure, and print the model."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        os.environ["JAXBUFFER_CACHE"] = str(cache or folder / "cache")
        jb.configure(cache=os.environ["JAXBUFFER_CACHE"])
        capture = solving(captures)
        rates = {processes: rate(captures, processes, folder) for processes in (1, 2)}
        block, number, files = storing(folder)
        scheduler, memory = scheduling(calls)
    print(f"a capture: {1e3 * capture:.2f} ms of a core")
    for processes, per_second in rates.items():
        print(f"processes: {processes}; {per_second:.0f} captures/s")
    print(f"scaling from 1 to 2 processes: {rates[2] / rates[1]:.2f}")
    print(f"storing a block: {1e3 * block:.1f} ms in {files} files, and {1e6 * number:.2f} µs a capture")
    print(f"a call: {1e3 * scheduler:.2f} ms of scheduler and driver together")
    print(f"driver's memory along {calls} calls: " + ", ".join(f"{it:.0f}" for it in memory) + " MiB")
    print("\n".join(predicted(Costs(capture, block, number, scheduler, files))))
