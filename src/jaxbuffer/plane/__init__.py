"""Plane geometry and small linear algebra: the ground that bodies and contacts share."""

from .basis import PLANE as PLANE
from .basis import Plane as Plane
from .linear import Factors as Factors
from .linear import inverse as inverse
from .linear import ldl_solve as ldl_solve
from .trigonometry import cos_sin as cos_sin
from .vectors import Frame as Frame
from .vectors import Vector as Vector
