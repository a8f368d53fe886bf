"""The reference: docstrings as they are written here for Sphinx, and the commands' own help as a page."""

import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.util import logging

import jaxbuffer

LOGGER = logging.getLogger(__name__)
CODE = re.compile(r"(?<!`)`([^`]+)`(?!`)(\w?)")  # `simulate`, `Case`s
PAGE = re.compile(r"\bdocs/([a-z_]+)\.md\b")  # docs/tuning.md
IN_TEXT = re.compile(r"(?<!\]\()(?<![\[/\w`])`?docs/([a-z_]+)\.md\b`?(?!\])")  # but in a link's own text or target
FENCE = re.compile(r"(^```.*?^```)", re.MULTILINE | re.DOTALL)


def docstring(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """From the Markdown of our docstrings to reStructuredText, in place."""
    text = "\n".join(lines)
    if not text.strip():
        LOGGER.warning("%s has an entry in the reference, and no docstring", name)
    text = re.sub(r"\n(- .*(?:\n(?!- |\n).+)*)", _item, text)
    text = CODE.sub(_code, text)
    lines[:] = PAGE.sub(r":doc:`docs/\1.md </\1>`", text).split("\n")


def _item(match: re.Match[str]) -> str:
    """A list's item, whose other lines are indented below it."""
    first, *rest = match[1].split("\n")
    return "\n" + "\n".join([first, *(f"  {line.strip()}" for line in rest)])


def _code(match: re.Match[str]) -> str:
    """A public name links to its entry; any other is code."""
    name, letter = match[1], match[2]
    said = f":py:obj:`~jaxbuffer.{name}`" if name in jaxbuffer.__all__ else f"``{name}``"
    return said + (rf"\ {letter}" if letter else "")


def links(app: Sphinx, page: str, source: list[str]) -> None:
    """Where a page names another one, docs/NAME.md, it links to it; code stays as it is."""
    if not page.startswith(("generated/", "notebook/")):
        parts = FENCE.split(source[0])
        parts[::2] = [IN_TEXT.sub(r"[docs/\1.md](/\1.md)", part) for part in parts[::2]]
        source[0] = "".join(parts)


def complete(app: Sphinx, env: Any) -> None:
    """Warn of each public name that the reference lacks."""
    entries = env.get_domain("py").objects
    for name in jaxbuffer.__all__:
        if f"jaxbuffer.{name}" not in entries:
            LOGGER.warning("jaxbuffer.%s is public, and docs/api has no entry of it", name)


def signature(app: Sphinx, what: str, name: str, obj: Any, options: Any, shown: str, returned: str) -> Any:
    """Classes whose example does not make one are results: how to make them says nothing."""
    if what == "class" and f"{name.rpartition('.')[2]}(" not in (obj.__doc__ or ""):
        return "", returned
    return shown, returned


def commands(app: Sphinx) -> None:
    """Write the page of the commands."""
    from typer.main import get_command
    from typer.testing import CliRunner

    from jaxbuffer.cli.app import app as line

    runner = CliRunner()
    said = lambda *words: runner.invoke(line, [*words, "--help"], prog_name="jaxbuffer", terminal_width=100).output  # noqa: E731
    parts = ["# Commands\n\nWhat `jaxbuffer --help` and `jaxbuffer COMMAND --help` say.\n", _help("jaxbuffer", said())]
    parts += [_help(f"jaxbuffer {name}", said(name)) for name in get_command(line).commands]  # type: ignore[attr-defined]
    target = Path(app.srcdir) / "generated" / "commands.md"
    target.parent.mkdir(exist_ok=True)
    target.write_text("\n".join(parts), encoding="utf-8")


def _help(command: str, text: str) -> str:
    return f"## {command}\n\n```text\n{text.strip()}\n```\n"


def setup(app: Sphinx) -> dict[str, bool]:
    """Sphinx calls this."""
    app.connect("autodoc-process-docstring", docstring)
    app.connect("source-read", links)
    app.connect("autodoc-process-signature", signature)
    app.connect("env-check-consistency", complete)
    app.connect("builder-inited", commands)
    return {"parallel_read_safe": True}
