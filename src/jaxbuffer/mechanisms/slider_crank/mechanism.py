"""The slider-crank, as everything else knows it."""

from ...fields import replace
from ..mechanism import Defaults, Mechanism
from ..registry import register
from .assembly import slider_crank
from .design import SliderCrank, SliderCrankScenario, check_fit, valid
from .quantities import QUANTITIES
from .view import VIEW

MEMORY_TIME = 1e-6  # s: bounces follow each other within 1e-4 s


def smooth(design: SliderCrank, scenario: SliderCrankScenario) -> SliderCrank:
    """Return the design with pins whose memory of the touchdown's speed follows by itself, so that they need no
    events."""
    if design.piston_pin.memory_time is not None:
        return design
    return replace(design, {"piston_pin.memory_time": MEMORY_TIME})


SLIDER_CRANK = register(
    Mechanism(
        name="slider_crank",
        design=SliderCrank,
        scenario=SliderCrankScenario,
        quantities=QUANTITIES,
        system=slider_crank,
        check_fit=check_fit,
        valid=valid,
        smooth=smooth,
        view=VIEW,
        defaults=Defaults(
            duration=0.012,
            parameters=("piston_pin.clearance", "slider.mass", "piston_pin.restitution"),
            differentiated=("impact.1.peak_force", "impact.2.peak_force", "impact.3.peak_force"),
            grid={"piston_pin.clearance": {"from": 1e-4, "to": 1e-3, "count": 10}},  # m
            mapped=("peak_force", "slider_acceleration", "drive_torque", "contact_share"),
            variables={"piston_pin.clearance": [5e-5, 5e-4], "slider.mass": [0.05, 0.5]},  # m, kg
        ),
    )
)
