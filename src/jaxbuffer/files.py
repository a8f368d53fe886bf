"""Files that are whole or not there, their checksums, and folders that one run at a time may use."""

import contextlib
import errno
import fcntl
import hashlib
import os
import platform
import pwd
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import ClassVar, Self

from .errors import InputError

LOCK, DRAFT = ".lock", ".part"
SEAL = b"\njaxbuffer checksum "


def home() -> Path | None:
    """Return the user's home folder, None where neither $HOME nor the system knows one, as in some containers."""
    try:
        return Path(os.environ.get("HOME") or pwd.getpwuid(os.getuid()).pw_dir)
    except KeyError:
        return None


def user_path(path: str | os.PathLike[str]) -> Path:
    """Return a path as a user means it: a leading "~" is the home folder, also where no shell has replaced it.

    **Raises:** `InputError` where that folder is not known.
    """
    first, *rest = Path(path).parts or (".",)
    if not first.startswith("~"):
        return Path(path)
    if first == "~":
        folder = home()
    else:
        try:
            folder = Path(first).expanduser()
        except RuntimeError:  # no such user
            folder = None
    if folder is None:
        raise InputError(f"{path}: the folder {first} is not known; write the whole path, or ./{path} for one named so")
    return folder.joinpath(*rest)


def cache_folder() -> Path | None:
    """Return the default folder of compiled programs, None where neither the environment nor a home folder says one."""
    chosen = os.environ.get("JAXBUFFER_CACHE")
    if chosen:
        return user_path(chosen)
    own = home()
    shared = os.environ.get("XDG_CACHE_HOME", "")
    if own is not None and (shared == "~" or shared.startswith("~/")):  # a file that no shell reads has set it
        shared = str(own / shared[2:])
    # A relative path would be another folder wherever one stands: the XDG specification has it ignored.
    if Path(shared).is_absolute():
        return Path(shared) / "jaxbuffer"
    return None if own is None else own / ".cache" / "jaxbuffer"


def check_links(folder: Path) -> None:
    """Raise `InputError` where a folder is, or is in, a link that leads nowhere: a disk may not be mounted."""
    for place in (folder, *folder.parents):
        if place.is_symlink() and not place.exists():
            target = place.parent / os.readlink(place)
            raise InputError(f"{place} is a link to {target}, which is not there; make it, or choose another folder")


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
    draft = _draft(path)
    try:
        with naming(path):
            # A path's bytes that are no UTF-8 are surrogates in Python, which UTF-8 has not: written as \udc80.
            _fill(draft, content.encode(errors="backslashreplace") if isinstance(content, str) else content)
            # A rename replaces the file in one step: nobody ever reads half of it.
            if overwrite:
                draft.replace(path)
            else:
                _link(draft, path)
            # The new name is an entry of the folder: a power failure could lose it though the file is on disk.
            _sync(path.parent)
    finally:
        with contextlib.suppress(OSError):
            draft.unlink(missing_ok=True)


def write_all(contents: Mapping[Path, bytes]) -> None:
    """Write files in this order, each whole or not at all, and none before there is room for all of them.

    They are left to the system to put on disk, because that takes longer than all the rest: a power failure may leave
    them empty, so that whoever reads them needs a checksum.
    """
    drafts = {path: _draft(path) for path in contents}
    try:
        for path, draft in drafts.items():
            try:
                _fill(draft, contents[path], sync=False)
            except FileNotFoundError:  # the first file of its folder
                path.parent.mkdir(parents=True, exist_ok=True)
                _fill(draft, contents[path], sync=False)
        for path, draft in drafts.items():
            draft.replace(path)
    except BaseException:
        for draft in drafts.values():
            draft.unlink(missing_ok=True)
        raise


@contextlib.contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """Give an empty folder that takes the place of what is at ``path`` once the block has ended without an error.

    What was there is renamed, then deleted, so that an interrupt never leaves a half-deleted one under that name.
    """
    draft, former = (path.with_name(f".{path.name}.{word}") for word in ("draft", "old"))
    with naming(path):
        for left in (draft, former):  # by a process that was killed
            if left.exists():
                shutil.rmtree(left)
        draft.mkdir()
        try:
            yield draft
        except BaseException:
            shutil.rmtree(draft, ignore_errors=True)
            raise
        # A rename does not replace a folder that has files, so that the former one leaves its name first.
        if path.exists():
            path.rename(former)
        draft.rename(path)
        if former.exists():
            shutil.rmtree(former)


def checksum(content: bytes) -> str:
    """Return a checksum of a content: a text that is another one if the content has been damaged."""
    return hashlib.blake2b(content, digest_size=16).hexdigest()


def sealed(content: bytes) -> bytes:
    """Return a content with its checksum behind it, where formats that know their own end do not look."""
    return content + SEAL + checksum(content).encode()


def unsealed(content: bytes) -> bytes | None:
    """Return what `sealed` was given, or None where there is no checksum.

    **Raises:** `ValueError` where the content is not what it was.
    """
    original, mark, stored = content.rpartition(SEAL)
    if not mark:
        return None
    if stored != checksum(original).encode():
        raise ValueError("its checksum is another one")
    return original


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


def _draft(path: Path) -> Path:
    """Return the name of a file's draft, which no other thread, process or machine uses, and `_remove_drafts` knows."""
    return path.with_name(f".{path.name}.{os.urandom(4).hex()}.{os.getpid()}{DRAFT}")


def _fill(draft: Path, content: bytes, sync: bool = True) -> None:
    """Write a draft; with ``sync`` it is on disk afterwards."""
    with draft.open("wb") as file:
        file.write(content)
        if sync:
            file.flush()
            os.fsync(file.fileno())


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
        if not _is_alive(draft.name.removesuffix(DRAFT).rpartition(".")[2]):
            draft.unlink(missing_ok=True)


def remove_all_drafts(folder: Path) -> None:
    """Remove all drafts in a folder and those below, also of other machines; nobody else may be at work there."""
    for draft in folder.rglob(f".*{DRAFT}"):
        draft.unlink(missing_ok=True)


def _is_alive(process: str) -> bool:
    """Return whether a process of this number is at work on this machine."""
    try:
        # Signal 0 only asks whether the process exists.
        os.kill(int(process), 0)
    except (ValueError, OverflowError, ProcessLookupError):
        return False
    except OSError:  # another user's, alive
        return True
    return True


class Lock:
    """The right to write in a folder, made if it is not there, until `release` or the end of the process.

    What killed processes left half written there is removed. Where the file system cannot lock files (Lustre without
    the option flock, some network folders), what the file says of its owner counts instead.

    **Raises:** `InputError` while another run has it, and for a link that leads nowhere.
    """

    of_command: ClassVar[dict[Path, "Lock"]] = {}  # whose folder the sweeps and tunings in it share
    unlocked: ClassVar[set[Path]] = set()  # files of this process that could not be locked

    def __init__(self, folder: Path) -> None:
        self.path, self.descriptor = folder.resolve() / LOCK, -1
        if self.path in Lock.of_command:
            return
        check_links(folder)
        self.new_folders = [path for path in (self.path.parent, *self.path.parent.parents) if not path.exists()]
        with naming(self.path):
            while not self._acquired(folder):
                pass
        _remove_drafts(folder)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

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
            raise self._in_use(folder, self._owner()[0] or "unknown") from None
        except OSError:  # ENOSYS, ENOLCK, EOPNOTSUPP and others: there are no locks here
            self._check_owner(folder)
            Lock.unlocked.add(self.path)
        try:
            # Its former owner may have removed the file after it was opened here: a lock on it would be no lock.
            current = os.stat(self.path).st_ino == os.fstat(self.descriptor).st_ino
        except FileNotFoundError:
            current = False
        if not current:
            os.close(self.descriptor)
            return False
        os.ftruncate(self.descriptor, 0)
        os.pwrite(self.descriptor, f"{os.getpid()} {platform.node()}\n".encode(), 0)
        return True

    def _owner(self) -> tuple[str, str]:
        """Return the process and the machine that the file names, "" for what it does not."""
        process, _, machine = os.pread(self.descriptor, 300, 0).decode(errors="replace").strip().partition(" ")
        return process, machine

    def _check_owner(self, folder: Path) -> None:
        """Raise `InputError` where the file names a process that is at work, or might be, on another machine."""
        process, machine = self._owner()
        if machine not in ("", platform.node()):
            raise self._in_use(folder, f"{process} on {machine}", f", or delete {self.path} once that has ended")
        # A process in a new container often has the number of one that was killed.
        at_work = self.path in Lock.unlocked if process == str(os.getpid()) else _is_alive(process)
        if at_work:
            raise self._in_use(folder, process)

    def _in_use(self, folder: Path, owner: str, remedy: str = "") -> InputError:
        os.close(self.descriptor)
        self.descriptor = -1
        return InputError(f"{folder} is in use by another run, process {owner}; choose another folder{remedy}")

    def release(self) -> None:
        """Let others write there; may be called again."""
        if self.descriptor >= 0:
            Lock.of_command.pop(self.path, None)
            Lock.unlocked.discard(self.path)
            # Removed while it is still locked: afterwards the file could be that of the next owner.
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
