"""What is told of a capture and drawn of it."""

from ...labelled.record import amounts
from ..view import Names, View
from .assembly import CONTACTS
from .contradictions import contradictions
from .design import Design
from .diagnosis import diagnosis
from .drawing import drawing
from .label import scenario_label
from .law_validity import limits, warnings
from .panels import panels
from .parts import PARTS
from .parts.vehicles import OTHER_NAMES
from .sanity_checks import sanity_checks
from .summary import first_impact_line, summary
from .vehicle_forces import larger_than_contact


def names(design: Design) -> Names:
    """Return what the parts of a design are called; a hinge with play has no rows."""
    hinge = {} if design.hinge.has("play") else {"hinge x": "N", "hinge y": "N"}
    return Names(
        bodies=("active", "cylinder", "probe", "passive"),
        contacts=CONTACTS,
        # Multipliers are named by their places, in the order of the joints' rows (M15).
        multipliers={**hinge, "prismatic moment": "N m", "prismatic force": "N"},
        others={
            "tip_spin": "rad/s",
            "hinge_force": "N",
            "buffer_force": "N",
            "stroke": "m",
            "hinge_angle": "rad",
            "throat_distance": "m",
            "relative_energy": "J",
            "passive_force": "N",
            **{name: unit for part in PARTS for name, unit in part.recorded.items()},
        },
        shares={"relative_energy": "energy_left"},
    )


CLOSED_FORM = {"effective_mass": "kg", "effective_energy": "J", "elastic_peak": "N", "predicted_peak": "N"}

VIEW = View(
    title="Capture",
    synonyms=OTHER_NAMES,
    run_name="capture",
    contact="flank",
    names=names,
    label=scenario_label,
    approach=lambda scenario: f"approach at {scenario_label(scenario)}",
    summary=summary,
    record=lambda run: {"first_impact": amounts(CLOSED_FORM, [getattr(run.first_impact, it) for it in CLOSED_FORM])},
    notes=lambda run: [first_impact_line(run)],
    diagnosis=diagnosis,
    sanity_checks=sanity_checks,
    contradictions=contradictions,
    largest=lambda design: {"stroke": float(design.buffer.longest_stroke)},
    larger_force=larger_than_contact,
    limitations=(
        "The motion is planar: nothing moves or turns out of the plane.",
        "The forces have not been compared with a test of hardware: docs/verification.md.",
    ),
    limitations_without=tuple((part.path, part.limitation) for part in PARTS if part.limitation),
    warnings=warnings,
    validity=limits,
    panels=panels,
    drawing=drawing,
)
