"""The catalogue of a slider-crank's quantities."""

from jaxtyping import Array, Float

from ..quantity import CONTACT_TIME, DISSIPATED, END_TIME, PEAK_FORCE, PEAK_TIME, PENETRATION, Quantity, largest
from ..run import Run


def deepest(run: Run) -> Float[Array, ""]:
    """Return the deepest penetration where it is watched [m], else the depth that the peak force bounds (M72)."""
    return run.maxima.get("penetration", run.penetration)


QUANTITIES: dict[str, Quantity] = {
    "peak_force": PEAK_FORCE,
    "peak_time": PEAK_TIME,
    "penetration": PENETRATION._replace(of=deepest),
    "contact_time": CONTACT_TIME,
    "contact_share": Quantity(
        "-",
        lambda run: run.contact_time / run.end_time,
        "share of the time in which a pin touches its bush",
        "share of contact",
        swept=True,
        tuned=True,
    ),
    "drive_torque": Quantity(
        "N m",
        lambda run: run.maxima["drive_torque"],
        "largest torque of the drive",
        "largest drive torque",
        signed=True,
        swept=True,
        tuned=True,
    ),
    "torque_ripple": Quantity(
        "N m",
        # The least torque is minus the largest braking torque.
        lambda run: run.maxima["drive_torque"] + run.maxima["braking_torque"],
        "largest less least torque of the drive",
        "torque ripple",
        swept=True,
        tuned=True,
    ),
    "slider_acceleration": Quantity(
        "m/s²",
        lambda run: run.maxima["slider_acceleration"],
        "largest size of the slider's acceleration",
        "slider acceleration",
        swept=True,
        tuned=True,
    ),
    "rod_deflection": Quantity(
        "m",
        largest("rod_deflection"),
        "largest deflection of the rod's middle off the line through its ends, 0 for a rigid rod",
        "rod deflection",
        swept=True,
        tuned=True,
        shown=("µm", 1e6),
        part="rod.modes",
    ),
    "rod_stress": Quantity(
        "Pa",
        largest("rod_stress"),
        "largest stress along the rod on the surface of its middle, of bending (of a shape, in all), 0 for a rigid rod",
        "rod stress",
        swept=True,
        tuned=True,
        shown=("MPa", 1e-6),
        part="rod.modes",
    ),
    "slider_deflection": Quantity(
        "m",
        largest("slider_deflection"),
        "largest displacement of the piston pin against the slider's guide, along its line, 0 for a rigid slider",
        "slider deflection",
        swept=True,
        tuned=True,
        shown=("µm", 1e6),
        part="slider.modes",
    ),
    "end_time": END_TIME,
    "dissipated": DISSIPATED,
}
