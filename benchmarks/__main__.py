"""Wall times of one Table-2 capture, of value and gradient, and of their compilation; prints a table, writes JSON.

Best of several warm runs; compilation is what the first call takes over a warm one. Run it on an idle machine.
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

import jaxbuffer as jb

jb.configure()

import diffrax  # noqa: E402
import jax  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.progress import track  # noqa: E402
from rich.table import Table  # noqa: E402

from jaxbuffer.integrate import ExplicitRungeKutta, LinearlyImplicit  # noqa: E402
from jaxbuffer.sensitivity import PARAMETERS, linearised  # noqa: E402

REFERENCE = {"peak_force": 253.13152694328107, "end_time": 0.7193424826485937}  # independent program, rtol 1e-10
SOLVERS = {
    "implicit KenCarp5 (default)": LinearlyImplicit(),
    "implicit KenCarp4": LinearlyImplicit(diffrax.KenCarp4()),
    "explicit Tsit5": ExplicitRungeKutta(),
}


def timed(call: Callable[[], object], repeats: int = 7) -> tuple[float, float]:
    """Seconds of the first call over a warm one, and of the best warm one."""

    def once() -> float:
        begin = time.perf_counter()
        jax.block_until_ready(call())
        return time.perf_counter() - begin

    first = once()
    warm = min(once() for _ in range(repeats))
    return first - warm, warm


def capture_rows(rtol: float) -> list[dict]:
    """One row a solver: the capture alone, in a process that has compiled nothing else of it."""
    rows = []
    for name, solver in track(list(SOLVERS.items()), f"captures at rtol {rtol:g}"):
        compile_time, warm = timed(lambda solver=solver: jb.simulate(jb.table2(), rtol=rtol, solver=solver))
        capture = jb.simulate(jb.table2(), rtol=rtol, solver=solver)
        rows.append(
            {
                "what": f"capture, {name}",
                "rtol": rtol,
                "warm_ms": 1e3 * warm,
                "compile_s": compile_time,
                "steps": int(capture.attempts),
                "peak_force_error": abs(float(capture.peak_force) / REFERENCE["peak_force"] - 1),
                "end_time_error": abs(float(capture.end_time) / REFERENCE["end_time"] - 1),
            }
        )
    return rows


def gradient_rows(rtol: float) -> list[dict]:
    """Value and gradient in the five parameters, a row a solver."""
    design = jb.table2()
    values = [jb.get(design, path) for path in PARAMETERS]
    rows = []
    for name, solver in track(list(SOLVERS.items()), f"gradients at rtol {rtol:g}"):
        call = lambda solver=solver: linearised(design, jb.Scenario(), PARAMETERS, values, rtol=rtol, solver=solver)  # noqa: E731
        compile_time, warm = timed(call, 3)
        rows.append(
            {
                "what": f"value and gradient, {name}",
                "rtol": rtol,
                "warm_ms": 1e3 * warm,
                "compile_s": compile_time,
                "steps": int(call().capture.attempts),
            }
        )
    return rows


def show(rows: list[dict]) -> None:
    """The table."""
    table = Table(title="Table-2 capture")
    for heading in ("what", "rtol", "warm [ms]", "compile [s]", "steps", "peak error", "end time error"):
        table.add_column(heading, justify="left" if heading == "what" else "right")
    for row in rows:
        errors = [f"{row[key]:.1e}" if key in row else "" for key in ("peak_force_error", "end_time_error")]
        table.add_row(
            row["what"],
            f"{row['rtol']:g}",
            f"{row['warm_ms']:.2f}",
            f"{row['compile_s']:.1f}",
            str(row["steps"]),
            *errors,
        )
    Console(width=130).print(table)


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("benchmarks/results/times.json"), help="JSON file to write")
    arguments = parser.parse_args()
    rows = [row for rtol in (1e-6, 1e-7) for row in capture_rows(rtol)] + gradient_rows(1e-7)
    show(rows)
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(json.dumps(rows, indent=1))
    print(f"wrote {arguments.output}")


if __name__ == "__main__":
    main()
