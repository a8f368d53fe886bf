"""Kinds of tables in a study: each reads itself from TOML, and describes itself to editors, from what it declares."""

import dataclasses
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol, TypeVar

import equinox as eqx

from ..errors import InputError, check_known
from ..fields import (
    POSITIVE,
    SCENARIO,
    Part,
    by_path,
    declared,
    meaning,
    metadata,
    paths,
    point_paths,
    replace,
    single_fields,
    single_paths,
    unit,
    unknown,
)
from ..files import user_path
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.registry import mechanism_of
from ..tuning.problem.objective import quantity_in_words
from .values import Known, Schema, ValueKind, as_table, key_schema, object_schema, read_number, read_value

T = TypeVar("T", bound=eqx.Module)
Keys = Mapping[str, Known]  # what is declared of the keys of a table


class StudyNames(NamedTuple):
    """What tables may name: fields of the ``design`` and the ``scenario``, and quantities.

    ``own``: the study's own quantities, of each its unit; ``folder``: the study's, where its files lie.
    """

    design: Part
    scenario: Part
    own: Mapping[str, str] = MappingProxyType({})
    folder: Path = Path()

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism whose study it is."""
        return mechanism_of(self.design)

    @property
    def units(self) -> dict[str, str]:
        """Return the units of the quantities that objectives and limits may use."""
        return {name: self.mechanism.quantities[name].unit for name in self.mechanism.tuned} | dict(self.own)


class StudyTable(Protocol):
    """A kind of table."""

    def read(self, where: str, given: Any, names: StudyNames) -> Any:
        """Return what a table means, whose address is ``where``. **Raises:** `InputError` for what is wrong in it."""

    def schema(self, names: StudyNames) -> Schema:
        """Return what an editor checks it by."""


def subtable(kind: StudyTable, doc: str, empty: Callable[[], Any] = lambda: None, key: str = "") -> Any:
    """Declare a field for a table within a table.

    **Arguments:** ``doc``: what it is for; ``empty``: makes the value of one that is not there; ``key``: its name in a
    study, by default the field's.
    """
    return dataclasses.field(default_factory=empty, metadata={"table": kind, "doc": doc, "key": key})


def read_keys(where: str, given: Mapping[str, Any], keys: Keys, names: StudyNames) -> dict[str, Any]:
    """Return the values of those ``keys`` that a table has. ``where``: what makes an address of a key."""
    values = {}
    for name in keys:
        if name in given and (table := keys[name].get("table")) is not None:
            values[name] = table.read(where + name, given[name], names)
        elif name in given:
            values[name] = read_value(where + name, given[name], keys[name])
    return values


def keys_schema(keys: Keys, names: StudyNames) -> Schema:
    """Return the schema of a table that has these keys and no others."""
    schemas = {}
    for name, known in keys.items():
        table = known.get("table")
        own = {} if table is None else table.schema(names) | {"description": known["doc"]}
        schemas[name] = own or key_schema(name, known)
    return object_schema(schemas)


def replaced(module: T, values: Mapping[str, Any], prefix: str = "", folder: Path = Path()) -> T:
    """Do as `replace` with values from TOML or the command line. ``prefix``: of paths in messages; ``folder``: where
    mesh files lie."""
    known = [prefix + path for path in (*paths(module), *point_paths(module))]
    checked = {}
    for path, value in values.items():
        if prefix + path not in known:
            means = lambda it: meaning(module, it.removeprefix(prefix))  # noqa: E731
            raise InputError(f"{prefix}{path}{unknown(module, prefix + path, known, means)}")
        symbol = unit(module, path)
        limits = metadata(module, path)["limits"] if symbol else {}
        checked[path] = read_number(prefix + path, value, symbol, **limits) if symbol else value
        # A text that begins with a brace is a mesh itself, as JSON; any other names a file beside the study.
        if isinstance(value, str) and "mesh" in metadata(module, path) and not value.startswith("{"):
            checked[path] = str(folder / user_path(value))
    return replace(module, checked)


class PartTable(NamedTuple):
    """A table of a part's fields; ``of``: the part with its defaults."""

    of: Callable[[StudyNames], Part]

    def read(self, where: str, given: Any, names: StudyNames) -> Part:
        return replaced(self.of(names), as_table(where, given), f"{where}.")

    def schema(self, names: StudyNames) -> Schema:
        return keys_schema(declared(self.of(names)), names)


class PathTable(NamedTuple):
    """A table by dotted path; TOML reads paths as tables in tables, or quoted as they are.

    - ``kind``: of the values.
    - ``of``: whose fields the paths are: of the "design", of the "scenario", or of "both", by their addresses.
    - ``numbers``: whether only numbers have such a value.
    - ``words``: keys that make a table a value.
    - ``example``: an entry, for the message where there is none; "" where there may be none.
    """

    kind: ValueKind
    of: str
    numbers: bool = True
    words: tuple[str, ...] = ()
    example: str = ""

    def read(self, where: str, given: Any, names: StudyNames) -> dict[str, Any]:
        part, given = getattr(names, self.of, None), as_table(where, given)
        single = single_fields(names.design, names.scenario) if part is None else single_paths(part)
        # A scenario has no sections: a table there is a value, whatever its name.
        flat = given if part is names.scenario else by_path(given, self.words, where, single)
        if self.example and not flat:
            raise InputError(f"{where} is empty; name a field and its bounds, such as {self.example}")
        return {path: self.kind.read(f"{where}.{path}", path, value, part) for path, value in flat.items()}

    def schema(self, names: StudyNames) -> Schema:
        parts = {"": names.design, SCENARIO: names.scenario} if self.of == "both" else {"": getattr(names, self.of)}
        fields = {prefix + path: metadata(part, path) for prefix, part in parts.items() for path in paths(part)}
        nested, whole, patterns = dict[str, dict[str, Schema]](), dict[str, Schema](), dict[str, Schema]()
        for path, known in fields.items():
            section, _, name = path.partition(".")
            if "curve" in known:  # its numbers: "force[2]" say
                numbers = {axis: self.kind.schema({"unit": unit, "limits": POSITIVE}) for axis, unit in known["curve"]}
                inner = {rf"^{axis}\[[0-9]+\]$": it for axis, it in numbers.items()}
                patterns |= {rf"^{re.escape(path)}\.{axis}\[[0-9]+\]$": it for axis, it in numbers.items()}
                whole[path] = object_schema({}, patternProperties=inner)
            elif "unit" in known or not self.numbers:
                whole[path] = self.kind.schema(known)
            if name and path in whole:
                nested.setdefault(section, {})[name] = whole[path]
        sections = {section: object_schema(inner) for section, inner in nested.items()}
        # An editor sees a path as a table in a table or, in quotes, as one key: it must know both.
        return object_schema(sections | whole, **({"patternProperties": patterns} if patterns else {}))


class KeyTable(NamedTuple):
    """A table of declared keys, and of quantities by name if these have a kind of value.

    - ``make``: returns what the table means, of `StudyNames`, the quantities' values and the keys' values.
    - ``keys``: of a mechanism's studies.
    - ``quantity``: the kind of a quantity's value.
    - ``first``: whether a message names the keys before the quantities.
    - ``hint``: what a message about an unknown name ends with.
    """

    make: Callable[[StudyNames, dict[str, Any], dict[str, Any]], Any]
    keys: Callable[[Mechanism], Keys]
    quantity: ValueKind | None = None
    first: bool = False
    hint: str = ""

    def read(self, where: str, given: Any, names: StudyNames) -> Any:
        given, keys, kind = as_table(where, given), self.keys(names.mechanism), self.quantity
        units = {} if kind is None else names.units
        try:
            check_known(given, (*keys, *units) if self.first else (*units, *keys), where, quantity_in_words)
        except InputError as error:
            raise error.between(after=self.hint) from None
        others = {name: it for name, it in given.items() if name not in keys}
        quantities = {name: kind.read(f"{where}.{name}", it, units[name]) for name, it in others.items() if kind}
        return self.make(names, quantities, read_keys(f"{where}.", given, keys, names))

    def schema(self, names: StudyNames) -> Schema:
        keys, catalogue = keys_schema(self.keys(names.mechanism), names), names.mechanism.quantities
        if self.quantity is None:
            return keys
        words = {name: f"[{catalogue[name].unit}] {catalogue[name].description}" for name in names.units}
        quantities = {name: self.quantity.schema() | {"description": it} for name, it in words.items()}
        # Not closed, since own quantities have other names; [problem] closes it where there are none.
        return {"type": "object", "properties": quantities | keys["properties"]}
