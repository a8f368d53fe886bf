"""Which runs of the slider-crank the paper's section 3 shows. Its k, e, c, d and torques are in N, mm and s."""

import math
from collections.abc import Mapping
from typing import Any

from ...fields import replace
from ...mechanisms.slider_crank import SliderCrank, SliderCrankScenario, published_slider_crank
from ...mechanisms.slider_crank.design import Rod
from ..study import Study, StudyCase

SPEED = 10.0  # rad/s, ω_0
CYCLE = 2.0 * math.pi / SPEED  # s
REST = SliderCrankScenario(crank_speed=0.0)
LIMITS = {"max_events": 4096, "max_steps": 1_000_000, "history": 100_000}  # one program for all
OPTIONS = {"duration": 2.02 * CYCLE, **LIMITS}  # two cycles and the start
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
FIRST, LONGER = {"duration": 0.1, **LIMITS}, {"duration": 0.5, **LIMITS}


def published(exponent: float, stiffness: float, torque: float) -> SliderCrank:
    """Return a printed set. ``exponent``: e [-]; ``stiffness``: k [N/mm^e]; ``torque``: M_0 [N mm]."""
    return replace(published_slider_crank(exponent, stiffness), {"drive.torque": 1e-3 * torque})


def rods(
    exponent: float,
    stiffness: float,
    torque: float,
    options: Mapping[str, Any],
    onset: float = 1e-8,
    ratio: float = 0.01,
) -> tuple[StudyCase, ...]:
    """Return a rigid rod, and the same bar with modes of a damping ``ratio``; the spring comes in over ``onset``
    [m]."""
    design = replace(published(exponent, stiffness, torque), {"piston_pin.onset_depth": onset})
    # The same mass and inertia, so that bending is all that differs.
    rigid = {"rod.mass": BAR.body.mass, "rod.inertia": BAR.body.inertia}
    bends = {"rod.depth": BAR.depth, "rod.damping_ratio": ratio}
    return tuple(
        StudyCase(
            f"{n} modes" if n else "rigid", n, replace(design, {**bends, "rod.modes": n} if n else rigid), REST, options
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
            StudyCase(f"e = {e:g}, k = {k:.0e}, M₀ = {m:.0e}".replace("e+0", "e"), e, published(e, k, m), REST, OPTIONS)
            for e, k, m in RIGID
        ),
    ),
    Study(
        "crank_rod",
        "36-39",
        "The rod bends: e = 0.1, k = 2e4, M₀ = 1e5",
        "modes of the rod [-]",
        "the rod is a steel bar of 15 mm by 15 mm, 1 % damping of each mode, or the same bar rigid. Only the first "
        "0.1 s: later the rod rubs on a side in ever more and smaller impacts. Two cycles take 968 236 steps and have "
        "97 366 impacts (2 modes), 828 637 and 63 605 (4 modes), too many to draw",
        rods(*BENDING, FIRST),
    ),
    Study(
        "crank_cycles",
        "36-39",
        "The rod bends, over two cycles: e = 0.1, k = 2e4, M₀ = 1e5",
        "modes of the rod [-]",
        "as before, but the contact's spring comes in over 1 µm, as the printed damper does, in place of 10 nm, and "
        "each mode is damped by 10 %: the first peaks fall to a third, and a rod that rubs on a side comes to rest",
        rods(*BENDING, OPTIONS, 1e-6, 0.1),
    ),
    Study(
        "crank_contact",
        "36-39",
        "The rod bends, with an exponent that a contact can have: e = 1.5",
        "modes of the rod [-]",
        "exponent and unit of k are ours: k = 2e4 N/mm^1.5 and all else as in the study of 0.1 s, over 0.5 s",
        rods(*CONTACT, LONGER),
    ),
)
