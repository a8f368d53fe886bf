"""The folder of compiled programs, and the files in it.

Programs are code, so nobody but the user may be able to write to the folder. A file is a line that says what it is,
plain descriptions and the compiled programs, and a checksum. Nothing in it is looked at before the checksum is right.
A file that turns out bad is deleted, also where it ended the process: a marker that lies beside a file while it is
loaded is left behind then.
"""

import base64
import contextlib
import json
import logging
import os
import stat
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from .. import files
from .load import MachineCode

try:
    import fcntl
except ImportError:  # Windows: files are trusted to load
    fcntl = None  # type: ignore[assignment]

OTHERS = stat.S_IWGRP | stat.S_IWOTH
MAGIC = b"jaxbuffer program 5\n"  # the number is the format's
SUFFIX, MARKER, DRAFT, MAKING = ".program", ".loading", ".draft", ".making"
UNUSED = 30 * 86400.0  # s after which a file is deleted: new source makes new files
_log = logging.getLogger(__name__)
_folder: Path | None = None


def store_in(folder: str | Path | None) -> str:
    """Keep programs of functions marked `cache.stored` in a folder from now on, or, with None, in memory only.

    **Returns:** why the folder is not used, if others can write there; "" otherwise.
    """
    global _folder  # noqa: PLW0603 # process-wide like JAX's own cache, which is set beside it
    _folder = None
    if folder is None:
        return ""
    # Whoever can write to the folder could have their own code run here.
    wrong = made_private(Path(folder).absolute())
    if not wrong:
        _folder = Path(folder).resolve()
    return wrong


def folder() -> Path | None:
    """Return the folder in which programs are kept, if any."""
    return _folder


def made_private(folder: Path) -> str:
    """Make the folder where it is missing, readable by its owner only, and return what is wrong with it and how to mend
    it.

    The text is "" if nobody else can write there.

    Where a link is on the way, what counts is where it leads; the folder itself must not be one. Windows, which has no
    such modes, leaves it to the home folder's own protection.
    """
    if not hasattr(os, "getuid"):
        folder.mkdir(parents=True, exist_ok=True)
        return ""
    try:
        missing = [place for place in (folder, *folder.parents) if not place.is_symlink() and not place.exists()]
        # One by one, for the owner only: `mkdir` with parents gives those the process's own mode.
        for above in reversed(missing):
            above.mkdir(mode=0o700, exist_ok=True)
        if stat.S_ISLNK(os.lstat(folder).st_mode):
            return f"{folder} is a link; set JAXBUFFER_CACHE to where it leads"
        place = folder.resolve(strict=True)
        wrong = _wrong(place, os.lstat(place))
        return wrong or next(filter(None, (_replaceable(parent, os.lstat(parent)) for parent in place.parents)), "")
    except OSError as error:
        return f"{error.filename or folder}: {error.strerror}; set JAXBUFFER_CACHE to a folder of your own"


def _wrong(folder: Path, status: os.stat_result) -> str:
    if not stat.S_ISDIR(status.st_mode):
        return f"{folder} is not a folder; set JAXBUFFER_CACHE to one"
    if status.st_uid != os.getuid():
        return f"{folder} belongs to another user; set JAXBUFFER_CACHE to a folder of your own"
    if status.st_mode & OTHERS:
        return f"others may write to {folder}; once you trust what is in it: chmod 700 '{folder}'"
    return ""


def _replaceable(parent: Path, status: os.stat_result) -> str:
    """Return what lets others put another folder in the place of one in here: in a sticky one (/tmp) they can't."""
    if status.st_uid not in (0, os.getuid()):
        return f"{parent} belongs to another user; set JAXBUFFER_CACHE to a folder of your own"
    if status.st_mode & OTHERS and not status.st_mode & stat.S_ISVTX:
        return f"others may write to {parent}: chmod go-w '{parent}', or set JAXBUFFER_CACHE to another folder"
    return ""


class Stored(NamedTuple):
    """What a file holds: a description as JSON has it, the pickled ``example`` of a result, without its numbers, and
    the compiled parts of a program."""

    description: Any
    example: bytes
    compiled: list[MachineCode]


def write(file: Path, stored: Stored) -> None:
    """Write a file whole or not at all; files long unused are deleted."""
    _remove_unused(file.parent)
    record = {
        "description": stored.description,
        "example": _text(stored.example),
        "compiled": [(_text(content), *others) for content, *others in stored.compiled],
    }
    files.write(file, files.sealed(MAGIC + json.dumps(record).encode()))


def _text(content: bytes) -> str:
    return base64.b64encode(content).decode()


def read(file: Path) -> Stored | None:
    """Read what was written, None where there is nothing.

    A file that is no whole program of this format, or that ended a process before, is deleted.
    """
    if _ended_a_process(file):
        _log.info("%s ended the process that loaded it last", file)
        remove(file)
    try:
        content = file.read_bytes()
    except OSError:
        return None
    # Nothing of the file is parsed before its checksum is known to be right.
    body = _body(content)
    if body is None:
        _log.info("%s is not a whole program of this format", file)
        remove(file)
        return None
    with contextlib.suppress(OSError):
        # `_remove_unused` deletes by this time; a file system that cannot set it is no reason not to read.
        file.touch()
    record = json.loads(body)
    compiled = [MachineCode(base64.b64decode(content), *others) for content, *others in record["compiled"]]
    return Stored(record["description"], base64.b64decode(record["example"]), compiled)


def _body(content: bytes) -> bytes | None:
    """Return what is behind a file's first line, if the file is whole and of this format."""
    try:
        whole = files.unsealed(content)
    except ValueError:
        return None
    return whole.removeprefix(MAGIC) if whole is not None and whole.startswith(MAGIC) else None


def remove(*paths: Path) -> None:
    """Delete files, if that is possible."""
    for path in paths:
        with contextlib.suppress(OSError):
            path.unlink()


@contextlib.contextmanager
def being_loaded(file: Path) -> Iterator[None]:
    """Mark a file while it is loaded and first run.

    This process locks the marker: once it has ended, however it did, the lock is gone and the marker is not.
    """
    handle, draft = tempfile.mkstemp(prefix=f"{file.name}.", suffix=DRAFT, dir=file.parent)
    marker = Path(draft).with_suffix(MARKER)
    try:
        if _locked(handle):  # a marker without a lock would be taken for one that was left behind
            os.replace(draft, marker)  # locked before anybody finds it
        yield
    finally:
        remove(Path(draft))
        remove(marker)
        os.close(handle)


def _locked(handle: int) -> bool:
    """Lock a file of one's own; False where files cannot be locked."""
    if fcntl is None:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
    except OSError:
        return False
    return True


@contextlib.contextmanager
def being_made(file: Path) -> Iterator[None]:
    """Hold the right to make a file, once whoever has it is done or gone; where files can't be locked, all make it."""
    lock = file.with_suffix(MAKING)
    with contextlib.ExitStack() as stack:
        if fcntl is not None:
            with contextlib.suppress(OSError):
                opened = stack.enter_context(open(lock, "wb"))
                stack.callback(remove, lock)  # who waits for it will find the file made
                fcntl.flock(opened, fcntl.LOCK_EX)
        yield


def _ended_a_process(file: Path) -> bool:
    """Return whether a marker was left behind; a marker that a process at work has locked is not counted."""
    left = False
    for marker in file.parent.glob(f"{file.name}.*{MARKER}"):
        with contextlib.suppress(OSError), open(marker, "rb") as opened:
            if fcntl is not None:
                # This fails, and the marker stays, while the process that made it is at work.
                fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
            remove(marker)
            left = True
    return left


def _remove_unused(folder: Path) -> None:
    for suffix in (SUFFIX, MARKER, DRAFT, MAKING):
        for old in folder.glob(f"*{suffix}"):
            with contextlib.suppress(OSError):
                if time.time() - old.stat().st_mtime > UNUSED:
                    old.unlink()
