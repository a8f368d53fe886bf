"""Which runs of the slider-crank the paper's section 3 shows. Its k, e, c, d and torques are in N, mm and s."""

import math
from collections.abc import Mapping
from typing import Any

from ...fields import replace
from ...mechanisms.slider_crank import SliderCrank, SliderCrankScenario, published_slider_crank
from ...mechanisms.slider_crank.design import Rod
from ..study import Case, Study

SPEED = 10.0  # rad/s, ω_0
CYCLE = 2.0 * math.pi / SPEED  # s
REST = SliderCrankScenario(crank_speed=0.0)
OPTIONS = {"duration": 2.02 * CYCLE, "max_events": 4096}  # two cycles and the start
RIGID = (  # e [-], k [N/mm^e], M_0 [N mm]; the last is ours: the larger stiffness with the smaller torque
    (0.01, 1e4, 1e7),
    (0.1, 1e4, 1e7),
    (0.2, 1e4, 1e7),
    (0.2, 1e5, 1e8),
    (0.2, 1e5, 1e7),
)
BENDING = (0.1, 2e4, 1e5)
CONTACT = (1.5, 2e4, 1e5)  # ours: an exponent that a contact can have
MODES = (0, 2, 4)
BAR = Rod(depth=0.015)  # 15 mm by 15 mm of steel: about the default rod's mass and inertia
FIRST, LONGER = {"duration": 0.1, "max_events": 4096}, {"duration": 0.5, "max_events": 4096}


def published(exponent: float, stiffness: float, torque: float) -> SliderCrank:
    """A printed set. ``exponent``: e [-]; ``stiffness``: k [N/mm^e]; ``torque``: M_0 [N mm]."""
    return replace(published_slider_crank(exponent, stiffness), {"drive.torque": 1e-3 * torque})


def rods(exponent: float, stiffness: float, torque: float, options: Mapping[str, Any]) -> tuple[Case, ...]:
    """A rigid rod, and the same bar with modes."""
    design = published(exponent, stiffness, torque)
    rigid = {"rod.mass": BAR.body.mass, "rod.inertia": BAR.body.inertia}
    return tuple(
        Case(
            f"{n} modes" if n else "rigid",
            n,
            replace(design, {"rod.depth": BAR.depth, "rod.modes": n} if n else rigid),
            REST,
            options,
        )
        for n in MODES
    )


STUDIES = (
    Study(
        "crank",
        "30-33",
        "Slider-crank of rigid links with play in the piston pin",
        "force exponent e [-]",
        "lengths and masses of an engine, a crank of 5 kg and 0.01 kg m², the torque's sign, and the clearance of "
        "1.1 mm as the trigger distance on both sides of both components; y is read as across the slider's line, z as "
        "along it",
        tuple(
            Case(f"e = {e:g}, k = {k:.0e}, M₀ = {m:.0e}".replace("e+0", "e"), e, published(e, k, m), REST, OPTIONS)
            for e, k, m in RIGID
        ),
    ),
    Study(
        "crank_rod",
        "36-39",
        "The rod bends: e = 0.1, k = 2e4, M₀ = 1e5",
        "modes of the rod [-]",
        "the rod is a steel bar of 15 mm by 15 mm, 1 % damping of each mode, or the same bar rigid. Only the first "
        "0.1 s: later a rod of 2 modes rubs on a side in ever more and smaller impacts, 18 479 by 0.365 s, where the "
        "limit of 200 000 steps is reached and the run fails; with 4 modes two cycles fail likewise",
        rods(*BENDING, FIRST),
    ),
    Study(
        "crank_contact",
        "36-39",
        "The rod bends, with an exponent that a contact can have: e = 1.5",
        "modes of the rod [-]",
        "exponent and unit of k are ours: k = 2e4 N/mm^1.5 and all else as in the study before, over 0.5 s",
        rods(*CONTACT, LONGER),
    ),
)
