"""A study to begin with for somebody's own numbers, as text: every number with its rule and its usual range."""

from collections.abc import Iterator
from typing import Any

from ..errors import InputError
from ..fields import Part, declared, unit
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.sizing import ScaledNumber, ScaledStudy
from ..value_text import with_unit
from .example import SCHEMA, entry_of, line_of

DIGITS = 3
AS_GIVEN = 6  # digits of what was typed: an angle of 2 deg stays one in radians


def scaled_toml(mechanism: Mechanism, given: dict[str, Any]) -> str:
    """Return the study that a mechanism makes from the ``given`` numbers of its task, by name, with units or without.

    **Raises:** `InputError` for a mechanism that makes none, and for numbers out of range.
    """
    if mechanism.sizing is None:
        raise InputError(f"kind = {mechanism.name}: no study is made from {', '.join(given)}; leave them out")
    task = mechanism.sizing.task(**given)
    study = mechanism.sizing.study(task)
    return "\n".join([*_head(mechanism, task, study), *_sections(mechanism, study), *_problem(mechanism, study)]) + "\n"


def _head(mechanism: Mechanism, task: Part, study: ScaledStudy) -> Iterator[str]:
    yield f"#:schema ./{SCHEMA}"
    known = {name: with_unit(getattr(task, name), it["unit"]) for name, it in declared(type(task)).items()}
    made_of = ", ".join(f"{name.replace('_', ' ')} {text}" for name, text in known.items())
    yield f"# A study to begin with, made from {made_of}:"
    yield f"# {study.remark}."
    yield "# Behind each number stand its unit, the rule that made it, and the range in which it usually is."
    yield ""
    yield f'kind = "{mechanism.name}"'


def _sections(mechanism: Mechanism, study: ScaledStudy) -> Iterator[str]:
    design, by_section = mechanism.design(), dict[str, list[ScaledNumber]]()
    for it in study.numbers:
        by_section.setdefault(it.path.rpartition(".")[0], []).append(it)
    for section, numbers in by_section.items():
        yield from ("", f"[{section}]")
        for it in numbers:
            low, high = _bounds(it)
            usual = "" if low == high else f"; usually {low:g} to {high:g}"
            rule = f"{unit(design, it.path)}: {it.rule}{usual}"
            yield line_of(entry_of(it.path.removeprefix(f"{section}."), _rounded(it.value)), rule)
    yield from ("", "[scenario]  # what is simulated; the grid below is what is tuned for")
    scenario = mechanism.scenario()
    for name, value in study.scenario.items():
        said = "" if isinstance(value, str) else unit(scenario, name)
        said = f"{said}: {study.rules[name]}" if name in study.rules else said
        yield line_of(entry_of(name, value if isinstance(value, str) else _rounded(value, AS_GIVEN)), said)
    yield from ("", "[options]", line_of(entry_of("duration", _rounded(study.duration, 2)), "s"))


def _problem(mechanism: Mechanism, study: ScaledStudy) -> Iterator[str]:
    design, scenario = mechanism.design(), mechanism.scenario()
    yield from ("", "[problem.grid]  # every combination is a load case")
    for name, values in study.grid.items():
        yield line_of(entry_of(name, [_rounded(value, AS_GIVEN) for value in values]), unit(scenario, name))
    yield from ("", "[problem.variables]  # what a tuning may change: [low, high]")
    for it in study.numbers:
        if it.tuned:
            yield line_of(entry_of(it.path, list(_bounds(it))), unit(design, it.path))
    yield from ("", "[problem.objective]", entry_of(study.objective, 1.0), "", "[problem.constraints]")
    for name, (value, rule) in study.limits.items():
        known = mechanism.quantities.get(name)
        text = rule if known is None else f"{known.unit}: {rule}"
        yield line_of(entry_of(name, value if isinstance(value, bool) else _rounded(value)), text)


def _bounds(it: ScaledNumber) -> tuple[float, float]:
    low, high = (_rounded(share * it.value) for share in it.usual)
    return low, high


def _rounded(value: float, digits: int = DIGITS) -> float:
    return float(f"{value:.{digits}g}")
