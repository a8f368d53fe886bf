"""A capture in space: the run of the docking in three dimensions."""

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import ClassVar

from jaxtyping import Array, Float

from ..impacts import Impacts
from ..probe_cone.capture import DOCKED_UNITS, Capture, Docking

MISSES_UNITS: Mapping[str, tuple[str, float]] = MappingProxyType(
    {"swing_miss": DOCKED_UNITS["attitude_miss"], "swing_miss_rate": DOCKED_UNITS["attitude_miss_rate"]}
)


class Docking3D(Docking):
    """Docking beyond the crossing of the capture plane, in space; scalars, NaN where a run has no such thing.

    Beside those of `Docking`, of which ``lateral_miss`` is the tip's distance from the cone's axis, and
    ``attitude_miss`` the angle of the rotation from the passive vehicle to the probe, roll included:

    - ``swing_miss`` [rad], ``swing_miss_rate`` [rad/s]: angle between the probe's axis and the cone's.
    """

    swing_miss: Float[Array, ""]
    swing_miss_rate: Float[Array, ""]

    @property
    def units(self) -> Mapping[str, tuple[str, float]]:
        return {**super().units, **MISSES_UNITS}

    def direction_text(self) -> str:
        swing, whole = (math.degrees(float(angle)) for angle in (self.swing_miss, self.attitude_miss))
        return f"probe {swing:.4g} deg against it, {whole:.4g} deg with its roll"

    def drift_text(self) -> str:
        speed = 1e3 * float(self.lateral_miss_rate)
        return f"moving {'away from' if speed > 0.0 else 'towards'} it at {abs(speed):.3g} mm/s"


class Capture3D(Capture):
    """A simulated capture in space: all that a `Capture` has. There is one contact, of the tip with the cone.

    - ``hinge_angle``: the largest √(α² + β²) of the universal joint [rad].
    - ``docking``: a `Docking3D`.

    **Example:** what works on captures works on it.

    >>> issubclass(jb.Capture3D, jb.Capture)
    True
    """

    docking_type: ClassVar[type[Docking]] = Docking3D
    impacts_type: ClassVar[type[Impacts]] = Impacts
    docking: Docking3D
