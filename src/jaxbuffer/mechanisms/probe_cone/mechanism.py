"""The probe-cone mechanism, as everything else knows it."""

from ...fields import replace
from ..mechanism import Defaults, Floor, Mechanism, Names
from ..registry import register
from .closed_form import first_impact
from .design import Design, Scenario, check_fit, valid
from .diagnosis import diagnosis
from .drawing import drawing
from .label import scenario_label
from .law_validity import limits, warnings
from .outcome import Outcome
from .panels import panels
from .problem import check_problem
from .quantities import QUANTITIES
from .solved import capture
from .summary import first_impact_line, first_impact_record, summary
from .system import CONTACTS, ENDS, CaptureMechanism


def names(design: Design) -> Names:
    """What the parts of a design are called; a hinge with play has no rows."""
    hinge = {} if design.hinge.play is not None else {"hinge x": "N", "hinge y": "N"}
    return Names(
        bodies=("active", "cylinder", "probe", "passive"),
        contacts=CONTACTS,
        multipliers={**hinge, "prismatic moment": "N m", "prismatic force": "N"},
        others={
            "tip_spin": "rad/s",
            "hinge_force": "N",
            "buffer_force": "N",
            "stop_force": "N",
            "stroke": "m",
            "hinge_angle": "rad",
            "throat_distance": "m",
            "hinge_gap": "m",
            "bending": "m",
        },
    )


PROBE_CONE = register(
    Mechanism(
        name="probe_cone",
        title="Capture",
        design=Design,
        scenario=Scenario,
        quantities=QUANTITIES,
        system=CaptureMechanism,
        outcomes=Outcome,
        ends=ENDS,
        time_is_up="timeout",
        success="captured",
        run_name="capture",
        check_fit=check_fit,
        valid=valid,
        run=capture,
        summary=summary,
        label=scenario_label,
        approach=lambda scenario: f"approach at {scenario_label(scenario)}",
        leaves_out=(
            "The motion is planar: nothing moves or turns out of the plane.",
            "The run ends at capture: what the parts do afterwards is not simulated.",
            "The forces have not been compared with a test of hardware: docs/verification.md.",
        ),
        warnings=warnings,
        validity=limits,
        notes=lambda run: [first_impact_line(run)],
        diagnosis=diagnosis,
        panels=panels,
        drawing=drawing,
        record=lambda run: {"first_impact": first_impact_record(run)},
        names=names,
        contact="flank",
        defaults=Defaults(
            duration=8.0,
            parameters=("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T", "probe.tip_mass"),
            differentiated=("peak_force", "peak_hinge_force", "stroke", "hinge_angle", "end_time"),
            grid={
                "scenario.approach_speed": {"from": 0.05, "to": 0.25, "count": 11},  # m/s
                "scenario.misalignment": {"from": -0.1, "to": 0.1, "count": 11},  # rad
            },
            mapped=("peak_force", "peak_hinge_force", "stroke", "hinge_angle"),
            variables={
                "buffer.k_A": [100.0, 2000.0],  # N/m
                "buffer.c_A": [1.0, 60.0],  # N s/m
                "buffer.k_T": [50.0, 1500.0],  # N m/rad
                "buffer.c_T": [0.2, 20.0],  # N m s/rad
                "probe.tip_mass": [0.02, 0.2],  # kg
            },
            limits={"stroke": 0.025},  # m, what fits into Table 2's cylinder
        ),
        always={"stroke_share": 1.0},  # no buffer may come to its end
        check_problem=check_problem,
        smooth=lambda design: replace(design, {"contact.memory": "smooth"}),
        margin="capture_share",
        floor=Floor(first_impact, ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T")),
    )
)
