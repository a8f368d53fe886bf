"""Mechanisms built from bodies, joints, force elements and contacts."""

from .capture import CaptureMechanism as CaptureMechanism
from .design import Design as Design
from .design import Scenario as Scenario
from .design import check_fit as check_fit
from .design import rigid_probe as rigid_probe
from .design import table2 as table2
from .hybrid import HybridSystem as HybridSystem
from .hybrid import Linearisation as Linearisation
from .label import scenario_label as scenario_label
from .paths import get as get
from .paths import paths as paths
from .paths import replace as replace
from .paths import unit as unit
