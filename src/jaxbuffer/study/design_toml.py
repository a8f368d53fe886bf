"""Designs written as studies."""

import dataclasses
from collections.abc import Iterable, Mapping
from types import MappingProxyType

import equinox as eqx
import tomli_w

from ..fields import SCENARIO, Curve, Part, as_written, unit
from ..mechanisms.registry import mechanism_of
from ..value_text import unit_text
from .config import DEFAULT_KIND, sections


def design_toml(
    design: Part,
    scenarios: Iterable[Part] = (),
    comment: str = "",
    units: Mapping[str, str] = MappingProxyType({}),
    first: Part | None = None,
) -> str:
    """Write a study that `load` reads back to exactly the same numbers.

    **Arguments:** ``units``: those that numbers were typed with, by address, in which they are written; others have
    theirs as a comment; ``first``: what [scenario] is, which commands of one run take; they take the first of the
    ``scenarios`` where it is None or one of them, and where a field of it that is set is not set in others, which begin
    with all of its fields.
    """
    blocks = [f"# {line}".rstrip() for line in comment.splitlines()]
    mechanism = mechanism_of(design)
    if mechanism.name != DEFAULT_KIND:
        blocks += ["", f'kind = "{mechanism.name}"']
    for section in sections(mechanism):
        blocks += ["", f"[{section}]", *_lines(getattr(design, section), f"{section}.", units)]
    listed = list(scenarios)
    if first is not None and not (listed and first is listed[0]) and all(_sets(first) <= _sets(it) for it in listed):
        blocks += ["", "[scenario]", *_lines(first, SCENARIO, units)]
    for number, scenario in enumerate(listed, 1):
        comment = f"  # {number}: {mechanism.view.label(scenario, listed)}" if len(listed) > 1 else ""
        blocks += ["", f"[[scenarios]]{comment}", *_lines(scenario, SCENARIO, units)]
    # Without a comment the file would begin with an empty line.
    return "\n".join(blocks).lstrip("\n") + "\n"


def _sets(part: Part) -> set[str]:
    """Return the names of the fields that are set."""
    return {field.name for field in dataclasses.fields(part) if getattr(part, field.name) is not None}


def _lines(part: eqx.Module, prefix: str, units: Mapping[str, str]) -> list[str]:
    """Return a line for each field; ``prefix`` makes its address of its name."""
    lines = []
    for name in (field.name for field in dataclasses.fields(part)):
        value, symbol = getattr(part, name), unit(part, name)
        if value is None:  # a stiffness to be computed: TOML has no word for it, leaving it out says it
            continue
        if isinstance(value, Curve):
            (x, first), (y, second) = value.axes
            points = points_text(value, f"{prefix}{name}", units)
            lines.append(f"{name} = {points}  # " + (f"{x}, {y}" if '"' in points else f"{x} {first}, {y} {second}"))
            continue
        # A number may be an array of JAX without dimensions, which the writer of TOML does not know.
        written = as_written(float(value), symbol, units.get(f"{prefix}{name}", "")) if symbol else value
        entry = tomli_w.dumps({name: written}).rstrip()
        lines.append(entry if isinstance(written, str) else f"{entry}{unit_text(symbol, '  # ')}")
    return lines


def points_text(curve: Curve, path: str, units: Mapping[str, str]) -> str:
    """Return a curve's points as a study writes them, in the ``units`` that were typed with ``path[0]`` and
    ``path[1]``, its two axes."""
    columns = []
    for k, ((_, symbol), numbers) in enumerate(zip(curve.axes, (curve.places, curve.values), strict=True)):
        written = [as_written(float(number), symbol, units.get(f"{path}[{k}]", "")) for number in numbers]
        if not all(isinstance(it, str) for it in written):  # one cannot be written in its unit exactly
            written = [float(number) for number in numbers]
        columns.append([f'"{it}"' if isinstance(it, str) else repr(it) for it in written])
    return "[" + ", ".join(f"[{place}, {number}]" for place, number in zip(*columns, strict=True)) + "]"
