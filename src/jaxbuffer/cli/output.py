"""Result files: refused before computing if they exist; saved at the end, and only then is anything printed."""

import errno
import os
from collections.abc import Callable, Sequence
from pathlib import Path

from ..errors import InputError
from ..files import Lock, write, write_beside
from ..output.formats import Contents
from .streams import note, show

ENDINGS = (".csv", ".gif", ".html", ".json", ".mp4", ".nc", ".npz", ".png", ".svg", ".toml", ".txt")  # of result files


def _vector(name: str) -> tuple[str, ...]:
    """Every figure is written as SVG too."""
    return (f"{name.removesuffix('.png')}.svg",) if name.endswith(".png") else ()


def is_figure(name: str) -> bool:
    """Whether a file is a figure, which shows what other files hold."""
    return name.endswith((".png", ".svg"))


def drawing_error(path: Path, error: Exception) -> OSError:
    """What is said of a figure that matplotlib fails to draw."""
    told = next((line for line in str(error).splitlines() if line.strip()), "")
    return OSError(errno.EIO, f"cannot be drawn, {type(error).__name__}: {told}".rstrip(": "), str(path))


def _listed(paths: Sequence[str]) -> str:
    """The first of some paths, and how many more there are."""
    return paths[0] if len(paths) == 1 else f"{paths[0]} and {len(paths) - 1} more"


class Output:
    """The files of one command in a folder, which is its own until `entry.run` ends, or nothing at all without one."""

    def __init__(
        self,
        folder: Path | None,
        names: Sequence[str],
        force: bool,
        resumable: Sequence[str] = (),
        resume: bool = False,
        as_json: bool = False,
    ) -> None:
        self.folder, self.force, self.as_json = folder, force or resume, as_json
        if folder is None:
            return
        if folder.suffix.lower() in ENDINGS and not folder.exists():
            plain = folder.with_suffix("")
            raise InputError(f"--output {folder} has the ending of a file and names a folder; write --output {plain}")
        names = [name for one in names for name in (one, *_vector(one))]
        parent = next(p for p in (folder, *folder.absolute().parents) if p.exists())
        if not parent.is_dir():
            raise InputError(f"{parent} is a file; --output needs a folder")
        if not os.access(parent, os.W_OK | os.X_OK):
            raise InputError(f"{folder}: no permission to write there")
        Lock(folder).lend()
        taken = [str(folder / name) for name in (*names, *resumable) if (folder / name).exists()]
        begun = [str(folder / name) for name in resumable if (folder / name).exists()]
        if taken and not self.force:
            goes_on = "--resume goes on, " if begun else ""
            exist, them = ("exists", "it") if len(taken) == 1 else ("exist", "them")
            keeps = f"another --output keeps {them}"
            raise InputError(f"{_listed(taken)} {exist}; {goes_on}--force overwrites, {keeps}")
        if begun and not resume:
            note(f"--force: an earlier run is overwritten, {', '.join(begun)}")

    def save_and_show(
        self, contents: Callable[[], Contents], result: object, record: Callable[[], str] | None = None
    ) -> None:
        """Write every file, figures last, then print the result and what was written; with --json print the ``record``
        alone on stdout.

        A file that cannot be made or written leaves the others and the printing alone. **Raises:** the first such
        error, an `OSError` for a figure that cannot be drawn.
        """
        failure: Exception | None = None
        written: list[Path] = []
        try:
            if self.folder is not None:
                for name, content in sorted(contents().items(), key=lambda item: is_figure(item[0])):
                    path = self.folder / name
                    try:
                        written.append(self._write(path, content()))
                    except OSError as error:
                        failure = failure or error
                    except Exception as error:
                        failure = failure or (drawing_error(path, error) if is_figure(name) else error)
        finally:
            if self.as_json and record is not None:
                for path in written:
                    note(f"wrote {path}")
                show(record().rstrip("\n"))
            else:
                show("\n".join([str(result), *(f"wrote {path}" for path in written)]))
        if failure is not None:
            raise failure

    def _write(self, path: Path, content: str | bytes) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        if self.force:
            write(path, content)
            return path
        found = write_beside(path, content)
        if found != path:
            note(f"{path} appeared meanwhile and is left as it is; the result is in {found}")
        return found
