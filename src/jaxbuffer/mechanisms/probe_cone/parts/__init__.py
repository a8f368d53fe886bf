"""Parts of the probe-cone mechanism: fields of its design, and the registry of those that a design may have or lack.

A new optional part is a module here with its fields and a `ProbePart`, an entry in `PARTS`, and its section in the
design.
"""

from typing import Any

from .bending import BENDING
from .buffer import ProbeBuffer as ProbeBuffer
from .control import CONTROL
from .control import Control as Control
from .hinge_play import HINGE_PLAY
from .hinge_play import Hinge as Hinge
from .latch import LATCH
from .latch import Latches as Latches
from .lockout import LOCKOUT
from .lockout import LockoutFields as LockoutFields
from .part import ProbePart as ProbePart
from .probe import Probe as Probe
from .rod import ALUMINIUM_DENSITY as ALUMINIUM_DENSITY
from .rod import ROD_RADIUS as ROD_RADIUS
from .rod import TIP_RADIUS as TIP_RADIUS
from .rod import RodFields as RodFields
from .shock import SHOCK
from .shock import Shock as Shock
from .stops import END_STOP, REBOUND_STOP
from .thrust import THRUST
from .thrust import ThrustFields as ThrustFields
from .vehicles import Active as Active
from .vehicles import Cone as Cone
from .vehicles import Passive as Passive

# In the order in which energies are listed.
PARTS: tuple[ProbePart, ...] = (
    END_STOP,
    BENDING,
    HINGE_PLAY,
    REBOUND_STOP,
    LATCH,
    LOCKOUT,
    THRUST,
    CONTROL,
    SHOCK,
)


def parts_of(design: Any, scenario: Any = None) -> list[ProbePart]:
    """Return the optional parts that a design in a scenario has."""
    return [part for part in PARTS if part.present(design, scenario)]


def part_of_element(name: str) -> ProbePart | None:
    """Return the part whose element has a name, None where it is no part's."""
    return next((part for part in PARTS if part.name == name), None)


def holder_of(design: Any) -> ProbePart | None:
    """Return the part that holds the tip behind the capture plane; None of a design whose runs end there."""
    return next((part for part in parts_of(design) if part.holds), None)
