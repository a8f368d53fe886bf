"""The catalogue of a drop's quantities."""

import operator

from ..quantity import CONTACT_TIME, END_TIME, PEAK_FORCE, PEAK_TIME, PENETRATION, Quantity
from .outcome import FORMS

QUANTITIES: dict[str, Quantity] = {
    "peak_force": PEAK_FORCE._replace(description="largest force of the cushion on the slider"),
    "peak_time": PEAK_TIME,
    "wall_mass": Quantity(
        "kg",
        lambda run: run.wall_mass,
        "mass of the wall, the ribs and the plates, without the tank's ends",
        "wall mass",
        swept=True,
        tuned=True,
    ),
    "reserve": Quantity(
        "-",
        lambda run: run.reserve,
        "yield stress over the largest stress after von Mises, or the plies' least reserve factor; below 1 one failed",
        "reserve factor",
        swept=True,
        tuned=True,
    ),
    "peak_stress": Quantity(
        "Pa",
        lambda run: run.peak_stress,
        "largest stress after von Mises on the faces of the wall",
        "peak stress",
        swept=True,
        tuned=True,
        shown=("MPa", 1e-6),
    ),
    "smooth_stress": Quantity(
        "Pa",
        lambda run: run.smooth_stress,
        "smooth maximum of the stress over wall and time, below the largest",
        "smooth peak stress",
        tuned=True,
        shown=("MPa", 1e-6),
    ),
    "plastic_strain": Quantity(
        "-",
        lambda run: run.plastic_strain,
        "largest equivalent plastic strain",
        "plastic strain",
        swept=True,
        tuned=True,
    ),
    "plastic_work": Quantity(
        "J", lambda run: run.plastic_work, "energy that yielding took", "plastic work", swept=True, tuned=True
    ),
    "deflection": Quantity(
        "m",
        lambda run: run.deflection,
        "largest deflection of the middle of the top, downwards",
        "deflection of the top",
        swept=True,
        tuned=True,
    ),
    "travel": Quantity(
        "m", lambda run: run.travel, "how far the slider goes down", "travel of the slider", swept=True, tuned=True
    ),
    "penetration": PENETRATION._replace(
        description="how far the cushion is pressed together at most",
        title="penetration of the cushion",
    ),
    "compression": Quantity(
        "-",
        lambda run: run.compression,
        "largest compression of the cushion, over its thickness; solid from 0.8 on",
        "compression of the cushion",
        swept=True,
        tuned=True,
    ),
    "highest_pressure": Quantity(
        "Pa",
        lambda run: run.highest_pressure,
        "highest pressure of the liquid on the wall; it does not settle with the mesh",
        "highest pressure",
        swept=True,
        tuned=True,
        shown=("kPa", 1e-3),
    ),
    "lowest_pressure": Quantity(
        "Pa",
        lambda run: run.lowest_pressure,
        "lowest pressure of the liquid on the wall, over the atmosphere's",
        "lowest pressure",
        signed=True,
        swept=True,
        shown=("kPa", 1e-3),
    ),
    "impulse": Quantity("N s", lambda run: run.impulse, "impulse of the force on the slider", "impulse", swept=True),
    "rebound_speed": Quantity(
        "m/s",
        lambda run: run.rebound_speed,
        "speed of the slider at the end, upwards",
        "rebound speed",
        signed=True,
        swept=True,
        tuned=True,
    ),
    "slide": Quantity(
        "m",
        lambda run: run.slide,
        "how far the middle of the bottom has gone to the right at the end; 0 of half a section",
        "slide of the tank",
        signed=True,
        swept=True,
    ),
    **{
        f"{form}_time": Quantity(
            "s",
            operator.attrgetter(f"{form}_time"),
            f"when {what} for the first time; NaN if never",
            differentiable=False,
        )
        for form, what in FORMS.items()
    },
    "contact_time": CONTACT_TIME,
    "end_time": END_TIME,
}
