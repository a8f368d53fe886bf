"""Result files: refused before computing if they exist; saved at the end, and only then is anything printed."""

from collections.abc import Callable, Sequence
from pathlib import Path

from ...files import Lock
from ...output.companions import stale
from ...output.formats import Contents, check_folder, check_free, write_all
from ..streams import note, show


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
        check_folder(folder, "--output")
        Lock(folder).lend()
        # every figure is written as SVG too
        twins = [f"{name.removesuffix('.png')}.svg" for name in names if name.endswith(".png")]
        begun = [str(folder / name) for name in resumable if (folder / name).exists()]
        goes_on = "--resume goes on, " if begun else ""
        ways = f"{goes_on}--force overwrites, another --output keeps {{}}"
        left = [path.name for path in stale(folder, [*names, *twins])]
        check_free(folder, [*names, *twins, *resumable, *left], self.force, ways)
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
                written, failure = write_all(self.folder, contents(), self.force, note)
        finally:
            # Also after a failure: what was computed is shown in any case.
            if self.as_json and record is not None:
                for path in written:
                    note(f"wrote {path}")
                show(record().rstrip("\n"))
            else:
                show("\n".join([str(result), *(f"wrote {path}" for path in written)]))
        if failure is not None:
            raise failure
