"""The folder of compiled programs, and the files in it.

Programs are code, so nobody but the user may be able to write to the folder. A file is a line that says what it is,
plain descriptions and the exported programs, and a checksum. Nothing in it is looked at before the checksum is right.
A file that turns out bad is deleted, also where it ended the process: a marker that lies beside a file while it is
loaded is left behind then. What JAX's persistent cache compiled from a program is in files beside it, whose checksums
are in the program's own.

A wheel may have programs in the package itself, as exported: they are as trustworthy as the source beside them.
"""

import base64
import contextlib
import json
import logging
import os
import stat
import tempfile
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from .. import files

try:
    import fcntl
except ImportError:  # Windows: files are trusted to load
    fcntl = None  # type: ignore[assignment]

OTHERS = stat.S_IWGRP | stat.S_IWOTH
MAGIC = b"jaxbuffer program 3\n"  # the number is the format's
SUFFIX, MARKER, DRAFT, MAKING = ".program", ".loading", ".draft", ".making"
COMPILED = "-cache"  # what the names of files of JAX's persistent cache end with
SHIPPED = Path(__file__).parent / "shipped"  # in a wheel that was built with programs
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
        _make(folder)
        if stat.S_ISLNK(os.lstat(folder).st_mode):
            return f"{folder} is a link; set JAXBUFFER_CACHE to where it leads"
        place = folder.resolve(strict=True)
        wrong = _wrong(place, os.lstat(place))
        return wrong or next(filter(None, (_replaceable(parent, os.lstat(parent)) for parent in place.parents)), "")
    except OSError as error:
        return f"{error.filename or folder}: {error.strerror}; set JAXBUFFER_CACHE to a folder of your own"


def _make(folder: Path) -> None:
    """Make the folder and those above it, for the owner only whatever the process's mask is."""
    missing = [place for place in (folder, *folder.parents) if not place.is_symlink() and not place.exists()]
    # One by one: `mkdir` with parents gives those the process's own mode.
    for place in reversed(missing):
        place.mkdir(mode=0o700, exist_ok=True)


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
    """What a file holds: a description as JSON has it, and exported programs."""

    description: Any
    exported: list[bytes]


def part_name(file: Path, k: int) -> str:
    """Return the name of the k-th part of a file's program, from which JAX's cache makes the names of its files."""
    return f"of_{file.stem.rpartition('-')[2]}_{k}"


def compiled_from(file: Path, of_jax: Path | None) -> list[Path]:
    """Return the files that JAX's cache, in the folder ``of_jax`` if anywhere, holds of a file's program."""
    return [] if of_jax is None else sorted(of_jax.glob(f"*{part_name(file, 0)[:-1]}*{COMPILED}"))


def write(file: Path, stored: Stored, of_jax: Path | None) -> None:
    """Write a file whole or not at all, with checksums of what JAX compiled; files long unused are deleted."""
    _remove_unused(file.parent)
    exported = [base64.b64encode(program).decode() for program in stored.exported]
    checksums = _checksums(compiled_from(file, of_jax))
    content = json.dumps({"description": stored.description, "exported": exported, "compiled": checksums}).encode()
    files.write(file, files.sealed(MAGIC + content))


def read(file: Path, of_jax: Path | None) -> Stored | None:
    """Read what was written, None where there is nothing.

    A file that is no whole program of this format, that ended a process before, or from which JAX compiled something
    else than what is there now, is deleted.
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
    record, compiled = json.loads(body), compiled_from(file, of_jax)
    if record["compiled"] != _checksums(compiled):
        _log.info("what was compiled from %s has changed", file)
        remove(file)
        return None
    for path in (file, *compiled):
        with contextlib.suppress(OSError):
            # `_remove_unused` deletes by this time; a file system that cannot set it is no reason not to read.
            path.touch()
    return _stored(record)


def read_shipped(name: str) -> Stored | None:
    """Read a program that the package came with; None where there is none, or none that is whole."""
    try:
        body = _body((SHIPPED / name).read_bytes())
    except OSError:
        return None
    return None if body is None else _stored(json.loads(body))


def ship(folder: Path, into: Path) -> None:
    """Write a folder's programs as a wheel has them: as exported, under a name that is the same for all processors."""
    into.mkdir(parents=True, exist_ok=True)
    for file in folder.glob(f"*{SUFFIX}"):
        body = _body(file.read_bytes())
        if body is not None:
            stored = _stored(json.loads(body))
            write(into / stored.description["shipped"], stored, None)


def _body(content: bytes) -> bytes | None:
    """Return what is behind a file's first line, if the file is whole and of this format."""
    try:
        whole = files.unsealed(content)
    except ValueError:
        return None
    return whole.removeprefix(MAGIC) if whole is not None and whole.startswith(MAGIC) else None


def _stored(record: Any) -> Stored:
    return Stored(record["description"], [base64.b64decode(program) for program in record["exported"]])


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


def _checksums(paths: Iterable[Path]) -> dict[str, str]:
    return {path.name: files.checksum(path.read_bytes()) for path in paths}


def _remove_unused(folder: Path) -> None:
    for suffix in (SUFFIX, COMPILED, MARKER, DRAFT, MAKING):
        for old in folder.glob(f"*{suffix}"):
            with contextlib.suppress(OSError):
                if time.time() - old.stat().st_mtime > UNUSED:
                    old.unlink()
