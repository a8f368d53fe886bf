"""The drop onto a tank, as everything else knows it."""

from ...structures.contact import SOLID
from ..mechanism import Defaults, Mechanism
from ..registry import register
from .design import ZONES, TankDrop, TankDropScenario, check_fit, valid
from .outcome import TankOutcome
from .quantities import QUANTITIES
from .stepper import ExplicitElements
from .view import VIEW

TANK_DROP = register(
    Mechanism(
        name="tank_drop",
        design=TankDrop,
        scenario=TankDropScenario,
        quantities=QUANTITIES,
        stepper=ExplicitElements(),
        outcomes=TankOutcome,
        successes=("whole",),
        check_fit=check_fit,
        valid=valid,
        view=VIEW,
        defaults=Defaults(
            duration=0.08,
            parameters=(*(f"wall.{zone}" for zone in ZONES), "cushion.stiffness", "cushion.damping"),
            differentiated=("peak_force", "peak_stress", "deflection"),
            grid={"scenario.height": {"from": 0.1, "to": 2.0, "count": 5}},  # m
            mapped=("peak_force", "reserve", "deflection", "plastic_strain"),
            variables={
                "cushion.stiffness": [1e5, 2e7],  # Pa/m
                "cushion.damping": [1e2, 1e5],  # Pa s/m
            },
            limits={"compression": SOLID},
        ),
    )
)
