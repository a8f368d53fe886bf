"""Which mechanisms there are, found by a design's type or by name."""

import copyreg
from typing import Any

from ..errors import InputError, nearest, shown
from .mechanism import Mechanism

_BY_DESIGN: dict[type, Mechanism] = {}


def register(mechanism: Mechanism) -> Mechanism:
    """Make a mechanism known: from then on `simulate` and all else serve its designs. Registering a name again
    replaces the mechanism."""
    # A module that is loaded again brings a new class of designs under the old name.
    for design, other in list(_BY_DESIGN.items()):
        if other.name == mechanism.name:
            del _BY_DESIGN[design]
    _BY_DESIGN[mechanism.design] = mechanism
    return mechanism


def mechanism_of(design: Any) -> Mechanism:
    """Return the mechanism of a design. **Raises:** `InputError` for what is no design of any."""
    if (mechanism := _of_type(type(design))) is not None:
        return mechanism
    known = ", ".join(f"{m.design.__name__} of {m.name}" for m in _BY_DESIGN.values())
    hint = "write the design first, then the scenario"
    raise InputError(f"design = {shown(design)} is not a design of a mechanism; {hint}; known are {known or 'none'}")


def mechanism_of_type(design: type) -> Mechanism:
    """Return the mechanism of a type of designs: what a pickled mechanism becomes again. **Raises:** `InputError`."""
    if (mechanism := _of_type(design)) is not None:
        return mechanism
    raise InputError(f"{design.__name__} is not the design of a mechanism that this process has registered")


def _of_type(design: type) -> Mechanism | None:
    return next((_BY_DESIGN[kind] for kind in design.__mro__ if kind in _BY_DESIGN), None)


def mechanism_of_scenario(scenario: Any) -> Mechanism:
    """Return the mechanism of a scenario. **Raises:** `InputError` for what is no scenario of any."""
    for mechanism in _BY_DESIGN.values():
        if isinstance(scenario, mechanism.scenario):
            return mechanism
    raise InputError(f"scenario = {shown(scenario)} is not a scenario of a mechanism")


def registered(name: Any) -> Mechanism:
    """Return the mechanism of a name. **Raises:** `InputError` that lists those there are."""
    for mechanism in _BY_DESIGN.values():
        if mechanism.name == name:
            return mechanism
    names = sorted(mechanism.name for mechanism in _BY_DESIGN.values())
    near = nearest(name, names)
    hint = f"; did you mean {near}?" if near else ""
    raise InputError(f"kind = {shown(name)} is unknown; choose one of {', '.join(names)}{hint}")


def all_registered() -> tuple[Mechanism, ...]:
    """Return all mechanisms that are registered by now."""
    return tuple(_BY_DESIGN.values())


# A mechanism is pickled as its design's type alone: most of it is functions, which another process has itself once it
# has imported that type's module.
copyreg.pickle(Mechanism, lambda mechanism: (mechanism_of_type, (mechanism.design,)))
