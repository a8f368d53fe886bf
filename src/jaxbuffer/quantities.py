"""What can be asked of a capture by name: each quantity with its unit, its function of the capture, and what it is.

All of them have the right derivative: events move with the parameters, maxima sit at their own located times.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from jaxtyping import Array, Float

from .errors import InputError, check_names, suggest
from .validity import pressure

if TYPE_CHECKING:
    from .capture import Capture


class Quantity(NamedTuple):
    """A scalar of a capture: ``unit``, ``of``: function of the `Capture`, ``description``, ``signed``: whether it can
    change sign, when a relative change of it means little and derivatives are shown instead of elasticities."""

    unit: str
    of: "Callable[[Capture], Float[Array, '']]"
    description: str
    signed: bool = False


QUANTITIES: dict[str, Quantity] = {
    "peak_force": Quantity("N", lambda c: c.peak_force, "largest contact force of either flank"),
    "peak_hinge_force": Quantity("N", lambda c: c.peak_hinge_force, "largest reaction in the hinge"),
    "stroke": Quantity("m", lambda c: c.stroke, "largest shortening of the buffer"),
    "hinge_angle": Quantity("rad", lambda c: c.hinge_angle, "largest angle between cylinder and active vehicle"),
    "end_time": Quantity("s", lambda c: c.end_time, "end of the run: of a captured one, the capture time"),
    "peak_time": Quantity("s", lambda c: c.peak_time, "when the contact force is largest"),
    "peak_buffer_force": Quantity("N", lambda c: c.peak_buffer_force, "largest force of the axial spring-damper"),
    "contact_time": Quantity("s", lambda c: c.contact_time, "time during which a flank is touched"),
    "throat_distance": Quantity(
        "m",
        lambda c: c.throat_distance,
        "tip before the capture plane at the run's end; at any time, as duration",
        signed=True,
    ),
    "capture_margin": Quantity(
        "m",
        lambda c: c.capture_margin,
        "tip beyond the capture plane at the duration, coasting on, or stroke_margin",
        signed=True,
    ),
    "stroke_margin": Quantity(
        "m",
        lambda c: c.stroke_margin,
        "stroke left before the buffer's end; of a bottomed run minus what is missing",
        signed=True,
    ),
    "stroke_share": Quantity(
        "-",
        lambda c: 1.0 - c.stroke_margin / c.design.buffer.longest_stroke,
        "share of the buffer's stroke that is used; of a bottomed run above 1",
    ),
    "peak_stop_force": Quantity("N", lambda c: c.peak_stop_force, "largest force of the buffer's end stop"),
    "penetration": Quantity("m", lambda c: c.penetration, "depth that the tip's deepest penetration does not exceed"),
    "contact_pressure": Quantity(
        "Pa", lambda c: pressure(c.design, c.peak_force), "Hertz's largest pressure at the peak contact force"
    ),
    "axial_loss": Quantity("J", lambda c: c.energy.axial_damper, "energy lost in the axial damper by the run's end"),
    "torsional_loss": Quantity("J", lambda c: c.energy.torsional_damper, "energy lost in the torsional damper"),
    "contact_loss": Quantity("J", lambda c: c.energy.hysteresis, "energy lost in the contact's hysteresis"),
    "friction_loss": Quantity("J", lambda c: c.energy.friction, "energy lost in friction"),
    "stop_loss": Quantity("J", lambda c: c.energy.stop_damper, "energy lost in the buffer's end stop"),
    "dissipated": Quantity("J", lambda c: c.energy.dissipated, "energy lost altogether"),
    "effective_mass": Quantity("kg", lambda c: c.first_impact.effective_mass, "mass the first impact meets"),
    "effective_energy": Quantity("J", lambda c: c.first_impact.effective_energy, "T_c just before the first impact"),
    "elastic_first_peak": Quantity(
        "N", lambda c: c.first_impact.elastic_peak, "closed form of the first peak: no friction, loss, buffer"
    ),
    "predicted_first_peak": Quantity(
        "N", lambda c: c.first_impact.predicted_peak, "closed form of the first peak with the contact's loss"
    ),
}

IMPACT_UNITS = {"peak_force": "N", "approach_speed": "m/s", "time": "s", "release_time": "s"}
"""What can be asked of each impact, as in "impact.3.peak_force"; impacts count from 1."""


class OfImpact(NamedTuple):
    """One number of one impact: ``slot`` in the capture's `Impacts` (from 0) and the field's name."""

    slot: int
    field: str

    def of(self, capture: "Capture") -> Float[Array, ""]:
        """Its value; in a slot beyond the last impact it means nothing."""
        return getattr(capture.impacts, self.field)[self.slot]


def of_impact(name: str) -> OfImpact | None:
    """The impact and field that "impact.3.peak_force" asks for; None for names of the whole capture.

    **Raises:** `InputError` for an impact's quantity that does not exist.
    """
    if not name.startswith("impact."):
        return None
    number, _, field = name.removeprefix("impact.").partition(".")
    if not (number.isdecimal() and number.isascii() and int(number) >= 1):
        raise InputError(f"{name}: {number!r} is not an impact's number; they count from 1, as in impact.1.peak_force")
    if field not in IMPACT_UNITS:
        raise InputError(f"{name} is unknown; an impact has {', '.join(IMPACT_UNITS)}{suggest(field, IMPACT_UNITS)}")
    return OfImpact(int(number) - 1, field)


def quantity_unit(name: str) -> str:
    """The unit of a quantity."""
    asked = of_impact(name)
    return IMPACT_UNITS[asked.field] if asked else QUANTITIES[name].unit


def is_signed(name: str) -> bool:
    """Whether a quantity can change sign."""
    return name in QUANTITIES and QUANTITIES[name].signed


def check_quantities(names: Sequence[str]) -> tuple[str, ...]:
    """The names, once it is sure that all exist. **Raises:** `InputError` with the nearest name otherwise."""
    names = check_names("quantities", names, "peak_force")
    for name in names:
        if name not in QUANTITIES and of_impact(name) is None:
            raise InputError(f"quantity {name} is unknown{suggest(name, [*QUANTITIES, 'impact.1.peak_force'])}")
    return names


def value_of(capture: "Capture", name: str) -> float:
    """A quantity of a finished capture; NaN if it failed or has no such impact."""
    asked = of_impact(name)
    if asked is None:
        return float(QUANTITIES[name].of(capture))
    present = asked.slot < int(capture.impacts.count) and not capture.outcome.failed
    return float(asked.of(capture)) if present else float("nan")
