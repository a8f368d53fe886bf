"""The public names with their signatures, as lines: `PYTHONPATH=src python tests/public_api.py` writes them anew into
tests/public_api.txt."""

import dataclasses
import enum
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jaxbuffer as jb
from jaxbuffer.fields import Part

TABLE = Path(__file__).with_suffix(".txt")
MODULE = re.compile(r"\b(?:[A-Za-z_]\w*\.)+(?=[A-Za-z_])")  # before a class's name
PLAIN = (bool, int, float, str, type(None))


def lines() -> Iterator[str]:
    """A line for each public name, one for each public member of a class that is declared in jaxbuffer, and one for
    each number of a design or scenario."""
    for name in jb.__all__:
        thing = getattr(jb, name)
        if not inspect.isclass(thing):
            yield f"{name}{_signature(thing)}"
        elif issubclass(thing, enum.Enum):
            yield f"class {name}: {', '.join(thing.__members__)}"
        else:
            # What only jaxbuffer makes has no signature that anybody calls: see docs/_ext/reference.py.
            made = f"{name}(" in (thing.__doc__ or "") or issubclass(thing, Exception)
            yield f"class {name}{_signature(thing, returns=False) if made else ''}"
            yield from _members(thing, fields=not made)
            if issubclass(thing, Part):
                yield from (f"    field {path}" for path in jb.paths(thing()))


def _members(thing: type, fields: bool) -> Iterator[str]:
    listed = {it.name for it in dataclasses.fields(thing)} if dataclasses.is_dataclass(thing) else set()
    own = {
        name: member
        for base in reversed(thing.__mro__)
        if base.__module__.startswith("jaxbuffer")
        for name, member in vars(base).items()
    }
    shown = listed | own.keys() if fields else own.keys() - listed
    for name in sorted(it for it in shown if not it.startswith("_")):
        member = own.get(name)
        if isinstance(member, (staticmethod, classmethod)):
            member = member.__func__
        yield f"    {name}{_signature(member)}" if inspect.isfunction(member) else f"    {name}"


def _signature(function: Any, returns: bool = True) -> str:
    signature = inspect.signature(function)
    shown = [
        it if it.default is it.empty or isinstance(it.default, PLAIN) or it.default == () else it.replace(default=ELSE)
        for it in signature.parameters.values()
    ]
    returned = signature.return_annotation if returns else signature.empty
    return MODULE.sub("", str(signature.replace(parameters=shown, return_annotation=returned)))


class _Default:
    """Stands for a default that is no plain number or text."""

    def __repr__(self) -> str:
        return "…"


ELSE = _Default()

if __name__ == "__main__":
    jb.configure()
    TABLE.write_text("".join(f"{line}\n" for line in lines()), encoding="utf-8")
