"""`size`: parts that fit a design's scenarios by closed forms, confirmed by runs of the sized design."""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..errors import InputError
from ..fields import Part, get
from ..hybrid import Solver
from ..mechanisms.mechanism import EndCount, Mechanism
from ..mechanisms.registry import mechanism_of
from ..mechanisms.run import Run
from ..mechanisms.sizing import ClosedForm, SizedParts
from ..tables import table, text
from ..value_text import UNKNOWN
from .request import DEFAULT_TOLERANCE
from .simulate import simulate

MOST = 16  # scenarios that are simulated, spread evenly over more
LONGER = 1.5  # times the estimated time until held that is simulated at least, where no duration is given


class Confirmed(NamedTuple):
    """What runs say of a `ClosedForm`: the largest ``value``, NaN where a run has none, and ``where``: the number of
    its scenario; ``kept``: whether it keeps what was wished."""

    value: float
    where: int
    kept: bool


class Sized:
    """Parts that fit, with runs that confirm it. Print it for a summary.

    - ``parts``: what the closed forms say, `SizedParts`; ``design``: the sized design.
    - ``runs``: of the sized design, by the scenario's number; ``duration`` [s] of each at most; ``scenarios``: how many
      there are, not all of which need have run.
    - ``confirmed``: what they say of each estimate, by quantity.

    **Example:**

    >>> meeting = jb.Scenario(start="free", offset="1 cm", approach_speed=0.1)
    >>> sized = jb.size(jb.table2(), [meeting])
    >>> print(f"held in {sized.estimates['settling_time'].value:.1f} s: {sized.runs[1].outcome.name}")
    held in 4.2 s: held
    """

    def __init__(self, parts: SizedParts, runs: Mapping[int, Run], duration: float, scenarios: int) -> None:
        self.parts, self.runs, self.duration, self.scenarios = parts, dict(runs), duration, scenarios
        self.confirmed = {name: self._confirmed(it) for name, it in parts.estimates.items()}

    @property
    def design(self) -> Any:
        """Return the sized design."""
        return self.parts.design

    @property
    def estimates(self) -> Mapping[str, ClosedForm]:
        """Return what the closed forms say, by quantity."""
        return self.parts.estimates

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism whose design it is."""
        return mechanism_of(self.design)

    @property
    def missed(self) -> list[str]:
        """Return a line for each wish that a run does not keep, and for runs that do not end as they should."""
        lines = [
            f"{name} is {self._shown(name, it.value)} in scenario {it.where}, wished"
            f" {self._shown(name, self.parts.estimates[name].limit)}"
            for name, it in self.confirmed.items()
            if not it.kept
        ]
        ends = self.ends
        return lines if ends is None or ends.complete else [str(ends), *lines]

    @property
    def ends(self) -> EndCount | None:
        """Return in how many runs the strictest end was reached; None where the mechanism knows none."""
        counts = Counter(run.outcome.name for run in self.runs.values())
        return self.mechanism.end_count(lambda path: get(self.design, path), counts)

    def _confirmed(self, estimate: ClosedForm) -> Confirmed:
        quantity = self.mechanism.quantities[estimate.quantity]
        values = {number: float(quantity.of(run)) for number, run in self.runs.items()}
        # What is not known of a run is worse than any number.
        where = max(values, key=lambda number: math.inf if math.isnan(values[number]) else values[number])
        value, limit = values[where], estimate.limit
        return Confirmed(value, where, limit is None or value <= limit * (1.0 + 1e-9))

    def _shown(self, name: str, value: float | None) -> str:
        if value is None or math.isnan(value):
            return UNKNOWN
        return self.mechanism.quantities[name].in_words(value, 4)

    def __repr__(self) -> str:
        made = table(
            "Largest values, by closed form and simulated", ("quantity",), ("wished", "closed form", "simulated")
        )
        for heading in ("scenario", "", "from"):
            made.add_column(heading)
        for name, it in self.parts.estimates.items():
            found = self.confirmed[name]
            state = "" if it.limit is None else "kept" if found.kept else "missed"
            values = (self._shown(name, value) for value in (it.limit, it.value, found.value))
            made.add_row(name, *values, str(found.where), state, it.rule)
        ended = f"{self.ends} runs" if self.ends else f"{len(self.runs)} runs"
        line = f"{ended} of at most {self.duration:.4g} s"
        if self.scenarios > len(self.runs):
            line += f"; {self.scenarios - len(self.runs)} of the {self.scenarios} scenarios were not simulated"
        return text(self.parts.numbers_table(), made, line, *self.parts.remarks)


def size(
    design: Part,
    scenarios: Sequence[Part],
    duration: float | None = None,
    *,
    solver: Solver | str | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    report: Callable[[str], None] = lambda line: None,
    **wishes: Any,
) -> Sized:
    """Size parts of a design by closed forms, and simulate the sized design in its scenarios.

    Of a docking these are latch and buffer: see `size_latch` and `size_buffer`.

    **Arguments:**

    - ``design``: of a mechanism that sizes parts; what is not sized is kept.
    - ``scenarios``: in which it runs; of more than 16, so many of them are simulated.
    - ``duration``: of a run [s] (default: the mechanism's, or half as long again as the closed form says).
    - ``solver``, ``rtol``: as of `simulate`.
    - ``report``: is called with how far it is.
    - ``wishes``: limits by quantity, with units or without, as `size_latch` and `size_buffer` take them.

    **Returns:** a `Sized`.

    **Raises:** `InputError` for a mechanism that sizes nothing, for wishes that are unknown or out of range.

    **Example:**

    >>> meetings = [jb.Scenario(start="free", offset="1 cm", approach_speed=speed) for speed in (0.08, 0.15)]
    >>> sized = jb.size(jb.table2(), meetings, latch_energy_share="8 %")
    >>> sized.missed, f"{float(sized.runs[2].peak_latch_force):.1f} N"
    ([], '3.4 N')
    """
    mechanism = mechanism_of(design)
    if mechanism.sizer is None:
        raise InputError(f"kind = {mechanism.name}: there is nothing that sizes its parts; tune it instead")
    parts = mechanism.sizer.size(design, scenarios, mechanism.sizer.wishes(**wishes))
    if duration is None:
        duration = max(mechanism.duration(parts.design), LONGER * parts.duration)
    runs = dict[int, Run]()
    numbers = sorted({round(float(it)) for it in np.linspace(1, len(scenarios), min(MOST, len(scenarios)))})
    for done, number in enumerate(numbers, 1):
        report(f"simulating {done} of {len(numbers)} scenarios")
        runs[number] = simulate(parts.design, scenarios[number - 1], duration, solver=solver, rtol=rtol)
    return Sized(parts, runs, duration, len(scenarios))
