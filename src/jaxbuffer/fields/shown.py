"""A design or scenario as text: every field with its unit and number."""

import dataclasses
from typing import Any

import equinox as eqx
import jax
import numpy as np

MOST = 6  # entries of an array that are shown
DIGITS = 8


def part_text(part: eqx.Module) -> str:
    """A field a line, its unit beside its name: ``k_A [N/m] = 500.0``.

    The unit belongs to the field. In a gradient, which has a design's fields, each number is the derivative by its
    field: its unit is the quantity's over the one shown.
    """
    lines = _lines(part)
    short = f"{type(part).__name__}({', '.join(lines)})"
    if len(lines) <= 1 or (not any("\n" in line for line in lines) and len(short) <= 100):
        return short
    body = ",\n".join("  " + line.replace("\n", "\n  ") for line in lines)
    return f"{type(part).__name__}(\n{body},\n)"


def _lines(part: eqx.Module) -> list[str]:
    lines = []
    for field in dataclasses.fields(part):
        value, symbol = getattr(part, field.name), field.metadata.get("unit", "")
        name = f"{field.name} [{symbol}]" if symbol else field.name
        equals = " = " if symbol else "="
        lines.append(f"{name}{equals}{value_text(value)}")
    return lines


def value_text(value: Any) -> str:
    """A number in full, an array's entries to eight digits, anything else as it calls itself."""
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
