"""The docking in space, as everything else knows it."""

import dataclasses
from typing import Any

from ..assembled import Assembled
from ..probe_cone.mechanism import PROBE_CONE
from ..probe_cone.outcome import Outcome
from ..probe_cone.reading import reader
from ..probe_cone.scaled import VehiclesToDock
from ..probe_cone.solved import capture_of
from ..registry import register
from ..sizing import Sizing
from .assembly import assemble
from .capture import Capture3D
from .design import Design3D, Scenario3D, check_fit, valid
from .misses import misses
from .quantities import QUANTITIES
from .scaled import scaled_study
from .view import VIEW


def capture(mechanism: Assembled, solved: Any) -> Capture3D:
    """Return what was solved, as a capture."""
    return capture_of(Capture3D, mechanism, solved)


DOCKING3D = register(
    dataclasses.replace(
        PROBE_CONE,
        name="docking3d",
        design=Design3D,
        scenario=Scenario3D,
        quantities=QUANTITIES,
        system=assemble,
        outcomes=Outcome,
        check_fit=check_fit,
        valid=valid,
        run=capture,
        reader=reader(misses),
        sizing=Sizing(VehiclesToDock, scaled_study),
        view=VIEW,
        defaults=dataclasses.replace(
            PROBE_CONE.defaults,
            grid={
                "scenario.approach_speed": {"from": 0.05, "to": 0.25, "count": 11},  # m/s
                "scenario.passive_pitch": {"from": -0.1, "to": 0.1, "count": 11},  # rad
            },
        ),
    )
)
