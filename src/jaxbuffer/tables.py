"""Tables as plain text: the same on a terminal, in a file and in a notebook."""

import io

from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

WIDTH = 118  # characters


def table(title: str, left: tuple[str, ...] = (), right: tuple[str, ...] = ()) -> Table:
    """An empty table with its columns, words aligned to the left and numbers to the right."""
    made = Table(title=title, title_justify="left", title_style="", box=SIMPLE, pad_edge=False)
    for heading in left:
        made.add_column(heading)
    for heading in right:
        made.add_column(heading, justify="right")
    return made


def text(*parts: str | Table) -> str:
    """Lines and tables one below the other."""
    console = Console(file=io.StringIO(), width=WIDTH, color_system=None, force_terminal=False, legacy_windows=False)
    with console.capture() as captured:
        for part in parts:
            console.print(part, markup=False, highlight=False)
    return "\n".join(line.rstrip() for line in captured.get().splitlines())
