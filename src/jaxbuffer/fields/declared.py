"""Declared fields: numbers with unit, range and meaning, and words to choose from, checked when a part is made."""

import dataclasses
import functools
import inspect
import math
import operator
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool

from .._types import Scalar
from ..errors import InputError, check_choice, check_flag, check_number, check_type, check_whole, inside, suggest
from .curve import Curve
from .needs import Needs
from .portable import Portable
from .units import as_unit, in_unit

if TYPE_CHECKING:  # a part also takes text with a unit ("3 mm") and, for a sweep, lists: no one type says all of that
    Number = Any
else:
    Number = Scalar


def number(default: float | None, unit: str, *, doc: str = "", needs: Needs = (), **limits: Any) -> Any:
    """Declare a differentiable field with its unit and allowed range; lists of numbers become arrays, and text with a
    unit ("0.5 kN/m") becomes a number in the field's.

    **Arguments:** ``default``: in the field's unit, None if it may be left out; ``unit``: as in messages and tables;
    ``doc``: what the field means, in a few words, for tables, studies and editors; ``needs``: conditions without which
    it has no effect (`on`, `chosen`, `absent`); ``limits``: keywords of `check_number` that bound it (``low``,
    ``high``, ``low_open``, ``high_open``).
    """
    # Text becomes a number in the field's unit before anything computes with it.
    convert = functools.partial(as_unit, unit=unit)
    return eqx.field(
        default=default, converter=convert, metadata={"unit": unit, "limits": limits, "doc": doc, "needs": needs}
    )


def whole(default: int | None, least: int, most: int | None = None, *, doc: str = "", needs: Needs = ()) -> Any:
    """Declare a static field that takes whole numbers from ``least`` up, or from there to ``most``; ``default``,
    ``doc`` and ``needs`` as of `number`."""
    return eqx.field(default=default, static=True, metadata={"least": least, "most": most, "doc": doc, "needs": needs})


def choice(default: str | None, *options: str, doc: str = "", needs: Needs = ()) -> Any:
    """Declare a static field that takes one of a few words, one of the ``options``; ``default``, ``doc`` and ``needs``
    as of `number`."""
    return eqx.field(default=default, static=True, metadata={"choices": options, "doc": doc, "needs": needs})


def flag(default: bool, *, doc: str = "", needs: Needs = ()) -> Any:
    """Declare a static field that is true or false; ``doc`` and ``needs`` as of `number`."""
    return eqx.field(default=default, static=True, metadata={"flag": True, "doc": doc, "needs": needs})


def text(default: Any = dataclasses.MISSING, *, pattern: str = "", doc: str = "") -> Any:
    """Declare a field of a dataclass that takes text, which must be given where it has no default.

    **Arguments:** ``pattern``: a regular expression for editors; ``doc`` as of `number`.
    """
    return dataclasses.field(default=default, metadata={"pattern": pattern, "doc": doc})


def like(owner: type, name: str) -> Any:
    """Declare a field as another class has it: unit, range, default and meaning."""
    field = next(field for field in dataclasses.fields(owner) if field.name == name)
    return dataclasses.field(default=field.default, metadata=field.metadata)


def declared(owner: Any) -> dict[str, dict[str, Any]]:
    """Return what the fields of a dataclass declare of themselves, by name, each with its value in an instance, or its
    default in a class, as "default". A field that declares nothing is left out."""
    return {
        field.name: {**field.metadata, "default": getattr(owner, field.name, dataclasses.MISSING)}
        for field in dataclasses.fields(owner)
        if field.metadata
    }


def fields_in_words(fields: Mapping[str, dataclasses.Field[Any]]) -> list[str]:
    """Return a line of a docstring for each field that says what it means, with its unit and range."""
    lines = []
    for name, field in fields.items():
        it = field.metadata
        if not it.get("doc"):
            continue
        notes = [*([f"[{it['unit']}]"] if "unit" in it else []), *range_in_words(it)]
        lines.append(f"- ``{name}``: {' '.join([it['doc'], *notes])}.")
    return lines


def range_in_words(known: Mapping[str, Any]) -> list[str]:
    """Return what a field takes, as notes after its meaning: "(above 0)"; none for what takes anything."""
    if "choices" in known:
        # A meaning that explains each word needs no list of them.
        named = all(word in known["doc"] for word in known["choices"])
        return [] if named else [f"(one of {', '.join(known['choices'])})"]
    limits = known.get("limits", {})
    low, high = limits.get("low"), limits.get("high")
    ends = [] if low is None else [f"{'above' if limits.get('low_open') else 'at least'} {low:g}"]
    ends += [] if high is None else [f"{'below' if limits.get('high_open') else 'at most'} {high:g}"]
    return [f"({', '.join(ends)})"] if ends else []


def check_choosing(path: str, value: Any, known: Mapping[str, Any]) -> None:
    """Raise `InputError` for a word, a truth or a whole number that a field does not take; ``known``: what the field
    declares."""
    if "choices" in known:
        check_choice(path, value, known["choices"])
    elif "flag" in known:
        check_flag(path, value)
    elif "least" in known:
        check_whole(path, value, known["least"], known["most"])


def check_declared(owner: Any, prefix: str) -> None:
    """Raise `InputError` for a value that its field in a dataclass does not take; ``prefix`` makes its path of its
    name."""
    for name, known in declared(type(owner)).items():
        value = getattr(owner, name)
        if value is None and known["default"] is None:
            continue
        if "unit" in known:
            check_number(prefix + name, value, known["unit"], **known["limits"])
        else:
            check_choosing(prefix + name, value, known)


class Part(Portable):
    """A group of fields, each checked against its declared range when the part is made.

    A field states its unit, range and meaning once: docstrings, help, studies and editors tell it from there.

    - ``section``: the part's name in dotted paths.
    """

    section: ClassVar[str] = ""

    def __init_subclass__(cls, **named: Any) -> None:
        """Add a line for each field of its own to the class's docstring, before what it raises and its examples."""
        super().__init_subclass__(**named)
        own = {name: it for name, it in vars(cls).items() if isinstance(it, dataclasses.Field)}
        if not cls.__doc__ or not (lines := fields_in_words(own)):
            return
        said = inspect.cleandoc(cls.__doc__)
        before, mark, after = said.partition("\n\n**") if "\n\n**" in said else (said, "", "")
        cls.__doc__ = "\n".join([f"{before}\n", *lines]) + mark + after

    def __new__(cls, *given: Any, **named: Any) -> Self:
        known = {field.name: field.metadata for field in dataclasses.fields(cls)}
        for name, value in named.items():
            if name not in known:
                raise InputError(f"{cls.__name__}: {name} is unknown{suggest(name, known)}")
            if isinstance(value, str) and "unit" in known[name]:  # the field's converter keeps no unit for a message
                path = f"{cls.section}.{name}" if cls.section else name
                in_unit(path, value, known[name]["unit"], **known[name]["limits"])
        return super().__new__(cls)

    @property
    def without_effect(self) -> tuple[str, ...]:
        """Return the names of the fields that mean nothing with the others, such as those of another kind of start."""
        return ()

    def __post_init__(self) -> None:
        # A measured curve stands for numbers beside it, whose defaults then mean nothing. That a number is the default
        # and was not given shows only in that it is the same object.
        declared = {field.name: field for field in dataclasses.fields(self)}
        for field in declared.values():
            for name in field.metadata.get("instead_of", ()):
                if getattr(self, field.name) is not None and getattr(self, name) is declared[name].default:
                    object.__setattr__(self, name, None)

    def __check_init__(self) -> None:
        prefix, fields = f"{self.section}." if self.section else "", dataclasses.fields(self)
        replaced = {  # numbers for which measured curves stand
            name
            for field in fields
            if getattr(self, field.name) is not None
            for name in field.metadata.get("instead_of", ())
        }
        for field in fields:
            value, path = getattr(self, field.name), prefix + field.name
            if "check" in field.metadata:  # which knows more than its choices: a law may be an object
                field.metadata["check"](path, value)
            else:
                check_choosing(path, value, field.metadata)
            if "unit" in field.metadata:
                if value is not None or not (field.default is None or field.name in replaced):
                    symbol, limits = field.metadata["unit"], field.metadata["limits"]
                    in_unit(path, value, symbol, **limits)  # what is still text has a unit that does not fit
                    check_number(path, value, symbol, **limits)
            elif isinstance(field.default, Part):
                check_type(path, value, type(field.default), f"{type(field.default).__name__}(…)")
        self.check_together()

    def __repr__(self) -> str:
        from .shown import part_text

        return part_text(self)

    def has(self, name: str) -> bool:
        """Return whether a field that may be left out has a value."""
        return getattr(self, name) is not None

    def check_together(self) -> None:
        """Raise `InputError` where fields, each good in itself, don't go together."""

    def in_range(self) -> Iterator[Bool[Array, ""]]:
        """Yield whether each number is in its declared range, for numbers known only inside compiled code; NaN is in
        none.

        A part with a `check_together` of its own overrides this too.
        """
        ranged = list[tuple[Any, Mapping[str, Any]]]()
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, Part | Curve):
                yield from value.in_range()
            elif "unit" in field.metadata and value is not None:
                ranged.append((value, field.metadata["limits"]))
        if ranged and all(isinstance(value, jax.core.Tracer) and not value.ndim for value, _ in ranged):
            # Compiled together: there are a hundred of them.
            yield jnp.all(_inside_each([value for value, _ in ranged], [limits for _, limits in ranged]))
            return
        for value, limits in ranged:
            yield inside(value, **limits)


def _inside_each(values: Sequence[Any], limits: Sequence[Mapping[str, Any]]) -> Any:
    """Return which traced numbers are `inside` the range of each."""
    numbers = jnp.stack([jnp.asarray(value, float) for value in values])
    most = float(np.finfo(numbers.dtype).max)  # no number that is finite is larger
    least, largest = np.empty(len(values)), np.empty(len(values))
    for k, it in enumerate(limits):
        low, high = it.get("low", -math.inf), it.get("high", math.inf)
        least[k] = max(np.nextafter(low, math.inf) if it.get("low_open") else low, -most)
        largest[k] = min(np.nextafter(high, -math.inf) if it.get("high_open") else high, most)
    return (numbers >= least) & (numbers <= largest)


def all_of(conditions: Iterable[Bool[Array, ""]]) -> Bool[Array, ""]:
    """Return whether all conditions hold. ``conditions``: 0-d booleans."""
    return functools.reduce(operator.and_, map(jnp.asarray, conditions))
