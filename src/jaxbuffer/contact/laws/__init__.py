"""Normal contact laws, one class each, and the names by which designs choose them: ours, and those registered."""

import dataclasses
import inspect
import re
from collections.abc import Callable, Mapping
from types import MappingProxyType

from ..._types import Scalar
from ...errors import InputError, suggest
from .adams import AdamsImpact as AdamsImpact
from .adams import step as step
from .base import BEYOND_LAW as BEYOND_LAW
from .base import METHODS
from .base import ContactLaw as ContactLaw
from .cylindrical import PIN_IN_HOLE_LAWS as PIN_IN_HOLE_LAWS
from .cylindrical import Liu as Liu
from .cylindrical import Pereira as Pereira
from .cylindrical import SphereInSphere as SphereInSphere
from .cylindrical import pin_in_hole_law as pin_in_hole_law
from .damping import DAMPING_FACTORS as DAMPING_FACTORS
from .damping import damping_factor as damping_factor
from .hertzian import CarvalhoMartins as CarvalhoMartins
from .hertzian import DampedHertz as DampedHertz
from .hertzian import ExactRestitution as ExactRestitution
from .hertzian import Flores as Flores
from .hertzian import Gonthier as Gonthier
from .hertzian import HerbertMcWhannell as HerbertMcWhannell
from .hertzian import Hertz as Hertz
from .hertzian import HuGuo as HuGuo
from .hertzian import HuntCrossley as HuntCrossley
from .hertzian import HystereticLaw as HystereticLaw
from .hertzian import LankaraniNikravesh as LankaraniNikravesh
from .hertzian import LeeWang as LeeWang
from .hysteresis import DampedSpring as DampedSpring
from .hysteresis import PowerLaw as PowerLaw
from .impact import FreeImpact as FreeImpact
from .impact import free_impact as free_impact
from .kelvin_voigt import KelvinVoigt as KelvinVoigt
from .logarithmic import DubowskyFreudenstein as DubowskyFreudenstein
from .logarithmic import Esdu78035 as Esdu78035
from .logarithmic import Goldsmith as Goldsmith
from .logarithmic import Johnson as Johnson
from .logarithmic import LogarithmicLaw as LogarithmicLaw
from .logarithmic import Radzimovsky as Radzimovsky
from .pin_in_hole import PinInHoleLaw as PinInHoleLaw
from .pressure import hertz_pressure as hertz_pressure
from .pressure import yield_pressure as yield_pressure
from .stiffness import contact_modulus as contact_modulus
from .stiffness import hertz_stiffness as hertz_stiffness
from .stiffness import socket_stiffness as socket_stiffness
from .stiffness import two_spheres_stiffness as two_spheres_stiffness

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


def register_law(name: str, law: type[ContactLaw]) -> None:
    """Make a law of your own available to designs as ``contact.law``, at any time; registering a name again replaces
    its law at once, also for designs that exist.

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
    _all[name] = law


def contact_law(name: str, numbers: Mapping[str, Scalar]) -> ContactLaw:
    """Make a law by its name.

    **Arguments:** ``name``: a key of `LAWS`; ``numbers``: values by field name, of which the law takes those that it
    has.
    """
    law = LAWS[name]
    # A design has numbers for all laws; each takes its own.
    return law(**{field: numbers[field] for field in _numbers_of(law) if field in numbers})


def laws_with(number: str) -> Callable[[], tuple[str, ...]]:
    """Return a function that names the laws that have this ``number``, those registered later too."""
    return lambda: tuple(name for name, law in LAWS.items() if number in _numbers_of(law))


def _numbers_of(law: type[ContactLaw]) -> list[str]:
    """Return the names of a law's fields that are numbers."""
    return [field.name for field in dataclasses.fields(law) if not field.metadata.get("static", False)]
