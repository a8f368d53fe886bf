"""A paper's claims as tables: the numbers of the rows that a claim concerns, the sentence that says them, and the
conditions under which the claim holds."""

import functools
import operator
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

YES, PARTLY, NO, OPEN = "confirmed", "in part", "not confirmed", "cannot be judged"
Row = dict[str, str | float | int]
Rows = dict[str, tuple[Row, ...]]
"""The rows of each study, by its name."""
NEAR = 0.03  # relative: what still counts as a printed number, or as another one
NONE = "none"  # in a row, for what its run does not have
Cases = slice | Sequence[int] | Callable[[Row], bool]


class Value(NDArrayOperatorsMixin):
    """A number that rows give, or one for each of several cases. Operators and NumPy's functions of values give values,
    case by case, as they do with arrays; comparisons are the conditions of a claim."""

    def __init__(self, of: Callable[[Rows], Any]) -> None:
        self.of = of

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> "Value":
        def of(rows: Rows) -> Any:
            return getattr(ufunc, method)(*(it.of(rows) if isinstance(it, Value) else it for it in inputs), **options)

        return Value(of)

    def __getitem__(self, case: int) -> "Value":
        return Value(lambda rows: self.of(rows)[case])

    __iter__ = None  # the number of cases is the rows' to say

    def map(self, function: Callable[[Any], Any]) -> "Value":
        """Return a function of the number, or of the array of numbers."""
        return Value(lambda rows: function(self.of(rows)))


def cell(study: str, case: int, name: str) -> Value:
    """Return the number in column ``name`` of one case's row; cases are counted from 0."""
    return Value(lambda rows: rows[study][case][name])


def column(study: str, name: str, cases: Cases = slice(None)) -> Value:
    """Return the numbers in column ``name`` of several cases: a slice or places of them, or those whose row passes a
    test."""

    def of(rows: Rows) -> Any:
        made = rows[study]
        if isinstance(cases, slice):
            return np.array([row[name] for row in made[cases]])
        if callable(cases):
            return np.array([row[name] for row in made if cases(row)])
        return np.array([made[case][name] for case in cases])

    return Value(of)


def joined(*values: Value) -> Value:
    """Return the numbers of several values, one behind the other."""
    return Value(lambda rows: np.concatenate([np.atleast_1d(value.of(rows)) for value in values]))


def listed(form: str, *values: Value, joint: str = ", ") -> Value:
    """Return a text for each case, joined: ``form`` has a place for the case's number of each value."""
    return Value(
        lambda rows: joint.join(form.format(*one) for one in zip(*(value.of(rows) for value in values), strict=True))
    )


def either(conditions: Iterable[Value]) -> Value:
    """Return whether one of several conditions holds."""
    return functools.reduce(operator.or_, conditions)


class _Shown:
    """A value in a sentence: of several numbers each takes the place's format."""

    def __init__(self, value: Any) -> None:
        self.value = value

    def __format__(self, form: str) -> str:
        if isinstance(self.value, np.ndarray):
            return ", ".join(format(one, form) for one in self.value)
        return format(self.value, form)


class ClaimVerdict(NamedTuple):
    """``finding``: what the model shows, with its numbers; ``verdict``: `YES`, `PARTLY`, `NO` or `OPEN`."""

    finding: str
    verdict: str


class Claim(NamedTuple):
    """A statement of a paper's text, and how rows answer it.

    ``where``: section and figures of the paper; ``finding``: what the model shows, with a place for each of ``values``;
    ``holds``: the parts of the claim, each a condition or one for each case: with none it cannot be judged; ``suffix``:
    of the names of the studies that it reads.
    """

    claim: str
    where: str
    finding: str
    values: tuple[Value, ...] = ()
    holds: tuple[Value | bool, ...] = ()
    suffix: str = ""

    def judge(self, rows: Rows) -> ClaimVerdict:
        """Return what the rows show, and whether the claim holds."""
        own = {name.removesuffix(self.suffix): made for name, made in rows.items() if name.endswith(self.suffix)}
        finding = self.finding.format(*(_Shown(value.of(own)) for value in self.values))
        parts = [np.ravel(it.of(own) if isinstance(it, Value) else it) for it in self.holds]
        return ClaimVerdict(finding, verdict([bool(part) for part in np.concatenate(parts)]) if parts else OPEN)


def near(value: Any, printed: Any) -> Any:
    """Return whether numbers, or values, count as the printed ones: see `NEAR`, relative to the printed ones."""
    return abs(value / printed - 1.0) < NEAR


def verdict(parts: Sequence[bool]) -> str:
    """Return `YES` if all of a claim's parts hold, `PARTLY` if some do."""
    return YES if all(parts) else PARTLY if any(parts) else NO
