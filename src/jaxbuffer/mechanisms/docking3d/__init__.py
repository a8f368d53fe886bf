"""The docking in space: a probe with a ball tip behind a buffer and a universal joint meets a cone of revolution."""

from .capture import Capture3D as Capture3D
from .design import Design3D as Design3D
from .design import Scenario3D as Scenario3D
from .design import docking3d as docking3d
from .mechanism import DOCKING3D as DOCKING3D
