"""A quantity of a run: what it is called, its unit, how it is read off, what it may be used for."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, NamedTuple

import jax
import numpy as np
from jaxtyping import Array, Float

from ..errors import InputError, check_names, suggest
from ..fields import display_unit
from ..suggestions import Meaning
from ..value_text import DIGITS, with_unit

# By unit: what is smaller is what rounding leaves of zero, as of the force on a hinge that nothing loads.
NEGLIGIBLE: Mapping[str, float] = MappingProxyType({"N": 1e-4, "m": 1e-9})


class Quantity(NamedTuple):
    """A scalar of a run, differentiable: events move with the parameters, maxima are taken at their located times.

    ``unit``; ``of``: its value from the `Run`; ``description``: what it is, in a line of help; ``title``: its name in
    figures; ``signed``: whether it can change sign, when a relative change of it means little and derivatives are shown
    instead of elasticities; ``swept``: whether sweeps, records and summaries have it; ``tuned``: whether an objective
    or a limit may use it; ``shown``: unit in figures and how many of those a unit is (default: as of
    `display_unit`, mm for m and degrees for rad);
    ``part``: path of the field of the design without which it means nothing (None or 0 there), or "";
    ``differentiable``: whether it has derivatives; one without is read off a finished run alone; ``awaits``: name of
    the `RequiredEnd` that it is the time of, "" for none: it is NaN in a run that does not end so.
    """

    unit: str
    of: Callable[[Any], Float[Array, ""]]
    description: str
    title: str = ""
    signed: bool = False
    swept: bool = False
    tuned: bool = False
    shown: tuple[str, float] | None = None
    part: str = ""
    differentiable: bool = True
    awaits: str = ""

    @property
    def in_figures(self) -> tuple[str, float]:
        """Return the unit that people are shown, and how many of those its own unit is."""
        return self.shown or display_unit(self.unit)

    def in_words(self, value: float, digits: int = DIGITS) -> str:
        """Return a value in the unit that people are shown: "7.1 mm"."""
        unit, factor = self.in_figures
        return with_unit(factor * value, unit, digits)


Catalogue = Mapping[str, Quantity]


def zero(run: Any) -> Float[Array, "..."]:
    """Return 0 for what has no such part, in the shape of one run or many: NaN where a run failed."""
    if isinstance(run.peak_force, jax.core.Tracer):
        return 0.0 * run.peak_force
    # Of a finished run by NumPy: any operation of JAX would be a program of its own.
    return jax.device_put(0.0 * np.asarray(run.peak_force))


def largest(name: str) -> Callable[[Any], Float[Array, "..."]]:
    """Return what reads a maximum of a run that only an optional part has, `zero` without that part."""
    return lambda run: run.maxima[name] if name in run.maxima else zero(run)


# what a mechanism with impacts may have, under any name: `Mechanism.name_of` finds them
PEAK_FORCE = Quantity(
    "N", lambda run: run.peak_force, "largest contact force", "peak contact force", swept=True, tuned=True
)
PEAK_TIME = Quantity(
    "s", lambda run: run.peak_time, "when the contact force is largest", "time of the peak", swept=True
)
PENETRATION = Quantity(
    "m",
    lambda run: run.penetration,
    "depth that the deepest penetration does not exceed",
    "penetration",
    swept=True,
    shown=("µm", 1e6),
)
END_TIME = Quantity("s", lambda run: run.end_time, "end of the run", "end time", swept=True, tuned=True)
CONTACT_TIME = Quantity("s", lambda run: run.contact_time, "time in contact", "contact time", swept=True)
DISSIPATED = Quantity("J", lambda run: run.energy.dissipated, "energy lost altogether", "energy lost")

IMPACT_PEAK = "peak_force"  # the field of an impact that is its largest force
IMPACT_UNITS = {IMPACT_PEAK: "N", "approach_speed": "m/s", "time": "s", "release_time": "s"}
LOAD_UNITS = {"effective_energy": "J", "compression_end": "s"}
OF_IMPACT = IMPACT_UNITS | LOAD_UNITS
"""What can be asked of each impact, as in "impact.3.peak_force"; impacts count from 1. Every run has the first ones;
the others are computed where they are asked for (`Loads`)."""
EXAMPLE = f"impact.1.{IMPACT_PEAK}"


class OfImpact(NamedTuple):
    """One number of one impact: ``slot`` in the run's `Impacts` (from 0) and a name in `OF_IMPACT`."""

    slot: int
    field: str


def of_impact(name: str) -> OfImpact | None:
    """Return the impact and field that "impact.3.peak_force" asks for; None for names of the whole run.

    **Raises:** `InputError` for an impact's quantity that does not exist.
    """
    if not name.startswith("impact."):
        return None
    number, _, field = name.removeprefix("impact.").partition(".")
    # Digits of other scripts are decimal, too.
    if not (number.isdecimal() and number.isascii() and int(number) >= 1):
        raise InputError(f"{name}: {number!r} is not an impact's number; they count from 1, as in {EXAMPLE}")
    if field not in OF_IMPACT:
        raise InputError(f"{name} is unknown; an impact has {', '.join(OF_IMPACT)}{suggest(field, OF_IMPACT)}")
    return OfImpact(int(number) - 1, field)


def unit_of(catalogue: Catalogue, name: str) -> str:
    """Return the unit of a quantity."""
    address = of_impact(name)
    return OF_IMPACT[address.field] if address else catalogue[name].unit


def is_signed(catalogue: Catalogue, name: str) -> bool:
    """Return whether a quantity can change sign."""
    return name in catalogue and catalogue[name].signed


def _meaning(catalogue: Catalogue) -> Meaning:
    """Return a function that says what a quantity of the catalogue means, by its name, for `suggest`."""
    return lambda name: f"{it.title} {it.description}" if (it := catalogue.get(name)) else ""


def check_differentiable(catalogue: Catalogue, names: Sequence[str]) -> tuple[str, ...]:
    """Return the names, once it is sure that all exist and have derivatives. **Raises:** `InputError` otherwise."""
    names = check_quantities(catalogue, names)
    for name in names:
        if name in catalogue and not catalogue[name].differentiable:
            raise InputError(f"quantity {name} has no derivatives; simulate tells it")
    return names


def check_quantities(catalogue: Catalogue, names: Sequence[str]) -> tuple[str, ...]:
    """Return the names, once it is sure that all exist. **Raises:** `InputError` with the nearest name otherwise."""
    names = check_names("quantities", names, next(iter(catalogue), EXAMPLE))
    for name in names:
        if name not in catalogue and of_impact(name) is None:
            raise InputError(f"quantity {name} is unknown{suggest(name, [*catalogue, EXAMPLE], _meaning(catalogue))}")
    return names
