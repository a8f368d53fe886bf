"""Mechanisms built from bodies, joints, force elements and contacts."""

from .capture import CaptureMechanism as CaptureMechanism
from .design import Design as Design, Scenario as Scenario, check_fit as check_fit, rigid_probe as rigid_probe
from .design import table2 as table2
from .hybrid import HybridSystem as HybridSystem, Linearisation as Linearisation
from .paths import get as get, paths as paths, replace as replace, unit as unit
