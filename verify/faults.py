"""Kill, fill, cut and contradict a sweep over a scheduler: it ends with the bits of an undisturbed one, or says no.

    python -m verify.faults [--captures 50000] [--kills 20] [--seed 16] [--only kills disk]

Everything runs on this machine; all traffic stays on 127.0.0.1.
"""

from __future__ import annotations

import argparse
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from jaxbuffer.labelled.netcdf import read

from .cluster import OTHER_PROCESSOR, PATIENCE, Cluster, driver, enlarged, killed, small_disk
from .run import ROOT

ARRAYS, STORE = "sweep.nc", "sweep.zarr"
GONE = ("its scheduler is gone", "no scheduler answers")  # what a driver says without its scheduler
COLUMNS = 250  # spring rates of the grid


class Setup(NamedTuple):
    """Of all checks. ``folder``: theirs; ``cache``: of compiled programs; ``words``: the sweep's."""

    folder: Path
    cache: Path
    words: tuple[str, ...]
    kills: int
    seed: int

    def arguments(self, name: str, *more: str) -> list[str]:
        """Of a driver whose results go to the folder of that name."""
        return [*self.words, "--output", str(self.folder / name), *more]


class Ended(NamedTuple):
    """How a driver ended."""

    code: int
    errors: str


def words(captures: int) -> tuple[str, ...]:
    """A sweep of so many short captures."""
    springs = min(COLUMNS, captures)
    over = [f"scenario.approach_speed=0.1:0.3:{captures // springs}", f"buffer.k_A=200:900:{springs}"]
    return ("--over", over[0], "--over", over[1], "--duration", "0.1", "--rtol", "1e-3")


def run(setup: Setup, name: str, *more: str) -> Ended:
    """A driver, to its end."""
    return ended(driver(setup.cache, *setup.arguments(name, *more)))


def ended(process: subprocess.Popen[str], timeout: float = 1800.0) -> Ended:
    """Wait for a driver."""
    _, errors = process.communicate(timeout=timeout)
    return Ended(process.returncode, errors)


def undisturbed(setup: Setup) -> None:
    """The sweep without a scheduler, with which all others are compared."""
    if not (setup.folder / "whole" / ARRAYS).exists():
        process = run(setup, "whole")
        assert process.code == 0, process.errors


def same(setup: Setup, name: str) -> bool:
    """Whether every array of a sweep is that of the undisturbed one, bit by bit."""
    undisturbed(setup)
    one, other = (read(setup.folder / place / ARRAYS) for place in ("whole", name))
    numbers = [name for name in one if one[name].dtype.kind in "if"]
    return one.identical(other) and all(one[it].values.tobytes() == other[it].values.tobytes() for it in numbers)


def kills(setup: Setup) -> str:
    """SIGKILL to workers, the scheduler and the driver at random moments, until so many have happened."""
    chance, counts, ends = random.Random(setup.seed), dict.fromkeys(("worker", "scheduler", "driver"), 0), 0
    with Cluster(setup.folder / "kills-cluster", setup.cache) as cluster:
        process: subprocess.Popen[str] | None = None
        try:
            while sum(counts.values()) < setup.kills or process is not None:
                cluster.tidy(2)
                if process is None:
                    begun = (setup.folder / "kills" / STORE).exists() and not (setup.folder / "kills" / ARRAYS).exists()
                    more = ["--scheduler", cluster.address, "--resume" if begun else "--force"]
                    process = driver(setup.cache, *setup.arguments("kills", *more))
                enough = sum(counts.values()) >= setup.kills
                if _waited(process, PATIENCE if enough else chance.uniform(1.0, 12.0)):
                    ends += _judged(ended(process), setup)
                    process = None
                elif not enough:
                    victim = chance.choice([*counts])
                    killed({"worker": cluster.workers[0], "driver": process}.get(victim) or cluster.scheduler)
                    counts[victim] += 1
                    process = None if victim == "driver" else process
        finally:
            if process is not None:
                killed(process)
    victims = ", ".join(f"{count} of a {victim}" for victim, count in counts.items())
    return f"{setup.kills} kills, {victims}; {ends} sweeps ended, each with the bits of the undisturbed one"


def _judged(process: Ended, setup: Setup) -> int:
    """1 for a sweep that ended right, 0 for one that said that its scheduler was gone."""
    assert "Traceback" not in process.errors, process.errors
    if process.code == 0:
        assert same(setup, "kills")
        return 1
    assert any(words in process.errors for words in GONE), process
    return 0


def _waited(process: subprocess.Popen[str], seconds: float) -> bool:
    """Whether a process ends in that time."""
    ends = time.monotonic() + seconds
    while time.monotonic() < ends:
        if process.poll() is not None:
            return True
        time.sleep(0.05)
    return False


def disk(setup: Setup) -> str:
    """A disk that is full in the middle: the message names the store; with more room, resuming goes on."""
    with small_disk(setup.folder / "disk", "600k") as made:
        if not made:
            return "not checked: this user can't make a small file system; the tests limit the size of files instead"
        with Cluster(setup.folder / "disk-cluster", setup.cache) as cluster:
            cluster.tidy(2)
            over = ["--scheduler", cluster.address]
            full = run(setup, "disk", *over)
            assert full.code == 3 and "No space left on device" in full.errors and STORE in full.errors, full
            enlarged(setup.folder / "disk", "256m")
            again = run(setup, "disk", *over, "--resume")
            assert again.code == 0, again.errors
        assert same(setup, "disk")
        (said,) = (line for line in full.errors.splitlines() if line.startswith("error:"))
    return f"refused: {said.replace(str(setup.folder), 'DIR')}; with more room the same bits"


def damage(setup: Setup) -> str:
    """Files of a finished store cut in the middle, emptied, overwritten and removed: these blocks are solved again."""
    chance, name = random.Random(setup.seed), "damage"
    with Cluster(setup.folder / "damage-cluster", setup.cache) as cluster:
        cluster.tidy(2)
        over = ["--scheduler", cluster.address]
        first = run(setup, name, *over)
        assert first.code == 0, first.errors
        files = [path for path in sorted((setup.folder / name / STORE).rglob("*")) if path.is_file()]
        chosen = chance.sample([path for path in files if not path.name.startswith(".")], 12)
        for k, path in enumerate(chosen):
            content = path.read_bytes()
            spoiled = (content[: len(content) // 2], b"", chance.randbytes(len(content)), None)[k % 4]
            path.unlink() if spoiled is None else path.write_bytes(spoiled)
        again = run(setup, name, *over, "--resume")
        assert again.code == 0, again.errors
    assert same(setup, name)
    return f"{len(chosen)} of {len(files)} files cut, emptied, overwritten or removed; the same bits"


def drivers(setup: Setup) -> str:
    """A second driver in the folder of one at work: refused, and the first one ends right."""
    with Cluster(setup.folder / "drivers-cluster", setup.cache) as cluster:
        cluster.tidy(2)
        over = ["--scheduler", cluster.address]
        first = driver(setup.cache, *setup.arguments("drivers", *over))
        while not (setup.folder / "drivers" / STORE).exists() and first.poll() is None:
            time.sleep(0.05)
        second = run(setup, "drivers", *over, "--resume")
        process = ended(first)
    assert second.code == 2 and "is in use by another run, process" in second.errors, second
    assert process.code == 0 and same(setup, "drivers"), process
    return f"refused: {_last(second, setup)}; the first one's bits are the same"


def other_version(setup: Setup) -> str:
    """A worker of another source: left out beside one that fits, refused alone."""
    source = setup.folder / "other-source"
    shutil.copytree(ROOT / "src", source, ignore=shutil.ignore_patterns("__pycache__"))
    with (source / "jaxbuffer" / "version.py").open("a") as file:
        file.write("\n# another version\n")
    return _stranger(setup, "version", lambda cluster: cluster.start_worker(source=source))


def other_processor(setup: Setup) -> str:
    """A worker that says that its processor is another one."""
    return _stranger(setup, "processor", lambda cluster: cluster.start_worker(before=OTHER_PROCESSOR))


def _stranger(setup: Setup, name: str, start: Callable[[Cluster], object]) -> str:
    with Cluster(setup.folder / f"{name}-cluster", setup.cache) as cluster:
        cluster.tidy(2)
        start(cluster)
        _until(cluster, 3)
        beside = run(setup, name, "--scheduler", cluster.address)
    assert beside.code == 0 and "is left out: it differs in" in beside.errors, beside
    assert same(setup, name)
    said = next(line for line in beside.errors.splitlines() if "is left out" in line)
    if name == "processor":  # alone, its machine is the one that counts
        return f"left out: {said}; the same bits"
    with Cluster(setup.folder / f"{name}-cluster", setup.cache) as cluster:
        start(cluster)
        alone = run(setup, f"{name}-alone", "--scheduler", cluster.address)
    assert alone.code == 2 and "no process of the executor can be used" in alone.errors, alone
    return f"left out: {said}; alone refused: {_last(alone, setup)}"


def _until(cluster: Cluster, count: int) -> None:
    """Wait until so many workers are there."""
    from distributed import Client

    with Client(cluster.address, set_as_default=False) as client:
        client.wait_for_workers(count, timeout=PATIENCE)


def _last(process: Ended, setup: Setup) -> str:
    return process.errors.strip().splitlines()[-1].replace(str(setup.folder), "DIR")


CHECKS: dict[str, Callable[[Setup], str]] = {
    "kills": kills,
    "disk": disk,
    "damage": damage,
    "drivers": drivers,
    "version": other_version,
    "processor": other_processor,
}


def checked(setup: Setup, only: list[str]) -> Iterator[str]:
    """What each check says, as it ends."""
    undisturbed(setup)
    for name in only:
        begin = time.monotonic()
        yield f"{name}: {CHECKS[name](setup)} ({time.monotonic() - begin:.0f} s)"


def main() -> int:
    """Print a line for each check; a check that fails ends with its assertion."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--captures", type=int, default=50_000)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=16)
    parser.add_argument("--only", nargs="+", choices=[*CHECKS], default=[*CHECKS])
    parser.add_argument("--cache", type=Path, default=None, help="folder of compiled programs; default: a new one")
    options = parser.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with tempfile.TemporaryDirectory(prefix="jaxbuffer-faults-") as folder:
        cache = options.cache or Path(folder) / "cache"
        setup = Setup(Path(folder), cache, words(options.captures), options.kills, options.seed)
        print(f"{options.captures} captures, seed {options.seed}", flush=True)
        for line in checked(setup, options.only):
            print(line, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
