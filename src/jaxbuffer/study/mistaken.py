"""What may be meant by a study that can't be read: a file that is not there, text that is no TOML, unknown tables."""

import inspect
import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from ..errors import LONGEST, nearest, suggest

PLACE = re.compile(r"at line (\d+), column \d+")
OPEN = re.compile(r"""=\s*(\"\"\"|'''|"|')(?!.*\1)""")  # a quote that its line does not close
QUOTES = ("Unterminated string", "Illegal character '\\n'", 'Expected "\'"')  # what tomllib says of an open quote
VALUE = r"(?:^|[=\[,{])\s*"
HINTS = (  # what the line of an error looks like, and what to write
    (re.compile(r"=\s*[+-]?\d+,\d"), "numbers have a point, not a comma"),
    (re.compile(rf"{VALUE}(?:yes|no|on|off|true|false)\b", re.IGNORECASE), "write true or false"),
    (re.compile(rf"{VALUE}([-+]?[\d.]+\s*[A-Za-z°%µ][^\],}}#]*)"), 'a value with its unit needs quotes: "{}"'),
    (re.compile(r"=\s*([A-Za-z][\w-]*)\s*(?:#|$)"), 'text needs quotes: "{}"'),
)
ALSO = {"chaser": "active", "servicer": "active", "target": "passive", "client": "passive"}  # what others call a part
ALIKE = 3  # tables that are offered for an unknown one at most


def no_file(path: Path) -> str:
    """The file that may be meant by one that is not there, or how to begin."""
    folder = path.parent
    if not path.suffix:
        return '; a study ends in .toml, and a value with its unit needs quotes: "-4 deg"'
    near = nearest(path.name, [file.name for file in folder.glob("*.toml")]) if folder.is_dir() else None
    return f"; did you mean {folder / near}?" if near else f"; jaxbuffer init {path} writes one to begin with"


def no_toml(text: str, error: ValueError) -> str:
    """What tomllib says, with the text of the line and what may be meant by it."""
    lines, said = text.splitlines(), str(error)
    place = PLACE.search(said)
    number = int(place[1]) if place else 0
    is_open = said.startswith(QUOTES)
    if is_open and not number:
        number = next((k for k, line in enumerate(lines, 1) if OPEN.search(line)), 0)
        said += f", opened at line {number}" if number else ""
    line = lines[number - 1].strip() if 0 < number <= len(lines) else ""
    shown = f": {line if len(line) <= LONGEST else line[: LONGEST - 1] + '…'}" if line else ""
    if is_open:
        return f"{said}{shown}; a quote is open: text ends with the quote it begins with"
    hints = (
        "; " + hint.format(*(group.strip() for group in found.groups()))
        for kind, hint in HINTS
        if (found := kind.search(line))
    )
    return f"{said}{shown}{next(hints, '')}"


def no_table(name: str, known: Iterable[str], parts: Mapping[str, type]) -> str:
    """The table that may be meant by an unknown one: of a name like it, or of a part that is said to be such a thing.

    **Arguments:** ``parts``: the classes of the design's parts, whose docstrings are searched.
    """
    first, names = name.split(".", maxsplit=1)[0], list(known)
    told = {part: _first_sentence(kind) for part, kind in parts.items()}
    begins = re.compile(rf"\b{re.escape(first)}", re.IGNORECASE)
    found = [part for part, words in told.items() if len(first) > 2 and begins.search(words)]
    if ALSO.get(first.lower()) in parts:
        found = [ALSO[first.lower()]]
    if not found or nearest(first, names):
        return suggest(first, names)
    return f"; did you mean {' or '.join(f'[{part}] ({told[part]})' for part in found[:ALIKE])}?"


def _first_sentence(kind: type) -> str:
    """Of a part's docstring, without the numbers of equations: "the active vehicle S, which carries the probe"."""
    words = " ".join((inspect.getdoc(kind) or "").split())
    sentence = re.sub(r" \(M\d+\)", "", re.split(r"\.(?:\s|$)", words)[0])
    return sentence[:1].lower() + sentence[1:]
