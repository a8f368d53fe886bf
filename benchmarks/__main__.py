"""One command for all benchmarks; see docs/benchmarks.md."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

PARTS = ("capture", "gradient", "sweep", "scaling", "stiff", "slider_crank", "cold")
LONG = ("slider_crank",)  # takes part in a quick run only where it is named


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks",
        description="Speed of jaxbuffer and its peers on the same model, machine and accuracy, in one run.",
    )
    parser.add_argument("--quick", action="store_true", help="two minutes: two peers, small sweeps")
    parser.add_argument("--only", type=lambda text: text.split(","), metavar="PART,…", help=", ".join(PARTS))
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results"), metavar="FOLDER")
    parser.add_argument("--check-baseline", action="store_true", help="status 1 where a ratio fell by over 30 %%")
    parser.add_argument("--store-baseline", action="store_true", help="make this run's ratios the baseline")
    options = parser.parse_args(arguments)
    if options.only is None:
        options.only = [part for part in PARTS if not (options.quick and part in LONG)]
    if unknown := set(options.only) - set(PARTS):
        parser.error(f"no such part: {', '.join(sorted(unknown))}")
    return options


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the parts, write and print what they found; the exit status."""
    options = parsed(arguments)
    from rich.console import Console

    from . import baseline, report
    from .figures import Part
    from .plan import Plan

    mode = "quick" if options.quick else "full"
    plan = Plan(options.quick)
    run, begin = report.about(mode), time.perf_counter()
    parts, failed = [], []
    for name in (name for name in PARTS if name in options.only):
        plan.console.rule(name)
        try:
            parts.append(importlib.import_module(f"benchmarks.{name}").measure(plan))
        except RuntimeError as error:  # no accurate setting, or a process that failed: the other parts still count
            failed.append(name)
            parts.append(Part(name, name, notes=(f"failed: {error}",)))
    run["seconds"] = time.perf_counter() - begin
    out = Console(width=None if sys.stdout.isatty() else 160)
    report.show(parts, out)
    for file in report.write(parts, run, options.output):
        out.print(f"wrote {os.path.relpath(file)}", highlight=False)
    now = baseline.ratios(parts)
    if options.store_baseline:
        baseline.store(mode, now)
        out.print(f"stored {len(now)} ratios in {os.path.relpath(baseline.FILE)}", highlight=False)
    slower = False
    if options.check_baseline:
        before = baseline.due(baseline.load(mode), options.only)
        lines = baseline.fallen(now, before)
        for line in lines:
            out.print(f"SLOWER {line}", highlight=False)
        out.print(f"{len(before) - len(lines)} of {len(before)} ratios are at their {mode} baseline", highlight=False)
        slower = bool(lines) or not before
    return 1 if slower or failed else 0


if __name__ == "__main__":
    sys.exit(main())
