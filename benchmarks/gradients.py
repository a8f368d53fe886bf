"""Time per gradient and memory for 1 to 1000 scenarios in one design problem: ``python -m benchmarks gradients``.

A gradient here is every quantity of every scenario with its derivatives by five variables (one `Evaluator` call), and
then the step the search makes of it. Memory is the process's peak so far, of which most is the compiled program.
"""

from __future__ import annotations

import json
import resource
import sys
import time
from pathlib import Path

import jaxbuffer.programs.process


def main(counts: str = "1,10,100,1000", output: Path = Path("benchmarks/results/gradients.json")) -> int:
    """Measure, print, write."""
    jaxbuffer.programs.process.configure(cache=None)
    from rich.console import Console
    from rich.table import Table

    from jaxbuffer import Limits, Objective, Problem, Variable, table2
    from jaxbuffer.mechanisms.probe_cone import PROBE_CONE
    from jaxbuffer.tuning import Case, Distribution, Scatter
    from jaxbuffer.tuning.problem.settings import Settings
    from jaxbuffer.tuning.search.evaluation import Evaluator
    from jaxbuffer.tuning.search.goal import Goal
    from jaxbuffer.tuning.search.search import Search

    variables = [Variable(path, *bounds) for path, bounds in PROBE_CONE.defaults.variables.items()]
    spread = {"approach_speed": Distribution("uniform", 0.1, 0.3), "misalignment": Distribution("normal", 0.0, 0.02)}
    table, rows = Table(title="One gradient of a design problem, five variables"), []
    headings = ("scenarios", "gradient [s]", "a scenario [ms]", "step [s]", "captured", "memory [MiB]")
    for heading in headings:
        table.add_column(heading, justify="right")
    for count in map(int, counts.split(",")):
        cases = Scatter(count, spread, seed=1).cases([Case(PROBE_CONE.scenario())], table2())
        problem = Problem(table2(), cases, variables, Objective(), Limits(at_most={"stroke": 0.025}))
        goal = Goal(problem, problem.objective)
        with Evaluator(problem) as evaluate:
            if not rows:
                evaluate([problem.start()])  # compiles
            begin = time.perf_counter()
            (point,) = evaluate([problem.start()])
            seconds = time.perf_counter() - begin
        search = Search(goal, goal.value(point), Settings())
        branch = search.begin(point)
        begin = time.perf_counter()
        search.plan(branch)
        step = time.perf_counter() - begin
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        numbers = (count, seconds, 1e3 * seconds / count, step, int(point.succeeded.sum()), memory)
        rows.append(dict(zip(headings, numbers, strict=True)))
        table.add_row(*(f"{x:.4g}" for x in numbers))
    Console(width=None if sys.stdout.isatty() else 120).print(table)
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text(json.dumps(rows, indent=1) + "\n")
    print(f"wrote {output}")
    return 0
