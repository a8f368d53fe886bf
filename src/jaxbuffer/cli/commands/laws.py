"""`jaxbuffer laws`: the contact laws side by side."""

from collections.abc import Sequence
from typing import Any

from ...errors import check_number
from ...mechanisms.probe_cone.comparison import ASKED, Comparison, compare_laws
from ...output import style
from ...output.formats import csv_text
from ...output.laws_figure import laws_figure
from ..exits import OK
from .request import CommandLine


def laws(request: CommandLine, mass: str | None, speed: str | None) -> int:
    """Compare the contact laws."""
    study = request.study()
    files = request.files("laws.csv", "laws.png")
    comparison = compare_laws(
        study.design, study.scenario, mass=_number("--mass", mass, "kg"), speed=_number("--speed", speed, "m/s")
    )
    table = {"laws.csv": lambda: csv_text(*_rows(comparison))}
    files.save_and_show(lambda: {**table, **style.both("laws", lambda: laws_figure(comparison))}, comparison)
    return OK


def _number(option: str, text: str | None, unit: str) -> float | None:
    """Read what was typed as a number above 0."""
    if text is None:
        return None
    try:
        value: Any = float(text)
    except ValueError:
        # The check below says what is wrong with it.
        value = text
    check_number(option, value, unit, low=0.0, low_open=True)
    return value


def _rows(comparison: Comparison) -> tuple[list[str], list[Sequence[Any]]]:
    header = [
        *("law", "source", "validity", "stiffness unit"),
        *(f"delivered restitution for {e:g} [-]" for e in ASKED),
        *("restitution [-]", "max_penetration [m]", "peak_force [N]", "duration [s]"),
    ]
    return header, [
        [entry.name, entry.law.source, entry.law.validity, entry.law.unit, *entry.delivered, *entry.impact[:4]]
        for entry in comparison.laws
    ]
