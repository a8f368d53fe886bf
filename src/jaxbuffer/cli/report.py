"""`jaxbuffer report`: what a folder of results holds, without computing it again."""

from pathlib import Path
from typing import Annotated

import typer

from ..errors import InputError
from ..output.formats import ARRAYS
from .exits import OK
from .streams import show


def report(folder: Annotated[Path, typer.Argument(metavar="DIR", help="A folder that --output named.")]) -> int:
    """Print the summaries of the results in DIR again, and name the figures there.

    \b
    Example: jaxbuffer report results/table2
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder")
    found = sorted(file for file in folder.glob("*.txt") if file.is_file())
    if (folder / ARRAYS).is_file():
        from ..output.sweep_files import read

        show(read(folder / ARRAYS))
    for file in found:
        show(_text(file))
    if not found and not (folder / ARRAYS).is_file():
        raise InputError(f"{folder} holds no results of simulate, sensitivity, sweep, sample, tune or pareto")
    for figure in sorted(folder.glob("*.png")):
        show(f"figure {figure}")
    return OK


def _text(file: Path) -> str:
    try:
        text = file.read_text(encoding="utf-8").rstrip("\n")
    except UnicodeDecodeError as error:
        raise InputError(f"{file} is damaged: byte {error.start} is not text") from None
    if not text:
        raise InputError(f"{file} is damaged: it is empty")
    return text
