"""What a gradient costs by how many variables: ``python -m benchmarks variables``.

Captures and gradients are timed in turns in one process, and the shortest of each is taken; a gradient's time is given
in captures at the same tolerance. It is processor time: wall time, on a machine that others use, lengthens long calls
only. The variables are numbers of the design and its scenario, those first that one
tunes; the last seven do nothing in these designs, and no more than the forty are there. Every gradient holds all
quantities, so that asking for more of them costs what reading them takes.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from .ours import jax, jb  # configures, before any computation of JAX's

COUNTS, RTOLS, QUANTITIES = (1, 5, 10, 20, 33, 40), (1e-6, 1e-4), (1, 5, 19)
DESIGNS = ("table2", "random-1-5", "random-1-12")  # of tests/verification/captures.json; one program for all
NUMBERS = """
    buffer.k_A buffer.c_A buffer.k_T buffer.c_T probe.tip_mass contact.restitution contact.friction probe.length
    cone.half_angle scenario.approach_speed active.mass active.inertia active.hinge_offset passive.mass passive.inertia
    probe.tip_radius contact.young_modulus contact.poisson_ratio scenario.contact_distance cone.offset
    cone.throat_radius scenario.misalignment scenario.passive_rate buffer.free_length buffer.cylinder_mass
    buffer.cylinder_length probe.rod_mass contact.slip_speed cone.length hinge.bush_radius hinge.damping
    hinge.young_modulus hinge.poisson_ratio
    contact.linear_stiffness contact.damping contact.exponent contact.ramp_depth contact.onset_length
    contact.memory_time buffer.stop_damping
"""
VARIABLES = tuple(NUMBERS.split())
Row = dict[str, Any]


def in_turns(calls: Mapping[Any, Callable[[], Any]], rounds: int) -> dict[Any, float]:
    """The shortest processor time [s] of each call."""
    best = dict.fromkeys(calls, float("inf"))
    for _ in range(rounds):
        for key, call in calls.items():
            begin = time.process_time()
            call()
            best[key] = min(best[key], time.process_time() - begin)
    return best


def captured(case: Any, rtol: float) -> jb.Capture:
    """One capture."""
    return jax.block_until_ready(jb.simulate(case.design, case.scenario, rtol=rtol))


def differentiated(case: Any, count: int, rtol: float, quantities: int = 1) -> jb.Sensitivity:
    """One gradient by the first ``count`` variables, without a certificate."""
    names = list(case.catalogue)[:quantities]
    return jb.sensitivity(
        case.design, case.scenario, wrt=VARIABLES[:count], quantities=names, rtol=rtol, certify="none"
    )


def compiled(case: Any, counts: list[int]) -> dict[int, float]:
    """Time of the first call [s] of a capture (0 variables) and of a gradient by each number of variables."""
    seconds = {}
    for count in (0, *counts):
        begin = time.perf_counter()
        differentiated(case, count, RTOLS[0]) if count else captured(case, RTOLS[0])
        seconds[count] = time.perf_counter() - begin
    return seconds


def by_variables(case: Any, counts: list[int], rtol: float, rounds: int) -> list[Row]:
    """Cost and steps of one design's gradients."""
    calls: dict[int, Callable[[], Any]] = {0: lambda: captured(case, rtol)}
    calls |= {count: lambda count=count: differentiated(case, count, rtol) for count in counts}
    best, rows = in_turns(calls, rounds), []
    for count, seconds in best.items():
        run = calls[count]().run if count else calls[count]()
        steps = {"attempts": int(run.attempts), "accepted": int(run.accepted)}
        rows.append(
            {"design": case.name, "rtol": rtol, "variables": count, "captures": seconds / best[0], "ms": 1e3 * seconds}
            | steps
        )
    return rows


def by_quantities(case: Any, count: int, rounds: int) -> list[Row]:
    """Cost of one gradient by how many quantities are asked for, over that for one."""
    calls = {n: lambda n=n: differentiated(case, count, RTOLS[0], n) for n in QUANTITIES}
    best = in_turns(calls, rounds)
    return [{"quantities": n, "ratio": seconds / best[QUANTITIES[0]]} for n, seconds in best.items()]


def cases() -> list[Any]:
    """The designs with their scenarios."""
    from types import SimpleNamespace

    from jaxbuffer.mechanisms.probe_cone import PROBE_CONE

    from .plan import of_tests

    known = of_tests("verification.cases").CASES
    return [
        SimpleNamespace(
            name=name, design=known[name].design, scenario=known[name].scenario, catalogue=PROBE_CONE.quantities
        )
        for name in DESIGNS
    ]


def main(
    counts: Annotated[str, typer.Option(help="numbers of variables")] = ",".join(map(str, COUNTS)),
    rounds: int = 20,
    output: Path = Path("benchmarks/results/variables.json"),
) -> int:
    """Measure, print, write."""
    numbers = [int(text) for text in counts.split(",")]
    if not all(0 < count <= len(VARIABLES) for count in numbers):
        raise typer.BadParameter(f"--counts: 1 to {len(VARIABLES)} variables, not {counts}")
    designs = cases()
    first = compiled(designs[0], numbers)
    print("first calls [s]: " + ", ".join(f"{count} variables {seconds:.1f}" for count, seconds in first.items()))
    print(f"{'design':<14}{'rtol':>8}{'variables':>11}{'captures':>10}{'[ms]':>9}{'attempts':>10}{'accepted':>10}")
    rows = []
    for case in designs:
        for rtol in RTOLS:
            for row in by_variables(case, numbers, rtol, rounds):
                rows.append(row)
                print(
                    f"{row['design']:<14}{rtol:>8.0e}{row['variables']:>11}{row['captures']:>10.2f}{row['ms']:>9.2f}"
                    f"{row['attempts']:>10}{row['accepted']:>10}",
                    flush=True,
                )
    choice = by_quantities(designs[0], numbers[-1], rounds)
    print(
        f"by {numbers[-1]} variables, over one quantity: "
        + ", ".join(f"{row['quantities']} quantities {row['ratio']:.3f}" for row in choice)
    )
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(json.dumps({"first": first, "variables": rows, "quantities": choice}, indent=1) + "\n")
    print(f"wrote {output}")
    return 0
