"""Records and figures of result files, as parts of a page: quantities as people are shown them, values as cells."""

import base64
import re
from collections.abc import Container, Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

from ..fields import Curve, paths
from ..labelled.record import Record, heading
from ..mechanisms.mechanism import Mechanism
from ..output.folder import Results
from ..output.layout import DOTS_PER_INCH
from ..output.provenance import MADE
from ..output.words import called
from ..tuning.problem.cases import built_label, in_sentence, numbered
from ..value_text import table_text
from .page import Cell, Figure

NONE: Mapping[str, Any] = MappingProxyType({})
ROUNDING = 1e-9  # relative, what two numbers of equal meaning may differ by
ACTIVE = re.compile(r"<script|<foreignObject|javascript:|\son\w+=", re.IGNORECASE)  # what no figure of ours holds


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
    typed = next((it[MADE]["units"] for it in results.records.values() if "units" in it.get(MADE, {})), NONE)
    return {**results.records.get("choice", NONE).get("units", NONE), **typed}


def sentence(line: str) -> str:
    """Return a line of a record as a sentence, with a full stop, and a capital letter unless it begins with a field."""
    text = line if set("._") & set(line.partition(" ")[0]) else f"{line[:1].upper()}{line[1:]}"
    return text if text.endswith(".") else f"{text}."


def field_name(path: str) -> str:
    """Return a field in words, without its section: "approach speed", "k_A"."""
    return called(path.rsplit(".", 1)[-1])


def scenario_of(mechanism: Mechanism, record: Record) -> Any:
    """Return the scenario that a record describes."""
    return mechanism.scenario(**{path: record[path] for path in paths(mechanism.scenario()) if path in record})


def ended(mechanism: Mechanism, outcome: str) -> Cell:
    """Return how a run ended, marked as good or bad."""
    good = outcome in mechanism.successes if mechanism.successes else not outcome.startswith("failed")
    return Cell(outcome, "good" if good else "bad")


class Display(NamedTuple):
    """How people are shown a quantity: its ``title``, its ``unit`` in figures, and how many of those its own unit is
    (``factor``)."""

    title: str
    unit: str
    factor: float = 1.0

    @property
    def heading(self) -> str:
        """Return the title with the unit: "buffer stroke [mm]"."""
        return heading(self.title, self.unit)

    def text(self, value: float | None) -> str:
        """Return a value, given in the quantity's own unit, as it stands in a table."""
        return table_text(None if value is None else self.factor * value)


def display(mechanism: Mechanism, name: str, own: Mapping[str, Any] = NONE) -> Display:
    """Return how people are shown a quantity. ``own``: the record of a study's own quantities, by name."""
    if name in own:
        return Display(words(name), str(own[name]["unit"]))
    known = mechanism.quantities[name]
    return Display(known.title or words(name), *known.in_figures)


def title(mechanism: Mechanism, name: str) -> str:
    """Return a quantity's title, or what one of an impact is called."""
    return display(mechanism, name).title if name in mechanism.quantities else words(name)


def main_quantity(results: Results, values: Container[str]) -> str:
    """Return the quantity among the names of ``values`` that stands for a run; "" where there is none."""
    mechanism = results.mechanism
    return mechanism.main_quantity([name for name in mechanism.quantities if name in values], results.design)


def main_in_words(results: Results, record: Record) -> tuple[str, str] | None:
    """Return the name and the value of a run's main quantity; None where it is not known."""
    name = main_quantity(results, record)
    value = record.get(name)
    return None if value is None else (name, results.mechanism.quantities[name].in_words(value, 4))


def main_first(results: Results, values: Container[str], others: Iterable[str]) -> list[str]:
    """Return the main quantity of a record's ``values``, if it is there, and then the other names, each once."""
    return [name for name in dict.fromkeys([main_quantity(results, values), *others]) if name]


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
        content = png.read_bytes()
        # No larger than it was drawn, as an SVG: a PNG begins with its mark, a block's head, and its width in pixels.
        points = 72.0 * int.from_bytes(content[16:20]) / DOTS_PER_INCH
        return [Figure(caption, png=base64.b64encode(content).decode(), width=points)]
    return []


def _inline(svg: str, prefix: str) -> str:
    """Return an SVG file as part of a page: without its head, no larger than it was drawn, its identifiers made its
    own."""
    # Within HTML the declaration of XML and the document's type would be errors.
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


def elsewhere(results: Results, scenario: Record) -> list[str]:
    """Return a line that says in which scenarios of a tuning its main quantity and the limited ones are largest.

    There is no line where the run that is shown, of ``scenario``, is one of those.
    """
    if results.tuned is None:
        return []
    mechanism, cases = results.mechanism, [case["after"] for case in results.tuned["scenarios"]]
    met = [scenario_of(mechanism, case) for case in results.tuned["scenarios"]]
    labels = [in_sentence(*pair) for pair in zip(case_texts(results), case_numbers(results), strict=True)]
    names = main_first(results, cases[0], results.tuned["limits"])
    own = results.tuned.get("quantities", {})
    # A value that is not known counts as zero, so that it is never the largest.
    largest = {name: max(range(len(cases)), key=lambda k: cases[k][name] or 0.0) for name in names}
    if scenario_of(mechanism, scenario) in [met[k] for k in largest.values()]:
        return []
    places = ", ".join(f"{display(mechanism, name, own).title} at {labels[k]}" for name, k in largest.items())
    return [f"This is not the scenario that decides: over all scenarios of the tuning the largest are {places}."]


def run_in_sentence(mechanism: Mechanism, record: Record) -> str:
    """Return the scenario of a run's record as a sentence names it, with its number among several of its study."""
    label = mechanism.view.label(scenario_of(mechanism, record["scenario"]))
    return in_sentence(label, record.get("scenario_number", ""))


def case_labels(results: Results) -> list[str]:
    """Return a tuning's scenarios in words, each behind its number where there are several."""
    return [numbered(*pair) for pair in zip(case_texts(results), case_numbers(results), strict=True)]


def case_numbers(results: Results) -> list[str]:
    """Return the numbers of a tuning's scenarios as the folder's study has them; "" of a single one."""
    cases = [] if results.tuned is None else results.tuned["scenarios"]
    return [case.get("number", "") for case in cases] if len(cases) > 1 else [""] * len(cases)


def case_texts(results: Results, among: Sequence[Any] = ()) -> list[str]:
    """Return a tuning's scenarios in words, with where the built mechanism differs from the drawn one.

    They are told apart from the scenarios ``among`` which they are shown, by default each other.
    """
    cases = [] if results.tuned is None else results.tuned["scenarios"]
    met = [scenario_of(results.mechanism, case) for case in cases]
    others = list(among) or met
    design = results.mechanism.design()
    built = [[case.get(name, {}).items() for name in ("factors", "shifts", "values")] for case in cases]
    return [
        results.mechanism.view.label(scenario, others) + built_label(design, *differing)
        for differing, scenario in zip(built, met, strict=True)
    ]
