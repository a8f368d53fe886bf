"""Which captures each figure of the paper shows. Values the text leaves open are marked as assumed."""

import math

from ...fields import replace
from ...mechanisms.probe_cone.design import Design, Scenario, rigid_probe, table2
from ..study import Study, StudyCase

SPEEDS = (0.05, 0.1, 0.15, 0.2)  # m/s
RATES = (0.0, 0.05, 0.1)  # °/s, the paper's
ANGLES = (0.0, 1.0, 2.0, 3.0)  # °
FRICTIONS = (0.1, 0.2, 0.33, 0.4, 0.5)  # "five cases"
WELDED = table2()
FREE = replace(table2(), {"probe.free_tip": True})


def _by_speed(design: Design) -> tuple[StudyCase, ...]:
    return tuple(StudyCase(f"{v:g} m/s", v, design, Scenario(approach_speed=v)) for v in SPEEDS)


def _by_rate(design: Design) -> tuple[StudyCase, ...]:
    return tuple(StudyCase(f"{w:g} °/s", w, design, Scenario(passive_rate=math.radians(w))) for w in RATES)


def _by_angle(design: Design) -> tuple[StudyCase, ...]:
    return tuple(StudyCase(f"{a:g}°", a, design, Scenario(misalignment=math.radians(a))) for a in ANGLES)


def _by_friction(design: Design) -> tuple[StudyCase, ...]:
    return tuple(
        StudyCase(f"μ = {mu:g}", mu, replace(design, {"contact.friction": mu}), Scenario()) for mu in FRICTIONS
    )


SPEED, RATE, ANGLE = "approach speed [m/s]", "angular velocity of the passive vehicle [°/s]", "misalignment [°]"
STUDIES = (
    Study(
        "rigid",
        "6-7",
        "Rigid probe against the buffer",
        "probe",
        "a buffer of 1e10 N/m and 1e8 N m/rad for the text's coefficients «high enough»; 0.1 m/s for the rigid probe",
        (StudyCase("rigid", 0.0, rigid_probe(), Scenario()), StudyCase("buffered", 1.0, WELDED, Scenario())),
    ),
    Study(
        "motion",
        "8-9",
        "Velocities of the vehicles, and the buffer's motion",
        "probe",
        "",
        (StudyCase("Table 2", 0.0, WELDED, Scenario()),),
    ),
    Study("speed", "10", "Approach speed, tip welded", SPEED, "all speeds but 0.1 m/s", _by_speed(WELDED)),
    Study("rate", "11", "Angular velocity, tip welded", RATE, "", _by_rate(WELDED)),
    Study("misalignment", "12", "Misalignment, tip welded", ANGLE, "all angles", _by_angle(WELDED)),
    Study("friction", "13", "Friction, tip welded", "friction [-]", "all values but 0.33", _by_friction(WELDED)),
    Study(
        "tip",
        "14",
        "Welded against free tip",
        "tip",
        "",
        (StudyCase("welded", 0.0, WELDED, Scenario()), StudyCase("free", 1.0, FREE, Scenario())),
    ),
    Study("speed_free", "15", "Approach speed, tip free", SPEED, "all speeds but 0.1 m/s", _by_speed(FREE)),
    Study("rate_free", "16", "Angular velocity, tip free", RATE, "", _by_rate(FREE)),
    Study("misalignment_free", "17", "Misalignment, tip free", ANGLE, "all angles", _by_angle(FREE)),
)
