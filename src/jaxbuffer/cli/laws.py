"""`jaxbuffer laws`: the contact laws side by side."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import check_number
from .exits import OK
from .request import CommandLine

if TYPE_CHECKING:
    from ..mechanisms.probe_cone.comparison import Comparison
    from ..output.formats import Contents

Mass = Annotated[str | None, typer.Option(metavar="KG", help="Effective mass [kg]; default: of the first contact.")]
Speed = Annotated[str | None, typer.Option(metavar="M/S", help="Speed [m/s]; default: of the first contact.")]


def laws(
    request: CommandLine,
    mass: Mass = None,
    speed: Speed = None,
) -> int:
    """Compare the contact laws: the restitution each delivers, not what it is asked for, and one impact of two bodies.

    Choose a law for a capture with contact.law, here or in CONFIG.toml.

    \b
    Files in DIR:
      laws.csv  the table: sources, restitutions, penetration, force, duration
      laws.png, .svg  force over penetration and over time, delivered over asked restitution

    \b
    Example: jaxbuffer laws --contact.restitution 0.5 --output results/laws
    """
    study = request.study()
    files = request.files("laws.csv", "laws.png")
    from ..mechanisms.probe_cone.comparison import compare_laws

    comparison = compare_laws(
        study.design, study.scenario, mass=_number("--mass", mass, "kg"), speed=_number("--speed", speed, "m/s")
    )
    files.save_and_show(lambda: _contents(comparison), comparison)
    return OK


def _contents(comparison: "Comparison") -> "Contents":
    from ..output.formats import csv_text
    from ..output.laws_figure import laws_figure
    from ..output.style import both

    return {
        "laws.csv": lambda: csv_text(*_rows(comparison)),
        **both("laws", lambda: laws_figure(comparison)),
    }


def _number(option: str, text: str | None, unit: str) -> float | None:
    """What was typed as a number above 0."""
    if text is None:
        return None
    try:
        value: Any = float(text)
    except ValueError:
        value = text
    check_number(option, value, unit, low=0.0, low_open=True)
    return value


def _rows(comparison: "Comparison") -> tuple[list[str], list[Sequence[Any]]]:
    from ..mechanisms.probe_cone.comparison import ASKED

    header = [
        *("law", "source", "validity", "stiffness unit"),
        *(f"delivered restitution for {e:g} [-]" for e in ASKED),
        *("restitution [-]", "max_penetration [m]", "peak_force [N]", "duration [s]"),
    ]
    return header, [
        [entry.name, entry.law.source, entry.law.validity, entry.law.unit, *entry.delivered, *entry.impact[:4]]
        for entry in comparison.laws
    ]
