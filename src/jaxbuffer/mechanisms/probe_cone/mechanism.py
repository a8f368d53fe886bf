"""The probe-cone mechanism, as everything else knows it."""

from ...fields import replace
from ..mechanism import Defaults, Floor, Mechanism, TuningRules
from ..registry import register
from .closed_form import first_impact
from .design import Design, Scenario, check_fit, valid
from .outcome import Outcome
from .problem import check_problem
from .quantities import QUANTITIES
from .solved import capture
from .system import CaptureMechanism
from .view import VIEW

PROBE_CONE = register(
    Mechanism(
        name="probe_cone",
        design=Design,
        scenario=Scenario,
        quantities=QUANTITIES,
        system=CaptureMechanism,
        outcomes=Outcome,
        success="captured",
        check_fit=check_fit,
        valid=valid,
        run=capture,
        view=VIEW,
        tuning=TuningRules(
            always={"stroke_share": 1.0},  # no buffer may come to its end
            check_problem=check_problem,
            margin="capture_share",
            floor=Floor(first_impact, ("buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T")),
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
            variables={
                "buffer.k_A": [100.0, 2000.0],  # N/m
                "buffer.c_A": [1.0, 60.0],  # N s/m
                "buffer.k_T": [50.0, 1500.0],  # N m/rad
                "buffer.c_T": [0.2, 20.0],  # N m s/rad
                "probe.tip_mass": [0.02, 0.2],  # kg
            },
            limits={"stroke": 0.025},  # m, what fits into Table 2's cylinder
        ),
        smooth=lambda design: replace(design, {"contact.memory": "smooth"}),
    )
)
