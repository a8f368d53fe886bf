"""The probe-cone mechanism, as everything else knows it."""

from ...errors import InputError
from ...fields import replace
from ..mechanism import Defaults, LowerBound, Mechanism, RequiredEnd, TuningRules
from ..registry import register
from .assembly import assemble
from .closed_form import first_impact, first_impact_elasticities
from .design import Design, Scenario, check_fit, valid
from .outcome import Outcome
from .problem import check_problem, left_open, unfinished
from .quantities import QUANTITIES
from .reading import READER
from .solved import capture
from .view import VIEW

COMPLIANT_PARTS = ("k_A", "c_A", "k_T", "c_T", "spring_curve", "damper_curve", "preload", "c_A2", "friction")

LATCHED = {  # defaults of designs with a latch: how hard it is held, and how long until it is at rest
    "duration": 20.0,
    "success": "latched",  # at the end, whether at rest together or not yet
    "differentiated": ("peak_force", "peak_hinge_force", "stroke", "hinge_angle", "peak_latch_force", "end_time"),
    "mapped": ("peak_force", "stroke", "hinge_angle", "peak_latch_force", "settling_time", "relative_energy"),
}


def smooth(design: Design, scenario: Scenario) -> Design:
    """Return the design with the contact law that needs no events. **Raises:** `InputError` for what does: a latch,
    whose closing begins at one, and a thrust, which ends at one."""
    for part, number in ((design.latch, "stiffness"), (scenario, "thrust")):
        if part.has(number):
            raise InputError(
                f"{part.section}.{number} is given, which diffrax.diffeqsolve cannot solve: it locates no events on the"
                " way; leave it out, or take a solver with events: automatic, implicit or explicit"
            )
    return replace(design, {"contact.memory": "smooth"})


PROBE_CONE = register(
    Mechanism(
        name="probe_cone",
        design=Design,
        scenario=Scenario,
        quantities=QUANTITIES,
        system=assemble,
        outcomes=Outcome,
        successes=("captured", "held", "latched"),
        check_fit=check_fit,
        valid=valid,
        run=capture,
        reader=READER,
        view=VIEW,
        tuning=TuningRules(
            # No buffer may come to its end, and no latch may tear.
            always={"stroke_share": 1.0, "latch_share": 1.0},
            check_problem=check_problem,
            margin="capture_share",
            ends=(
                RequiredEnd("latched", ("latched", "held"), "latch.stiffness"),
                RequiredEnd("held", ("held",), "latch.stiffness", "relative_energy", "latch.quiet"),
            ),
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
            with_part={"latch.stiffness": LATCHED},
            variables={
                "buffer.k_A": [100.0, 2000.0],  # N/m
                "buffer.c_A": [1.0, 60.0],  # N s/m
                "buffer.k_T": [50.0, 1500.0],  # N m/rad
                "buffer.c_T": [0.2, 20.0],  # N m s/rad
                "probe.tip_mass": [0.02, 0.2],  # kg
            },
            limits={"stroke": 0.025},  # m, what fits into Table 2's cylinder
            example={"latch.stiffness": 2000.0, "latch.damping": 50.0, "latch.strength": 50.0},  # N/m, N s/m, N
            example_limits={"relative_energy": 0.05},  # at most a twentieth is left after the 20 s
        ),
        smooth=smooth,
    )
)
