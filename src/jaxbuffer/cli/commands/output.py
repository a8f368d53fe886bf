"""Result files: refused before computing if they exist; saved at the end, and only then is anything printed, figures
last."""

from collections.abc import Callable, Sequence
from pathlib import Path

from ...errors import check_choice
from ...files import Lock, write
from ...output.companions import stale
from ...output.formats import FIGURES, Contents, check_folder, check_free, is_figure, with_figures, write_all
from ...output.style import require_matplotlib
from ..streams import note, show


class Output:
    """The files of one command in a folder, which is its own until `entry.run` ends, or nothing at all without one."""

    def __init__(
        self,
        folder: Path | None,
        names: Sequence[str],
        force: bool,
        figures: str | None = None,
        resumable: Sequence[str] = (),
        resume: bool = False,
        as_json: bool = False,
    ) -> None:
        self.folder, self.force, self.as_json = folder, force or resume, as_json
        self.kept = list[str]()
        self.figures = next(iter(FIGURES)) if figures is None else figures
        check_choice("--format", self.figures, tuple(FIGURES))
        if folder is None:
            return
        drawn = [name.removesuffix(".png") for name in names if name.endswith(".png")]
        names = [name for name in names if not name.endswith(".png")]
        names += [f"{name}{ending}" for name in drawn for ending in FIGURES[self.figures]]
        # Said before anything is computed, not when figures are drawn at the end.
        if any(map(is_figure, names)):
            require_matplotlib()
        # Before the lock, which makes the folder.
        check_folder(folder, "--output")
        Lock(folder).lend()
        begun = [str(folder / name) for name in resumable if (folder / name).exists()]
        goes_on = "--resume goes on, " if begun else ""
        ways = f"{goes_on}--force overwrites, another --output keeps {{}}"
        # What is left of an earlier result is removed when this one is written, and so needs --force as well.
        left = [path.name for path in stale(folder, names)]
        check_free(folder, [*names, *resumable, *left], self.force, ways)
        if begun and not resume:
            note(f"--force: an earlier run is overwritten, {', '.join(begun)}")

    def keep(self, name: str, content: str) -> None:
        """Write a file before all others, which `save_and_show` replaces."""
        if self.folder is not None and (self.force or not (self.folder / name).exists()):
            write(self.folder / name, content)
            self.kept.append(name)

    def save_and_show(
        self, contents: Callable[[], Contents], result: object, record: Callable[[], str] | None = None
    ) -> None:
        """Write every file, print the result and what was written, and write the figures, each of which is told; with
        --json print the ``record`` alone on stdout.

        A file that cannot be made or written leaves the others and the printing alone. **Raises:** the first such
        error, an `OSError` for a figure that cannot be drawn.
        """
        alone = record if self.as_json else None
        tell = _Telling((lambda: str(result)) if alone is None else alone, None if alone is None else note)
        failure: Exception | None = None
        written: list[Path] = []
        try:
            if self.folder is not None:
                files = with_figures(contents(), self.figures)
                written, failure = write_all(self.folder, files, self.force, note, tell, self.kept)
        finally:
            # Also after a failure: what was computed is shown in any case.
            tell(written)
        for error in (tell.failure, failure):
            if error is not None:
                raise error

    def save_record(self, contents: Contents, result: object, name: str) -> None:
        """Do as `save_and_show` with files of which the one of that ``name`` has the record."""
        self.save_and_show(lambda: contents, result, lambda: str(contents[name]()))


class _Telling:
    """Shows a result once, and after it each file that was written; what fails at that is kept as ``failure``, for
    files are written all the same.

    **Arguments:** ``text`` of the result; ``beside``: what tells files where the text stands alone on stdout.
    """

    def __init__(self, text: Callable[[], str], beside: Callable[[str], None] | None) -> None:
        self._text, self._beside = text, beside
        self._told: list[Path] | None = None
        self.failure: Exception | None = None

    def __call__(self, written: Sequence[Path]) -> None:
        shown = [self._text().rstrip("\n")] if self._told is None else []
        lines = [f"wrote {path}" for path in written[len(self._told or ()) :]]
        self._told = list(written)
        # The first error is the one that is told, and another attempt could replace it.
        if self.failure is not None:
            return
        try:
            below = lines if self._beside is None else []
            if shown or below:
                show("\n".join([*shown, *below]))
            if self._beside is not None:
                for line in lines:
                    self._beside(line)
        except Exception as error:
            self.failure = error
