"""Records and figures of result files, as parts of a page: names without units, values as cells."""

import base64
import re
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any

from ..fields import Curve, paths
from ..fields.record import without_unit
from ..mechanisms.mechanism import Mechanism
from ..output.folder import Record, Results
from ..output.provenance import MADE
from ..output.words import called
from ..value_text import table_text
from .page import Cell, Figure

NONE: Mapping[str, Any] = MappingProxyType({})
ROUNDING = 1e-9  # relative, what two numbers of equal meaning may differ by
ACTIVE = re.compile(r"<script|<foreignObject|javascript:|\son\w+=", re.IGNORECASE)  # what no figure of ours holds


def by_name(record: Record) -> dict[str, Any]:
    """Return a record's values by names without units: "stroke [m]" is "stroke"."""
    return {without_unit(name)[0]: value for name, value in record.items()}


def same(value: Any, other: Any) -> bool:
    """Return whether two fields' values are equal, numbers to nine digits; a curve is equal to a record's list of its
    points."""
    value, other = (it.points() if isinstance(it, Curve) else it for it in (value, other))
    numbers = all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in (value, other))
    return value == other or (numbers and abs(value - other) <= ROUNDING * max(abs(value), abs(other)))


def words(name: str) -> str:
    """Return a name as one reads it."""
    return name.replace("_", " ")


def units_of(results: Results) -> Mapping[str, str]:
    """Return the units that a folder's numbers were typed with, by path, in which people are shown them."""
    return next((it[MADE]["units"] for it in results.records.values() if "units" in it.get(MADE, {})), NONE)


def field_name(path: str) -> str:
    """Return a field in words, without its section: "approach speed", "k_A"."""
    return called(path.rsplit(".", 1)[-1])


def scenario_of(mechanism: Mechanism, record: Record) -> Any:
    """Return the scenario that a record describes."""
    values = by_name(record)
    return mechanism.scenario(**{path: values[path] for path in paths(mechanism.scenario()) if path in values})


def ended(mechanism: Mechanism, outcome: str) -> Cell:
    """Return how a run ended, marked as good or bad."""
    good = outcome in mechanism.successes if mechanism.successes else not outcome.startswith("failed")
    return Cell(outcome, "good" if good else "bad")


def quantity(mechanism: Mechanism, name: str, values: Mapping[str, Any]) -> list[str]:
    """Return a quantity's title, its unit in figures, and its value in that unit."""
    title, symbol, factor = in_figures(mechanism, name)
    value = values.get(name)
    return [title, symbol, table_text(None if value is None else factor * value)]


def in_figures(
    mechanism: Mechanism, name: str, own: Mapping[str, Any] = MappingProxyType({})
) -> tuple[str, str, float]:
    """Return a quantity's title, its unit in figures, and how many of those its own unit is.

    ``own``: the record of a study's own quantities, by name.
    """
    if name in own:
        return words(name), str(own[name]["unit"]), 1.0
    known = mechanism.quantities[name]
    return known.title or words(name), *known.in_figures


def title(mechanism: Mechanism, name: str) -> str:
    """Return a quantity's title, or what one of an impact is called."""
    return in_figures(mechanism, name)[0] if name in mechanism.quantities else words(name)


def by_quantity(rows: Iterable[Record]) -> dict[str, list[Record]]:
    """Return rows of a record by the quantity that they are of."""
    groups: dict[str, list[Record]] = {}
    for row in rows:
        groups.setdefault(row["quantity"], []).append(row)
    return groups


def figure(results: Results, stem: str, caption: str) -> list[Figure]:
    """Return the figure of that name, if the folder has it: an SVG rather than a PNG."""
    svg, png = results.folder / f"{stem}.svg", results.folder / f"{stem}.png"
    # A file that holds anything active is not ours, and would run in the reader's browser: it stays out.
    if svg.is_file() and not ACTIVE.search(text := svg.read_text(encoding="utf-8")):
        return [Figure(caption, svg=_inline(text, re.sub(r"\W+", "-", f"{results.folder}-{stem}").strip("-")))]
    if png.is_file():
        return [Figure(caption, png=base64.b64encode(png.read_bytes()).decode())]
    return []


def _inline(svg: str, prefix: str) -> str:
    """Return an SVG file as part of a page: without its head, no larger than it was drawn, its identifiers made its
    own."""
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    # Several figures in one page may have the same identifiers, and would show each other's parts.
    svg = re.sub(r'\bid="([^"]+)"', rf'id="{prefix}-\1"', svg)
    svg = re.sub(r'href="#([^"]+)"', rf'href="#{prefix}-\1"', svg)
    svg = re.sub(r"url\(#([^)]+)\)", rf"url(#{prefix}-\1)", svg)
    width = re.search(r'<svg\b[^>]*? width="([\d.]+)pt"', svg)
    for size in ("width", "height"):
        svg = re.sub(rf'(<svg\b[^>]*?) {size}="[^"]*"', r"\1", svg, count=1)
    return svg if width is None else svg.replace("<svg", f'<svg style="--natural: {width[1]}pt"', 1)
