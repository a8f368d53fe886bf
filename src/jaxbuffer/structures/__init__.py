"""Structures of finite elements in explicit dynamics: elements, materials, contact, a liquid, and time stepping."""

from .acoustics import Liquid as Liquid
from .bars import Bars as Bars
from .central_differences import advance as advance
from .central_differences import march as march
from .materials import Elastic as Elastic
from .materials import Orthotropic as Orthotropic
from .materials import Plastic as Plastic
from .materials import mises as mises
from .quads import Quads as Quads
from .quads import at_faces as at_faces
from .structure import Plane as Plane
from .structure import Rods as Rods
from .system import FiniteElementSystem as FiniteElementSystem
from .system import State as State
