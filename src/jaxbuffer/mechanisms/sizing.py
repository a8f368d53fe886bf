"""A study to begin with that a mechanism makes from a few numbers of its user's, and parts sized to fit a study."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float

from ..fields import Part, get, unit
from ..tables import table, text
from ..value_text import UNKNOWN, number_text, with_unit


class ScaledNumber(NamedTuple):
    """A number of a design, made by a rule.

    ``path``; ``value``, in the field's unit; ``usual``: the range in which it usually is, in shares of the value;
    ``rule``: how it was made, in words; ``tuned``: whether a tuning varies it in that range.
    """

    path: str
    value: float
    usual: tuple[float, float]
    rule: str
    tuned: bool = False


class ScaledStudy(NamedTuple):
    """A study that is ready to be simulated and tuned.

    ``numbers`` of the design; ``scenario``, fields of the one that is simulated, and ``rules`` of those that were not
    given as they are; ``grid``: values of its fields that a tuning combines; ``duration`` [s]; ``objective``: what a
    tuning lowers; ``limits`` with their rules, by name; ``remark``: what was made of the given numbers, in words.
    """

    numbers: tuple[ScaledNumber, ...]
    scenario: Mapping[str, Any]
    rules: Mapping[str, str]
    grid: Mapping[str, list[float]]
    duration: float
    objective: str
    limits: Mapping[str, tuple[Any, str]]
    remark: str


class Sizing(NamedTuple):
    """What a study is made from: ``task``, declared fields, and the ``study`` of such a task."""

    task: type[Part]
    study: Callable[[Any], ScaledStudy]


class SizedNumber(NamedTuple):
    """A number of a design, sized: its ``path``, its ``value`` in the field's unit, and in words the ``rule``."""

    path: str
    value: float
    rule: str


class ClosedForm(NamedTuple):
    """What a closed form says of a sized design: the largest value of a ``quantity`` over the scenarios.

    ``limit``: at most so much was wished, None where nothing was; ``rule``: the closed form in words.
    """

    quantity: str
    value: float
    unit: str
    limit: float | None
    rule: str

    @property
    def kept(self) -> bool:
        """Return whether the closed form keeps the wish."""
        return self.limit is None or self.value <= self.limit


class TradeOff(NamedTuple):
    """How closed forms go with one number of the design: its ``path``, its ``values``, and those of quantities by
    name."""

    path: str
    values: Float[np.ndarray, " values"]
    quantities: Mapping[str, Float[np.ndarray, " values"]]


class SizedParts:
    """Parts of a design that fit its scenarios, by closed forms. Print it for a summary.

    - ``before``, ``design``: the design that was given, and the sized one.
    - ``numbers``: what was sized, a `SizedNumber` each.
    - ``estimates``: what the closed forms say of it, a `ClosedForm` each.
    - ``trade_offs``: how these go with a stiffness.
    - ``remarks``: which wishes stand in each other's way, in words.
    - ``duration``: after which a run of the sized design is over, about [s]; 0 where that is not known.

    **Example:**

    >>> sized = jb.size_buffer(jb.table2(), [jb.Scenario(approach_speed=0.1)], stroke="2 cm")
    >>> [(it.path, round(it.value, 1)) for it in sized.numbers[:2]]
    [('buffer.k_A', 131.7), ('buffer.c_A', 23.5)]
    """

    def __init__(
        self,
        before: Any,
        design: Any,
        numbers: Sequence[SizedNumber],
        estimates: Sequence[ClosedForm],
        trade_offs: Sequence[TradeOff] = (),
        remarks: Sequence[str] = (),
        duration: float = 0.0,
    ) -> None:
        self.before, self.design = before, design
        self.numbers, self.estimates = tuple(numbers), {it.quantity: it for it in estimates}
        self.trade_offs, self.remarks, self.duration = tuple(trade_offs), tuple(remarks), duration

    def numbers_table(self) -> Any:
        """Return the table of what was sized."""
        made = table("Sized", ("number",), ("before", "sized"))
        made.add_column("rule")
        for it in self.numbers:
            was, symbol = get(self.before, it.path), unit(self.before, it.path)
            shown = UNKNOWN if was is None else number_text(float(was), 4)
            made.add_row(it.path, shown, with_unit(it.value, symbol, 4), it.rule)
        return made

    def __repr__(self) -> str:
        made = table("By closed forms", ("quantity",), ("value", "wished"))
        made.add_column("from")
        for it in self.estimates.values():
            wished = UNKNOWN if it.limit is None else with_unit(it.limit, it.unit, 4)
            made.add_row(it.quantity, with_unit(it.value, it.unit, 4), wished, it.rule)
        return text(self.numbers_table(), made, *self.remarks)


class Sizer(NamedTuple):
    """What sizes parts of a mechanism: what may be wished, declared fields of ``wishes`` that are named as quantities
    where they limit one, and ``size``, which takes a design, its scenarios and wishes."""

    wishes: type[Part]
    size: Callable[[Any, Sequence[Any], Any], SizedParts]
