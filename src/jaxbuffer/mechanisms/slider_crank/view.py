"""What is told of a slider-crank and drawn of its runs."""

from ..view import Names, View
from .design import SliderCrank
from .drawing import drawing
from .picture import panels
from .summary import label, summary, validity, warnings

OTHERS = {"drive_torque": "N m", "braking_torque": "N m", "slider_acceleration": "m/s²"}


def names(design: SliderCrank) -> Names:
    """Return what the contacts of a design are called, in order, and its observables."""
    # In the order in which `slider_crank` puts them together.
    contacts = (*design.piston_pin.contacts, *design.crank_pin.contacts)
    pins = [pin for pin in (design.piston_pin, design.crank_pin) if pin.joint == "clearance"]
    places = {f"{pin.section}_{axis}": "m" for pin in pins for axis in ("x", "y")}
    depth = {"penetration": "m"} if design.piston_pin.by_components else {}
    bending = {"rod_deflection": "m", "rod_stress": "Pa"} if design.rod.modes else {}
    if design.slider.modes:
        bending["slider_deflection"] = "m"
    return Names(bodies=("crank", "rod", "slider"), contacts=contacts, others=OTHERS | depth | bending | places)


VIEW = View(
    title="Slider-crank",
    contact="pin",
    names=names,
    label=label,
    approach=label,
    summary=summary,
    limitations=(
        "The motion is planar: nothing moves or turns out of the plane.",
        "The forces have not been compared with a measurement: docs/verification.md.",
    ),
    warnings=warnings,
    validity=validity,
    chaotic=True,
    panels=panels,
    drawing=drawing,
)
