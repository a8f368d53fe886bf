"""Suggestions for a study that cannot be read: a missing file, invalid TOML, an unknown table."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from ..errors import LONGEST, nearest, suggest
from ..fields import declared
from ..mechanisms.view import Synonym
from .model import ProblemTable

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
WITHIN = {  # tables that stand within another one, or are called otherwise
    **{name: f"problem.{name}" for name in declared(ProblemTable)},
    **{"limits": "problem.constraints", "limit": "problem.constraints", "constraint": "problem.constraints"},
    **{"bounds": "problem.variables", "objectives": "problem.objective", "ranges": "sample.ranges"},
    **{"optimize": "tune", "optimise": "tune", "tuning": "tune", "optimizer": "tune", "optimization": "tune"},
    **{"settings": "options", "simulation": "options", "simulate": "options"},
}


def no_file(path: Path) -> str:
    """Suggest the file that a missing one may mean, or how to begin."""
    folder = path.parent
    # Without quotes the shell cuts -4 deg up, and its second word is taken for the study.
    if not path.suffix:
        return '; a study ends in .toml, and a value with its unit needs quotes: "-4 deg"'
    near = nearest(path.name, [file.name for file in folder.glob("*.toml")]) if folder.is_dir() else None
    return f"; did you mean {folder / near}?" if near else f"; jaxbuffer init {path} writes one to begin with"


def in_folder(folder: Path) -> str:
    """Suggest the study that a folder given in its place may mean."""
    studies = sorted(folder.glob("*.toml"))
    return f"; did you mean {studies[0]}?" if studies else "; give a file that ends in .toml"


def no_toml(text: str, error: ValueError) -> str:
    """Return the message of tomllib with the line's text and a suggestion."""
    lines, message = text.splitlines(), str(error)
    place = PLACE.search(message)
    number = int(place[1]) if place else 0
    is_open = message.startswith(QUOTES)
    # Of some open quotes tomllib says only that the file has ended: the first line that leaves one open is meant.
    if is_open and not number:
        number = next((k for k, line in enumerate(lines, 1) if OPEN.search(line)), 0)
        message += f", opened at line {number}" if number else ""
    if message.startswith("Cannot overwrite") and not number and lines:  # what is given twice is in the last line
        number = len(text.rstrip().splitlines())
        message += f", line {number}"
    line = lines[number - 1].strip() if 0 < number <= len(lines) else ""
    shown = f": {line if len(line) <= LONGEST else line[: LONGEST - 1] + '…'}" if line else ""
    if is_open:
        return f"{message}{shown}; a quote is open: text ends with the quote it begins with"
    hints = (
        "; " + hint.format(*(group.strip() for group in match.groups()))
        for pattern, hint in HINTS
        if (match := pattern.search(line))
    )
    return f"{message}{shown}{next(hints, '')}"


def no_table(name: str, known: Iterable[str], synonyms: Mapping[str, Synonym]) -> str:
    """Suggest the table that an unknown one may mean: one with a similar name, or the part with this other name.

    **Arguments:** ``known``: the tables that there are; ``synonyms``: what the mechanism's parts are called otherwise.
    """
    first, names = name.split(".", maxsplit=1)[0], list(known)
    if (within := WITHIN.get(first.lower())) and within.partition(".")[0] in names:
        return f"; did you mean [{within}]?"
    if (meant := synonyms.get(first.lower())) is not None:
        return f"; did you mean [{meant.section}] ({meant.meaning})?"
    return suggest(first, names)
