"""What a field means, in the words of its class's docstring."""

import dataclasses
import inspect
import re
from collections.abc import Mapping
from typing import Any

import equinox as eqx

_NAME = re.compile(r"``(\w+)``")
_ASIDE = re.compile(r"\s*(\[[^\]]*\]|\((?:M\d+|default:)[^)]*\))")  # units and numbers of equations
LONGEST = 90  # characters of a meaning
SYMBOL = 6  # characters of a symbol, such as k_A
FOLLOWING = ("of", "from", "about", "to", "between", "across", "in", "at", "above")  # what goes on after the name
BROKEN = (" with", " the", " and", " or", " share")  # ends of a clause that another field's name breaks off


def meanings(kind: type[eqx.Module]) -> Mapping[str, str]:
    """What each field means: the words that follow its name, as in "``mass``: of the rod", up to the end of the clause.

    A field of which the docstring says nothing else means what its name says; in "``a``, ``b``: lengths" both have the
    same words.
    """
    known = [field.name for field in dataclasses.fields(kind)]  # type: ignore[arg-type]
    text = re.split(r"\*\*\w+", inspect.getdoc(kind) or "")[0].replace("\n- ", " ¶ ")
    pieces = _NAME.split(" ".join(text.split()))
    said: dict[str, str] = {}
    for k in range(len(pieces) - 2, 0, -2):
        name, after = pieces[k], pieces[k + 1]
        clause = _clause(after)
        if not clause and after.strip().endswith((",", "and", "or")) and k + 2 < len(pieces):
            clause = said.get(pieces[k + 2], "")
        if name in known:
            said[name] = clause
    return {
        name: _joined(name.replace("_", " ") if len(name) > len("k_A") else name, said.get(name, "")) for name in known
    }


def _joined(name: str, clause: str) -> str:
    """What is said of a field, with its name where that is part of it: "length from the hinge", "mass m_S"."""
    name = name.replace("_", " ") if len(name) > len("k_A") else name
    if not clause:
        return name
    return f"{name} {clause}" if clause.split(maxsplit=1)[0] in FOLLOWING or len(clause) <= SYMBOL else clause


def meaning(module: eqx.Module, path: str) -> str:
    """What the field at a dotted ``path`` of ``module`` means."""
    *owners, name = path.split(".")
    owner: Any = module
    for section in owners:
        owner = getattr(owner, section)
    return meanings(type(owner))[name]


def _clause(after: str) -> str:
    """The first clause of what follows a name, "" for none and for one that another name breaks off."""
    first, *rest = re.split(r"¶|[;.](?:\s|$)", after, maxsplit=1)
    words = _ASIDE.sub("", first).replace("`", "").strip(" :")
    if not rest and not words.endswith(",") and words.endswith(BROKEN):
        words = words.rpartition(",")[0]
    words = words.strip(" ,")
    return "" if words in ("and", "or") or len(words) > LONGEST else words
