"""The bar dropped on a plate, as everything else knows it."""

from ...contact import law_class
from ...errors import InputError
from ...fields import replace
from ..mechanism import Defaults, Mechanism
from ..registry import register
from .assembly import bar_drop
from .design import BarDrop, BarDropScenario, check_fit, valid
from .quantities import QUANTITIES
from .run import READER, dropped
from .view import VIEW

MEMORY_TIME = 2e-4  # s, a hundredth of the time between two of its impacts


def smooth(design: BarDrop, scenario: BarDropScenario) -> BarDrop:
    """Return the design with a memory of the touchdown's speed that follows by itself, so that it needs no events."""
    if law_class(design.impact.law).jumps:
        raise InputError(
            f"impact.law = {design.impact.law!r}: its force jumps at touchdown, which takes events; take another law, "
            "or a solver with events: automatic, implicit or explicit"
        )
    return design if design.impact.memory_time is not None else replace(design, {"impact.memory_time": MEMORY_TIME})


BAR_DROP = register(
    Mechanism(
        name="bar_drop",
        design=BarDrop,
        scenario=BarDropScenario,
        quantities=QUANTITIES,
        system=bar_drop,
        check_fit=check_fit,
        valid=valid,
        run=dropped,
        reader=READER,
        smooth=smooth,
        view=VIEW,
        defaults=Defaults(
            duration=0.3,
            parameters=("impact.stiffness", "impact.damping", "impact.ramp_depth", "impact.exponent", "bar.density"),
            differentiated=("peak_force", "penetration", "contact_time"),
            grid={"scenario.height": {"from": 0.02, "to": 0.2, "count": 10}},  # m
            mapped=("peak_force", "penetration", "rebound_height", "restitution"),
            variables={
                "impact.stiffness": [1e10, 1e12],  # N/m^e
                "impact.damping": [1.0, 6000.0],  # N s/m
                "impact.ramp_depth": [1e-6, 1e-4],  # m
                "impact.exponent": [1.5, 2.5],  # -
            },
            limits={"penetration": 2e-4},  # m, a tenth of the ball's radius
        ),
    )
)
