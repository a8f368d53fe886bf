"""A program's file: a header that says what it is, then plain descriptions and machine code.

Nothing behind the header is looked at before its checksum is right. A file that turns out bad is deleted, also where
it ended the process: a marker that lies beside a file while it is loaded is left behind then.
"""

import contextlib
import hashlib
import json
import logging
import os
import struct
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

try:
    import fcntl
except ImportError:  # Windows: files are trusted to load
    fcntl = None  # type: ignore[assignment]

MAGIC = b"jaxbuffer program 1\n"  # the number is the format's
SUFFIX, MARKER, DRAFT, MAKING = ".program", ".loading", ".draft", ".making"
UNUSED = 30 * 86400.0  # s after which a file is deleted: new source makes new files
_log = logging.getLogger(__name__)


class Stored(NamedTuple):
    """What a file holds: a description as JSON has it, and machine code in parts."""

    description: Any
    code: list[bytes]


def write(file: Path, stored: Stored) -> None:
    """Put the file there in one go: another process may read it at the same time. Files long unused go."""
    _remove_unused(file.parent)
    content = _packed(stored)
    handle, draft = tempfile.mkstemp(suffix=DRAFT, dir=file.parent)
    try:
        with open(handle, "wb") as opened:
            opened.write(MAGIC + hashlib.sha256(content).digest() + content)
        os.replace(draft, file)
    except BaseException:
        remove(Path(draft))
        raise


def read(file: Path) -> Stored | None:
    """What was written, None where there is nothing; a file that is no whole program, or of another format, or that
    ended a process before, is deleted."""
    if _ended_a_process(file):
        _log.info("%s ended the process that loaded it last", file)
        remove(file)
    try:
        content = file.read_bytes()
    except OSError:
        return None
    body = content[len(MAGIC) + hashlib.sha256().digest_size :]
    if content[: -len(body) or None] != MAGIC + hashlib.sha256(body).digest():
        _log.info("%s is not a whole program of this format", file)
        remove(file)
        return None
    with contextlib.suppress(OSError):
        file.touch()
    return _unpacked(body)


def remove(file: Path) -> None:
    """Delete a file, if that is possible."""
    with contextlib.suppress(OSError):
        file.unlink()


@contextlib.contextmanager
def being_loaded(file: Path) -> Iterator[None]:
    """Mark a file while it is loaded and first run. The marker is locked by this process: once that has ended, however
    it did, the lock is gone and the marker is not."""
    handle, draft = tempfile.mkstemp(prefix=f"{file.name}.", suffix=DRAFT, dir=file.parent)
    marker = Path(draft).with_suffix(MARKER)
    try:
        if fcntl is not None:
            fcntl.flock(handle, fcntl.LOCK_EX)
        os.replace(draft, marker)  # locked before anybody finds it
        yield
    finally:
        remove(Path(draft))
        remove(marker)
        os.close(handle)


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
    """Whether a marker was left behind; markers of processes at work are theirs."""
    left = False
    for marker in file.parent.glob(f"{file.name}.*{MARKER}"):
        with contextlib.suppress(OSError), open(marker, "rb") as opened:
            if fcntl is not None:
                fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
            remove(marker)
            left = True
    return left


def _packed(stored: Stored) -> bytes:
    sizes = [len(code) for code in stored.code]
    description = json.dumps({"sizes": sizes, "description": stored.description}).encode()
    return b"".join([struct.pack(">Q", len(description)), description, *stored.code])


def _unpacked(body: bytes) -> Stored:
    start = struct.calcsize(">Q")
    (length,) = struct.unpack(">Q", body[:start])
    head = json.loads(body[start : start + length])
    place, code = start + length, []
    for size in head["sizes"]:
        code.append(body[place : place + size])
        place += size
    return Stored(head["description"], code)


def _remove_unused(folder: Path) -> None:
    for suffix in (SUFFIX, MARKER, DRAFT, MAKING):
        for old in folder.glob(f"*{suffix}"):
            with contextlib.suppress(OSError):
                if time.time() - old.stat().st_mtime > UNUSED:
                    old.unlink()
