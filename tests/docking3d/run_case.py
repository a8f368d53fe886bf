"""Run one case of the reference and print what it gives, as JSON: a process of its own, with LLVM's flags."""

import json
import sys

import jaxbuffer as jb

jb.configure()

from docking3d.reference import CASES, QUANTITIES  # noqa: E402

case = CASES[sys.argv[1]]
run = jb.simulate(case.design, case.scenario, case.duration, solver="explicit")
values = {name: float(run.quantity(name)) for name in QUANTITIES}
print(
    json.dumps(
        {"outcome": run.outcome.name, "impacts": int(run.impact_count), "energy": float(run.balance.energy), **values}
    )
)
