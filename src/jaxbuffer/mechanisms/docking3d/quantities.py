"""The catalogue of quantities of a docking in space: the plane's, and what is a size or new there."""

from ..probe_cone.parts.bending import BENDING
from ..probe_cone.parts.hinge_play import HINGE_PLAY
from ..probe_cone.parts.lockout import LOCKOUT
from ..probe_cone.quantities import QUANTITIES as PLANAR
from ..quantity import Quantity

# Parts that a design in space does not have.
OF_THE_PLANE = {name for part in (BENDING, HINGE_PLAY, LOCKOUT) for name in part.quantities}

QUANTITIES: dict[str, Quantity] = {
    **{name: quantity for name, quantity in PLANAR.items() if name not in OF_THE_PLANE},
    "peak_force": PLANAR["peak_force"]._replace(description="largest contact force of the cone"),
    "hinge_angle": PLANAR["hinge_angle"]._replace(
        description="largest √(α² + β²) of the universal joint between cylinder and active vehicle"
    ),
    "contact_time": PLANAR["contact_time"]._replace(description="time during which the cone is touched"),
    "lateral_miss": PLANAR["lateral_miss"]._replace(
        description="distance of the tip from the cone's axis where it crosses the capture plane", signed=False
    ),
    "attitude_miss": PLANAR["attitude_miss"]._replace(
        description="angle of the rotation from the cone to the probe there, roll included", signed=False
    ),
    "swing_miss": Quantity(
        "rad",
        lambda c: c.docking.swing_miss,
        "angle between the probe's axis and the cone's where the tip crosses the capture plane",
        "swing miss",
    ),
    "swing_miss_rate": Quantity(
        "rad/s",
        lambda c: c.docking.swing_miss_rate,
        "how fast that changes there",
        signed=True,
    ),
}
