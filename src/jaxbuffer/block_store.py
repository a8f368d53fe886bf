"""A store of blocks of arrays, from which a computation goes on after whatever ended it.

A block is read as it was written or not at all: a checksum of all its numbers is written with it, last. A store says
what it is of, so that none but the same computation goes on with it. `BlockStore` leaves to its subclasses in which
files a block lies.
"""

import dataclasses
import hashlib
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Generic, NamedTuple, Self, TypeVar

import numpy as np

from .errors import InputError
from .files import write

B = TypeVar("B")  # what names a block
Arrays = Mapping[str, np.ndarray]
Identity = Mapping[str, str]  # what makes a computation the one it is, a text for each part of it
HEAD, CHECKSUM = "head", "checksum"  # arrays of an archive beside a block's own
IDENTITY, TOKEN = "identity", "token"  # where the description of a store has them, that of a result the first one


class BlockError(Exception):
    """A block cannot be read; the message says why: it "is damaged"."""


class MissingBlock(BlockError):
    """A block is not there."""

    def __init__(self) -> None:
        super().__init__("is missing")


class Head(NamedTuple):
    """What tells one store from another.

    ``identity``: of the computation; ``token``: made up when the store was begun, differs where that was done again.
    """

    identity: Identity
    token: str

    def described(self) -> dict[str, str]:
        """Return the entries of a store's description that `of` reads."""
        return {IDENTITY: identity_text(self.identity), TOKEN: self.token}

    @staticmethod
    def of(description: Mapping[str, Any]) -> "Head":
        """Read a store's description. **Raises:** `BlockError` where it is damaged or that of something else."""
        identity = described_identity(description)
        if identity is None or TOKEN not in description:
            raise BlockError("is damaged")
        return Head(identity, str(description[TOKEN]))


@dataclasses.dataclass(frozen=True)
class BlockStore(Generic[B]):
    """The blocks of one computation, as a process that reads or writes them sees them; ``head``: of the store."""

    head: Head

    def write(self, block: B, arrays: Arrays) -> None:
        """Store a block's arrays, by name, in place of what was there."""
        self._write_files(block, arrays, self._checksum(block, arrays))

    def read(self, block: B) -> dict[str, np.ndarray]:
        """Return a block's arrays. **Raises:** `BlockError`; `MissingBlock` where it has not been written."""
        try:
            arrays, checksum = self._read_files(block)
        except BlockError:
            raise
        except Exception:  # files and what unpacks them fail in many ways; all mean the same
            raise BlockError("is damaged") from None
        if checksum != self._checksum(block, arrays):
            raise BlockError("is damaged")
        return arrays

    def check_identity(self, identity: Identity) -> None:
        """Raise `InputError` where the store is of another computation, with what `_refusal` says of it."""
        if parts := differing(identity, self.head.identity):
            raise InputError(self._refusal(identity, parts))

    def _refusal(self, identity: Identity, parts: list[str]) -> str:
        """Return why a computation of this identity does not go on with the store, of whose ``parts`` some differ."""
        raise NotImplementedError

    def _write_files(self, block: B, arrays: Arrays, checksum: int) -> None:
        """Write a block's files, each whole or not at all, that of the checksum not before the others."""
        raise NotImplementedError

    def _read_files(self, block: B) -> tuple[dict[str, np.ndarray], int]:
        """Read a block's arrays and its checksum.

        **Raises:** `MissingBlock` where there is no checksum; any other error where something is damaged.
        """
        raise NotImplementedError

    def _name(self, block: B) -> str:
        """Return a name that no other block of the store has."""
        return str(block)

    def _checksum(self, block: B, arrays: Arrays) -> int:
        """Return a positive whole number that differs for other numbers, and for those of another block or store."""
        whose = f"{identity_text(self.head.identity)} {self.head.token} {self._name(block)}\n"
        content = hashlib.blake2b(whose.encode(), digest_size=8)
        # Sorted: the order in which a reader lists the arrays must not change the checksum.
        for name in sorted(arrays):
            values = arrays[name]
            # Name, type and shape count too: the same bytes under another name or in another shape are another block.
            content.update(f"{name} {values.dtype.str} {values.shape}\n".encode())
            content.update(np.ascontiguousarray(values).tobytes())
        return int.from_bytes(content.digest(), "little") or 1  # 0 is what a missing number is read as


@dataclasses.dataclass(frozen=True)
class ArchiveStore(BlockStore[str]):
    """A store in a ``folder`` whose blocks are named by their files, NumPy archives that also say what they are of."""

    folder: Path

    @classmethod
    def of(cls, folder: Path, block: str) -> Self:
        """Return the store that a block is of. **Raises:** `BlockError` where that cannot be read."""
        try:
            description = json.loads(str(_archive(folder / block)[HEAD]))
        except ValueError:
            raise BlockError("is damaged") from None
        return cls(Head.of(description), folder)

    def _write_files(self, block: str, arrays: Arrays, checksum: int) -> None:
        content, head = io.BytesIO(), json.dumps(self.head.described())
        all_arrays: dict[str, Any] = {HEAD: head, **arrays, CHECKSUM: np.uint64(checksum)}
        np.savez(content, **all_arrays)
        write(self.folder / block, content.getvalue())

    def _read_files(self, block: str) -> tuple[dict[str, np.ndarray], int]:
        arrays = _archive(self.folder / block)
        del arrays[HEAD]
        return arrays, int(arrays.pop(CHECKSUM))


def _archive(file: Path) -> dict[str, np.ndarray]:
    """Return the arrays of a block. **Raises:** `BlockError` that says what is wrong with it."""
    try:
        with file.open("rb") as content, np.load(content, allow_pickle=False) as stored:
            arrays = dict(stored)
    except FileNotFoundError:
        raise MissingBlock from None
    except Exception:  # zip files and arrays fail in many ways; all mean the same
        raise BlockError("is damaged") from None
    if not {HEAD, CHECKSUM} <= arrays.keys():
        raise BlockError("is of another version of jaxbuffer")
    return arrays


def identity_text(identity: Identity) -> str:
    """Return an identity as a description has it."""
    return json.dumps(dict(identity), sort_keys=True)


def described_identity(description: Mapping[str, Any]) -> dict[str, str] | None:
    """Return the identity in the description of a store or a result, or None where that is missing or damaged."""
    try:
        return dict(json.loads(str(description[IDENTITY])))
    except (KeyError, ValueError, TypeError):
        return None


def short_hash(identity: Identity) -> str:
    """Return a short text that differs for another identity, which a result's record has."""
    return hashlib.sha256(identity_text(identity).encode()).hexdigest()[:16]


def differing(one: Mapping[str, Any], other: Mapping[str, Any]) -> list[str]:
    """Return the names whose entries differ, in two identities or in the kinds of two processes."""
    return [name for name in {**one, **other} if one.get(name) != other.get(name)]
