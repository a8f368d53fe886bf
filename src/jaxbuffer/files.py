"""Files that are whole or not there, and folders that one run at a time may use."""

import contextlib
import errno
import fcntl
import os
from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

from .errors import InputError

LOCK, DRAFT = ".lock", ".part"


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Let an `OSError` raised inside, such as "no space left on device", name this file."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno or errno.EIO, error.strerror or str(error), str(path)) from None


def write(path: Path, content: str | bytes, overwrite: bool = True) -> None:
    """Write a file so that it is whole or, whatever goes wrong, as it was before.

    **Arguments:** ``content``: text is written as UTF-8; ``overwrite``: whether to replace a file that is there.
    **Raises:** `FileExistsError` without ``overwrite``; any other `OSError` too names the file.
    """
    draft = path.with_name(f".{path.name}.{os.getpid()}{DRAFT}")
    try:
        with naming(path):
            with draft.open("wb") as file:
                # A path's bytes that are no UTF-8 are surrogates in Python, which UTF-8 has not: written as \udc80.
                file.write(content.encode(errors="backslashreplace") if isinstance(content, str) else content)
                file.flush()
                os.fsync(file.fileno())
            if overwrite:
                draft.replace(path)
            else:
                _link(draft, path)
            _sync(path.parent)
    finally:
        with contextlib.suppress(OSError):
            draft.unlink(missing_ok=True)


def write_beside(path: Path, content: str | bytes) -> Path:
    """Write a file under its own name or, if that is taken, under the next free one: "a-1.csv" beside "a.csv"."""
    number, free = 0, path
    while True:
        try:
            write(free, content, overwrite=False)
        except FileExistsError:
            number += 1
            free = path.with_name(f"{path.stem}-{number}{path.suffix}")
        else:
            return free


def _link(draft: Path, path: Path) -> None:
    """Give the draft its name unless that is taken; a file system without links leaves a moment between the two."""
    try:
        os.link(draft, path)
    except FileExistsError:
        raise
    except OSError:
        if path.exists():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST)) from None
        draft.replace(path)


def _sync(folder: Path) -> None:
    """Have the folder's entries on disk too; some file systems cannot do that for folders."""
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):
            os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _remove_drafts(folder: Path) -> None:
    """Remove the drafts of processes that are gone."""
    for draft in folder.glob(f".*{DRAFT}"):
        process = draft.name.removesuffix(DRAFT).rpartition(".")[2]
        try:
            os.kill(int(process), 0)
        except (ValueError, ProcessLookupError):
            draft.unlink(missing_ok=True)
        except OSError:  # another user's, alive
            continue


class Lock:
    """The right to write in a folder, made if it is not there, until `release` or the end of the process.

    What killed processes left half written there is removed.

    **Raises:** `InputError` while another run has it.
    """

    of_command: ClassVar[dict[Path, "Lock"]] = {}  # whose folder the sweeps and tunings in it share

    def __init__(self, folder: Path) -> None:
        self.path, self.descriptor = folder.resolve() / LOCK, -1
        if self.path in Lock.of_command:
            return
        self.new_folders = [path for path in (self.path.parent, *self.path.parent.parents) if not path.exists()]
        with naming(self.path):
            while not self._acquired(folder):
                pass
        _remove_drafts(folder)

    def _acquired(self, folder: Path) -> bool:
        """Lock the file; False if its former owner removed it meanwhile, and it is to be made anew."""
        folder.mkdir(parents=True, exist_ok=True)
        try:
            self.descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
        except FileNotFoundError:  # its former owner removed the folder
            return False
        try:
            fcntl.flock(self.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            owner = os.read(self.descriptor, 20).decode(errors="replace").strip() or "unknown"
            os.close(self.descriptor)
            self.descriptor = -1
            raise InputError(f"{folder} is in use by another run, process {owner}; choose another folder") from None
        try:
            current = os.stat(self.path).st_ino == os.fstat(self.descriptor).st_ino
        except FileNotFoundError:
            current = False
        if not current:
            os.close(self.descriptor)
            return False
        os.ftruncate(self.descriptor, 0)
        os.pwrite(self.descriptor, f"{os.getpid()}\n".encode(), 0)
        return True

    def release(self) -> None:
        """Let others write there; may be called again."""
        if self.descriptor >= 0:
            Lock.of_command.pop(self.path, None)
            self.path.unlink(missing_ok=True)
            os.close(self.descriptor)
            self.descriptor = -1

    def lend(self) -> None:
        """Let other locks of this folder in this process be this one, until `release`."""
        Lock.of_command.setdefault(self.path, self)

    @staticmethod
    def release_all() -> None:
        """Release what was lent, and remove folders that were made for it and are empty."""
        for lock in list(Lock.of_command.values()):
            lock.release()
            with contextlib.suppress(OSError):  # the first that is not empty
                for folder in lock.new_folders:
                    folder.rmdir()
