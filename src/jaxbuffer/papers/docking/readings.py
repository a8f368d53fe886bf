"""Other readings of what the paper leaves open: does any of them bear out what Table 2, as read here, does not?

Each reading is run welded and free, at 0.1 and at 0.05 m/s.
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..._types import Figure
from ...fields import replace
from ...mechanisms.probe_cone.design import Scenario, table2
from ...mechanisms.probe_cone.parts import ALUMINIUM_DENSITY, ROD_RADIUS, TIP_RADIUS
from ...output.style import drawing, line, panels
from ..claims import Claim, Row, Rows, Value
from ..study import PaperPart, Studied, Study, StudyCase
from .claims import BACK
from .published import EQUATIONS
from .rows import COLUMNS, SHOWN, row

SPEEDS = (0.1, 0.05)  # m/s
RESTITUTIONS = (0.5, 0.7, 0.8, 0.9, 0.95)
RADII = (TIP_RADIUS, ROD_RADIUS)  # m: R_tip and r_p, which Table 1 calls the ball's
RODS = (float(table2().probe.rod_mass), 0.5, 0.8, 1.0, 1.2, 2.0)  # kg
SLIPS = (1e-4, 1e-2)  # m/s
BENDING = 71.7e9 * math.pi * ROD_RADIUS**4 / 4.0  # N m², of the aluminium rod
SEVEN, NEAR = -0.07, 0.02  # the printed change of the largest force, and what counts as it


class Reading(NamedTuple):
    """What is read into the paper. ``bends``: whether the rod does."""

    published: bool
    radius: float  # m
    rod: float  # kg
    restitution: float = 0.9
    slip: float = 1e-3  # m/s
    bends: bool = False

    def __str__(self) -> str:
        parts = [
            "equations 10, 21" if self.published else "our equations",
            f"tip {1e3 * self.radius:g} mm",
            f"rod {self.rod:.3g} kg",
            f"e = {self.restitution:g}",
        ]
        slip = [f"slip speed {self.slip:g} m/s"] if self.slip != 1e-3 else []
        return ", ".join([*parts, *slip, *(["rod bends"] if self.bends else [])])

    @property
    def changes(self) -> Mapping[str, Any]:
        """Return the reading's changes of Table 2's design; the tip is a solid ball of its radius."""
        return {
            **(EQUATIONS if self.published else {}),
            **({"probe.bending_stiffness": BENDING} if self.bends else {}),
            "probe.tip_radius": self.radius,
            "probe.tip_mass": ALUMINIUM_DENSITY * 4.0 / 3.0 * math.pi * self.radius**3,
            "probe.rod_mass": self.rod,
            "contact.restitution": self.restitution,
            "contact.slip_speed": self.slip,
        }


def readings() -> Iterator[Reading]:
    """Return all combinations of equations, radius, mass and restitution; with one restitution slip speeds and
    bending."""
    yield from itertools.starmap(Reading, itertools.product((False, True), RADII, RODS, RESTITUTIONS))
    for radius, rod in itertools.product(RADII, RODS):
        yield Reading(False, radius, rod, bends=True)
        if rod in (RODS[0], 1.0):
            yield from (Reading(False, radius, rod, slip=slip) for slip in SLIPS)


def _cases(reading: Reading) -> Iterator[StudyCase]:
    for free, speed in itertools.product((False, True), SPEEDS):
        design = replace(table2(), {**reading.changes, "probe.free_tip": free})
        yield StudyCase(f"{reading}: {'free' if free else 'welded'}", speed, design, Scenario(approach_speed=speed))


READINGS = tuple(readings())
STUDY = Study(
    "readings",
    "9, 10, 14, 15",
    "Other readings of the paper",
    "approach speed [m/s]",
    "a tip that is a solid ball of its radius; a rod that bends is of aluminium, 18 mm thick, without damping",
    tuple(case for reading in READINGS for case in _cases(reading)),
)


def table(studied: Studied) -> list[Row]:
    """Return one row a reading: what a free tip changes, what is left of the stroke, what 0.05 m/s ends as."""
    return [
        {"reading": str(reading), **_compared(studied.rows[4 * k : 4 * k + 4])} for k, reading in enumerate(READINGS)
    ]


def _compared(rows: Sequence[Row]) -> Row:
    # In the order of `_cases`.
    welded, welded_slow, free, free_slow = rows
    first, whole = (float(free[name]) / float(welded[name]) - 1.0 for name in ("first_peak", "peak_force"))
    left = [abs(float(row["end_stroke"])) / float(row["stroke"]) for row in (welded, free)]
    slow = [str(row["outcome"]) for row in (welded_slow, free_slow)]
    claims = (
        abs(whole - SEVEN) < NEAR,
        welded["outcome"] == "captured" and left[0] < BACK,
        slow == ["captured", "captured"],
    )
    return {
        "first force, change by a free tip [%]": 100.0 * first,
        "largest force, change by a free tip [%]": 100.0 * whole,
        "stroke left, welded [%]": 100.0 * left[0],
        "stroke left, free [%]": 100.0 * left[1],
        "0.05 m/s, welded": slow[0],
        "0.05 m/s, free": slow[1],
        **dict(zip(TESTS, ("yes" if h else "no" for h in claims), strict=True)),
    }


TESTS = ("7 % less", "buffer back", "0.05 m/s captured")


def _holding(*tests: str) -> Value:
    """Return whether all of some tests hold in each reading."""

    def of(rows: Rows) -> Any:
        made = rows[STUDY.name]
        compared = [_compared(made[4 * k : 4 * k + 4]) for k in range(len(READINGS))]
        return np.array([all(one[test] == "yes" for test in tests) for one in compared])

    return Value(of)


def _such_as(holding: Any) -> str:
    return f", such as: {READINGS[int(np.argmax(holding))]}" if np.any(holding) else ""


def _best_pair(rows: Rows) -> str:
    """Return how far the best pair of tests gets where no reading has all three; "" where one has."""
    if np.any(_holding(*TESTS).of(rows)):
        return ""
    pairs = {pair: _holding(*pair).of(rows) for pair in itertools.combinations(TESTS, 2)}
    (first, second), two = max(pairs.items(), key=lambda it: int(np.sum(it[1])))
    return f"; «{first}» and «{second}» in {np.sum(two)}{_such_as(two)}"


def _in_some(claim: str, where: str, *tests: str) -> Claim:
    """Claim that some tests hold in the same reading, whichever it is."""
    holding = _holding(*tests)
    finding = f"in {{}} of {len(READINGS)} readings{{}}{{}}"
    rest = Value(_best_pair if len(tests) > 1 else lambda rows: "")
    return Claim(claim, where, finding, (holding.map(sum), holding.map(_such_as), rest), (holding,))


CLAIMS = (
    _in_some("A free tip lowers the largest force by 7 %, in other readings", "8, fig. 14", TESTS[0]),
    _in_some("The axial buffer comes back to its length, in other readings", "7, fig. 9", TESTS[1]),
    _in_some("Captured at 0.05 m/s, welded and free, in other readings", "8, fig. 10, 15", TESTS[2]),
    _in_some("All three in one reading", "7, 8", *TESTS),
)


def figure(studied: Studied) -> Figure:
    """Draw what the probe's mass changes, for both radii, with our equations and e = 0.9."""
    compared = dict(zip(READINGS, table(studied), strict=True))
    with drawing():
        drawn, grid = panels(9.0, 6.5, 2, 2)
        axes = grid.ravel()
        names = (
            "first force, change by a free tip [%]",
            "largest force, change by a free tip [%]",
            "stroke left, welded [%]",
        )
        for k, radius in enumerate(RADII):
            made = [Reading(False, radius, rod) for rod in RODS]
            tip = f"tip {1e3 * radius:g} mm"
            for axis, name in zip(axes, names, strict=False):
                axis.plot(RODS, [float(compared[one][name]) for one in made], **line(k), marker=".", label=tip)
            for run, mark, kind in ((1, "s", "welded"), (3, "o", "free")):
                rows = [studied.rows[4 * READINGS.index(one) + run] for one in made]
                times = [float(r["capture_time"]) if r["outcome"] == "captured" else math.nan for r in rows]
                never = ": never" if all(map(math.isnan, times)) else ""
                axes[3].plot(RODS, times, **line(k), marker=mark, label=f"{tip}, {kind}{never}")
        for axis, name in zip(axes, (*names, "captured from 0.05 m/s after [s]"), strict=True):
            axis.set_xlabel("mass of the probe's rod [kg]")
            axis.set_ylabel(name)
        for axis in axes[:2]:
            axis.axhline(100.0 * SEVEN, color="0.5", linewidth=0.8)
        axes[2].axhline(100.0 * BACK, color="0.5", linewidth=0.8)
        axes[0].legend(frameon=False)
        axes[3].legend(frameon=False)
        drawn.suptitle("Other readings of the paper: our equations, e = 0.9 (grey: 7 % less, 5 % left)")
        return drawn


PART = PaperPart((STUDY,), COLUMNS, SHOWN, row, CLAIMS, figure, table)
