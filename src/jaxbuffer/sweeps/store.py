"""A sweep on disk: a file that only grows, so that a kill costs about a second of work.

``sweep.chunks`` begins with a line that says whose sweep it is: a CRC-32 and JSON. Records follow, each with what was
finished since the last: a mark, the number of runs, the CRC-32 of the rest; the runs' numbers in the sweep; then
one quantity after the other. Each number has 8 bytes, little-endian.
"""

import hashlib
import json
import mmap
import os
import struct
import time
import warnings
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np

from ..errors import InputError
from ..files import Lock, naming, write
from ..version import version

STORE, ZARR = "sweep.chunks", "sweep.zarr"  # and that of a sweep over a scheduler (`zarr_store`)
PERIOD = 1.0  # s between records
MARK = b"\xf1CHUNK\r\n"
HEAD = struct.Struct("<8sII")


def identity(**parts: Any) -> dict[str, str]:
    """What makes a sweep the one it is, by name: a hash of each part's numbers and of how they are arranged."""
    hashes = {"version": version()}
    for name, part in parts.items():
        leaves, structure = jax.tree.flatten(part)
        content = hashlib.sha256(str(structure).encode())
        for leaf in leaves:
            content.update(repr(leaf).encode() if isinstance(leaf, str) else _bytes(np.asarray(leaf, float)))
        hashes[name] = content.hexdigest()[:16]
    return hashes


def differing(file: Path, own: Mapping[str, str], found: Mapping[str, str]) -> None:
    """Raise `InputError` where a file or store has another sweep's identity."""
    differ = [name for name in {**own, **found} if own.get(name) != found.get(name)]
    if differ:
        told = "repeat the study, the options and the same --over of the first, or choose another --output"
        raise InputError(f"{file} holds another sweep, differing in {_and(differ)}; {told}; it is left as it is")


class SweepStore:
    """The folder of one sweep, locked until `close`."""

    def __init__(
        self,
        folder: Path,
        identity: Mapping[str, str],
        columns: Sequence[np.ndarray],
        finished: np.ndarray,
        resume: bool,
    ) -> None:
        """Begin a file, or with ``resume`` fill in what an earlier run finished.

        **Arguments:** ``columns``: an array (n,) a quantity, of float or int; ``finished`` (n,): which runs are in
        them. Both are read again at each `save`.
        """
        self.file, self.columns, self.finished = folder / STORE, tuple(columns), finished
        self.stored = np.zeros_like(finished)
        self.due = time.monotonic() + PERIOD
        if resume and not self.file.exists():
            other = f", {ZARR} is one of --scheduler" if (folder / ZARR).exists() else ""
            told = f"{STORE} is missing{other}; leave out --resume to begin one"
            raise InputError(f"{folder}: there is no sweep to resume; {told}")
        self.lock = Lock(folder)
        try:
            self.length = self._read(identity) if resume else self._begin(identity)
            self.descriptor = os.open(self.file, os.O_WRONLY)
        except BaseException:
            self.lock.release()
            raise

    def save(self, now: bool = False) -> None:
        """Store what was finished since the last record, if that is long enough ago or ``now``."""
        if not now and time.monotonic() < self.due:
            return
        new = np.flatnonzero(self.finished & ~self.stored)
        if new.size:
            body = b"".join(map(_bytes, (new, *(column[new] for column in self.columns))))
            record = memoryview(HEAD.pack(MARK, new.size, zlib.crc32(body)) + body)
            written = 0
            with naming(self.file):  # at a fixed place: what an interrupt cut short is written over
                while written < len(record):
                    written += os.pwrite(self.descriptor, record[written:], self.length + written)
                os.fsync(self.descriptor)
            self.length += len(record)
            self.stored[new] = True
        self.due = time.monotonic() + PERIOD

    def close(self) -> None:
        """Store the rest and leave the folder to others."""
        try:
            self.save(now=True)
        finally:
            os.close(self.descriptor)
            self.lock.release()

    def _begin(self, identity: Mapping[str, str]) -> int:
        text = json.dumps(dict(identity), sort_keys=True).encode()
        line = b"%08x %b\n" % (zlib.crc32(text), text)
        write(self.file, line)
        return len(line)

    def _read(self, identity: Mapping[str, str]) -> int:
        """Fill in what is stored; returns the length of the file up to the end of its last good record."""
        with naming(self.file), self.file.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            self._check(file.readline(65536), identity)
            begin = end = good = file.tell()
            if size > begin:
                with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
                    for stop, places, columns in _records(content, begin, self.columns, self.finished.size):
                        for mine, values in zip(self.columns, columns, strict=True):
                            mine[places] = values
                        self.finished[places] = self.stored[places] = True
                        good += HEAD.size + 8 * places.size * (1 + len(columns))
                        end = stop
        if good < size:
            done = f"{int(self.finished.sum())} of {self.finished.size} runs"
            warnings.warn(f"{self.file}: {size - good} bytes are damaged; going on with {done}", stacklevel=2)
            with naming(self.file):
                os.truncate(self.file, end)
        return end

    def _check(self, line: bytes, identity: Mapping[str, str]) -> None:
        """Raise `InputError` unless the file's first line says that it is this sweep's."""
        check, _, text = line.rstrip(b"\n").partition(b" ")
        if check != b"%08x" % zlib.crc32(text):
            raise InputError(f"{self.file} is damaged at its beginning and cannot be resumed; it is left as it is")
        found = json.loads(text)
        differing(self.file, identity, found)


def _records(
    content: mmap.mmap, start: int, columns: Sequence[np.ndarray], count: int
) -> Iterator[tuple[int, np.ndarray, list[np.ndarray]]]:
    """The end of each good record, the numbers of its runs and their quantities; damaged ones are passed over."""
    position = content.find(MARK, start)
    while position >= 0:
        end = position + 1
        if position + HEAD.size <= len(content):
            _, size, check = HEAD.unpack_from(content, position)
            begin, length = position + HEAD.size, 8 * size * (1 + len(columns))
            body = content[begin : begin + length]
            if len(body) == length and zlib.crc32(body) == check:
                places, *values = np.split(np.frombuffer(body, "<i8"), 1 + len(columns))
                if places.min(initial=0) >= 0 and places.max(initial=0) < count:
                    end = begin + length
                    yield end, places, [v.view(c.dtype) for v, c in zip(values, columns, strict=True)]
        position = content.find(MARK, end)


def _bytes(array: np.ndarray) -> bytes:
    return np.ascontiguousarray(array, array.dtype.newbyteorder("<")).tobytes()


def _and(words: Sequence[str]) -> str:
    *others, last = words
    return f"{', '.join(others)} and {last}" if others else last
