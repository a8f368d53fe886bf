"""The slider-crank, as everything else knows it."""

from ..mechanism import Defaults, Mechanism, Names
from ..registry import register
from .design import SliderCrank, SliderCrankScenario, check_fit, valid
from .drawing import drawing
from .picture import panels
from .quantities import QUANTITIES
from .summary import label, summary, validity, warnings
from .system import slider_crank

SIDES = ("right of piston", "left of piston", "above piston", "below piston")
OTHERS = {"drive_torque": "N m", "braking_torque": "N m", "slider_acceleration": "m/s²"}


def names(design: SliderCrank) -> Names:
    """What the contacts of a design are called, in order, and its observables."""
    contacts: tuple[str, ...] = ()
    if design.piston_pin.joint == "clearance":
        contacts += SIDES if design.piston_pin.by_components else ("piston",)
    if design.crank_pin.joint == "clearance":
        contacts += ("crank",)
    pins = [pin for pin in (design.piston_pin, design.crank_pin) if pin.joint == "clearance"]
    places = {f"{pin.section}_{axis}": "m" for pin in pins for axis in ("x", "y")}
    depth = {"penetration": "m"} if design.piston_pin.by_components else {}
    bending = {"rod_deflection": "m", "rod_stress": "Pa"} if design.rod.modes else {}
    return Names(bodies=("crank", "rod", "slider"), contacts=contacts, others=OTHERS | depth | bending | places)


SLIDER_CRANK = register(
    Mechanism(
        name="slider_crank",
        title="Slider-crank",
        design=SliderCrank,
        scenario=SliderCrankScenario,
        quantities=QUANTITIES,
        system=slider_crank,
        check_fit=check_fit,
        valid=valid,
        summary=summary,
        label=label,
        approach=label,
        leaves_out=(
            "The motion is planar: nothing moves or turns out of the plane.",
            "The forces have not been compared with a measurement: docs/verification.md.",
        ),
        warnings=warnings,
        validity=validity,
        panels=panels,
        drawing=drawing,
        names=names,
        contact="pin",
        chaotic=True,
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
