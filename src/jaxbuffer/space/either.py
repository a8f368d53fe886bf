"""Vectors, turns and frames of the plane or of space, which have the same operations."""

from typing import TYPE_CHECKING

from .. import plane
from .._types import Scalar
from .frames import Frame as SpaceFrame
from .vectors import Vector as SpaceVector

if TYPE_CHECKING:  # what is said of the plane's holds of space's
    from ..plane import Frame, Vector

    Turn = Scalar
else:
    Frame, Vector = plane.Frame | SpaceFrame, plane.Vector | SpaceVector
    Turn = Scalar | SpaceVector
