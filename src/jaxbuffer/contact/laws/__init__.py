"""Normal contact laws, one class each, and the names by which designs choose them."""

import dataclasses
from collections.abc import Mapping

from ..._types import Scalar
from .adams import AdamsImpact as AdamsImpact
from .adams import step as step
from .base import ContactLaw as ContactLaw
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
from .impact import FreeImpact as FreeImpact
from .impact import free_impact as free_impact
from .kelvin_voigt import KelvinVoigt as KelvinVoigt
from .pressure import hertz_pressure as hertz_pressure
from .pressure import yield_pressure as yield_pressure
from .stiffness import hertz_stiffness as hertz_stiffness
from .stiffness import socket_stiffness as socket_stiffness
from .stiffness import two_spheres_stiffness as two_spheres_stiffness

LAWS: Mapping[str, type[ContactLaw]] = {
    "lankarani-nikravesh": LankaraniNikravesh,
    "hertz": Hertz,
    "hunt-crossley": HuntCrossley,
    "herbert-mcwhannell": HerbertMcWhannell,
    "lee-wang": LeeWang,
    "gonthier": Gonthier,
    "flores": Flores,
    "hu-guo": HuGuo,
    "exact": ExactRestitution,
    "kelvin-voigt": KelvinVoigt,
    "adams": AdamsImpact,
}


def contact_law(name: str, numbers: Mapping[str, Scalar]) -> ContactLaw:
    """The law of a name, with those of ``numbers`` that it takes (its fields are named alike everywhere)."""
    law = LAWS[name]
    fields = [field.name for field in dataclasses.fields(law) if not field.metadata.get("static", False)]
    return law(**{field: numbers[field] for field in fields if field in numbers})
