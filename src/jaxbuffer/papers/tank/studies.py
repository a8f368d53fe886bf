"""The paper's drop, and what its text says of contact methods and of cushions: cases as data."""

from ...fields import replace
from ...mechanisms.tank_drop.design import TankDrop, TankDropScenario
from ..study import Study, StudyCase

FULL = replace(TankDrop(), {"contents.kind": "full"})
BARE = replace(FULL, {"cushion.kind": "none"})
PAPERS = TankDropScenario(fill=1.0)  # 348 kg from 2.04 m
PARTLY_FILLED = TankDropScenario(fill=0.8)
HEIGHTS = (0.01, 0.1, 1.0)  # m
STIFFNESSES = (5e8, 5e9, 5e10)  # Pa/m, of an area
WHOLE, STRUCK = {"duration": 0.06}, {"duration": 0.02}  # s: until the slider is on its way up
ASSUMED = "dimensions, high-density polyethylene, walls of 5 mm, a cushion of 4 MPa/m and 150 mm"

STUDIES = (
    Study(
        "drop",
        "2-4",
        "348 kg from 2.04 m",
        "fill [-]",
        ASSUMED,
        (
            StudyCase("full", 1.0, FULL, PAPERS, WHOLE),
            StudyCase("80 %, air trapped", 0.8, replace(TankDrop(), {"contents.air": "trapped"}), PARTLY_FILLED, WHOLE),
            StudyCase("80 %, air open", 0.8, TankDrop(), PARTLY_FILLED, WHOLE),
        ),
    ),
    Study(
        "height",
        "-",
        "Height of the fall, full tank",
        "height [m]",
        f"{ASSUMED}; all heights but 2.04 m",
        (
            *(
                StudyCase(f"{h:g} m", h, FULL, TankDropScenario(height=h, fill=1.0), {"duration": 0.12})
                for h in HEIGHTS
            ),
            StudyCase("2.04 m", 2.04, FULL, PAPERS, {"duration": 0.12}),
        ),
    ),
    Study(
        "contact",
        "1",
        "The slider without a cushion, by three methods of contact",
        "method",
        "dimensions, material and walls as above; the method is that of slider and baffle alike",
        (
            StudyCase("defence node", 0.0, replace(BARE, {"support.method": "defence node"}), PAPERS, STRUCK),
            StudyCase("multiplier", 0.0, replace(BARE, {"support.method": "multiplier"}), PAPERS, STRUCK),
            *(
                StudyCase(f"penalty, {k:g} Pa/m", k, replace(BARE, {"support.stiffness": k}), PAPERS, STRUCK)
                for k in STIFFNESSES
            ),
        ),
    ),
)
