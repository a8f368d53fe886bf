"""How good are the gradients, and how often is their certificate right?

    python -m benchmarks certificates --designs 200

Every reference capture and N random designs: elasticities with their quick certificate, against differences of tight
solves by another solver (explicit, rtol 1e-11) for each parameter, whose own uncertainty is kept. Each case is written
to FOLDER/certificates.jsonl as soon as it is done, and cases found there are not computed again.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

import jaxbuffer as jb
from jaxbuffer.cluster.pool import Pool
from jaxbuffer.hybrid import ExplicitRungeKutta
from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
from jaxbuffer.sensitivities.certificate import KINK, TRUSTED
from jaxbuffer.sensitivities.evidence import FLOOR, TightSolve, TightSolves, course_of, each

from .plan import of_tests

PARAMETERS, QUANTITIES = PROBE_CONE.defaults.parameters, PROBE_CONE.defaults.differentiated
POOL = Pool()
WRONG = 1e-2  # relative error that no trusted elasticity may have
SIGNIFICANT = 1e-4  # elasticities above must have the right sign
EVERY = 5  # so many random designs hold one with a free tip


def cases(designs: int) -> Iterator[tuple[str, jb.Design, jb.Scenario]]:
    """Name, design, scenario; free tips, another program to compile, come last."""
    random_case = of_tests("verification.designs").random_case
    drawn = [(name, case.design, case.scenario) for name, case in of_tests("verification.cases").CASES.items()]
    for seed in range(designs):
        drawn.append((f"design {seed}", *random_case(seed, free_tip=seed % EVERY == EVERY - 1)))
    yield from sorted(drawn, key=lambda case: case[1].probe.free_tip)


def examined(name: str, design: jb.Design, scenario: jb.Scenario) -> dict:
    """One case: elasticities (quantities, parameters), their differences, and what the certificate says."""
    begin = time.perf_counter()
    sensitivity = jb.sensitivity(design, scenario)
    seconds, certificate, capture = time.perf_counter() - begin, sensitivity.certificate, sensitivity.capture
    record = {
        "name": name,
        "outcome": capture.outcome.name,
        "impacts": int(capture.impact_count),
        "first_peak": [float(capture.impacts.peak_force[0]), float(capture.first_impact.predicted_peak)],
        "verdicts": [verdict.name for verdict in certificate.verdicts],
        "reason": certificate.reason,
        "swap": None if certificate.peaks is None else certificate.peaks.swap_change,
        "elasticity": sensitivity.elasticities.tolist(),
        "estimated": certificate.error.tolist(),
        "seconds": seconds,
    }
    if not capture.outcome.failed:
        options = (8.0, ExplicitRungeKutta(), int(capture.code), course_of(capture))
        solve = TightSolve(PROBE_CONE, design, scenario, PARAMETERS, QUANTITIES, *options)
        tight = TightSolves(solve, sensitivity.values, np.abs(sensitivity.values), POOL)
        evidence = each(
            tight, sensitivity.elasticities, np.abs(sensitivity.results), np.zeros_like(sensitivity.elasticities)
        )
        record |= {"off": evidence.by_differences.tolist(), "uncertainty": evidence.uncertainty.tolist()}
    known = of_tests("verification.cases").CASES
    if name in known:
        reference = known[name].values["elasticity"]
        record["reference"] = [reference[path.rsplit(".", 1)[1]] for path in PARAMETERS]
    return record


class Summary:
    """Distributions over all records, for one quantity."""

    def __init__(self, records: list[dict], quantity: str) -> None:
        known = [r for r in records if "off" in r]
        k = QUANTITIES.index(quantity)
        self.quantity = quantity
        self.names = [r["name"] for r in known]
        self.elasticity, self.off, self.uncertainty, self.estimated = (
            np.array([r[key][k] for r in known], float) for key in ("elasticity", "off", "uncertainty", "estimated")
        )
        self.verdict = np.array([r["verdicts"][k] for r in known])
        self.size = np.maximum(np.abs(self.elasticity), FLOOR)
        # What differences can't tell says nothing against a gradient, nor for it.
        self.decided = self.uncertainty / self.size < WRONG / 2
        self.error = np.where(self.decided, self.off / self.size, np.nan)
        self.worst = np.nanmax(np.where(self.decided, self.error, -np.inf), axis=1)

    @property
    def wrong_signs(self) -> int:
        """Elasticities above `SIGNIFICANT` whose differences have the other sign."""
        # An elasticity whose distance from the differences exceeds itself has the other sign there.
        return int(
            np.sum(self.decided & (np.abs(self.elasticity) > SIGNIFICANT) & (self.off > np.abs(self.elasticity)))
        )

    def row(self) -> list[str]:
        """The table's."""
        error = self.error[self.decided]
        figures = [f"{x:.0e}" for x in np.quantile(error, [0.5, 0.9, 0.99, 1.0])]
        good = self.worst <= WRONG
        trusted = self.verdict == "trusted"
        undecided = ~np.all(self.decided, axis=1)
        return [
            self.quantity,
            *figures,
            str(self.wrong_signs),
            f"{np.sum(trusted & good)} / {np.sum(trusted & ~good)}",
            f"{np.sum(~trusted & ~good)} / {np.sum(~trusted & good)}",
            str(int(np.sum(undecided))),
            f"{np.max(self.worst[trusted], initial=0.0):.0e}",
        ]


def shown(records: list[dict], out: Console) -> None:
    """The tables."""
    table = Table(title=f"{len(records)} captures, {len(PARAMETERS)} elasticities a quantity: relative error")
    for heading in (
        "quantity", "median", "90 %", "99 %", "worst", "wrong signs", "trusted: right / wrong",
        "not trusted: off by 1 % / not", "undecided", "worst trusted",
    ):  # fmt: skip
        table.add_column(heading, justify="left" if heading == "quantity" else "right")
    for quantity in QUANTITIES:
        table.add_row(*Summary(records, quantity).row())
    out.print(table)
    out.print(
        f"relative to the elasticity, or to {FLOOR:g} where it is smaller; undecided: captures with an elasticity that "
        f"differences can't tell within {WRONG / 2:g}, left out there; trusted up to an estimate of {TRUSTED:g}, check "
        f"where {KINK:g} of a parameter would swap the peaks",
        highlight=False,
    )
    reference = [
        abs(elasticity - exact) / max(abs(exact), FLOOR)
        for r in records
        if "reference" in r
        for elasticity, exact in zip(r["elasticity"][0], r["reference"], strict=True)
    ]
    count = sum("reference" in r for r in records)
    out.print(f"against the {count} references' own elasticities: worst {max(reference):.1e}", highlight=False)
    first = np.array([simulated / predicted for simulated, predicted in (r["first_peak"] for r in records)])
    out.print(
        f"simulated first peak over its closed form: {first.min():.3f} to {first.max():.3f}, median "
        f"{np.median(first):.3f}",
        highlight=False,
    )
    failed = [f"{r['name']}: {r['reason']}" for r in records if "off" not in r]
    for line in failed:
        out.print(line, highlight=False)
    verdicts = [max(r["verdicts"], key=("trusted", "check", "refused").index) for r in records]
    counts = ", ".join(f"{verdicts.count(v)} {v}" for v in ("trusted", "check", "refused"))
    out.print(f"verdicts on all five quantities together: {counts}", highlight=False)
    for r, verdict in zip(records, verdicts, strict=True):
        if verdict != "trusted":
            out.print(f"  {r['name']}: {verdict}: {r['reason']}", highlight=False)


def main(
    designs: Annotated[int, typer.Option(help="random designs")] = 200, output: Path = Path("benchmarks/results")
) -> int:
    """Run what is missing, then show everything asked for."""
    jb.configure(cache=None)
    file = output / "certificates.jsonl"
    file.parent.mkdir(parents=True, exist_ok=True)
    known = {r["name"]: r for r in map(json.loads, file.read_text().splitlines())} if file.exists() else {}
    out, note = Console(width=None if sys.stdout.isatty() else 180), Console(stderr=True)
    selection = list(cases(designs))
    todo = [case for case in selection if case[0] not in known]
    note.print(f"{len(selection) - len(todo)} of {len(selection)} captures known from {file}")
    with file.open("a") as stream:
        for number, case in enumerate(todo, 1):
            record = known[case[0]] = examined(*case)
            stream.write(json.dumps(record) + "\n")
            stream.flush()
            note.print(f"{number} of {len(todo)}: {case[0]}, {record['outcome']}, {record['reason']}", highlight=False)
    shown([known[name] for name, *_ in selection], out)
    return 0
