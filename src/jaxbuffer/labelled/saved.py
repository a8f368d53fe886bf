"""What every result has: `save`."""

from pathlib import Path
from typing import Any


class Saved:
    """A result that can be written into a folder."""

    def save(self, folder: str | Path, *, force: bool = False, figures: bool = True, **beside: Any) -> tuple[Path, ...]:
        """Write the result into a folder, as the command of its kind does: see `jb.save`."""
        import jaxbuffer  # what writes results stands above all of them and is reached by its public name alone

        return jaxbuffer.save(self, folder, force=force, figures=figures, **beside)  # type: ignore[arg-type]
