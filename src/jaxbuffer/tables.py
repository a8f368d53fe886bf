"""Tables as plain text: the same on a terminal, in a file and in a notebook."""

import io
import re
from collections.abc import Iterable, Sequence
from html import escape

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

WIDTH = 118  # characters


def table(title: str, left: tuple[str, ...] = (), right: tuple[str, ...] = ()) -> Table:
    """Make an empty table with its columns, words aligned to the left and numbers to the right."""
    made = Table(title=title, title_justify="left", title_style="", box=SIMPLE, pad_edge=False)
    for heading in left:
        made.add_column(heading)
    for heading in right:
        made.add_column(heading, justify="right")
    return made


def text(*parts: str | Table) -> str:
    """Print lines and tables one below the other into text."""
    # Not the terminal's own width and colours: the same text must come out everywhere, in files too.
    console = Console(file=io.StringIO(), width=WIDTH, color_system=None, force_terminal=False, legacy_windows=False)
    with console.capture() as captured:
        for part in parts:
            console.print(part, markup=False, highlight=False)
    return "\n".join(line.rstrip() for line in captured.get().splitlines())


def html(*parts: str | Table) -> str:
    """Do as `text` for a notebook: lines stay as they are, tables become HTML."""
    return "\n".join(_html_table(it) if isinstance(it, Table) else f"<pre>{escape(it)}</pre>" for it in parts if it)


def summary_html(summary: str) -> str:
    """Turn a summary of lines, a heading and then names with values two spaces apart, into an HTML table."""
    heading, *lines = summary.splitlines()
    rows = [re.split(r"\s{2,}", line.strip(), maxsplit=1) for line in lines]
    return _html(heading, [], [], rows)


def _html_table(made: Table) -> str:
    columns = [list(column.cells) for column in made.columns]
    heads = [str(column.header) for column in made.columns]
    right = [column.justify == "right" for column in made.columns]
    return _html(str(made.title or ""), heads, right, [list(map(str, row)) for row in zip(*columns, strict=True)])


def _html(caption: str, heads: Sequence[str], right: Sequence[bool], rows: Iterable[Sequence[str]]) -> str:
    """Write a table in HTML; a row of one cell goes across."""

    def cells(kind: str, row: Sequence[str]) -> str:
        if len(row) == 1 and not heads:
            return f'<td colspan="2" style="text-align:left">{escape(row[0])}</td>'
        sides = [*right, *[False] * len(row)]
        made = (
            f'<{kind} style="text-align:{"right" if side else "left"}">{escape(cell)}</{kind}>'
            for cell, side in zip(row, sides, strict=False)
        )
        return "".join(made)

    head = f"<thead><tr>{cells('th', heads)}</tr></thead>" if heads else ""
    body = "".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    title = f'<caption style="text-align:left;white-space:nowrap">{escape(caption)}</caption>' if caption else ""
    return f"<table>{title}{head}<tbody>{body}</tbody></table>"
