"""Geometry of space: vectors, quaternions, frames and inertias, written out in numbers."""

from .basis import SPACE as SPACE
from .basis import Space as Space
from .frames import AXES as AXES
from .frames import Frame as Frame
from .quaternions import Quaternion as Quaternion
from .vectors import Vector as Vector
