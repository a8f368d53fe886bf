"""Programs that a command needed last time, loaded while Python imports what the command needs besides.

Loading them takes XLA as long as the imports take Python, and the two hardly wait for each other.
"""

import contextlib
import json
import logging
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from jax.stages import Compiled

from .. import files
from . import load, store
from .process import backend_is_up

NOTE = "ahead.json"  # in the folder of programs: the files that each command needed, by what was typed
MOST = 4  # files of one command: what it needs later is loaded in time anyway
_log = logging.getLogger(__name__)
_loading: threading.Thread | None = None
_loaded: dict[Path, "Loaded"] = {}
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
    global _loading  # noqa: PLW0603 # of this process
    folder = store.folder()
    if folder is None or backend_is_up():
        yield
        return
    before = _noted(folder)
    _loading = threading.Thread(target=_load, args=(folder, before.get(command, [])), name="loading programs")
    _used.clear()
    _loading.start()
    try:
        yield
    finally:
        now = [file.name for file in _used[:MOST]]
        if now and now != before.get(command):
            with contextlib.suppress(OSError):  # a full disk: the next start is slower
                files.write(folder / NOTE, json.dumps({**_noted(folder), command: now}, indent=1).encode())


def taken(file: Path) -> Loaded | None:
    """Return what was loaded of a file, once, and None where it was not; wait for it if it is under way."""
    if file not in _used:
        _used.append(file)
    if _loading is not None:
        _loading.join()
    return _loaded.pop(file, None)


def _noted(folder: Path) -> dict[str, list[str]]:
    """Return the names of the files that each command needed."""
    try:
        noted = json.loads((folder / NOTE).read_bytes())
    except (OSError, ValueError):
        return {}
    return noted if isinstance(noted, dict) else {}


def _load(folder: Path, names: list[str]) -> None:
    """Load the programs of these files, one after the other, as far as they are still whole."""
    for name in names:
        file = folder / Path(name).name
        try:
            stored = store.read(file)
            if stored is not None:
                with store.being_loaded(file):
                    _loaded[file] = Loaded(stored, load.all_ready(stored.compiled))
        except Exception as error:  # whatever it is, `cache` comes across it and compiles
            _log.info("%s cannot be loaded ahead: %s", file, error)
