"""``[parts]``, ``[roundings]`` and ``[choose]`` of a study: what `jaxbuffer choose` is to do."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from ..choosing.catalogue import FILE, TOTALS, PartsCatalogue, read_catalogues
from ..choosing.combinations import Combinations
from ..choosing.criterion import total_units
from ..choosing.series import SERIES, check_rule
from ..errors import InputError
from ..fields import Part, check_path, flag, whole
from ..tuning.problem.objective import Objective, SecondObjective
from ..tuning.problem.problem import Problem
from .values import TEXT, Schema, ValueKind, as_table


class ChoiceSettings(Part):
    """How a choice is made: the section ``[choose]`` of a study.

    - ``ranking``: how many of the best combinations are told.
    - ``optimum``: whether the continuous optimum is searched for beside them.
    - ``tuned``: for how many of the best the [problem.variables] are tuned.
    """

    section = "choose"
    ranking: int = whole(5, 1, 1000, doc="how many of the best combinations are told")
    optimum: bool = flag(True, doc="whether the continuous optimum over the catalogues' ranges is searched for")
    tuned: int = whole(0, 0, 1000, doc="for how many of the best [problem.variables] are tuned")


class Selection(NamedTuple):
    """What `jaxbuffer choose` chooses by: the ``problem``, its ``objective`` and ``then`` with price and mass among
    their quantities, None for the problem's own, and upper limits ``at_most`` on these."""

    problem: Problem
    objective: Objective | None
    then: SecondObjective | None
    at_most: Mapping[str, float]


def _read_rounding(where: str, path: str, given: Any, design: Part) -> Any:
    check_path(design, path)
    return check_rule(where, path, given, design)


def _rounding_schema(known: Mapping[str, Any]) -> Schema:
    words = f"an E series, or a step in {known['unit']}"
    return {"anyOf": [{"enum": list(SERIES)}, {"type": "number", "exclusiveMinimum": 0}, TEXT], "description": words}


PARTS_SCHEMA: Schema = {
    "type": "object",
    "additionalProperties": {
        "type": "object",
        "properties": {FILE: {"type": "string", "description": "a CSV file of parts, beside the study"}},
        "additionalProperties": {"type": "object", "minProperties": 1},
    },
}
PARTS = ValueKind(
    lambda where, given, names: read_catalogues(as_table(where, given), names.design, names.folder, where),
    lambda names: PARTS_SCHEMA,
)
ROUNDING = ValueKind(_read_rounding, _rounding_schema)


def sums(catalogues: tuple[PartsCatalogue, ...], design: Part) -> dict[str, str]:
    """Return the units of price and mass, of those that the parts have."""
    return total_units(Combinations(design, catalogues)) if catalogues else {}


def check_no_sums(where: str, names: Iterable[str]) -> None:
    """Raise `InputError` for an objective of price or mass, or a limit on it, which no run has."""
    for name in names:
        if name in TOTALS:
            raise InputError(
                f"problem.{where}.{name} is a sum over parts, which jaxbuffer choose alone has; leave it out"
            )
