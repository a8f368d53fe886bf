"""Is the peer in space right?  ``python -m benchmarks peers.space.check`` runs every reference capture without a latch.

Ends with status 1 where it is wrong.
"""

from __future__ import annotations

import json

from ...accuracy import best_of, errors
from ...plan import ROOT
from ..reference import Reference, reference_of
from .parameters import Parameters
from .run import capture

FILE = ROOT / "tests" / "docking3d" / "docking3d.json"
ACCURATE = 1e-6  # [-] relative error of peak force and end time at tight tolerances


def references() -> list[Reference]:
    """The reference captures that the peer has the parts for."""
    known = Parameters.__dataclass_fields__
    return [
        reference_of(case, Parameters.from_inputs(case["inputs"]))
        for case in json.loads(FILE.read_text())
        if set(case["inputs"]) <= set(known)
    ]


def main(rtol: float = 1e-9, atol: float = 1e-12) -> int:
    """Run the check; the exit status."""
    cases, right = references(), True
    capture(cases[0].parameters, 1e-4, 1e-6)  # compiles
    print(f"rtol {rtol:g}, atol {atol:g}")
    print(f"{'capture':24}{'peak error':>12}{'end error':>12}{'impacts':>9}{'steps':>7}{'ms':>9}")
    for case in cases:
        run, seconds = best_of(3, lambda: capture(case.parameters, rtol, atol))  # noqa: B023
        off = errors(run, case)
        fine = max(off.values()) <= ACCURATE
        right = right and fine
        mark = "" if fine else f"  WRONG: {run.outcome}, {case.outcome} after {case.impacts} expected"
        print(
            f"{case.name:24}{off['peak']:12.1e}{off['end']:12.1e}{run.impacts:9}{run.steps:7}{1e3 * seconds:9.2f}{mark}"
        )
    return 0 if right else 1
