"""Programs that a command needed last time, loaded while Python imports what the command needs besides.

Loading them takes XLA as long as the imports take Python, and the two hardly wait for each other.
"""

import contextlib
import json
import logging
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from jax.stages import Compiled

from .. import files
from . import load, store
from .process import backend_is_up

NOTE = "ahead.json"  # in the folder of programs: the files that each command needed, by what was typed
MOST = 8  # files of one command: what it needs later is loaded in time anyway
_log = logging.getLogger(__name__)
_loads: dict[Path, "Future[Loaded | None]"] = {}
_used: list[Path] = []


class Loaded(NamedTuple):
    """A file's content, and its program's parts, ready to run."""

    stored: store.Stored
    parts: list[Compiled]


@contextlib.contextmanager
def loading(command: str) -> Iterator[None]:
    """Begin to load what the ``command`` needed last time, and note at the end what it needed now.

    Only the first command of a process gains by it: the programs of later ones are in memory.
    """
    folder = store.folder()
    if folder is None or backend_is_up():
        yield
        return
    before = _noted(folder)
    _used.clear()
    # One after the other, in the order in which they were needed: the first one is not to wait for the last.
    loader = ThreadPoolExecutor(1, "loading programs")
    for name in before.get(command, []):
        file = folder / Path(name).name
        _loads[file] = loader.submit(_load, file)
    try:
        yield
    finally:
        loader.shutdown(wait=False, cancel_futures=True)
        _loads.clear()
        now = [file.name for file in _used[:MOST]]
        if now and now != before.get(command):
            with contextlib.suppress(OSError):  # a full disk: the next start is slower
                files.write(folder / NOTE, json.dumps({**_noted(folder), command: now}, indent=1).encode())


def taken(file: Path) -> Loaded | None:
    """Return what was loaded of a file, once, and None where it was not; wait for it if it is under way."""
    if file not in _used:
        _used.append(file)
    load_under_way = _loads.pop(file, None)
    return None if load_under_way is None else load_under_way.result()


def _noted(folder: Path) -> dict[str, list[str]]:
    """Return the names of the files that each command needed."""
    try:
        noted = json.loads((folder / NOTE).read_bytes())
    except (OSError, ValueError):
        return {}
    whole = isinstance(noted, dict) and all(isinstance(it, list) for it in noted.values())
    return {command: [str(name) for name in names] for command, names in noted.items()} if whole else {}


def _load(file: Path) -> Loaded | None:
    """Load the program of a file if it is still whole."""
    try:
        stored = store.read(file)
        if stored is None:
            return None
        with store.being_loaded(file):
            return Loaded(stored, load.all_ready(stored.compiled))
    except Exception as error:  # whatever it is, `cache` comes across it and compiles
        _log.info("%s cannot be loaded ahead: %s", file, error)
        return None
