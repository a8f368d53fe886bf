"""The data of a design problem, and what follows from them alone: quantities by name, load cases as drawn."""

import dataclasses
import functools
from collections.abc import Mapping, Sequence
from typing import Any

from ...fields import Part
from ...mechanisms.mechanism import Mechanism
from ...mechanisms.quantity import PEAK_FORCE, Catalogue
from ...mechanisms.registry import mechanism_of
from .cases import Case, Scatter
from .custom_quantity import CustomQuantity
from .objective import Limits, Objective, SecondObjective
from .variable import Variable


@dataclasses.dataclass(frozen=True)
class ProblemData:
    """The fields of a `Problem`, which says what each is."""

    design: Part
    scenarios: Sequence[Part | Case]
    variables: Sequence[Variable]
    objective: Objective
    limits: Limits
    then: SecondObjective | None
    duration: float
    rtol: float
    quantities: Mapping[str, CustomQuantity]
    scatter: Scatter | None
    units: Mapping[str, str]
    tolerances: Mapping[str, Any]
    signs: tuple[tuple[float, ...], ...]

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism whose designs are tuned."""
        return mechanism_of(self.design)

    @functools.cached_property
    def drawn(self) -> tuple[Case, ...]:
        """Return the load cases without tolerances: the scenarios, or the samples of them."""
        cases = tuple(it if isinstance(it, Case) else Case(it) for it in self.scenarios)
        return cases if self.scatter is None or not cases else self.scatter.cases(cases, self.design)

    @property
    def names(self) -> tuple[str, ...]:
        """Return the quantities that objectives and constraints may use: the `peak_quantity` first, the own ones
        last."""
        return (*self._tuned, *self.quantities)

    @functools.cached_property  # asked for hundreds of times in a search
    def _tuned(self) -> tuple[str, ...]:
        names = [name for name in self.mechanism.tuned if self.mechanism.has(name, self.design)]
        # First, because an `Evaluation` has the peak force apart from the rest.
        return tuple(sorted(names, key=lambda name: name != self.mechanism.name_of(PEAK_FORCE)))

    @functools.cached_property
    def peak_quantity(self) -> str | None:
        """Return the one of the `names` that is known of every impact; None where there is none."""
        name = self.mechanism.name_of(PEAK_FORCE)
        return name if name in self.names else None

    @functools.cached_property
    def main_quantity(self) -> str:
        """Return the one of the `names` that stands for a run where nothing is said."""
        return self.mechanism.main_quantity(self.names, self.design)

    @property
    def measured(self) -> tuple[str, ...]:
        """Return the mechanism's quantities among `names`, then those that only the own ones are made of."""
        parameters = (name for derived in self.quantities.values() for name in derived.parameters)
        return tuple(dict.fromkeys((*self._tuned, *parameters)))

    @property
    def rest(self) -> tuple[str, ...]:
        """Return the `names` without the `peak_quantity`."""
        return tuple(name for name in self.names if name != self.peak_quantity)

    @property
    def measured_rest(self) -> tuple[str, ...]:
        """Return the `measured` quantities without the `peak_quantity`."""
        return tuple(name for name in self.measured if name != self.peak_quantity)

    @property
    def catalogue(self) -> Catalogue:
        """Return the mechanism's quantities and the own ones."""
        own = {name: derived.as_quantity(name) for name, derived in self.quantities.items()}
        return {**self.mechanism.quantities, **own}

    @property
    def paths(self) -> tuple[str, ...]:
        """Return the variables' dotted paths."""
        return tuple(v.path for v in self.variables)
