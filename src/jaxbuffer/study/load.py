"""Studies read from TOML."""

import dataclasses
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError, shown
from ..fields import SCENARIO, by_path, errors_in_typed_units, typed_unit
from ..files import user_path
from ..mechanisms import mechanism_named
from .config import DEFAULT_KIND, Config, sections, study_tables
from .mistaken import in_folder, no_file, no_table, no_toml
from .parts_toml import sums
from .problem_toml import check_table
from .tables import StudyNames, read_keys, replaced
from .values import TOLERANCED, as_table


def load(path: str | Path | None) -> Config:
    """Read a study; without a file, Table 2's. Raises `InputError` with one line that starts with the file's name."""
    if path is None:
        return Config()
    try:
        path = file = user_path(path)
        content = file.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file{no_file(file)}") from None
    except IsADirectoryError:
        raise InputError(f"{path}: a folder, not a study{in_folder(file)}") from None
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    return loads(content, path)


def loads(content: bytes, name: str | Path) -> Config:
    """Read a study from a file's content; ``name`` starts an error's line."""
    # For the message, where the bytes are no text.
    text = ""
    try:
        # Some editors begin a file with a byte order mark, which TOML does not allow.
        text = content.decode("utf-8-sig")
        data = tomllib.loads(text)
    except ValueError as error:  # TOML syntax, with line and column, or bytes that are not UTF-8
        raise InputError(f"{name} is not valid TOML: {no_toml(text, error)}") from None
    try:
        units = dict(_typed_units(data))
        # A message tells a range in the unit that was typed, wherever the error is raised.
        with errors_in_typed_units(units):
            return dataclasses.replace(_config(data, Path(name).parent), units=units)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _config(data: dict[str, Any], folder: Path) -> Config:
    mechanism, tables = mechanism_named(data.get("kind", DEFAULT_KIND)), study_tables()
    parts = sections(mechanism)
    known = (*parts, "kind", *tables)
    for name in data:
        # Here rather than in `read_keys`, which would pass over a table that it is not asked for.
        if name not in known:
            raise InputError(f"[{name}] is unknown{no_table(name, known, mechanism.view.synonyms)}")
    data = _with_tolerances(data, (*parts, "scenario"))
    typed = {f"{part}.{key}": value for part in parts for key, value in as_table(part, data.get(part, {})).items()}
    design, rest = replaced(mechanism.design(), typed, folder=folder), dict(tables)
    names = StudyNames(design, mechanism.scenario(), folder=folder)
    # One after the other, since the scenario is what [[scenarios]] begin with, and all tables name its fields.
    scenario, listed = {"scenario": rest.pop("scenario")}, {"scenarios": rest.pop("scenarios")}
    read = read_keys("", data, scenario, names)
    names = names._replace(**read)
    read |= read_keys("", data, listed, names)
    # Commands of one run need one scenario: without a [scenario] it is the first that is listed.
    if "scenarios" in read and "scenario" not in read:
        names = names._replace(scenario=read["scenarios"][0])
    # Objective and limits may name price and mass where the parts have them.
    read |= read_keys("", data, {"parts": rest.pop("parts")}, names)
    names = names._replace(own=sums(read.get("parts", ()), design))
    read |= read_keys("", data, rest, names) | {"scenario": names.scenario}
    typed |= {f"{SCENARIO}{name}": value for name, value in data.get("scenario", {}).items()}
    typed |= {f"{name}.{key}": it for name in ("options", "tune") for key, it in data.get(name, {}).items()}
    texts = {path: value for path, value in typed.items() if isinstance(value, str)}
    values = {tables[name]["field"]: value for name, value in read.items()}
    config = Config(names.design, folder=folder, texts=texts, given=frozenset(typed), **values)
    # As listed in the file: `Config` has put [scenario] in the place of a list that is not there.
    check_table(config.table, names.design, names.scenario, read.get("scenarios", ()))
    return config


def _with_tolerances(data: dict[str, Any], parts: Iterable[str]) -> dict[str, Any]:
    """Return a study's tables in which the tolerances that stand with a number are among its [tolerances]."""
    data, of_numbers = dict(data), dict[str, Any]()
    for part in parts:
        table = dict(as_table(part, data.get(part, {})))
        for name, given in table.items():
            if not isinstance(given, Mapping):
                continue
            where = f"{part}.{name}"
            # A part has no tables of its own, so a table there can only be a number with its tolerance.
            if set(given) != set(TOLERANCED):
                raise InputError(f'{where} = {shown(given)}; write {name} = {{value = …, tolerance = "10 %"}}')
            table[name], of_numbers[where] = given["value"], given["tolerance"]
        if part in data:
            data[part] = table
    if not of_numbers:
        return data
    others = by_path(as_table("tolerances", data.get("tolerances", {})), where="tolerances")
    for where in of_numbers:
        if where in others:
            raise InputError(f"{where} has a tolerance in its own table and in [tolerances]; keep one")
    return data | {"tolerances": others | of_numbers}


def _typed_units(value: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield the unit that was typed with each number, by the address of its field, wherever it is set, tuned, swept or
    sampled. ``path``: of ``value`` in the file."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _typed_units(inner, f"{path}.{name}".lstrip("."))
    elif path == "scenarios" and isinstance(value, list):
        for inner in value:
            # All scenarios share the addresses of [scenario], by which messages and figures look a unit up.
            yield from _typed_units(inner, "scenario")
    elif isinstance(value, list) and value and all(isinstance(point, list) and len(point) == 2 for point in value):
        for k, column in enumerate(zip(*value, strict=True)):  # of a curve
            if symbol := typed_unit(column):
                yield f"{path}[{k}]", symbol
    elif symbol := typed_unit(value):
        # From the number's place in the file to the address of the field that it is about.
        path = re.sub(r"^(.*)\.tolerance$", r"tolerances.\1", path)
        path = re.sub(r"\.(from|to|uniform|normal|value)$", "", path)
        path = re.sub(r"^(problem\.variables|sweep|sample\.ranges|fit\.parameters)\.", "", path)
        path = re.sub(r"^problem\.grid\.(?=\w+\.)", "", path)
        yield re.sub(r"^problem\.(grid|sample\.scenario)\.", "scenario.", path), symbol
