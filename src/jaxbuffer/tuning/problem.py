"""The design problem as data: what may change, in which cases, what to lower and what to keep to."""

import dataclasses
import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Float

from ..capture import DEFAULT_DURATION, DEFAULT_TOLERANCE, TOLERANCES
from ..errors import (
    InputError,
    check_choice,
    check_flag,
    check_number,
    check_single,
    check_type,
    check_whole,
    shown,
    suggest,
)
from ..mechanisms import Design, Scenario, check_fit, get, paths, replace, scenario_label, unit

QUANTITIES = {  # that objectives and limits speak of; the first one is made of every impact's peak
    "peak_force": "N",
    "peak_hinge_force": "N",
    "peak_buffer_force": "N",
    "stroke": "m",
    "hinge_angle": "rad",
    "end_time": "s",
    "peak_stop_force": "N",
    "stroke_share": "-",
}
LARGEST = {"stroke_share": 1.0}  # limits that hold unless a problem sets lower ones: no buffer may come to its end
SCALES = ("log", "linear")
AGGREGATES = ("worst", "mean", "cvar")
ONE_LIMIT = "it holds for all cases"


@dataclasses.dataclass(frozen=True)
class Variable:
    """A number in the design to tune: its dotted path, its bounds in its own unit, and the ``scale`` ("log" or
    "linear") on which a step of given size counts the same everywhere between them."""

    path: str
    low: float
    high: float
    scale: str = "log"

    def value(self, place: float) -> float:
        """The number at a place between the bounds, 0 low, 1 high; exact at both ends."""
        if place <= 0.0 or place >= 1.0:
            return self.low if place <= 0.0 else self.high
        if self.scale == "log":
            return self.low * math.exp(place * math.log(self.high / self.low))
        return self.low + place * (self.high - self.low)

    def place(self, value: float) -> float:
        """The inverse of `value`."""
        if self.scale == "log":
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def slope(self, value: float) -> float:
        """d value / d place."""
        return value * math.log(self.high / self.low) if self.scale == "log" else self.high - self.low


@dataclasses.dataclass(frozen=True)
class Case:
    """One capture the design must serve: a scenario, and by which ``factors`` the built mechanism's numbers (dotted
    paths of the design) differ from the drawn one's."""

    scenario: Scenario
    factors: tuple[tuple[str, float], ...] = ()

    def __post_init__(self) -> None:
        check_type("case's scenario", self.scenario, Scenario, "Case(Scenario(approach_speed=0.2))")
        for pair in self.factors:
            if not isinstance(pair, tuple) or len(pair) != 2:
                raise InputError(
                    f"case's factors = {shown(self.factors)}; write Case(scenario, (('buffer.k_A', 1.1),))"
                )
            check_single(f"case's factor on {pair[0]}", pair[1], "-", "a case is one capture")

    def label(self, among: Sequence["Case"] = ()) -> str:
        """What people call the case: "0.2 m/s, 3°, 1.1 buffer.k_A"."""
        factors = (f", {factor:.4g} {path}" for path, factor in self.factors)
        return scenario_label(self.scenario, [case.scenario for case in among]) + "".join(factors)

    def of(self, design: Design) -> Design:
        """The mechanism as built."""
        return replace(design, {path: float(get(design, path)) * factor for path, factor in self.factors})


@dataclasses.dataclass(frozen=True)
class Objective:
    """What to lower: a weighted sum of `QUANTITIES` in each case, put together over the cases.

    **Arguments:** ``weights`` [N per unit of the quantity]: ``{"peak_force": 1, "stroke": 1e4}`` trades a millimetre of
    stroke for 10 N; ``over``: the "worst" case, the "mean", or the mean of the worst share ("cvar", conditional value
    at risk); ``level`` [-]: that share is 1 - ``level``.
    """

    weights: Mapping[str, float] = dataclasses.field(default_factory=lambda: {"peak_force": 1.0})
    over: str = "worst"
    level: float = 0.9

    def __post_init__(self) -> None:
        check_type("objective's weights", self.weights, Mapping, "Objective({'peak_force': 1.0})")
        if not self.weights:
            raise InputError("objective: no quantity is given; name one of " + ", ".join(QUANTITIES))
        for name, weight in self.weights.items():
            check_quantity("objective", name)
            check_single(f"objective.{name}", weight, f"N/{QUANTITIES[name]}", ONE_LIMIT, low=0.0, low_open=True)
        check_choice("objective.over", self.over, AGGREGATES)
        check_number("objective.level", self.level, "-", low=0.0, high=1.0, high_open=True)

    def cap(self, cases: int) -> float:
        """The largest weight of a case: each aggregate is max w·f over weights that sum to 1 and stay below it."""
        if self.over == "mean":
            return 1.0 / cases
        return 1.0 if self.over == "worst" else min(1.0, 1.0 / ((1.0 - self.level) * cases))

    def vector(self) -> Float[np.ndarray, " quantities"]:
        """The weights in the order of `QUANTITIES`."""
        return np.array([float(self.weights.get(name, 0.0)) for name in QUANTITIES])

    def aggregate(self, values: Float[np.ndarray, " cases"]) -> float:
        """The cases' values as one."""
        return float(self.case_weights(values) @ values)

    def case_weights(self, values: Float[np.ndarray, " cases"]) -> Float[np.ndarray, " cases"]:
        """How much each case counts; they sum to 1."""
        cap = self.cap(len(values))
        left = 1.0 - cap * np.arange(len(values))
        weights = np.empty(len(values))
        weights[np.argsort(-values, kind="stable")] = np.clip(left, 0.0, cap)
        return weights

    def __str__(self) -> str:
        names = [f"{w:g} {name}" if w != 1.0 else name for name, w in self.weights.items()]
        over = f"mean of the worst {1.0 - self.level:.3g}" if self.over == "cvar" else self.over
        return f"{' + '.join(names)}, {over} over the cases"


@dataclasses.dataclass(frozen=True)
class Limits:
    """What every case must keep to: ``captured`` within the duration; ``at_most``: upper limits of `QUANTITIES` in
    their units, of ``stroke_share`` always 1 at most (beyond, the buffer has come to its end); ``impacts``: at most so
    many touchdowns (a whole number, so without a gradient: a design that breaks it is rejected, none is led back by
    it)."""

    captured: bool = True
    at_most: Mapping[str, float] = dataclasses.field(default_factory=dict)
    impacts: int | None = None

    def __post_init__(self) -> None:
        check_type("constraints' at_most", self.at_most, Mapping, "Limits(at_most={'stroke': 0.025})")
        for name, limit in self.at_most.items():
            check_quantity("constraints", name)
            high = LARGEST.get(name, math.inf)
            check_single(f"constraints.{name}", limit, QUANTITIES[name], ONE_LIMIT, low=0.0, low_open=True, high=high)
        check_flag("constraints.captured", self.captured)
        if self.impacts is not None:
            check_whole("constraints.impacts", self.impacts, 1)


@dataclasses.dataclass(frozen=True)
class Then:
    """What decides among designs whose objective is within ``slack`` [-] of the best: a second objective."""

    objective: Objective
    slack: float = 0.01

    def __post_init__(self) -> None:
        check_type("then's objective", self.objective, Objective, "Then(Objective({'stroke': 1.0}))")
        check_number("then.slack", self.slack, "-", low=0.0, high=1.0, low_open=True)


@dataclasses.dataclass(frozen=True)
class Problem:
    """A design problem.

    **Arguments:** ``design`` to start from; ``scenarios``: `Scenario`s or `Case`s to serve; ``variables``;
    ``objective``; ``limits``; ``then``: what decides beyond the objective, or None; ``duration`` [s], ``rtol`` [-] as
    for `simulate`. **Raises:** `InputError` for names that are unknown, empty lists, bounds that are crossed or do not
    hold the start.
    """

    design: Design
    scenarios: Sequence[Scenario | Case]
    variables: Sequence[Variable]
    objective: Objective = dataclasses.field(default_factory=Objective)
    limits: Limits = dataclasses.field(default_factory=Limits)
    then: Then | None = None
    duration: float = DEFAULT_DURATION
    rtol: float = DEFAULT_TOLERANCE

    def __post_init__(self) -> None:
        self._check_parts()
        cases = tuple(s if isinstance(s, Case) else Case(s) for s in self.scenarios)
        object.__setattr__(self, "cases", cases)
        object.__setattr__(self, "variables", tuple(self.variables))
        if not cases:
            raise InputError("scenarios is empty; tuning needs at least one")
        _check_variables(self.design, self.variables)
        self._check_stroke()
        for number, case in enumerate(cases, 1):
            try:
                check_fit(case.of(self.design), case.scenario)
            except InputError as error:
                raise InputError(f"scenario {number} ({case.label(cases)}): {error}") from None

    def _check_parts(self) -> None:
        check_type("design", self.design, Design, "a design such as jb.table2()")
        for name, values, example in (
            ("scenarios", self.scenarios, "[Scenario(approach_speed=0.2)]"),
            ("variables", self.variables, "[Variable('buffer.k_A', 100.0, 2000.0)]"),
        ):
            if not isinstance(values, Iterable) or isinstance(values, (str, bytes, Mapping)):
                raise InputError(f"{name} = {shown(values)} is not a list; write {example}")
        check_type("objective", self.objective, Objective, "Objective({'peak_force': 1.0})")
        check_type("limits", self.limits, Limits, "Limits(at_most={'stroke': 0.025})")
        if self.then is not None:
            check_type("then", self.then, Then, "Then(Objective({'stroke': 1.0}))")
        check_single("duration", self.duration, "s", ONE_LIMIT, low=0.0, low_open=True)
        check_single("rtol", self.rtol, "-", ONE_LIMIT, **TOLERANCES)

    def _check_stroke(self) -> None:
        """A limit on the stroke beyond the longest one that a design within the bounds allows limits nothing."""
        longest = {"buffer.max_stroke", "buffer.free_length"}
        corners = [{v.path: v.high for v in self.variables if v.path in longest}, {}]
        most = max(float(np.asarray(replace(self.design, corner).buffer.longest_stroke)) for corner in corners)
        if (limit := self.limits.at_most.get("stroke", 0.0)) > most:
            raise InputError(
                f"constraints.stroke = {limit:g} m is out of range; allowed: (0, {most:g}] m, the buffer's end"
                " (buffer.max_stroke, or buffer.free_length with an end stop or without max_stroke)"
            )

    cases: tuple[Case, ...] = dataclasses.field(init=False, default=())

    @property
    def meetings(self) -> tuple[Scenario, ...]:
        """The cases' scenarios, as often as they occur."""
        return tuple(case.scenario for case in self.cases)

    @property
    def paths(self) -> tuple[str, ...]:
        """The variables' dotted paths."""
        return tuple(v.path for v in self.variables)

    def start(self) -> Float[np.ndarray, " variables"]:
        """The design's places between the bounds [-]."""
        return np.array([v.place(float(get(self.design, v.path))) for v in self.variables])

    def values(self, places: Iterable[float]) -> Float[np.ndarray, " variables"]:
        """The variables' numbers, each in its unit, at places between their bounds (0 low, 1 high)."""
        return np.array([v.value(float(z)) for v, z in zip(self.variables, places, strict=True)])

    def built(self, places: Iterable[float]) -> Design:
        """The design at those places."""
        return replace(self.design, dict(zip(self.paths, map(float, self.values(places)), strict=True)))

    def fingerprint(self) -> str:
        """The same for the same problem, so that a run goes on with none but its own."""
        listed = [f"{path}={get(self.design, path)!r}" for path in paths(self.design)]
        for case in self.cases:
            listed.append(repr([getattr(case.scenario, name) for name in paths(case.scenario)]) + repr(case.factors))
        rest: tuple[Any, ...] = (self.variables, self.objective, self.limits, self.then, self.duration, self.rtol)
        return hashlib.sha256("\n".join([*listed, *map(repr, rest)]).encode()).hexdigest()[:16]


def check_quantity(where: str, name: str) -> None:
    """Raise `InputError` unless ``name`` is one of `QUANTITIES`."""
    if name not in QUANTITIES:
        raise InputError(f"{where}.{name} is unknown{suggest(name, QUANTITIES)}")


def _check_variables(design: Design, variables: Sequence[Variable]) -> None:
    if not variables:
        raise InputError("variables is empty; tuning needs at least one")
    seen: set[str] = set()
    for variable in variables:
        check_type("variable", variable, Variable, "Variable('buffer.k_A', 100.0, 2000.0)")
        path, value = variable.path, get(design, variable.path)
        if path in seen:
            raise InputError(f"{path} is named twice among the variables")
        seen.add(path)
        if value is None or isinstance(value, (str, bool)):
            raise InputError(f"{path} = {value!r} is not a number that can be tuned")
        check_choice(f"{path} scale", variable.scale, SCALES)
        name, above_zero = unit(design, path), variable.scale == "log"
        lowest: dict[str, Any] = {"low": 0.0, "low_open": True} if above_zero else {}
        check_single(f"{path} low bound", variable.low, name, ONE_LIMIT, **lowest)
        check_single(f"{path} high bound", variable.high, name, ONE_LIMIT, low=variable.low, low_open=True)
        for bound in (variable.low, variable.high):
            replace(design, {path: bound})  # the design itself says what it does not allow
        check_single(path, value, name, "tuning starts from one design")
        if not variable.low <= value <= variable.high:
            bounds = f"[{variable.low:g}, {variable.high:g}] {name}".rstrip(" -")
            raise InputError(
                f"the start, {path} = {value:g} {name}, is outside its bounds {bounds}".replace(" -,", ",")
            )
