"""The probe-cone mechanism, as everything else knows it."""

from collections.abc import Iterable, Mapping
from typing import Any

from ...errors import InputError
from ...fields import replace
from ..mechanism import Defaults, LowerBound, Mechanism, TuningRules
from ..registry import register
from ..sizing import Sizing
from .assembly import assemble
from .closed_form import first_impact, first_impact_elasticities
from .design import Design, Scenario, check_fit, valid
from .outcome import SUCCESSES, Outcome
from .parts import PARTS, parts_of
from .problem import check_problem, left_open, unfinished
from .quantities import QUANTITIES
from .reading import READER
from .scaled import VehiclesToDock, scaled_study
from .sized.docking import SIZER
from .solved import capture
from .view import VIEW

COMPLIANT_PARTS = ("k_A", "c_A", "k_T", "c_T", "spring_curve", "damper_curve", "preload", "c_A2", "friction")


def smooth(design: Design, scenario: Scenario) -> Design:
    """Return the design with the contact law that needs no events. **Raises:** `InputError` for a part that does."""
    for part in parts_of(design, scenario):
        if part.has_events:
            raise InputError(
                f"{part.path} is given, which diffrax.diffeqsolve cannot solve: it locates no events on the"
                " way; leave it out, or take a solver with events: automatic, implicit or explicit"
            )
    return replace(design, {"contact.memory": "smooth"})


def _joined(of_parts: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what parts say, by name, in one."""
    return {name: value for numbers in of_parts for name, value in numbers.items()}


PROBE_CONE = register(
    Mechanism(
        name="probe_cone",
        design=Design,
        scenario=Scenario,
        quantities=QUANTITIES,
        system=assemble,
        outcomes=Outcome,
        successes=SUCCESSES,
        check_fit=check_fit,
        valid=valid,
        run=capture,
        reader=READER,
        view=VIEW,
        sizing=Sizing(VehiclesToDock, scaled_study),
        sizer=SIZER,
        tuning=TuningRules(
            # No buffer may come to its end.
            always={"stroke_share": 1.0} | _joined(part.always for part in PARTS),
            check_problem=check_problem,
            margin="capture_share",
            ends=tuple(end for part in PARTS for end in part.ends),
            unfinished=unfinished,
            left_open=left_open,
            lower_bound=LowerBound(
                first_impact,
                tuple(f"buffer.{name}" for name in COMPLIANT_PARTS),
                first_impact_elasticities,
                ("peak_hinge_force", "peak_vehicle_force", "peak_active_acceleration"),
            ),
        ),
        defaults=Defaults(
            duration=8.0,
            parameters=("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T", "probe.tip_mass"),
            differentiated=("peak_force", "peak_hinge_force", "stroke", "hinge_angle", "end_time"),
            grid={
                "scenario.approach_speed": {"from": 0.05, "to": 0.25, "count": 11},  # m/s
                "scenario.misalignment": {"from": -0.1, "to": 0.1, "count": 11},  # rad
            },
            mapped=("peak_force", "peak_hinge_force", "stroke", "hinge_angle"),
            with_part={part.path: part.defaults for part in PARTS if part.defaults},
            variables={
                "buffer.k_A": [100.0, 2000.0],  # N/m
                "buffer.c_A": [1.0, 60.0],  # N s/m
                "buffer.k_T": [50.0, 1500.0],  # N m/rad
                "buffer.c_T": [0.2, 20.0],  # N m s/rad
                "probe.tip_mass": [0.02, 0.2],  # kg
            },
            pushed=("active", "passive"),
            limits={"stroke": 0.025},  # m, what fits into Table 2's cylinder
            example=_joined(part.example for part in PARTS),
            example_variables=_joined(part.example_variables for part in PARTS),
            example_limits=_joined(part.example_limits for part in PARTS),
        ),
        smooth=smooth,
    )
)
