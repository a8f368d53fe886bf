"""The ``[problem.quantities]`` of a study: Python functions in a file beside it.

Reading a study runs nothing of them; `own_quantities` does, for the commands that need their values.
"""

import dataclasses
import inspect
import types
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError, check_known, nearest, shown
from ..fields import declared, text
from ..fields.units import check_unit
from ..files import user_path
from ..mechanisms.mechanism import Mechanism
from ..tuning.problem.custom_quantity import CustomQuantity, check_custom_quantities, check_name, line_in, raised
from .tables import StudyNames, StudyTable
from .values import Schema, key_schema, object_schema

EXAMPLE = '{function = "objectives.py:effort", unit = "N m"}'


@dataclasses.dataclass(frozen=True)
class NamedQuantity:
    """An own quantity as a study names it."""

    function: str = text(pattern=r"\.py:\w+$", doc="a file beside the study and a name: objectives.py:effort")
    unit: str = text(doc="of what the function returns, - for none")
    description: str = text("", doc="what it is, in a line")

    @property
    def file(self) -> str:
        """Return the file that the function is in."""
        return self.function.rpartition(":")[0]

    @property
    def name(self) -> str:
        """Return the function's name."""
        return self.function.rpartition(":")[2]


KEYS = declared(NamedQuantity)
REQUIRED = tuple(name for name, known in KEYS.items() if known["default"] is dataclasses.MISSING)


class OwnQuantitiesKind(StudyTable):
    """``[problem.quantities]``, read without looking at their files."""

    def read(self, where: str, given: Any, names: StudyNames) -> dict[str, NamedQuantity]:
        if not isinstance(given, dict):
            raise InputError(f"{where} = {shown(given)} is not a table; write effort = {EXAMPLE} below it")
        return {name: _named(where, name, entry, names.mechanism) for name, entry in given.items()}

    def schema(self, names: StudyNames) -> Schema:
        properties = {name: key_schema(name, known) for name, known in KEYS.items()}
        return {"type": "object", "additionalProperties": object_schema(properties, required=list(REQUIRED))}


OWN = OwnQuantitiesKind()


def _named(table: str, name: str, entry: Any, mechanism: Mechanism) -> NamedQuantity:
    where = f"{table}.{name}"
    check_name(name, mechanism.quantities)
    if not isinstance(entry, dict):
        raise InputError(f"{where} = {shown(entry)} is not a table; write {name} = {EXAMPLE}")
    check_known(entry, KEYS, where)
    for key in REQUIRED:
        if key not in entry:
            raise InputError(f"{where} has no {key}; write {name} = {EXAMPLE}")
    for key, value in entry.items():
        if not isinstance(value, str):
            raise InputError(f"{where}.{key} = {shown(value)} is not a text; write {name} = {EXAMPLE}")
    file, colon, function = entry["function"].rpartition(":")
    if not (colon and file.endswith(".py") and function.isidentifier()):
        remedy = "is not a file and a name in it, such as objectives.py:effort"
        raise InputError(f"{where}.function = {shown(entry['function'])} {remedy}")
    check_unit(f"{where}.unit", entry["unit"])
    return NamedQuantity(**entry)


def own_quantities(given: Mapping[str, NamedQuantity], mechanism: Mechanism, folder: Path) -> dict[str, CustomQuantity]:
    """Load own quantities; their files, beside the study in ``folder``, are run.

    **Raises:** `InputError` for files that are missing or raise something, and functions that make no quantity.
    """
    modules: dict[str, dict[str, Any]] = {}
    own = {}
    for name, named in given.items():
        where = f"problem.quantities.{name}"
        try:
            # Each file is run once, though several quantities may name functions of it.
            if named.file not in modules:
                modules[named.file] = _run(folder / user_path(named.file), named.file)
            function = _function(modules[named.file], named)
            own[name] = CustomQuantity(function, named.unit, named.description)
        except InputError as error:
            raise InputError(f"{where}: {error}") from None
    try:
        return check_custom_quantities(own, mechanism.quantities)
    except InputError as error:
        raise InputError(f"problem.{error}") from None


def _run(path: Path, shown_as: str) -> dict[str, Any]:
    """Run a Python file and return what it defines; nothing is written beside it."""
    try:
        source = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    # Not an import, since a study's file need not lie on Python's path.
    module = types.ModuleType(f"study {path.stem}")
    module.__file__ = str(path)
    try:
        exec(compile(source, str(path), "exec"), module.__dict__)  # docs/security.md says when
    except SyntaxError as error:
        raise InputError(f"{shown_as}, line {error.lineno}: {error.msg}") from None
    except (Exception, SystemExit) as error:
        # A script may end itself, which must not end the command without a word.
        line = line_in(str(path), error)
        raise InputError(f"{shown_as}{'' if line is None else f', line {line},'} {raised(error)}") from None
    return vars(module)


def _function(defined: Mapping[str, Any], named: NamedQuantity) -> Callable[..., Any]:
    """Return the function of that name."""
    if named.name in defined:
        function: Callable[..., Any] = defined[named.name]
        return function
    functions = [name for name, value in defined.items() if inspect.isfunction(value)]
    near = nearest(named.name, functions)
    remedy = f"; did you mean {near}?" if near else f"; it has {', '.join(functions) or 'none'}"
    raise InputError(f"{named.file} has no function {named.name}{remedy}")
