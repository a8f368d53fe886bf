"""The ``[problem.quantities]`` of a study: Python functions in a file beside it.

Reading a study runs nothing of them; `own_quantities` does, for the commands that need their values.
"""

import inspect
import types
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from ..errors import InputError, check_known, nearest, shown
from ..fields.units import check_unit
from ..files import user_path
from ..mechanisms.mechanism import Mechanism
from ..tuning.custom_quantity import CustomQuantity, check_custom_quantities, check_name, line_in, raised

EXAMPLE = '{function = "objectives.py:effort", unit = "N m"}'
FIELDS = ("function", "unit", "description")


class NamedQuantity(NamedTuple):
    """An own quantity as a study names it: the file and the function's name in it, its unit, and what it is."""

    file: str
    function: str
    unit: str
    description: str


def named_quantities(table: Mapping[str, Any], mechanism: Mechanism) -> dict[str, NamedQuantity]:
    """Return the own quantities of a ``[problem]``, without looking at their files. **Raises:** `InputError` for what
    names none."""
    given = table.get("quantities", {})
    if not isinstance(given, dict):
        raise InputError(f"problem.quantities = {shown(given)} is not a table; write effort = {EXAMPLE} below it")
    return {name: _named(name, entry, mechanism) for name, entry in given.items()}


def _named(name: str, entry: Any, mechanism: Mechanism) -> NamedQuantity:
    where = f"problem.quantities.{name}"
    check_name(name, mechanism.quantities)
    if not isinstance(entry, dict):
        raise InputError(f"{where} = {shown(entry)} is not a table; write {name} = {EXAMPLE}")
    check_known(entry, FIELDS, where)
    for key in FIELDS[:2]:
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
    return NamedQuantity(file, function, entry["unit"], entry.get("description", ""))


def own_quantities(table: Mapping[str, Any], mechanism: Mechanism, folder: Path) -> dict[str, CustomQuantity]:
    """Load the own quantities of a ``[problem]``; their files, beside the study in ``folder``, are run.

    **Raises:** `InputError` for files that are missing or raise something, and functions that make no quantity.
    """
    modules: dict[str, dict[str, Any]] = {}
    own = {}
    for name, named in named_quantities(table, mechanism).items():
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
    if named.function in defined:
        function: Callable[..., Any] = defined[named.function]
        return function
    functions = [name for name, value in defined.items() if inspect.isfunction(value)]
    near = nearest(named.function, functions)
    remedy = f"; did you mean {near}?" if near else f"; it has {', '.join(functions) or 'none'}"
    raise InputError(f"{named.file} has no function {named.function}{remedy}")
