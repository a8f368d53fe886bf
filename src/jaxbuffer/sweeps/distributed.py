"""A sweep over a cluster: blocks as tasks, whose workers store what they find; nothing of it passes through here."""

import json
import uuid
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..cluster.connect import connected, require
from ..cluster.spread import spread
from ..cluster.workers import Workers
from ..compiling.programs import folder as programs_folder
from ..errors import InputError
from ..files import Lock
from ..hybrid import name_of
from ..mechanisms.dataset import attributes
from ..mechanisms.registry import mechanism_of
from .chunk import CHUNK, Settings
from .columns import column_names
from .cut import Cut, GridSweep, RunsSweep
from .store import STORE as CHUNKS
from .store import ZARR as STORE
from .store import differing, identity
from .stored import StoredInterrupted, StoredSweep
from .task import Job, Told, solve_block
from .zarr_store import BLOCK, IDENTITY, KIND, TOKEN, create, known, remove_drafts

if TYPE_CHECKING:
    from distributed import Client

TASK = 512  # runs of a task at most on few threads: about a second
PER_THREAD = 8  # tasks a thread at least there, so that none waits long for the last
BUSY = 2  # runs of a task for each thread at least, so that one scheduler can hand out so many (docs/clusters.md)


class Asked(NamedTuple):
    """What a sweep over a cluster is to do; as in `sweep`."""

    sweep: Callable[[int], GridSweep | RunsSweep]  # cut into blocks of at most so many runs
    runs: int
    settings: Settings
    where: Any
    workers: int | None
    progress: Callable[[int, int], None] | None
    folder: str | Path | None
    resume: bool


class _Place(NamedTuple):
    """Where a sweep is stored, and the store's token."""

    store: Path
    token: str


def run(asked: Asked) -> StoredSweep:
    """Solve all runs, or those that the store lacks."""
    require()
    if asked.folder is None:
        raise InputError("a sweep over a scheduler needs a folder, where its workers store what they find")
    folder = Path(asked.folder).absolute()
    store = folder / STORE
    if asked.resume and not store.exists():
        other = f", {CHUNKS} is that of one without a scheduler" if (folder / CHUNKS).exists() else ""
        told = f"{STORE} is missing{other}; leave out --resume to begin one"
        raise InputError(f"{folder}: there is no sweep to resume; {told}")
    lock = Lock(folder)
    try:
        with connected(asked.where, asked.workers) as client:
            return _resumed(asked, client, store) if asked.resume else _begun(asked, client, store)
    finally:
        lock.release()


def task_size(runs: int, threads: int) -> int:
    """How many runs a task has at most."""
    return max(CHUNK, min(TASK, runs // (PER_THREAD * threads)), min(BUSY * threads, runs // threads))


def _begun(asked: Asked, client: "Client", store: Path) -> StoredSweep:
    workers = Workers(client, _cache())
    sweep = asked.sweep(task_size(asked.runs, max(1, workers.threads)))
    mechanism = mechanism_of(sweep.template.design)
    own = _identity(asked, sweep)
    about = {
        **attributes(mechanism, sweep.template.design, sweep.template.scenario),
        "settings": json.dumps(_settings(asked, sweep), sort_keys=True),
        IDENTITY: own,
        BLOCK: json.dumps(sweep.cut.block),
        KIND: json.dumps(workers.kind, sort_keys=True),
        TOKEN: uuid.uuid4().hex,
    }
    create(store, mechanism, sweep.cut, sweep.dims, sweep.coordinates(), about)
    return _solved(asked, client, workers, _Place(store, about[TOKEN]), sweep)


def _resumed(asked: Asked, client: "Client", store: Path) -> StoredSweep:
    there = known(store)
    remove_drafts(store)
    sweep = asked.sweep(CHUNK)
    differing(store, json.loads(_identity(asked, sweep)), there.identity)
    sweep.cut = Cut(sweep.cut.sizes, there.block)
    return _solved(asked, client, Workers(client, _cache(), there.kind), _Place(store, there.token), sweep)


def _solved(
    asked: Asked, client: "Client", workers: Workers, place: _Place, sweep: GridSweep | RunsSweep
) -> StoredSweep:
    store, token = place
    mechanism = mechanism_of(sweep.template.design)
    columns, grid = column_names(mechanism), isinstance(sweep, GridSweep)
    rtol, stabilisation = float(asked.settings.rtol), float(asked.settings.stabilisation)
    solver = name_of(asked.settings.solver)
    job = Job(str(store), token, columns, grid, sweep.template, rtol, stabilisation, solver, asked.settings.trust)
    outcomes, verdicts, done = Counter[int](), Counter[int](), 0

    def so_far() -> StoredSweep:
        return StoredSweep(store, sweep, asked.runs, done, dict(outcomes), dict(verdicts))

    try:
        for told in _spread(client, workers, job, sweep):
            done += told.runs
            outcomes.update(told.outcomes)
            verdicts.update(told.verdicts)
            if asked.progress is not None:
                asked.progress(done, asked.runs)
    except KeyboardInterrupt:
        raise StoredInterrupted(so_far()) from None
    except OSError as error:
        kept = f"{done} of {asked.runs} {mechanism.run_name}s are known to be in {store}; resuming goes on with them"
        if error.errno is None:
            raise ConnectionError(f"{error}; {kept}") from None
        raise OSError(error.errno, f"{error.strerror}; {kept}", error.filename) from None
    return so_far()


def _spread(client: "Client", workers: Workers, job: Job, sweep: GridSweep | RunsSweep) -> Iterator[Told]:
    return spread(client, workers, solve_block, job, sweep.blocks())


def _identity(asked: Asked, sweep: GridSweep | RunsSweep) -> str:
    options = (sweep.template.duration, *asked.settings)
    columns = column_names(mechanism_of(sweep.template.design))
    return json.dumps(identity(**sweep.identity(), options=options, quantities=columns), sort_keys=True)


def _settings(asked: Asked, sweep: GridSweep | RunsSweep) -> dict[str, Any]:
    settings = asked.settings
    return {
        "rtol [-]": float(settings.rtol),
        "stabilisation [1/s]": float(settings.stabilisation),
        "duration [s]": float(sweep.template.duration),
        "solver": name_of(settings.solver) or "automatic",
        "trust": settings.trust,
    }


def _cache() -> str | None:
    kept = programs_folder()
    return None if kept is None else str(kept)
