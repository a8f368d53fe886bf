"""Printing that cannot end a computation: any encoding will do, and nobody need be reading."""

import codecs
import io
import os
import sys
import warnings
from typing import Any, TextIO

PLAIN = {
    "×": "x", "·": "*", "…": "...", "─": "-", "━": "-", "−": "-", "–": "-", "→": "->", "⁻": "-", "≤": "<=", "≥": ">=",
    "µ": "u", "±": "+-", "°": " deg", "½": "1/2", "²": "2", "³": "3", "⁵": "5", "Δ": "d", "λ": "lambda",
}  # fmt: skip


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    characters = error.object[error.start : error.end]
    return "".join(PLAIN.get(character, "?") for character in characters), error.end


class Heedless:
    """A stream whose failures to write are nobody's business: progress and notes on a pipe that was closed."""

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)

    def write(self, text: str) -> int:
        """Write to the stream, or do nothing where that fails."""
        try:
            return self.stream.write(text)
        except OSError:
            return len(text)

    def flush(self) -> None:
        """Flush the stream, or do nothing where that fails."""
        try:
            self.stream.flush()
        except OSError:
            return


def prepare() -> None:
    """Let both streams print what their encoding can, and stderr fail in silence; warnings become one line each."""
    # A terminal without these characters gets a spelling of them instead of an error.
    codecs.register_error("jaxbuffer.plain", _plain)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:  # closed by whoever started this process
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        # A stream that somebody has put in its place, as notebooks do, need not have `reconfigure`.
        if isinstance(stream := getattr(sys, name), io.TextIOWrapper):
            stream.reconfigure(errors="jaxbuffer.plain")
    # Stdout stays as it is: a result that could not be printed is an error.
    sys.stderr = Heedless(sys.stderr)  # type: ignore[assignment]
    warnings.showwarning = lambda message, *_, **__: note(message)


def show(text: object) -> None:
    """Print to stdout. Raises an `OSError` that names it."""
    try:
        print(text, flush=True)
    except OSError as error:
        raise OSError(error.errno, error.strerror, "standard output") from None


def note(text: object) -> None:
    """Print one line to stderr."""
    print(f"note: {' '.join(str(text).split())}", file=sys.stderr, flush=True)
