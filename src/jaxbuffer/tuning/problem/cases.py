"""Load cases, the runs that a design must serve: one by one, as a grid of scenarios, or sampled from what scatters."""

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import scipy
from jaxtyping import Float

from ...errors import InputError, check_choice, check_single, check_type, shown
from ...fields import SCENARIO, Curve, Part, as_displayed, check_declared, check_path, get, replace, unit, whole
from ...mechanisms import all_mechanisms
from ...mechanisms.registry import mechanism_of_scenario
from ...value_text import unit_text, with_unit

KINDS = ("uniform", "normal")
MOST = 100_000  # cases in a sample
WHOLE_CORNERS = 6  # ranges up to which each corner of them is run
DEVIATIONS = 2.0  # of a normal distribution, from its mean to the ends of its range
ONE_NUMBER = "a distribution has two numbers"


@dataclasses.dataclass(frozen=True)
class Case:
    """A load case: one run that the design must serve.

    **Arguments:**

    - ``scenario``: of the design's mechanism.
    - ``factors``: pairs of a dotted path of the design and the factor by which the built mechanism's number differs
      from the drawn one's [-].
    - ``shifts``: pairs of a path and what is added to the number, after its factor, in its unit.
    - ``values``: pairs of a path and what stands there in place of the design's number, before factor and shift.

    **Raises:** `InputError` for what is no scenario, and for factors, shifts or values that are not such pairs.

    **Example:** a spring that came out 10 % too stiff.

    >>> case = jb.Case(jb.Scenario(approach_speed=0.2), factors=(("buffer.k_A", 1.1),))
    >>> print(f"{case.label()}: {case.of(jb.table2()).buffer.k_A:g} N/m")
    0.2 m/s, 0°, 1.1 buffer.k_A: 550 N/m
    """

    scenario: Part
    factors: tuple[tuple[str, float], ...] = ()
    shifts: tuple[tuple[str, float], ...] = ()
    values: tuple[tuple[str, Any], ...] = ()

    def __post_init__(self) -> None:
        try:
            mechanism_of_scenario(self.scenario)
        except InputError as error:
            raise InputError(f"case's {error}; write Case(Scenario(approach_speed=0.2))") from None
        for what in ("factors", "shifts", "values"):
            for pair in getattr(self, what):
                if not isinstance(pair, tuple) or len(pair) != 2:
                    example = "Case(scenario, (('buffer.k_A', 1.1),))"
                    raise InputError(f"case's {what} = {shown(getattr(self, what))}; write {example}")
        for path, number in (*self.factors, *self.shifts):
            check_single(f"case's factor on {path}", number, "-", "a case is one run")

    def label(self, among: Sequence["Case"] = ()) -> str:
        """Return what people call the load case: "0.2 m/s, +3°, 1.1 buffer.k_A"."""
        mechanism = mechanism_of_scenario(self.scenario)
        scenario = mechanism.view.label(self.scenario, [case.scenario for case in among])
        return scenario + built_label(mechanism.design(), self.factors, self.shifts, self.values)

    def of(self, design: Part) -> Part:
        """Return the design as built."""
        if not (self.factors or self.shifts or self.values):
            return design
        factors, shifts, values = dict(self.factors), dict(self.shifts), dict(self.values)
        built = dict(values)
        for path in (*factors, *shifts):
            number = float(values.get(path, get(design, path)))
            built[path] = number * factors.get(path, 1.0) + shifts.get(path, 0.0)
        return replace(design, built)


def numbered(label: str, number: str = "") -> str:
    """Return the label of a load case behind its number, if it has one: "2: 0.2 m/s"; for tables and figures."""
    return f"{number}: {label}" if number else label


def in_sentence(label: str, number: str = "") -> str:
    """Return the label of a load case as a sentence names it: "scenario 2 (0.2 m/s)"; a single one has no number."""
    return f"scenario {number} ({label})" if number else label


def built_label(
    design: Part,
    factors: Iterable[tuple[str, float]] = (),
    shifts: Iterable[tuple[str, float]] = (),
    values: Iterable[tuple[str, Any]] = (),
) -> str:
    """Return in words how a built mechanism differs from the drawn one, each after a comma; ``design``: for units."""
    texts = [
        *(f"{path} = {with_unit(*as_displayed(x, unit(design, path)), 4)}" if unit(design, path) else f"{path} = {x}"
          for path, x in values),
        *(f"{factor:.4g} {path}" for path, factor in factors),
        *(f"{path} {with_unit(*as_displayed(x, unit(design, path)), 4, sign=True)}" for path, x in shifts),
    ]  # fmt: skip
    return "".join(f", {text}" for text in texts)


@dataclasses.dataclass(frozen=True)
class Distribution:
    """A distribution says how a number scatters.

    It is "uniform" between ``first`` and ``second``, or "normal" with mean and deviation.
    """

    kind: str
    first: float
    second: float

    def __post_init__(self) -> None:
        check_choice("distribution", self.kind, KINDS)
        check_single(f"{self.kind}, first number", self.first, "-", ONE_NUMBER)
        low: dict[str, Any] = {"low": self.first} if self.kind == "uniform" else {"low": 0.0}
        check_single(f"{self.kind}, second number", self.second, "-", ONE_NUMBER, **low, low_open=True)

    def at(self, share: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
        """Return the quantiles of these shares."""
        if self.kind == "uniform":
            return self.first + share * (self.second - self.first)
        return np.asarray(scipy.stats.norm.ppf(share, self.first, self.second))

    @property
    def range(self) -> tuple[float, float]:
        """Return its ends; those of a normal distribution are two deviations on either side of the mean."""
        if self.kind == "uniform":
            return self.first, self.second
        return self.first - DEVIATIONS * self.second, self.first + DEVIATIONS * self.second


@dataclasses.dataclass(frozen=True)
class Scatter:
    """How scenarios and the built design scatter, to sample load cases from.

    **Arguments:**

    - ``count``: samples of each scenario, a Latin hypercube: each distribution is met evenly even by few of them.
    - ``fields``: distributions of the scenario's fields, in their units.
    - ``factors``: distributions of factors on numbers of the design [-], 1 being as drawn, by dotted path.
    - ``seed``: the same one draws the same samples.

    **Raises:** `InputError` for counts and seeds that are no such numbers, and where nothing scatters.
    """

    count: int = whole(
        16, 1, doc="samples of each scenario; their largest is no bound, so the ranges' corners are run too"
    )
    fields: Mapping[str, Distribution] = dataclasses.field(default_factory=dict)
    factors: Mapping[str, Distribution] = dataclasses.field(default_factory=dict)
    seed: int = whole(0, 0, doc="the same seed draws the same samples")

    def __post_init__(self) -> None:
        check_declared(self, "sample.")
        if not self.fields and not self.factors:
            raise InputError("sample: nothing scatters; give a field of the scenario or of the design a distribution")
        for name, distribution in (*self.fields.items(), *self.factors.items()):
            check_type(f"sample.{name}", distribution, Distribution, "Distribution('uniform', 0.9, 1.1)")

    @property
    def distributions(self) -> dict[str, Distribution]:
        """Return all distributions, the scenario's first, by the address of their number."""
        return {f"scenario.{name}": distribution for name, distribution in self.fields.items()} | dict(self.factors)

    def cases(self, scenarios: Sequence[Case], design: Part) -> tuple[Case, ...]:
        """Return the samples, each at every scenario. ``design``: to check the paths of ``factors`` with.

        **Raises:** `InputError` for unknown fields, those that are no numbers, ends of a range that a scenario does not
        allow, and too many cases.
        """
        if (most := MOST // len(scenarios)) < self.count:
            raise InputError(f"sample.count = {self.count} is out of range; allowed: [1, {most}]")
        for scenario in scenarios:
            for name in self.fields:
                check_path(scenario.scenario, name)
        for path in self.factors:
            value = get(design, path)
            if value is None or isinstance(value, (str, bool, Curve)):
                raise InputError(f"sample: {path} = {value!r} is not a number that can scatter")
        self.corners(scenarios)  # raises for ends of a range that a scenario does not allow
        # Quantiles of evenly spread shares, so that each distribution is met evenly.
        shares = scipy.stats.qmc.LatinHypercube(len(self.distributions), rng=self.seed).random(self.count).T
        spread = [d.at(s) for d, s in zip(self.distributions.values(), shares, strict=True)]
        return self._at(scenarios, np.array(spread).T)

    def corners(self, scenarios: Sequence[Case]) -> tuple[Case, ...]:
        """Return the corners of all ranges, each at every scenario: every one of up to six ranges, of more a
        fraction."""
        return self.at(scenarios, corner_signs(len(self.distributions)))

    def middle(self, scenarios: Sequence[Case]) -> tuple[Case, ...]:
        """Return the middle of all ranges at every scenario."""
        return self.at(scenarios, np.zeros((1, len(self.distributions))))

    def at(self, scenarios: Sequence[Case], signs: Float[np.ndarray, "n numbers"]) -> tuple[Case, ...]:
        """Return the low end (-1), the middle (0) or the high end (1) of each range, row by row, at every scenario."""
        ends = np.array([it.range for it in self.distributions.values()])
        numbers = np.where(signs > 0, ends[:, 1], np.where(signs < 0, ends[:, 0], np.mean(ends, axis=1)))
        return self._at(scenarios, numbers)

    def _at(self, scenarios: Sequence[Case], rows: Float[np.ndarray, "n numbers"]) -> tuple[Case, ...]:
        """Return each row of numbers at every scenario, all rows of the first one first."""
        split, names, cases = len(self.fields), [*self.distributions], list[Case]()
        for case, row in itertools.product(scenarios, rows.tolist()):
            # The scenario's numbers come first in each row, as in `distributions`.
            scenario = dataclasses.replace(case.scenario, **dict(zip(self.fields, row[:split], strict=True)))
            drawn = dict(zip(names[split:], row[split:], strict=True))
            factors = dict(case.factors)
            # A scenario may have a factor of its own on the same number: both hold, so that they are multiplied.
            factors |= {path: factor * factors.get(path, 1.0) for path, factor in drawn.items()}
            cases.append(dataclasses.replace(case, scenario=scenario, factors=tuple(factors.items())))
        return tuple(cases)


def corner_signs(count: int) -> Float[np.ndarray, "corners numbers"]:
    """Return corners of a number of ranges as rows of -1 and 1: every one of up to six ranges, of more a fraction.

    In the fraction each two ranges, and each three of up to 32, take all combinations of their ends equally often.
    It is a two-level fractional factorial design (Box and Hunter, 1961): a range is at its high end where an odd
    number of the basic factors in its own set are. The sets are distinct, those of odd size first.
    """
    # 2**basic - 1 sets are not empty, and each range needs one of its own.
    basic = min(count, max(WHOLE_CORNERS, count.bit_length()))
    sets = sorted(range(1, 2**basic), key=lambda it: (it.bit_count() % 2 == 0, it.bit_count()))[:count]
    high = [[(row & it).bit_count() % 2 for it in sets] for row in range(2**basic)]
    return 2.0 * np.array(high, float).reshape(2**basic, count) - 1.0


def _values_of(base: Part, name: str) -> str:
    symbol = unit(base, name)
    return f"values{unit_text(symbol, ' in ')}" if symbol else "choices"


def grid_address(name: str) -> str:
    """Return the address of a field of a grid: a path with a point is the design's, any other the scenario's."""
    return name if "." in name else f"{SCENARIO}{name}"


def grid(fields: Mapping[str, Sequence[Any]], base: Part | None = None, design: Part | None = None) -> tuple[Case, ...]:
    """Return every combination of the listed values of fields of the scenario and, by dotted path, of the design.

    The scenario's other fields are those of ``base``, by default of the first mechanism's scenario; ``design``: whose
    paths are checked.
    """
    base = all_mechanisms()[0].scenario() if base is None else base
    design = mechanism_of_scenario(base).design() if design is None else design
    check_type("grid's fields", fields, Mapping, "grid({'approach_speed': [0.1, 0.2]})")
    for name, values in fields.items():
        owner = design if "." in str(name) else base
        check_path(owner, name)
        if not isinstance(values, (Sequence, np.ndarray)) or isinstance(values, (str, bytes)):
            raise InputError(f"grid.{name} = {shown(values)} is not a list of {_values_of(owner, name)}")
        if not len(values):
            raise InputError(f"grid.{name} is empty; list at least one of its {_values_of(owner, name)}")
    if (count := math.prod(len(values) for values in fields.values())) > MOST:
        raise InputError(f"grid: {count:.4g} combinations of values are too many to tune for; at most {MOST}")
    cases = []
    for values in itertools.product(*fields.values()):
        point = dict(zip(fields, values, strict=True))
        scenario = {name: value for name, value in point.items() if "." not in name}
        built = tuple((name, value) for name, value in point.items() if "." in name)
        cases.append(Case(dataclasses.replace(base, **scenario), values=built))
    return tuple(cases)
