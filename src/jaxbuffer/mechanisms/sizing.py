"""A study to begin with that a mechanism makes from a few numbers of its user's."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from ..fields import Part


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

    ``numbers`` of the design; ``scenario``, fields of the one that is simulated; ``grid``: values of its fields that a
    tuning combines; ``duration`` [s]; ``objective``: what a tuning lowers; ``limits`` with their rules, by name;
    ``remark``: what was made of the given numbers, in words.
    """

    numbers: tuple[ScaledNumber, ...]
    scenario: Mapping[str, Any]
    grid: Mapping[str, list[float]]
    duration: float
    objective: str
    limits: Mapping[str, tuple[Any, str]]
    remark: str


class Sizing(NamedTuple):
    """What a study is made from: ``task``, declared fields, and the ``study`` of such a task."""

    task: type[Part]
    study: Callable[[Any], ScaledStudy]
