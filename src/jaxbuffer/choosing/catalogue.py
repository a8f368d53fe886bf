"""Catalogues of parts: each part has a name and the fields of the design that it sets together."""

import dataclasses
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError, as_number, check_number, shown
from ..fields import (
    NON_NEGATIVE,
    Curve,
    Part,
    check_units_agree,
    get,
    in_unit,
    limits_of,
    meaning,
    metadata,
    paths,
    point_paths,
    replace,
    typed_unit,
    unit,
    unknown,
)
from .catalogue_csv import CatalogueCell, read_csv

PRICE, MASS = "price", "mass"  # of a part, which no field of the design is
TOTALS = (PRICE, MASS)
FILE = "file"  # the key that names a CSV file
EXAMPLE = 'S1 = {buffer.k_A = "500 N/m", price = 12}'
# The word begins with a letter or a sign of money: ",50 EUR" of "9,50 EUR" is none.
AMOUNT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*((?:[^\W\d_]|[$€£¥])\D*?)?\s*")


@dataclasses.dataclass(frozen=True)
class CataloguePart:
    """A part that can be bought.

    - ``name``: as the catalogue has it.
    - ``fields``: what it sets, by dotted path of the design, each in its unit.
    - ``totals``: its price and mass [kg], where they are given.
    """

    name: str
    fields: Mapping[str, Any]
    totals: Mapping[str, float] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class PartsCatalogue:
    """The parts of which one is chosen.

    - ``role``: what they are for, "spring" say.
    - ``parts``: at least one.
    - ``units``: in which people are shown the numbers at some paths, and the mass, as they were typed.
    - ``price_unit``: of the prices, "" where none was typed.
    """

    role: str
    parts: tuple[CataloguePart, ...]
    units: Mapping[str, str] = dataclasses.field(default_factory=dict)
    price_unit: str = ""

    @property
    def paths(self) -> tuple[str, ...]:
        """Return the paths that any of the parts sets."""
        return tuple(dict.fromkeys(path for part in self.parts for path in part.fields))

    @property
    def totals(self) -> tuple[str, ...]:
        """Return which of price and mass the parts have."""
        return tuple(self.parts[0].totals)


def read_catalogues(
    given: Mapping[str, Any], design: Part, folder: Path = Path(), where: str = "parts"
) -> tuple[PartsCatalogue, ...]:
    """Return the catalogues that a mapping gives by role.

    **Arguments:** ``given``: of each role a mapping from a part's name to its fields, {"file": "springs.csv"}, the path
    of such a file, or a `PartsCatalogue`; ``folder``: where relative paths begin; ``where``: the mapping's name in
    messages.

    **Raises:** `InputError` for what is no such mapping, unknown fields, values out of range, parts that are named
    twice or lack a field that others set, and a field that two roles set.
    """
    if not isinstance(given, Mapping) or not given:
        raise InputError(f"{where} = {shown(given)}; write [{where}.spring] with its parts, such as {EXAMPLE}")
    catalogues = tuple(_catalogue(role, one, design, folder, f"{where}.{role}") for role, one in given.items())
    owners: dict[str, str] = {}
    for catalogue in catalogues:
        # A curve counts as the number that it stands for: the design has one of the two, so only one role may set it.
        for path in dict.fromkeys(stands_for(design, path) for path in catalogue.paths):
            if path in owners:
                raise InputError(f"{where}.{owners[path]} and {where}.{catalogue.role} both set {path}; keep one")
            owners[path] = catalogue.role
    _check_totals(catalogues, where)
    return catalogues


def _check_totals(catalogues: Sequence[PartsCatalogue], where: str) -> None:
    """Raise `InputError` where prices have several units, so that they have no sum."""
    units = {it.role: it.price_unit for it in catalogues if PRICE in it.totals}
    if len(set(units.values())) > 1:
        (first, unit_of_first), *others = units.items()
        role, other = next((role, it) for role, it in others if it != unit_of_first)
        raise InputError(
            f"{where}.{first} has prices in {unit_of_first or 'no unit'} and {where}.{role} in {other or 'no unit'};"
            " give all of them one unit"
        )


def _catalogue(role: str, given: Any, design: Part, folder: Path, where: str) -> PartsCatalogue:
    if isinstance(given, PartsCatalogue):
        return dataclasses.replace(given, role=role)
    # A part may be called "file" too: it has fields, and only a text after that key names a file.
    if isinstance(given, Mapping) and isinstance(given.get(FILE), str) and len(given) == 1:
        given = folder / given[FILE]
    if isinstance(given, (str, Path)):
        rows = read_csv(folder / given)
    elif isinstance(given, Mapping):
        rows = [
            (
                name,
                {
                    field: CatalogueCell(f"{where}.{name}.{field}", value)
                    for field, value in _fields(where, name, it).items()
                },
            )
            for name, it in given.items()
        ]
    else:
        raise InputError(f'{where} = {shown(given)}; write {EXAMPLE}, or file = "springs.csv"')
    if not rows:
        raise InputError(f"{where} has no part; write {EXAMPLE}")
    return _read(role, rows, design, where)


def _fields(where: str, name: str, given: Any) -> Mapping[str, Any]:
    """Return a part's fields by path: an unquoted ``buffer.k_A`` is a table in a table in TOML."""
    if not isinstance(given, Mapping) or not given:
        raise InputError(f"{where}.{name} = {shown(given)} is no part; write {EXAMPLE}")
    flat: dict[str, Any] = {}
    for key, value in given.items():
        flat |= {f"{key}.{inner}": it for inner, it in value.items()} if isinstance(value, Mapping) else {key: value}
    return flat


def _read(role: str, rows: list[tuple[str, dict[str, CatalogueCell]]], design: Part, where: str) -> PartsCatalogue:
    """Return the catalogue of named rows."""
    parts, units, prices = list[CataloguePart](), dict[str, str](), list[str]()
    cells: dict[str, list[CatalogueCell]] = {}
    for name, row in rows:
        fields: dict[str, Any] = {}
        totals: dict[str, float] = {}
        for key, cell in row.items():
            path = _resolved(key, design, cell.where)
            cells.setdefault(path, []).append(cell)
            if path == PRICE:
                totals[path], symbol = _amount(cell)
                prices.append(symbol)
            elif path == MASS:
                totals[path] = _number(cell, "kg", NON_NEGATIVE)
            elif path in fields:
                raise InputError(f"{cell.where}: {name} sets {path} twice; keep one")
            else:
                fields[path] = _value(cell, path, design)
            if symbol := typed_unit(cell.value):
                units.setdefault(path, symbol)
        if not fields:
            raise InputError(f"{where}.{name} sets no field of the design; write {EXAMPLE}")
        parts.append(CataloguePart(name, fields, totals))
    for path, those in cells.items():
        _check_one_unit(path, those)
    _check_same_fields(parts, design, where)
    if len(set(prices)) > 1:
        raise InputError(
            f"{where}: prices in {' and '.join(it or 'no unit' for it in dict.fromkeys(prices))}; keep one"
        )
    price_unit = units.pop(PRICE, "")
    return PartsCatalogue(role, tuple(parts), units, price_unit)


def _check_one_unit(path: str, cells: Sequence[CatalogueCell]) -> None:
    """Raise `InputError` where some of a column's numbers have a unit and others none."""
    numbers = [cell for cell in cells if not isinstance(cell.value, (bool, list))]
    # Zero is the same in every unit, so it may stand without one. Prices have a check of their own.
    bare = [cell for cell in numbers if type(as_number(cell.value)) is float and float(cell.value) != 0.0]
    typed = [cell for cell in numbers if typed_unit(cell.value)]
    if bare and typed and path != PRICE:
        check_units_agree(bare[0].where, [bare[0].value, typed[0].value])


def _check_same_fields(parts: Sequence[CataloguePart], design: Part, where: str) -> None:
    """Raise `InputError` where a part lacks what another one has: it would keep the design's own number."""
    first = {stands_for(design, path): path for path in parts[0].fields}
    for part in parts[1:]:
        own = {stands_for(design, path): path for path in part.fields}
        for have, lack, one, other in ((first, own, parts[0], part), (own, first, part, parts[0])):
            if missing := next((have[key] for key in have if key not in lack), None):
                raise InputError(
                    f"{where}.{other.name} has no {missing}, which {one.name} has; give each part the same"
                )
    for name in TOTALS:
        having = [part for part in parts if name in part.totals]
        if having and len(having) < len(parts):
            lacking = next(part for part in parts if name not in part.totals)
            raise InputError(f"{where}.{lacking.name} has no {name}, which {having[0].name} has; give each part one")


def stands_for(design: Part, path: str) -> str:
    """Return the number that a curve takes the place of; any other path as it is."""
    instead = metadata(design, path).get("instead_of") if path in paths(design) else None
    return f"{path.rpartition('.')[0]}.{instead[0]}" if instead else path


def _resolved(key: str, design: Part, where: str) -> str:
    """Return the path that a name means: a path, price or mass, or the last word of just one path."""
    known = (*paths(design), *point_paths(design))
    if key in TOTALS or key in known:
        return key
    ending = [path for path in known if path.rpartition(".")[2] == key]
    if len(ending) > 1:
        raise InputError(f"{where}: {key} may be {' or '.join(ending)}; write which")
    if not ending:
        raise InputError(f"{where}: {key}{unknown(design, key, (*known, *TOTALS), lambda it: _meaning(design, it))}")
    return ending[0]


def _meaning(design: Part, path: str) -> str:
    return f"{path} of the part" if path in TOTALS else meaning(design, path)


def _value(cell: CatalogueCell, path: str, design: Part) -> Any:
    """Return a part's value of a field, checked against the field's range or choices."""
    symbol = unit(design, path)
    if symbol:
        return _number(cell, symbol, limits_of(design, path))
    value: Any = cell.value
    if "curve" in metadata(design, path) and not isinstance(value, Curve):
        value = cell.points()
    try:
        # Put into the design and read back, so that the design's own checks decide what a choice or a curve may be.
        return get(replace(design, {path: value}), path)
    except InputError as error:
        raise error.between(f"{cell.where}: ") from None


def _number(cell: CatalogueCell, symbol: str, limits: Mapping[str, Any]) -> float:
    try:
        number = as_number(in_unit(cell.where, cell.value, symbol, **limits))
    except InputError as error:
        raise error from None
    if type(number) is not float:
        number = shown(cell.value)
    check_number(cell.where, number, symbol, **limits)
    return float(number)


def _amount(cell: CatalogueCell) -> tuple[float, str]:
    """Return a price and its unit: any word."""
    match = AMOUNT.fullmatch(cell.value) if isinstance(cell.value, str) else None
    number, symbol = (float(match[1]), match[2] or "") if match else (as_number(cell.value), "")
    if type(number) is not float:
        raise InputError(f'{cell.where} = {shown(cell.value)} is no price; write 12.5 or "12.5 EUR"')
    check_number(cell.where, number, symbol or "-", **NON_NEGATIVE)
    return number, symbol
