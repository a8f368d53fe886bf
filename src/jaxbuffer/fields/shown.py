"""A design or scenario as text: every field with its unit and number."""

import dataclasses
from collections.abc import Mapping
from typing import Any

import equinox as eqx
import jax
import numpy as np

from ..value_text import unit_text, with_unit

MOST = 6  # entries of an array that are shown
LONGEST = 80  # characters of a text that is shown whole: a mesh's is not
DIGITS = 8


def part_text(part: eqx.Module) -> str:
    """Return a part as text, a field a line, its unit beside its name: ``k_A [N/m] = 500.0``.

    A gradient has a design's fields, and each of its numbers is the derivative by its field: ``k_A [per N/m] = 0.2``,
    in the quantity's unit per that of the field. It is known by a number that no design allows: derivatives by fields
    that do nothing are zero, others negative.
    """
    return _text(part, is_gradient(part))


def _text(part: eqx.Module, gradient: bool) -> str:
    lines = _lines(part, gradient)
    short = f"{type(part).__name__}({', '.join(lines)})"
    if len(lines) <= 1 or (not any("\n" in line for line in lines) and len(short) <= 100):
        return short
    body = ",\n".join("  " + line.replace("\n", "\n  ") for line in lines)
    return f"{type(part).__name__}(\n{body},\n)"


def is_gradient(part: eqx.Module) -> bool:
    """Return whether a design's fields hold numbers that no design allows; False for traced ones, which are not
    known."""
    # Traced numbers cannot be compared with their ranges.
    if any(isinstance(leaf, jax.core.Tracer) for leaf in jax.tree.leaves(part)):
        return False
    in_range = getattr(part, "in_range", tuple)
    return not all(np.all(np.asarray(inside)) for inside in in_range())


def _lines(part: eqx.Module, gradient: bool) -> list[str]:
    lines = []
    for field in dataclasses.fields(part):
        value, symbol = getattr(part, field.name), field.metadata.get("unit", "")
        per = "per " if gradient and symbol != "-" else ""
        name = f"{field.name} [{per}{symbol}]" if symbol else field.name
        equals = " = " if symbol else "="
        # A measured curve is a module, yet shown as one value, the list of its points.
        is_part = isinstance(value, eqx.Module) and "curve" not in field.metadata
        inner = _text(value, gradient) if is_part else full_text(value)
        lines.append(f"{name}{equals}{inner}")
    return lines


def numbers_text(title: str, numbers: Mapping[str, tuple[Any, str, float]]) -> str:
    """Return a title, and below it a number a line with its unit.

    **Arguments:** ``numbers``: by name the number or array of them, the unit in which people are shown it, and how many
    of those its own unit is. A number that is not known, inside compiled code say, is shown as JAX shows it.
    """
    width = max(map(len, numbers), default=0)
    lines = []
    for name, (value, symbol, factor) in numbers.items():
        unknown = isinstance(value, jax.core.Tracer) or np.asarray(value).dtype.kind not in "fiu"
        text = repr(value) if unknown else _scaled(factor * np.asarray(value, float))
        lines.append(f"  {name.replace('_', ' '):{width}}  {text}{unit_text(symbol)}")
    return "\n".join([title, *lines])


def _scaled(value: np.ndarray) -> str:
    if value.ndim == 0:
        return "not known" if np.isnan(value) else f"{value.item():.6g}"
    entries = ", ".join(f"{entry:.6g}" for entry in value.ravel()[:MOST])
    if value.ndim == 1 and value.size <= MOST:
        return f"[{entries}]"
    if np.all(np.isnan(value)):
        return f"not known, of shape {value.shape}"
    few = f"[{entries}, …]" if value.size > MOST else f"[{entries}]"
    return f"{few} of shape {value.shape}, from {np.nanmin(value):.6g} to {np.nanmax(value):.6g}"


def cut(text: str) -> str:
    """Return a text; of a long one, such as a mesh's, its beginning and how long it is."""
    return text if len(text) <= LONGEST else f"{text[:20]}… {len(text)} characters in all"


def field_text(value: Any, unit: str) -> str:
    """Return a field's value with its unit: "500 N/m", "true", "hertz", "not set"."""
    if value is None:
        return "not set"
    if isinstance(value, bool):
        return str(value).lower()
    return with_unit(value, unit) if isinstance(value, float) else cut(str(value))


def full_text(value: Any) -> str:
    """Return a number in full, an array's entries to eight digits, and anything else as it calls itself."""
    if isinstance(value, str):
        return repr(cut(value))
    if isinstance(value, jax.core.Tracer) or not isinstance(value, jax.Array | np.ndarray | np.generic):
        return repr(value)
    array = np.asarray(value)
    if array.dtype.kind not in "fiu":
        return repr(value)
    if not array.ndim:
        return f"{array.item():.{DIGITS}g}"
    entries = ", ".join(f"{entry:.{DIGITS}g}" for entry in array.ravel()[:MOST])
    if array.ndim == 1:
        return f"[{entries}]" if array.size <= MOST else f"[{entries}, … {array.size} in all]"
    return f"[{entries}, …] of shape {array.shape}"
