"""What a study asks of a single run."""

from collections.abc import Mapping
from typing import NamedTuple

from ..mechanisms.quantity import Catalogue
from ..mechanisms.run import Run
from .derived import Derived
from .objective import Limits


class Asked(NamedTuple):
    """Limits, and the ``own`` quantities, by name, that they may be on."""

    limits: Limits
    own: Mapping[str, Derived]

    def broken_by(self, run: Run) -> list[str]:
        """A line for each limit that the run does not keep to."""
        return self.limits.broken_by(run, self._own_catalogue())

    def values(self, run: Run) -> dict[str, float]:
        """Each limited quantity of the run, in its unit."""
        catalogue = {**run.mechanism.quantities, **self._own_catalogue()}
        return {name: float(catalogue[name].of(run)) for name in (*self.limits.at_most, *self.limits.at_least)}

    def _own_catalogue(self) -> Catalogue:
        return {name: derived.as_quantity(name) for name, derived in self.own.items()}
