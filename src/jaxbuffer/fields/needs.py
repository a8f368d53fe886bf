"""What a field needs to have any effect, declared beside it, and which numbers of a design therefore have none."""

import dataclasses
import functools
from collections.abc import Callable, Collection, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..errors import concrete
from ..value_text import with_unit
from .paths import get, has_path, metadata, paths
from .shown import cut
from .units import as_typed

ROOT = "scenario."


class Need(NamedTuple):
    """A condition for a field to have an effect.

    - ``paths``: fields of the same part, or with a dot of the design or the scenario.
    - ``words``: one of the fields is one of these words, or of those that a function returns; none: one of the fields
      is set, and is not zero.
    - ``absent``: none of the fields is set, instead.
    - ``reason``: what the field is for, where no run reads it at all.
    """

    paths: tuple[str, ...]
    words: tuple[str, ...] | Callable[[], tuple[str, ...]] = ()
    absent: bool = False
    reason: str = ""


Needs = tuple[Need, ...]


def on(*names: str) -> Needs:
    """Return the need of a field that has an effect where one of the fields ``names`` is set and is not zero."""
    return (Need(names),)


def chosen(name: str, *words: str) -> Needs:
    """Return the need of a field that has an effect where the field ``name`` is one of ``words``."""
    return (Need((name,), words),)


def chosen_in(names: tuple[str, ...], *words: str) -> Needs:
    """Return the need of a field that has an effect where one of the fields ``names`` is one of ``words``."""
    return (Need(names, words),)


def chosen_of(name: str, words: Callable[[], tuple[str, ...]]) -> Needs:
    """Return the need of a field that has an effect where the field ``name`` is one of the words that ``words`` returns
    then."""
    return (Need((name,), words),)


def absent(*names: str) -> Needs:
    """Return the need of a field that has an effect where none of the fields ``names``, which replace it, is set."""
    return (Need(names, absent=True),)


def outside_runs(reason: str) -> Needs:
    """Return the need of a field that has no effect on any run; ``reason`` says what reads it."""
    return (Need((), reason=reason),)


def inactive(
    design: Any, scenario: Any = None, varied: Collection[str] = (), units: Mapping[str, str] = MappingProxyType({})
) -> list[str]:
    """Return a line for each field that was set and has no effect: "bar.depth = 3 mm has no effect: it needs
    bar.modes".

    **Arguments:** ``design``; ``scenario``, if any: conditions on it count as fulfilled without one; ``varied``: paths
    that a sweep or a tuning gives values, which count as set; ``units``: those that numbers were typed with, by path.
    Numbers that are only known inside compiled code are
    passed over.
    """
    lines = []
    for path in [*paths(design), *(f"{ROOT}{path}" for path in (() if scenario is None else paths(scenario)))]:
        why = why_inactive(design, scenario, path, varied)
        if not why:
            continue
        if path in varied:
            lines.append(f"{path} is varied and has no effect: {why}")
        elif _differs(design, scenario, path):
            lines.append(f"{path} = {_text(design, scenario, path, units.get(path, ''))} has no effect: {why}")
    return lines


def why_inactive(design: Any, scenario: Any, path: str, varied: Collection[str] = ()) -> str:
    """Return why the field at ``path`` (with "scenario." before one of the scenario's) has no effect, or "".

    **Arguments:** ``design``, ``scenario``, ``varied``: as of `inactive`.
    """
    part, own = _owner(design, scenario, path)
    if part is None or not has_path(part, own):
        return ""
    section = path.rpartition(".")[0]
    for need in metadata(part, own).get("needs", ()):
        if need.reason:
            return need.reason
        names = [name if "." in name or not section else f"{section}.{name}" for name in need.paths]
        # Without a scenario a condition on it counts as fulfilled.
        if scenario is None and any(name.startswith(ROOT) for name in names):
            continue
        values = [_value(design, scenario, name) for name in names]
        is_set = [name for name, value in zip(names, values, strict=True) if name in varied or _is_set(value)]
        if need.absent:
            if given := is_set:
                return f"{given[0]} stands in its place"
        elif need.words:
            words = need.words() if callable(need.words) else need.words
            if not any(value in words for value in values):
                quoted = [f'"{word}"' for word in words]
                return f"it needs {' or '.join(names)} = {' or '.join(quoted)}"
        elif not is_set:
            return f"it needs {' or '.join(names)}"
    return ""


def _owner(design: Any, scenario: Any, path: str) -> tuple[Any, str]:
    """Return the design or the scenario, whichever has the path, and the path in it."""
    return (scenario, path.removeprefix(ROOT)) if path.startswith(ROOT) else (design, path)


def _value(design: Any, scenario: Any, path: str) -> Any:
    part, own = _owner(design, scenario, path)
    return get(part, own)


def _is_set(value: Any) -> bool:
    """Return whether a field is set: neither None nor zero. What is not known yet counts as set."""
    if value is None or value is False:
        return False
    numbers = concrete(value) if not isinstance(value, bool | str) else None
    return numbers is None or bool(np.any(numbers != 0.0))


def _differs(design: Any, scenario: Any, path: str) -> bool:
    """Return whether a field was set to another value than its default."""
    part, own = _owner(design, scenario, path)
    *sections, name = own.split(".")
    holder = functools.reduce(getattr, sections, part)
    default = next(field.default for field in dataclasses.fields(holder) if field.name == name)
    value = getattr(holder, name)
    # A number that was not given is the same object as the default.
    if value is None or value is default:
        return False
    numbers = concrete(value) if not isinstance(value, bool | str) else None
    if numbers is None:
        return isinstance(value, bool | str) and value != default
    return default is None or bool(np.any(numbers != default))


def _text(design: Any, scenario: Any, path: str, typed: str) -> str:
    """Return a value as text with its unit, the one that was ``typed`` if any; of several, the first one."""
    part, own = _owner(design, scenario, path)
    value = get(part, own)
    if isinstance(value, str):
        return cut(f'"{value}"')
    numbers = concrete(value) if not isinstance(value, bool) else None
    if numbers is None or not numbers.size:
        return str(value)
    return with_unit(*as_typed(float(numbers.flat[0]), metadata(part, own).get("unit", "-"), typed))
