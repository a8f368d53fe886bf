"""The names of contact laws, ours and those registered, and the law that a design has chosen."""

import dataclasses
import inspect
import re
import sys
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any

import equinox as eqx

from ..._types import Scalar
from ...errors import InputError, check_choice, suggest
from .adams import AdamsImpact
from .base import METHODS, ContactLaw
from .hertzian import (
    CarvalhoMartins,
    ExactRestitution,
    Flores,
    Gonthier,
    HerbertMcWhannell,
    Hertz,
    HuGuo,
    HuntCrossley,
    LankaraniNikravesh,
    LeeWang,
)
from .kelvin_voigt import KelvinVoigt

_BUILT_IN: Mapping[str, type[ContactLaw]] = {
    "lankarani-nikravesh": LankaraniNikravesh,
    "hertz": Hertz,
    "hunt-crossley": HuntCrossley,
    "herbert-mcwhannell": HerbertMcWhannell,
    "lee-wang": LeeWang,
    "gonthier": Gonthier,
    "flores": Flores,
    "hu-guo": HuGuo,
    "carvalho-martins": CarvalhoMartins,
    "exact": ExactRestitution,
    "kelvin-voigt": KelvinVoigt,
    "adams": AdamsImpact,
}
_all: dict[str, type[ContactLaw]] = dict(_BUILT_IN)
LAWS: Mapping[str, type[ContactLaw]] = MappingProxyType(_all)
"""All laws by name, as they are at the moment: `register_law` adds to them."""

NUMBERS = ("stiffness", "restitution", "linear_stiffness", "damping", "exponent", "ramp_depth")  # a design's, for laws


_chosen: "dict[tuple[str, type[ContactLaw]], ChosenLaw]" = {}


@dataclasses.dataclass(init=False, frozen=True, eq=False, repr=False)
class ChosenLaw(str):
    """The law that a design has: its class, and the name by which it was chosen.

    It is that name wherever a text is wanted, in TOML, records, messages and when compared with a word. Two of them are
    equal where both name and class are, so that a program is made for the class.
    """

    name: str
    kind: type[ContactLaw]

    def __new__(cls, name: str, kind: type[ContactLaw] | None = None) -> "ChosenLaw":
        kind = LAWS[name] if kind is None else kind
        # One object for each law: JAX compares designs at every call, and an object with itself at once.
        if (name, kind) not in _chosen:
            _chosen[name, kind] = law = super().__new__(cls, name)
            object.__setattr__(law, "name", name)
            object.__setattr__(law, "kind", kind)
        return _chosen[name, kind]

    def __eq__(self, other: object) -> bool:
        return str.__eq__(self, other) and (not isinstance(other, ChosenLaw) or self.kind is other.kind)

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = str.__hash__

    def __deepcopy__(self, memo: Any) -> "ChosenLaw":
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        found: Any = sys.modules.get(self.kind.__module__)
        for part in self.kind.__qualname__.split("."):
            found = getattr(found, part, None)
        # A class that is made in a function cannot be pickled: another process must have registered it.
        return (ChosenLaw, (self.name, self.kind)) if found is self.kind else (chosen_law, (self.name,))


def law_class(chosen: str) -> type[ContactLaw]:
    """Return the class of the law that a design has chosen, or that a name stands for."""
    return chosen.kind if isinstance(chosen, ChosenLaw) else LAWS[chosen]


def laws_named(words: Iterable[Any]) -> tuple[type[ContactLaw], ...]:
    """Return the classes of those words that are names of laws."""
    return tuple(LAWS[word] for word in words if isinstance(word, str) and word in LAWS)


def chosen_law(law: Any) -> Any:
    """Return the law that a name or a class stands for; anything else unchanged, for `check_law`."""
    if isinstance(law, ChosenLaw):
        return law
    if isinstance(law, str) and law in LAWS:
        return ChosenLaw(law)
    if isinstance(law, type) and issubclass(law, ContactLaw):
        own = law.__name__ if law.__name__ not in LAWS else f"{law.__module__}.{law.__qualname__}"
        return ChosenLaw(next((name for name, kind in LAWS.items() if kind is law), own), law)
    return law


def law_choice(default: str) -> Any:
    """Declare a field of a design that holds a law: given as a registered name, or as a class of one's own."""
    doc = "contact law; it takes those of the other fields that it has"
    metadata = {"doc": doc, "choices": LAWS, "check": check_law}
    return eqx.field(default=default, converter=chosen_law, static=True, metadata=metadata)


def check_law(path: str, law: Any) -> None:
    """Raise `InputError` for what is neither a registered name nor a law's class."""
    if not isinstance(law, ChosenLaw):
        check_choice(path, law, LAWS)
    elif LAWS.get(law.name) is not law.kind:
        _check_class(law.name, law.kind)


def register_law(name: str, law: type[ContactLaw]) -> None:
    """Give a law of your own a name, by which TOML, the command line and designs choose it as ``contact.law``.

    A name that is registered again means the new law from then on; designs that exist keep the law they have.

    **Arguments:**

    - ``name``: letters, digits, ``-`` and ``_``.
    - ``law``: a subclass of `ContactLaw` with ``elastic`` [N], ``energy`` [J], ``force`` [N] and ``time_scale`` [s].
      Fields named as in `NUMBERS` get the design's numbers; others need defaults.

    **Raises:** `InputError` for a name that is taken by a built-in law, and for what is no such class.

    **Example:** Hertz's law with a damping force of 14.25 % of the elastic one at the speed of touchdown.

    >>> from jaxbuffer.contact.laws import Hertz
    >>> class Damped(Hertz):
    ...     hysteresis = 0.1425
    >>> jb.register_law("damped", Damped)
    >>> design = jb.replace(jb.table2(), {"contact.law": "damped"})
    >>> f"{float(jb.first_impact(design).predicted_peak):.1f} N"
    '143.1 N'
    """
    if not (isinstance(name, str) and re.fullmatch(r"[A-Za-z0-9][\w-]*", name)):
        raise InputError(f"law name {name!r}: use letters, digits, - and _")
    if name in _BUILT_IN:
        raise InputError(f"law name {name!r} is a built-in law's; choose another")
    if not (isinstance(law, type) and issubclass(law, ContactLaw)):
        raise InputError(f"law {name!r}: {law!r} is not a subclass of jaxbuffer.contact.ContactLaw")
    _check_class(name, law)
    _all[name] = law


def _check_class(name: str, law: type[ContactLaw]) -> None:
    """Raise `InputError` for a class that lacks methods, or that asks for numbers that a design does not have."""
    # Said here, not when a run is first traced, where the error would be far from its cause.
    missing = [method for method in METHODS if getattr(law, method) is getattr(ContactLaw, method)]
    if missing:
        raise InputError(f"law {name!r}: {law.__name__} lacks {', '.join(missing)}")
    taken = inspect.signature(law).parameters.values()
    unknown = [p.name for p in taken if p.default is p.empty and p.kind is not p.VAR_KEYWORD and p.name not in NUMBERS]
    if unknown:
        raise InputError(
            f"law {name!r}: field {unknown[0]} of {law.__name__} has no default and is none of a design's numbers, "
            f"{', '.join(NUMBERS)}{suggest(unknown[0], NUMBERS)}"
        )


def contact_law(chosen: str, numbers: Mapping[str, Scalar]) -> ContactLaw:
    """Make the law that a design has chosen.

    **Arguments:** ``chosen``: a `ChosenLaw`, or a key of `LAWS`; ``numbers``: values by field name, of which the law
    takes those that it has.
    """
    law = law_class(chosen)
    # A design has numbers for all laws; each takes its own.
    return law(**{field: numbers[field] for field in _numbers_of(law) if field in numbers})


def laws_with(number: str) -> Callable[[], tuple[str, ...]]:
    """Return a function that names the laws that have this ``number``, those registered later too."""
    return lambda: tuple(name for name, law in LAWS.items() if number in _numbers_of(law))


def _numbers_of(law: type[ContactLaw]) -> list[str]:
    """Return the names of a law's fields that are numbers."""
    return [field.name for field in dataclasses.fields(law) if not field.metadata.get("static", False)]
