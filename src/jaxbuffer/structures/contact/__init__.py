"""Contact of nodes with surfaces in explicit dynamics: search, then a force by penalty, multiplier or defence node."""

from .forces import METHODS as METHODS
from .forces import NodeContact as NodeContact
from .forces import NodeContactForces as NodeContactForces
from .forces import contact_forces as contact_forces
from .layer import SOLID as SOLID
from .layer import Layer as Layer
from .search import candidates as candidates
from .surfaces import Pairs as Pairs
from .surfaces import RigidPlane as RigidPlane
from .surfaces import Segments as Segments
