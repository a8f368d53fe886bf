"""A docking in space for two vehicles to begin with: the plane's, with roll, and a miss aside of the attitude's
plane."""

import math
from collections.abc import Iterator
from typing import Any

from ..probe_cone.parts import ROD_RADIUS
from ..probe_cone.scaled import MISS, Scale, VehiclesToDock, scale_of, study_of, vehicles
from ..sizing import ScaledNumber, ScaledStudy

ROLL = 0.45  # of the inertia about the other axes, as of both vehicles of `docking3d`
TURNED = 0.1  # of the attitude, by which the vehicle turns while it goes on by the cone's miss


def scaled_study(task: VehiclesToDock) -> ScaledStudy:
    """Return a study of a docking in space until held, scaled from its vehicles.

    The cone is one of revolution, so that only the angle between the miss and the attitude matters: load cases have
    45 and 135 degrees. The worst, with both in one plane, differ from these by some per cent.
    """
    scale, start, rules = scale_of(task), dict[str, Any](), dict[str, str]()
    if task.miss > 0.0:
        aside = float(task.miss) / math.sqrt(2.0)
        start |= {"offset_y": aside, "offset_z": aside}
        rules |= dict.fromkeys(start, "1/√2 of the miss")
    if task.attitude > 0.0:
        rate = TURNED * float(task.attitude) * float(task.slowest) / (MISS * scale.length)
        start["active_yaw"] = float(task.attitude)
        turning = f"{TURNED:g} of the attitude while the slow approach goes on by {1e3 * MISS:g} mm × λ"
        for name, about in (("active_rate_x", "roll"), ("active_rate_z", "yaw")):
            start[name], rules[name] = rate, f"{about}, {turning}"
    return study_of(task, scale, start, "offset_y", rules, _of_space(task, scale))


def _of_space(task: VehiclesToDock, scale: Scale) -> Iterator[ScaledNumber]:
    """Yield the numbers that the plane's design has not."""
    for it in vehicles(task):
        if it.path.endswith(".inertia"):
            roll = it.path.replace("inertia", "roll_inertia")
            yield ScaledNumber(roll, ROLL * it.value, (0.5, 3.0), f"take your own; here {ROLL:g} of the other inertia")
    yield ScaledNumber("probe.rod_radius", ROD_RADIUS * scale.length, (0.5, 1.5), "with λ")
