"""The files of sized parts: names, and what makes their contents."""

from typing import Any

from ..fields import get, unit
from ..labelled.record import amount, json_number, part_record
from ..run.sized import Sized
from ..study.config import Config
from ..study.sized_toml import sized_toml
from ..version import version
from . import style
from .formats import Contents, Made
from .provenance import record_text
from .size_figure import size_figure


def size_files(sized: Sized, study: Config, made: Made = None) -> Contents:
    """Return the files of `jaxbuffer size`. ``study``: whose parts were sized; ``made``: how it came about."""
    return {
        "design.toml": lambda: sized_toml(study, sized.design, sized.duration, _comment(sized)),
        "size.json": lambda: record_text(size_record(sized), made),
        "size.txt": lambda: f"{sized!r}\n",
        **style.both("size", lambda: size_figure(sized)),
    }


def size_record(sized: Sized) -> dict[str, Any]:
    """Return sized parts as a record, in SI units."""
    parts, quantities = sized.parts, sized.mechanism.quantities
    number = lambda value, symbol: None if value is None else amount(json_number(value), symbol)  # noqa: E731
    return {
        "kind": sized.mechanism.name,
        "numbers": {
            it.path: {
                "value": amount(it.value, unit(parts.design, it.path)),
                "before": number(get(parts.before, it.path), unit(parts.design, it.path)),
                "rule": it.rule,
            }
            for it in parts.numbers
        },
        "estimates": {
            name: {
                "value": number(it.value, quantities[name].unit),
                "wished": number(it.limit, quantities[name].unit),
                "simulated": number(sized.confirmed[name].value, quantities[name].unit),
                "scenario": sized.confirmed[name].where,
                "kept": sized.confirmed[name].kept,
                "rule": it.rule,
            }
            for name, it in parts.estimates.items()
        },
        "missed": sized.missed,
        "remarks": list(parts.remarks),
        "outcomes": {str(number): run.outcome.name for number, run in sized.runs.items()},
        "duration": amount(sized.duration, "s"),
        "design": part_record(sized.design),
        "jaxbuffer": version(),
    }


def _comment(sized: Sized) -> str:
    lines = ["Sized by closed forms, and simulated:", *(f"{it.path}: {it.rule}" for it in sized.parts.numbers)]
    return "\n".join([*lines, *(f"not as wished: {it}" for it in sized.missed)])
