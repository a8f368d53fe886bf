"""Which drops the paper's section 2 shows. Its k, e, d and c are in N, mm and s."""

from collections.abc import Mapping
from typing import Any

from ...fields import replace
from ...mechanisms.bar_drop import BarDrop, BarDropScenario
from ..study import Study, StudyCase

DAMPINGS = (0.0, 1.0, 6.0)  # N s/mm; 0 is ours, for the spring alone
PRINTED_SPEED = 1.325  # m/s
GRAVITY = 9.81  # m/s²
DROP = BarDropScenario(height=0.194)
SLOWER = BarDropScenario(height=PRINTED_SPEED**2 / (3.0 * GRAVITY))  # v² = 3 g H
PLATE = {"plate.modes": 32}
BODIES = {"plate.modes": 8, "bar.modes": 8}
VARIED = "damping c [N s/mm]"
ACCURATE = {"rtol": 1e-8}
# With 32 modes of the plate explicit steps take a fifth of the automatic solver's time (docs/bar_drop.md).
BENT = {"duration": 0.23, "rtol": 1e-7, "solver": "explicit", "history": 40_000}
WHOLE = {"duration": 0.6}  # s, the paper's
FRICTIONS = (0.0, 0.3, 1.0, 10.0)  # μ [-]; the last stands for "rough", where nothing slides


def _by_damping(
    changes: Mapping[str, int], scenario: BarDropScenario, options: Mapping[str, Any]
) -> tuple[StudyCase, ...]:
    return tuple(
        StudyCase(f"c = {c:g}", c, replace(BarDrop(), {**changes, "impact.damping": 1e3 * c}), scenario, options)
        for c in DAMPINGS
    )


def _by_friction(damping: float, changes: Mapping[str, int], options: Mapping[str, Any]) -> tuple[StudyCase, ...]:
    design = replace(BarDrop(), {**changes, "impact.damping": 1e3 * damping})
    return tuple(
        StudyCase(f"μ = {value:g}", value, replace(design, {"impact.friction": value}), DROP, {**options, **WHOLE})
        for value in FRICTIONS
    )


STUDIES = (
    Study(
        "drop",
        "7-10, 12, 16-17",
        "Rigid bar on a rigid plate, from the printed height of 194 mm",
        VARIED,
        "steel of 7850 kg/m³",
        _by_damping({}, DROP, {**ACCURATE, **WHOLE}),
    ),
    Study(
        "speed",
        "7-10, 16-17",
        "Rigid bar on a rigid plate, at the printed speed of 1.325 m/s",
        VARIED,
        "the height, 59.65 mm, that belongs to that speed",
        _by_damping({}, SLOWER, ACCURATE),
    ),
    Study(
        "plate",
        "13-15, 18-20",
        "A plate that bends under a rigid bar",
        VARIED,
        "simple supports at both ends of the 300 mm, 1 % damping of each of 32 modes",
        _by_damping(PLATE, DROP, BENT),
    ),
    Study(
        "bodies",
        "12-20, 23, 28-29",
        "Bar and plate bend, in few modes as a modal body of such programs has",
        VARIED,
        "8 modes of a free bar and 8 of the plate, 1 % damping of each; more modes lower the peak further",
        _by_damping(BODIES, DROP, {**BENT, **WHOLE}),
    ),
    Study(
        "friction",
        "25-27",
        "Friction where bar and plate bend, c = 1 N s/mm",
        "coefficient of friction [-]",
        "8 modes of each as before; friction sets in over a slip speed of 1 mm/s; μ = 10 stands for rough",
        _by_friction(1.0, BODIES, {**BENT, "rtol": 1e-6}),
    ),
    Study(
        "friction_rigid",
        "25-27",
        "Friction of a rigid bar on a rigid plate, c = 0",
        "coefficient of friction [-]",
        "no damper, so that the bar bounces; the ball touches one radius below the hinge's height",
        _by_friction(0.0, {}, ACCURATE),
    ),
)
