"""`jb.tune` and its peers on four design problems: objective reached, captures spent, time.

``python -m benchmarks optimisers`` prints a table and writes JSON; ``--only`` picks problems. All minimise the same
true objective under the same constraints. SLSQP and trust-constr get our gradients of objective and constraints and
start where `tune` starts; differential evolution and CMA-ES see values only, of the objective plus ten times what is
above the limits, and no gradient is computed for them. A capture with its derivatives counts as one, like one without.
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jaxbuffer.programs.process

from .names import chosen

PENALTY = 10.0
TIGHT = 1e-9
CLOSE = 1e-3  # of the best objective anyone found
FEWER = 20.0  # times fewer captures than the derivative-free methods


def problems() -> dict[str, Any]:
    """The four problems, all of five variables."""
    from jaxbuffer import Limits, Objective, Problem, Scenario, Variable, table2
    from jaxbuffer.mechanisms.probe_cone import PROBE_CONE

    variables = [Variable(path, *bounds) for path, bounds in PROBE_CONE.defaults.variables.items()]
    three = [Scenario(approach_speed=v) for v in (0.1, 0.15, 0.2)]
    slow = [Scenario(approach_speed=v) for v in (0.05, 0.1, 0.2, 0.3)]
    askew = [Scenario(approach_speed=0.15, misalignment=a) for a in (-0.0873, -0.0436, 0.0, 0.0436, 0.0873)]
    limits = Limits(at_most={"stroke": 0.025})
    return {
        "peak": Problem(table2(), three, variables, Objective(), limits),
        "hinge": Problem(table2(), three, variables, Objective({"peak_hinge_force": 1.0}), limits),
        "slow": Problem(table2(), slow, variables, Objective(), limits),
        "askew": Problem(
            table2(), askew, variables, Objective({"peak_force": 1.0, "peak_hinge_force": 0.5}, "cvar", 0.6), limits
        ),
    }


class Watched:
    """Merit of designs for a method, with the best feasible one so far at each count of captures."""

    def __init__(self, problem: Any, slopes: bool) -> None:
        import numpy as np

        from jaxbuffer.tuning.search.evaluation import Evaluator
        from jaxbuffer.tuning.search.goal import Goal

        self.goal, self.evaluator = Goal(problem, problem.objective), Evaluator(problem, slopes=slopes)
        self.best, self.scaled, self.history = np.inf, problem.start(), list[tuple[int, float]]()
        self._known: tuple[bytes, Any] = (b"", None)
        self.scale = self.goal.value(self.at(problem.start()))

    def at(self, scaled: Any) -> Any:
        """The evaluation at one design, kept for the next call."""
        import numpy as np

        scaled = np.clip(np.asarray(scaled, float), 0.0, 1.0)
        if self._known[0] != scaled.tobytes():
            self._known = scaled.tobytes(), self.batch([scaled])[0]
        return self._known[1]

    def batch(self, points: Any) -> list[Any]:
        """Evaluate designs together and remember the best."""
        evaluations = self.evaluator(points)
        for point in evaluations:
            value = self.goal.value(point)
            if self.goal.feasible(point) and value < self.best:
                self.best, self.scaled = value, point.scaled
                self.history.append((self.evaluator.captures, value))
        return evaluations

    def merit(self, point: Any) -> float:
        """What the derivative-free methods minimise."""
        return self.goal.value(point) / self.scale + PENALTY * float(self.goal.excess(point).sum())

    def slope(self, point: Any) -> Any:
        """Gradient of the true objective over the scale: of the largest peaks and the cases that count."""
        import numpy as np

        objective = self.goal.objective
        weights = self.goal.weights(objective)
        cases = objective.case_weights(point.quantities @ weights)
        by_case = weights[0] * point.peaks_slope[:, 0] + np.einsum("q,cqn->cn", weights[1:], point.rest_slope)
        return cases @ by_case / self.scale

    def room(self, point: Any) -> Any:
        """Constraints as SciPy has them, each at least zero."""
        return -self.goal.rows(point.quantities, point.margin)

    def room_slope(self, point: Any) -> Any:
        """Their Jacobian."""
        import numpy as np

        slopes = np.concatenate([point.peaks_slope[:, :1], point.rest_slope], axis=1)
        parts = [-slopes[:, q] / limit for q, limit in self.goal.signed_limits()]
        return np.concatenate([*parts, point.margin_slope])


def with_tune(problem: Any) -> tuple[Watched, str]:
    """Ours, at its defaults."""
    from jaxbuffer import tune

    watched = Watched.__new__(Watched)
    tuned = tune(problem)
    spent, best, history = 0, float("inf"), []
    for record in tuned.records:
        spent += len(problem.cases)
        if record["feasible"] and record["objective"] < best:
            best = record["objective"]
            history.append((spent, best))
    watched.history, watched.best, watched.scaled = history, best, tuned.after.scaled
    watched.evaluator = type("Spent", (), {"captures": spent})()  # type: ignore[assignment]
    return watched, tuned.message


def with_slsqp(problem: Any) -> tuple[Watched, str]:
    """SciPy's SLSQP."""
    from scipy.optimize import minimize

    w = Watched(problem, slopes=True)
    constraint = {"type": "ineq", "fun": lambda z: w.room(w.at(z)), "jac": lambda z: w.room_slope(w.at(z))}
    result = minimize(
        lambda z: (w.goal.value(w.at(z)) / w.scale, w.slope(w.at(z))),
        problem.start(),
        jac=True,
        bounds=[(0.0, 1.0)] * len(problem.variables),
        constraints=[constraint],
        method="SLSQP",
        options={"maxiter": 100},
    )
    return w, result.message


def with_trust_constr(problem: Any) -> tuple[Watched, str]:
    """SciPy's trust-constr."""
    from scipy.optimize import BFGS, Bounds, NonlinearConstraint, minimize

    w, size = Watched(problem, slopes=True), len(problem.variables)
    constraint = NonlinearConstraint(
        lambda z: w.room(w.at(z)), 0.0, float("inf"), jac=lambda z: w.room_slope(w.at(z)), hess=BFGS()
    )
    result = minimize(
        lambda z: w.goal.value(w.at(z)) / w.scale,
        problem.start(),
        jac=lambda z: w.slope(w.at(z)),
        hess=BFGS(),
        bounds=Bounds([0.0] * size, [1.0] * size, keep_feasible=True),
        constraints=[constraint],
        method="trust-constr",
        options={"maxiter": 100},
    )
    return w, result.message


def with_differential_evolution(problem: Any) -> tuple[Watched, str]:
    """SciPy's differential evolution at its defaults but a limit on generations."""
    import numpy as np
    from scipy.optimize import differential_evolution

    w = Watched(problem, slopes=False)
    result = differential_evolution(
        lambda population: np.array([w.merit(p) for p in w.batch(population.T)]),
        [(0.0, 1.0)] * len(problem.variables),
        rng=0,
        vectorized=True,
        updating="deferred",
        polish=False,
        maxiter=30,
    )
    return w, result.message


def with_cma(problem: Any) -> tuple[Watched, str]:
    """CMA-ES of the package cma at its defaults but a limit on evaluations."""
    import cma

    w, size = Watched(problem, slopes=False), len(problem.variables)
    options = {"bounds": [[0.0] * size, [1.0] * size], "maxfevals": 1500, "seed": 1, "verbose": -9, "tolfun": 1e-6}
    strategy = cma.CMAEvolutionStrategy([0.5] * size, 0.3, options)
    while not strategy.stop():
        candidates = strategy.ask()
        strategy.tell(candidates, [w.merit(point) for point in w.batch(candidates)])
    return w, ", ".join(strategy.stop())


METHODS: dict[str, Callable[[Any], tuple[Watched, str]]] = {
    "jb.tune": with_tune,
    "SciPy SLSQP": with_slsqp,
    "SciPy trust-constr": with_trust_constr,
    "differential evolution": with_differential_evolution,
    "CMA-ES": with_cma,
}
DERIVATIVE_FREE = ("differential evolution", "CMA-ES")


def compared(problem: Any, methods: list[str]) -> list[dict[str, Any]]:
    """All methods on one problem; their best designs judged at tight tolerance."""
    from jaxbuffer.tuning.search.evaluation import Evaluator
    from jaxbuffer.tuning.search.goal import Goal

    goal, rows = Goal(problem, problem.objective), []
    judge = Evaluator(problem, slopes=False)
    for name in methods:
        begin = time.perf_counter()
        try:
            watched, message = METHODS[name](problem)
        except Exception as error:  # a peer that gives up is a result, too
            rows.append({"method": name, "message": f"{type(error).__name__}: {error}", "feasible": False})
            continue
        seconds = time.perf_counter() - begin
        (point,) = judge([watched.scaled], rtol=TIGHT)
        rows.append(
            {
                "method": name,
                "objective [N]": goal.value(point),
                "feasible": goal.feasible(point),
                "captures": watched.evaluator.captures,
                "seconds": seconds,
                "message": str(message),
                "history": watched.history,
                "scaled": list(map(float, watched.scaled)),
            }
        )
        print(f"  {name}: {rows[-1]['objective [N]']:.6g} N, {watched.evaluator.captures} captures", file=sys.stderr)
    best = min((row["objective [N]"] for row in rows if row["feasible"]), default=float("nan"))
    for row in rows:
        row["above_best [-]"] = row.get("objective [N]", float("nan")) / best - 1.0
        near = [count for count, value in row.get("history", []) if value <= best * (1.0 + CLOSE)]
        row["captures_until_close"] = near[0] if near else None
    return rows


def main(
    only: str = "peak,hinge,slow,askew",
    methods: str = ",".join(METHODS),
    output: Path = Path("benchmarks/results/optimisers.json"),
) -> int:
    """Run, print, write."""
    jaxbuffer.programs.process.configure(cache=None)
    from rich.console import Console
    from rich.table import Table

    by_name, record, out = problems(), {}, Console(width=None if sys.stdout.isatty() else 150)
    for name in chosen(only.split(","), by_name, "problem"):
        print(name, file=sys.stderr)
        rows = compared(by_name[name], chosen(methods.split(","), METHODS, "method"))
        record[name] = {"objective": str(by_name[name].objective), "cases": len(by_name[name].cases), "methods": rows}
        table = Table(title=f"{name}: {by_name[name].objective}, {len(by_name[name].cases)} cases")
        for heading in ("method", "objective [N]", "above best", "feasible", "captures", "until 0.1 %", "s", "message"):
            table.add_column(heading)
        for row in rows:
            table.add_row(
                row["method"],
                f"{row.get('objective [N]', float('nan')):.6g}",
                f"{100 * row['above_best [-]']:.3f} %",
                "yes" if row["feasible"] else "no",
                str(row.get("captures", "")),
                str(row["captures_until_close"] or "never"),
                f"{row.get('seconds', float('nan')):.0f}",
                row["message"][:60],
            )
        out.print(table)
        ours = rows[0]
        others = [row for row in rows if row["method"] in DERIVATIVE_FREE and "captures" in row]
        if ours["method"] == "jb.tune" and others:
            ratio = min(row["captures"] for row in others) / ours["captures"]
            met = ours["above_best [-]"] <= CLOSE and ratio >= FEWER
            verdict = "met" if met else "MISSED"
            out.print(f"captures of the thriftier derivative-free method over ours: {ratio:.1f}; target {verdict}")
            record[name] |= {"captures_ratio": ratio, "target_met": met}
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(json.dumps(record, indent=1, default=dataclasses.asdict) + "\n")
    out.print(f"wrote {output}", highlight=False)
    return 0
