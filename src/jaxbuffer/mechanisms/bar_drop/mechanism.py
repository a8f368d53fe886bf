"""The bar dropped on a plate, as everything else knows it."""

from ...contact.laws import LAWS, HystereticLaw
from ...errors import InputError
from ..mechanism import Defaults, Mechanism
from ..registry import register
from .design import BarDrop, BarDropScenario, check_fit, valid
from .quantities import QUANTITIES
from .run import dropped
from .system import bar_drop
from .view import VIEW


def smooth(design: BarDrop) -> BarDrop:
    """The design itself, if its law knows no speed of the last touchdown: then it needs no events."""
    if issubclass(LAWS[design.impact.law], HystereticLaw) and design.impact.law != "hertz":
        raise InputError(
            f"impact.law = {design.impact.law!r} needs events, which diffrax.diffeqsolve has not; "
            "take 'adams' or 'hertz', or another solver"
        )
    return design


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
