"""What a folder of results holds, for a page."""

import base64
import dataclasses
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..mechanisms import all_mechanisms, mechanism_named
from ..mechanisms.mechanism import Mechanism
from ..output.formats import ARRAYS
from .page import Figure

Record = Mapping[str, Any]
ACTIVE = re.compile(r"<script|<foreignObject|javascript:|\son\w+=", re.IGNORECASE)  # what no figure of ours holds


@dataclasses.dataclass(frozen=True)
class Results:
    """One folder's results; what the folder does not hold is None.

    ``folder``; ``mechanism``; records of one ``run``, a ``sensitivity`` and a tuning (``tuned``) as their JSON files
    hold them; ``motion`` of the run (`output.motion_record`); ``sweep`` as `output.sweep_files.read` finds it.
    """

    folder: Path
    mechanism: Mechanism
    run: Record | None = None
    motion: Record | None = None
    sensitivity: Record | None = None
    tuned: Record | None = None
    sweep: Any = None

    @property
    def records(self) -> list[Record]:
        """All that there are."""
        return [record for record in (self.tuned, self.run, self.sensitivity) if record is not None]

    @property
    def design(self) -> Record | None:
        """The design of the first record: values by field with unit."""
        return next((record["design"] for record in self.records), None)

    def figure(self, stem: str, caption: str) -> list[Figure]:
        """The figure of that name, if the folder has it: an SVG rather than a PNG."""
        svg, png = self.folder / f"{stem}.svg", self.folder / f"{stem}.png"
        if svg.is_file() and not ACTIVE.search(text := svg.read_text(encoding="utf-8")):
            return [Figure(caption, svg=_inline(text, f"{self.folder.name}-{stem}"))]
        if png.is_file():
            return [Figure(caption, png=base64.b64encode(png.read_bytes()).decode())]
        return []


def results(folder: Path) -> Results:
    """Read a folder. **Raises:** `InputError` where it holds no results or a file is damaged."""
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder")
    tuned, sensitivity = (_record(folder / f"{name}.json") for name in ("tuned", "sensitivity"))
    runs = {mechanism.name: _record(folder / f"{mechanism.run_name}.json") for mechanism in all_mechanisms()}
    run = next((found for name, found in runs.items() if found is not None and found.get("kind") == name), None)
    sweep = None
    if (folder / ARRAYS).is_file():
        from ..output.sweep_files import read

        sweep = read(folder / ARRAYS)
    found = [record for record in (run, sensitivity, tuned) if record is not None]
    if sweep is None and not found:
        raise InputError(f"{folder} holds no results of simulate, sensitivity, sweep, sample, tune or pareto")
    kinds = [record["kind"] for record in found]
    mechanism = sweep.found.mechanism if sweep is not None else mechanism_named(kinds[0])
    motion = None if run is None else _record(folder / "motion.json")
    return Results(folder, mechanism, run, motion, sensitivity, tuned, sweep)


def _record(file: Path) -> Record | None:
    if not file.is_file():
        return None
    try:
        record = json.loads(file.read_text(encoding="utf-8"))
        if not isinstance(record, dict):
            raise ValueError("not a table")
    except ValueError as error:
        raise InputError(f"{file} is damaged: {error}") from None
    return record


def _inline(svg: str, prefix: str) -> str:
    """An SVG file as part of a page: without its head and fixed size, its identifiers made its own."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\bid="([^"]+)"', rf'id="{prefix}-\1"', svg)
    svg = re.sub(r'href="#([^"]+)"', rf'href="#{prefix}-\1"', svg)
    svg = re.sub(r"url\(#([^)]+)\)", rf"url(#{prefix}-\1)", svg)
    for size in ("width", "height"):
        svg = re.sub(rf'(<svg\b[^>]*?) {size}="[^"]*"', r"\1", svg, count=1)
    return svg
