"""Speed of jaxbuffer and its peers on the same model, machine and accuracy, in one run; see docs/benchmarks.md."""

from __future__ import annotations

import importlib
import os
import sys
import time
from pathlib import Path
from typing import Annotated

import typer

from .names import chosen

PARTS = ("capture", "gradient", "sweep", "scaling", "stiff", "slider_crank", "cold")
LONG = ("slider_crank",)  # takes part in a quick run only where it is named


def parts_of(only: str | None, quick: bool) -> list[str]:
    """Names of the parts of a run."""
    if only is None:
        return [part for part in PARTS if not (quick and part in LONG)]
    return chosen(only.split(","), PARTS, "part")


def main(
    quick: Annotated[bool, typer.Option("--quick", help="two minutes: two peers, small sweeps")] = False,
    only: Annotated[str | None, typer.Option(metavar="PART,…", help=", ".join(PARTS))] = None,
    output: Path = Path("benchmarks/results"),
    check_baseline: Annotated[bool, typer.Option("--check-baseline", help="1 where a ratio fell by over 30 %")] = False,
    store_baseline: Annotated[bool, typer.Option("--store-baseline", help="make these ratios the baseline")] = False,
) -> int:
    """Run the parts, write and print what they found; the exit status."""
    names = parts_of(only, quick)
    from rich.console import Console

    from . import baseline, report
    from .figures import Part
    from .plan import Plan

    mode = "quick" if quick else "full"
    plan = Plan(quick)
    run, begin = report.about(mode), time.perf_counter()
    parts, failed = [], []
    for name in (part for part in PARTS if part in names):
        plan.console.rule(name)
        try:
            parts.append(importlib.import_module(f"benchmarks.{name}").measure(plan))
        except RuntimeError as error:  # no accurate setting, or a process that failed: the other parts still count
            failed.append(name)
            parts.append(Part(name, name, notes=(f"failed: {error}",)))
    run["seconds"] = time.perf_counter() - begin
    out = Console(width=None if sys.stdout.isatty() else 160)
    report.show(parts, out)
    for file in report.write(parts, run, output):
        out.print(f"wrote {os.path.relpath(file)}", highlight=False)
    now = baseline.ratios(parts)
    slower = False
    if check_baseline:
        before = baseline.due(baseline.load(mode), names)
        lines = baseline.fallen(now, before)
        for line in lines:
            out.print(f"SLOWER {line}", highlight=False)
        kept = f"{len(before) - len(lines)} of {len(before)} ratios are at their {mode} baseline"
        out.print(f"{kept} ({baseline.machine_of(mode)})", highlight=False)
        slower = bool(lines) or not before
    if store_baseline:
        baseline.store(mode, now, run)
        out.print(f"stored {len(now)} ratios in {os.path.relpath(baseline.FILE)}", highlight=False)
    return 1 if slower or failed else 0
