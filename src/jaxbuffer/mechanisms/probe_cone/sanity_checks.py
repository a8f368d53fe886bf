"""What a design keeps of the laboratory model of the paper's Table 2 though its vehicles are far from that model's."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ...fields import as_typed, get, unit
from ...value_text import with_unit
from .assembly import tip_on_flanks
from .design import Design
from .parts import parts_of

FAR = 3.0  # a factor between masses from which on the model's other numbers are not to be relied on
UNLIKE = 0.05  # between the restitution that is asked for and the one that the law delivers
MASS, SPEED = 0.2, 0.1  # kg, m/s: of the first impact of Table 2


class TableValue(NamedTuple):
    """A field that is easily left at its default: its ``path``, the unit it is shown in, the vehicle whose mass it goes
    with, the ``power`` of the mass with which it grows in vehicles of one shape and density (0: with none), and
    ``why`` it matters."""

    path: str
    shown: str
    vehicle: str
    power: float
    why: str


# With shape and density kept, a length goes with the cube root of the mass, an inertia with mass times length squared.
LENGTH, INERTIA = 1.0 / 3.0, 5.0 / 3.0
TABLE_VALUES = (
    TableValue("active.inertia", "kg m²", "active", INERTIA, "how fast the active vehicle turns after an impact"),
    TableValue("active.hinge_offset", "mm", "active", LENGTH, "the arm with which the hinge's force turns the vehicle"),
    TableValue("passive.inertia", "kg m²", "passive", INERTIA, "how fast the passive vehicle turns after an impact"),
    TableValue(
        "cone.offset",
        "mm",
        "passive",
        LENGTH,
        "the arm of the forces on the cone; in one of 8 t it moved the stroke by 30 %",
    ),
    TableValue("cone.length", "mm", "", 0.0, "how far from the axis the tip may meet the cone"),
    TableValue("cone.throat_radius", "mm", "", 0.0, "how the tip fits its seat"),
    TableValue("probe.tip_radius", "mm", "", 0.0, "the contact's stiffness, and the tip's fit in the throat"),
    TableValue("probe.tip_mass", "g", "", 0.0, "the first impact's force, which no buffer softens"),
    TableValue("probe.rod_mass", "g", "", 0.0, "the same"),
    TableValue("buffer.free_length", "mm", "", 0.0, "the stroke at which the buffer bottoms, unless max_stroke is set"),
    TableValue("buffer.cylinder_mass", "kg", "", 0.0, "what the torsional spring has to move"),
    TableValue("buffer.cylinder_length", "mm", "", 0.0, "the same"),
    TableValue("contact.friction", "-", "", 0.0, "it brakes 30 to 45 % of the energy of some captures; measure it"),
)


def sanity_checks(design: Design) -> list[str]:
    """Return a line for each number that a design of far heavier or lighter vehicles leaves at its default, for a
    restitution that the contact's law does not deliver, and what its parts caution against."""
    return [*_table_values(design), *_restitution(design), *cautions(design)]


def cautions(design: Design) -> list[str]:
    """Return what the parts of a design caution against, a line each."""
    return [line for part in parts_of(design) for line in part.cautions(design)]


def _table_values(design: Design) -> Iterator[str]:
    usual = Design()
    ratios = {name: float(get(design, f"{name}.mass") / get(usual, f"{name}.mass")) for name in ("active", "passive")}
    if all(1.0 / FAR < ratio < FAR for ratio in ratios.values()):
        return
    lines = [
        _line(design, entry, ratios.get(entry.vehicle, 1.0))
        for entry in TABLE_VALUES
        if np.all(np.asarray(get(design, entry.path)) == get(usual, entry.path))
    ]
    if lines:
        masses = " and ".join(f"{float(get(usual, f'{name}.mass')):.3g} kg" for name in ratios)
        yield f"the vehicles are far from the laboratory model's {masses}, of which these numbers are kept:"
        yield from lines


def _line(design: Design, entry: TableValue, ratio: float) -> str:
    """Return a line such as "cone.offset 96 mm: why; grown with the mass 670 mm"."""
    value, symbol = float(np.max(np.asarray(get(design, entry.path)))), unit(design, entry.path)
    text = f"{entry.path} {with_unit(*as_typed(value, symbol, entry.shown))}: {entry.why}"
    # A number that goes with no vehicle's mass, or with one near the model's, has nothing to be grown by.
    if entry.power == 0.0 or 1.0 / FAR < ratio < FAR:
        return text
    grown = float(f"{value * ratio**entry.power:.2g}")
    return f"{text}; grown with the mass {with_unit(*as_typed(grown, symbol, entry.shown))}"


def _restitution(design: Design) -> Iterator[str]:
    nominal, law = float(np.max(np.asarray(design.contact.restitution))), tip_on_flanks(design).law
    # A law without a restitution does not miss the one that is asked for.
    if not hasattr(law, "restitution"):
        return
    delivered = float(law.delivered_restitution(MASS, SPEED))
    if not math.isclose(delivered, nominal, abs_tol=UNLIKE):
        yield (
            f"contact.restitution {nominal:g}: the law {design.contact.law} delivers {delivered:.2f}; 'jaxbuffer laws'"
            " compares the laws, exact delivers what it is asked"
        )
