"""The catalogue of a drop's quantities."""

from ..quantity import CONTACT_TIME, DISSIPATED, END_TIME, PEAK_FORCE, PEAK_TIME, PENETRATION, Quantity, largest

QUANTITIES: dict[str, Quantity] = {
    "peak_force": PEAK_FORCE,
    "peak_time": PEAK_TIME,
    "penetration": PENETRATION._replace(
        of=lambda run: run.maxima["penetration"], description="deepest penetration of the plate", tuned=True
    ),
    "rebound_height": Quantity(
        "m",
        lambda run: run.rebound_height,
        "height to which the ball end rises after its first release, 0 without one",
        "rebound height",
        swept=True,
        tuned=True,
    ),
    "restitution": Quantity(
        "-",
        lambda run: run.restitution,
        "speed of the first release over that of the first touchdown",
        "delivered restitution",
        swept=True,
    ),
    "plate_deflection": Quantity(
        "m",
        largest("plate_deflection"),
        "largest deflection of the plate under the ball, 0 for a rigid plate",
        "plate deflection",
        swept=True,
        tuned=True,
        shown=("µm", 1e6),
        part="plate.modes",
    ),
    "bar_deflection": Quantity(
        "m",
        largest("bar_deflection"),
        "largest deflection of the bar's middle from the line between its ends, 0 for a rigid bar",
        "bar deflection",
        swept=True,
        tuned=True,
        shown=("µm", 1e6),
        part="bar.modes",
    ),
    "contact_time": CONTACT_TIME._replace(description="time on the plate", tuned=True),
    "end_time": END_TIME,
    "dissipated": DISSIPATED,
}
