"""What a part of the benchmarks hands back: plain figures with their units, and what they are held against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from .accuracy import Setting


@dataclass(frozen=True)
class Figure:
    """One measured number."""

    label: str
    value: float
    unit: str  # a time ("s", "ms"), a rate ("1/s") or a size ("MiB")
    errors: dict[str, float] = field(default_factory=dict)  # [-] by name
    setting: str = ""


@dataclass(frozen=True)
class Ratio:
    """The product beside another in the same run; above 1 where the product is quicker."""

    key: str  # part/name, for the baseline
    what: str
    ours: Figure
    theirs: Figure
    target: float | None = None  # [-] at least

    @property
    def value(self) -> float:
        """How many times as fast [-]: times are divided theirs by ours, rates ours by theirs."""
        if self.ours.unit != self.theirs.unit:
            raise ValueError(f"{self.key}: {self.ours.unit} against {self.theirs.unit}")
        rate = self.ours.unit.startswith("1/")
        return self.ours.value / self.theirs.value if rate else self.theirs.value / self.ours.value

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None without one."""
        return None if self.target is None else self.value >= self.target


@dataclass(frozen=True)
class Check:
    """One figure of the product against a fixed bound."""

    what: str
    figure: Figure
    bound: float  # in the figure's unit
    at_least: bool = False

    @property
    def met(self) -> bool:
        """Whether the figure is on the right side of its bound."""
        return self.figure.value >= self.bound if self.at_least else self.figure.value <= self.bound


@dataclass(frozen=True)
class Curve:
    """Points of a plot."""

    label: str
    xs: tuple[float, ...]
    ys: tuple[float, ...]


@dataclass(frozen=True)
class Plot:
    """A plot on logarithmic axes; curves of the same label share a colour."""

    name: str  # of its file
    title: str
    x: str  # with its unit
    y: str
    curves: tuple[Curve, ...]
    line: float | None = None  # a target in y


@dataclass(frozen=True)
class Part:
    """Everything one part of the benchmarks found."""

    name: str
    title: str
    ratios: tuple[Ratio, ...] = ()
    checks: tuple[Check, ...] = ()
    plots: tuple[Plot, ...] = ()
    notes: tuple[str, ...] = ()
    figures: tuple[Figure, ...] = ()  # the product's own, held against nothing


def milliseconds(setting: Setting, label: str | None = None) -> Figure:
    """The time of a setting as a figure [ms]."""
    return Figure(label or setting.solver, 1e3 * setting.seconds, "ms", setting.errors, setting.tolerances)


def precision_plot(name: str, title: str, curves: Sequence[Sequence[Setting]], error: str, target: float) -> Plot:
    """Work against precision: the ``error`` of that name over wall time; points that mean nothing are left out."""
    lines = []
    for curve in curves:
        points = [(s.seconds, s.errors[error]) for s in curve if 0.0 < s.errors[error] < float("inf")]
        if points:
            lines.append(Curve(curve[0].solver, *(tuple(axis) for axis in zip(*points, strict=True))))
    return Plot(name, title, "wall time [s]", f"relative error of {error} [-]", tuple(lines), target)
