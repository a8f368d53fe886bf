"""The tables of a study, each declared once: reading, the schema for editors, suggestions and examples follow from it.

The keys of a table are the fields of a class, here or where their values are used: `Settings`, `Objective`, `Limits`,
`Scatter`, `SecondObjective`. A key that is added there is read, checked, suggested, described and written.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any

from ..errors import InputError, check_known
from ..experiments.points import METHODS, points
from ..experiments.ranges import ranges
from ..fields import POSITIVE, Part, choice, declared, number, paths, whole
from ..hybrid import SOLVER_NAMES, Solver, solver_named
from ..mechanisms.mechanism import Mechanism
from ..run.request import DEFAULT_TOLERANCE
from ..suggestions import listed
from ..sweeps.axis import SPAN
from ..sweeps.grid import grid
from ..tuning.problem.cases import KINDS, Distribution, Scatter
from ..tuning.problem.objective import Limits, Objective, SecondObjective
from ..tuning.problem.tolerances import read_tolerances
from ..tuning.problem.variable import Variable
from .own_quantities import OWN, NamedQuantity
from .parts_toml import ROUNDING
from .tables import Keys, KeyTable, PartTable, PathTable, StudyNames, StudyTable, keys_schema, read_keys, subtable
from .values import (
    BOUNDS,
    DISTRIBUTION,
    FACTOR,
    LIMIT,
    RANGE,
    SEVERAL,
    SWEPT,
    TOLERANCE,
    WEIGHT,
    Schema,
    ValueKind,
    as_table,
    as_tables,
)


class StudyOptions(Part):
    """How to simulate.

    - ``duration``: after which a run is over [s]; None: the mechanism's.
    - ``rtol``: relative error of a step [-].
    - ``solver``: a name in `SOLVER_NAMES`.
    """

    section = "options"
    duration: float | None = number(
        None, "s", **POSITIVE, doc="time after which a run is over; not set: the mechanism's"
    )
    rtol: float = number(DEFAULT_TOLERANCE, "-", low=1e-13, high=1e-2, doc="relative error of a step")
    solver: str = choice("automatic", *SOLVER_NAMES, doc="how runs are stepped")

    def stepper(self) -> Solver:
        """Return the solver that ``solver`` names."""
        return solver_named(self.solver)


@dataclasses.dataclass(frozen=True)
class Scattered:
    """What scatters in ``[problem.sample]``, beside the keys that a `Scatter` declares."""

    scenario: Mapping[str, Distribution] = subtable(
        PathTable(DISTRIBUTION, "scenario"), "how the scenario's fields scatter"
    )
    factors: Mapping[str, Distribution] = subtable(
        PathTable(FACTOR, "design", words=KINDS), "tolerances: factors on the design's numbers, 1 being as drawn"
    )


def limit_keys(mechanism: Mechanism) -> Keys:
    """Return the keys that limits have beside quantities: those that are true or false first, ends among them."""
    keys, words = declared(Limits), f"each {mechanism.view.run_name} must end {{}} within the duration"
    ends = {it.name: {"flag": True, "default": False, "doc": words.format(it.name)} for it in mechanism.tuning.ends}
    return {**{name: known for name, known in keys.items() if "flag" in known}, **ends, **keys}


def _objective(names: StudyNames, weights: dict[str, Any], keys: dict[str, Any]) -> Objective:
    return Objective(weights, **keys) if weights else Objective(**keys)


def _then(names: StudyNames, weights: dict[str, Any], keys: dict[str, Any]) -> SecondObjective:
    if not weights:
        raise InputError(f"problem.then names no quantity; choose some of {listed(names.units)}")
    own = {name: keys.pop(name) for name in declared(SecondObjective) if name in keys}
    return SecondObjective(Objective(weights, **keys), **own)


def _limits(names: StudyNames, sides: dict[str, Any], keys: dict[str, Any]) -> Limits:
    at_most, at_least = ({name: it[side] for name, it in sides.items() if side in it} for side in ("max", "min"))
    return Limits(at_most=at_most, at_least=at_least, **keys)


VARIABLES = PathTable(BOUNDS, "design", example="buffer.k_A = [100, 2000]")
LIMITS = KeyTable(_limits, limit_keys, LIMIT, first=True)
GRID_SCENARIO = PathTable(SEVERAL, "scenario", numbers=False)
GRID_DESIGN = PathTable(SEVERAL, "design", numbers=False, words=SPAN)


class GridKind(StudyTable):
    """``[problem.grid]``: a scenario's fields by name, a design's by path."""

    def read(self, where: str, given: Any, names: StudyNames) -> dict[str, list[Any]]:
        given = as_table(where, given)
        sections = {path.partition(".")[0] for path in paths(names.design) if "." in path}
        # Quoted, a path has a point; else TOML reads it as a table in a table.
        of_design = {name: it for name, it in given.items() if "." in name or name in sections}
        of_scenario = {name: it for name, it in given.items() if name not in of_design}
        return GRID_SCENARIO.read(where, of_scenario, names) | GRID_DESIGN.read(where, of_design, names)

    def schema(self, names: StudyNames) -> Schema:
        both, of_design = GRID_SCENARIO.schema(names), GRID_DESIGN.schema(names)
        patterns = {"patternProperties": of_design["patternProperties"]} if "patternProperties" in of_design else {}
        return both | {"properties": of_design["properties"] | both["properties"]} | patterns


@dataclasses.dataclass(frozen=True)
class ProblemTable:
    """``[problem]``: what `jaxbuffer tune` is to do. A table that a study does not have is None."""

    variables: Mapping[str, Variable] | None = subtable(
        VARIABLES, 'what jaxbuffer tune may change: [low, high] or [low, high, "linear"]'
    )
    grid: Mapping[str, list[Any]] | None = subtable(
        GridKind(),
        "for every combination of these values, of fields of the scenario and, by path, of the design",
    )
    sample: Scatter | None = subtable(
        KeyTable(
            lambda names, quantities, keys: Scatter(fields=keys.pop("scenario", {}), **keys),
            lambda mechanism: declared(Scatter) | declared(Scattered),
        ),
        "robust designs by samples (Monte Carlo): what scatters, at every point of a grid",
    )
    objective: Objective | None = subtable(
        KeyTable(_objective, lambda mechanism: declared(Objective), WEIGHT),
        "what it lowers: quantities with their weights, over the worst case, the mean or cvar",
    )
    constraints: Limits | None = subtable(
        LIMITS, "what it keeps to: at most, or {min = , max = }; a run outside them exits with 1"
    )
    then: SecondObjective | None = subtable(
        KeyTable(_then, lambda mechanism: declared(Objective) | declared(SecondObjective), WEIGHT),
        "what decides among designs that are about as good as the best",
    )
    quantities: Mapping[str, NamedQuantity] | None = subtable(
        OWN, "quantities of your own, by name: Python functions of those above"
    )

    def __bool__(self) -> bool:
        """Return whether the study has any of it."""
        return any(getattr(self, field.name) is not None for field in dataclasses.fields(self))


class ProblemKind(StudyTable):
    """``[problem]``: only a study with quantities of its own has other names than ours in it."""

    def read(self, where: str, given: Any, names: StudyNames) -> ProblemTable:
        keys = declared(ProblemTable)
        check_known(as_table(where, given), keys, where)
        # First, since objectives and limits may name them.
        own = read_keys(f"{where}.", given, {"quantities": keys.pop("quantities")}, names)
        # Price and mass are among the own ones already, where the study has parts.
        names = names._replace(own={**names.own, **{name: it.unit for name, it in own.get("quantities", {}).items()}})
        return ProblemTable(**own, **read_keys(f"{where}.", given, keys, names))

    def schema(self, names: StudyNames) -> Schema:
        whole = keys_schema(declared(ProblemTable), names)
        named = {name: known["table"] for name, known in declared(ProblemTable).items()}
        of_quantities = [
            name for name, kind in named.items() if isinstance(kind, KeyTable) and kind.quantity is not None
        ]
        closed = {
            name: {"propertyNames": {"enum": list(whole["properties"][name]["properties"])}} for name in of_quantities
        }
        return whole | {"if": {"not": {"required": ["quantities"]}}, "then": {"properties": closed}}


@dataclasses.dataclass(frozen=True)
class SampleTable:
    """``[sample]``: what `jaxbuffer sample` spreads runs over."""

    count: int = whole(256, 1, doc="points; for sobol and saltelli a power of two")
    method: str | None = choice(None, *METHODS, doc="not set: sobol, and saltelli where indices are asked for")
    seed: int = whole(0, 0, doc="the same seed spreads the same points")
    ranges: Mapping[str, Any] | None = subtable(
        PathTable(RANGE, "both"), "what is spread: [low, high] or [low, high, scale]"
    )


def _sample(names: StudyNames, quantities: dict[str, Any], keys: dict[str, Any]) -> SampleTable:
    read = SampleTable(**keys)
    if read.ranges is not None:
        # Made only to be checked: a sample is drawn when it is run.
        points(ranges(read.ranges, names.design, names.scenario), read.count, read.method or METHODS[0], read.seed)
    return read


SPANNED = PathTable(SWEPT, "both", numbers=False, words=SPAN)


class SweepKind(StudyTable):
    """``[sweep]``: fields by address, each with its values."""

    def read(self, where: str, given: Any, names: StudyNames) -> dict[str, Any]:
        if read := SPANNED.read(where, given, names):
            grid(read, names.design, names.scenario)  # checks it
        return read

    def schema(self, names: StudyNames) -> Schema:
        return SPANNED.schema(names)


PROBLEM = ProblemKind()
SAMPLE = KeyTable(_sample, lambda mechanism: declared(SampleTable), hint="; ranges go under [sample.ranges]")
SWEEP = SweepKind()
ROUNDINGS = PathTable(ROUNDING, "design", example='buffer.k_A = "E24"')
TOLERANCE_PATHS = PathTable(TOLERANCE, "both")
TOLERANCES = ValueKind(
    lambda where, given, names: read_tolerances(
        TOLERANCE_PATHS.read(where, given, names), names.design, names.scenario
    ),
    TOLERANCE_PATHS.schema,
)
SCENARIO_TABLE = PartTable(lambda names: names.scenario)
# Each of [[scenarios]] begins with the fields of [scenario].
SCENARIOS = ValueKind(
    lambda where, given, names: tuple(SCENARIO_TABLE.read(name, it, names) for name, it in as_tables(where, given)),
    lambda names: {"type": "array", "items": SCENARIO_TABLE.schema(names), "minItems": 1},
)
