"""What a shell completes beside commands and options: fields, laws, quantities and other words.

A key press must not wait for JAX, which all mechanisms import. Their names are therefore kept as JSON beside compiled
programs, until the package or the set of mechanisms changes.
"""

import contextlib
import functools
import hashlib
import json
import os
import tomllib
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import typer
from typer import _completion_classes

from ..errors import InputError
from ..files import cache_folder, write
from ..mechanisms import FOLDERS, entries
from ..version import version

Offers = list[tuple[str, str]]  # a word and what it means
WORDS = "jaxbuffer.words"  # the key of the words before the unfinished one in a context's ``meta``
SOURCES = Path(__file__).parents[1]
JOINED = ("--over",)  # options whose value is FIELD=WORD


def show_plain_texts() -> None:
    """Let shells show what words mean as it is written.

    typer renders these texts as rich's markup, which takes a unit in brackets for a style, and breaks them into lines
    of 80 characters, each of which fish offers as a word.
    """
    # Private, because typer has no setting for it; a version without it renders nothing.
    if hasattr(_completion_classes, "_sanitize_help_text"):
        _completion_classes._sanitize_help_text = lambda text: text


class Offer(NamedTuple):
    """A word that a shell offers, as typer formats it."""

    value: str
    help: str
    type: str = "plain"


def pending(words: Sequence[str]) -> tuple[str, str]:
    """Return the option whose value comes after these words, or "", and what of that value stands in them already: bash
    makes a word of each "=".

    >>> pending(["sweep", "--over", "contact.law", "="])
    ('--over', 'contact.law=')
    """
    value, rest = "", list(words)
    if rest[-1:] == ["="] and len(rest) > 2 and not rest[-2].startswith("--"):
        value, rest = f"{rest[-2]}=", rest[:-2]
    # Bash cuts --contact.law=VALUE up too: there the sign stands between the option and its value.
    if rest[-1:] == ["="]:
        rest.pop()
    option = rest[-1] if rest else ""
    # The values of all other options, whose names have no point in them, are completed by typer.
    known = option in JOINED if value else "." in option
    return (option, value) if option.startswith("--") and known else ("", "")


def joined() -> str:
    """Return "--contact.law=" where zsh or fish hold a dotted option and its unfinished value in one word, else ""."""
    # The parser has cut the word up by now, and these shells take only what begins with all of it.
    name, equals, _ = os.environ.get("_TYPER_COMPLETE_ARGS", "").rpartition(" ")[2].partition("=")
    return f"{name}=" if equals and name.startswith("--") and "." in name else ""


def field_options(words: Sequence[str], incomplete: str) -> list[Offer]:
    """Return the dotted options that begin with an unfinished word; none before their first letter, since they would
    hide the others."""
    if len(incomplete) < 3:
        return []
    known = names(words)["fields"]
    return [Offer(f"--{path}", it["doc"]) for path, it in known.items() if f"--{path}".startswith(incomplete)]


def value(words: Sequence[str], incomplete: str) -> list[Offer]:
    """Return what a dotted option may have as its value, or FIELD= of an option, where bash has cut it up."""
    if start := joined():
        known = _choices(words, start[2:-1])
        return [Offer(start + word, doc) for word, doc in known if word.startswith(incomplete)]
    option, before = pending(words)
    if not option:
        return []
    path = option.removeprefix("--")
    offers = _over(words, before + incomplete) if option in JOINED else _choices(words, path)
    return [
        Offer(word.removeprefix(before), doc)
        for word, doc in offers
        if word.removeprefix(before).startswith(incomplete)
    ]


def files_or_value(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer the value of a dotted option where CONFIG.toml might stand; without one the shell offers files."""
    return [(it.value, it.help) for it in value(ctx.meta.get(WORDS, ()), incomplete)]


def over(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer FIELD= and, behind it, the words that the field takes."""
    return _over(ctx.meta.get(WORDS, ()), incomplete)


def numbers(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer fields that are numbers."""
    return [(path, it["doc"]) for path, it in names(ctx.meta.get(WORDS, ()))["fields"].items() if it["number"]]


def quantities(use: str, listed: bool = False) -> Callable[[typer.Context, str], Offers]:
    """Return what offers quantities: of a ``use`` ("differentiable", "swept", "tuned"), also behind a comma."""

    def offer(ctx: typer.Context, incomplete: str) -> Offers:
        before = incomplete.rpartition(",")[0] + "," if listed and "," in incomplete else ""
        known = names(ctx.meta.get(WORDS, ()))["quantities"]
        return [(before + name, it["doc"]) for name, it in known.items() if it[use] and name not in before.split(",")]

    return offer


def kinds(ctx: typer.Context, incomplete: str) -> Offers:
    """Offer the names of mechanisms."""
    return [(name, it["title"]) for name, it in _all_names().items()]


def one_of(*words: str) -> Callable[[typer.Context, str], Offers]:
    """Return what offers some words."""
    return lambda ctx, incomplete: [(word, "") for word in words]


def names(words: Sequence[str]) -> Mapping[str, Any]:
    """Return the fields and quantities of the mechanism of the study among ``words``, by default a capture's."""
    kind, known = FOLDERS[0], _all_names()
    for word in words:
        if word.endswith(".toml"):
            # A study that is still being written may be no TOML yet: then fields are those of the usual mechanism.
            with contextlib.suppress(OSError, ValueError):
                kind = tomllib.loads(Path(word).expanduser().read_text(encoding="utf-8")).get("kind", kind)
    nothing: Mapping[str, Any] = {"fields": {}, "quantities": {}, "impacts": {}}
    # The file may give anything as its kind, a list say, which is no key.
    return known.get(kind, nothing) if isinstance(kind, str) else nothing


def _over(words: Sequence[str], incomplete: str) -> Offers:
    path, equals, chosen = incomplete.partition("=")
    if not equals:
        return [(f"{path}=", it["doc"]) for path, it in names(words)["fields"].items() if it["number"] or it["words"]]
    *before, _ = chosen.split(",")
    return [(f"{path}={','.join([*before, word])}", doc) for word, doc in _choices(words, path) if word not in before]


def _choices(words: Sequence[str], path: str) -> Offers:
    return [(word, "") for word in names(words)["fields"].get(path, {"words": ()})["words"]]


@functools.cache
def _all_names() -> dict[str, Any]:
    """Return the names of all mechanisms, as `commands.names` collects them, from the file where they are kept."""
    folder = cache_folder()
    # What the names depend on: the package's files, and which packages bring mechanisms. By sizes and times of the
    # files: to read all of them would be felt at every key press.
    facts = [version(), sorted((it.name, it.value) for it in entries()), *sorted(_stamps(SOURCES))]
    state = hashlib.sha256(repr(facts).encode()).hexdigest()[:16]
    kept = None if folder is None else folder / f"names-{state}.json"
    if kept is not None:
        with contextlib.suppress(OSError, ValueError):
            return dict(json.loads(kept.read_text(encoding="utf-8")))
    # here, because it imports JAX: once, until the package changes
    from .commands.names import all_names

    try:
        # A warning would be printed into the prompt that is being completed.
        with warnings.catch_warnings(action="ignore"):
            known = all_names()
    except InputError:
        return {}
    if kept is not None:
        with contextlib.suppress(OSError):
            kept.parent.mkdir(parents=True, exist_ok=True)
            # The names of an earlier state are not read again.
            for former in kept.parent.glob("names-*.json"):
                former.unlink(missing_ok=True)
            write(kept, json.dumps(known))
    return known


def _stamps(folder: Path) -> Iterable[tuple[str, int, int]]:
    with os.scandir(folder) as listing:
        for it in listing:
            if it.is_dir():
                yield from _stamps(Path(it.path))
            elif it.name.endswith(".py"):
                known = it.stat()
                yield it.path, known.st_size, known.st_mtime_ns
