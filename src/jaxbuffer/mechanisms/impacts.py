"""The touchdowns of a run, in order."""

import jax
import numpy as np
from jaxtyping import Array, Float, Int
from rich.table import Table

from ..fields import Portable
from ..labelled.arrays import Labelled
from ..labelled.record import heading
from ..tables import html, table, text
from .quantity import IMPACT_UNITS

MEANING = {
    "time": "touchdown",
    "approach_speed": "normal speed at touchdown",
    "peak_force": "largest force until the contact's next touchdown",
    "release_time": "release, NaN where the run ended in contact",
}


class Impacts(Portable):
    """Touchdowns in order, an entry each; slots beyond ``count`` are padding (contact -1, zeros). A run with more
    events than its log has room for lists the first ones; `Run.impact_count` counts all.

    ``time`` [s], ``contact`` (its number), ``approach_speed`` δ̇⁻ [m/s], ``peak_force`` [N] until the contact's next
    touchdown, ``release_time`` [s] (NaN where the run ended in contact).
    """

    time: Float[Array, " slots"]
    contact: Int[Array, " slots"]
    approach_speed: Float[Array, " slots"]
    peak_force: Float[Array, " slots"]
    release_time: Float[Array, " slots"]
    count: Int[Array, ""]

    def __repr__(self) -> str:
        return text(self._table()) if self._concrete else super().__repr__()

    def _repr_html_(self) -> str:
        return html(self._table() if self._concrete else super().__repr__())

    @property
    def _concrete(self) -> bool:
        """Return whether these are one run's, with numbers."""
        return not isinstance(self.count, jax.core.Tracer) and np.ndim(self.count) == 0

    def labelled(self) -> dict[str, Labelled]:
        """Return the numbers of the impacts that happened by name, an entry an impact."""
        count = int(self.count)
        return {
            name: Labelled(("impact",), np.asarray(getattr(self, name))[:count], IMPACT_UNITS[name], meaning)
            for name, meaning in MEANING.items()
        }

    def _table(self) -> Table:
        """Return a table of the impacts that happened, counted from 1."""
        count, columns = int(self.count), self.labelled()
        shown = table(f"{count} impact{'' if count == 1 else 's'}")
        for name in ("impact", "contact", *(heading(name, it.unit) for name, it in columns.items())):
            shown.add_column(name, justify="right")
        contacts = np.asarray(self.contact)[:count]
        for k, row in enumerate(zip(contacts, *(it.values for it in columns.values()), strict=True), 1):
            shown.add_row(str(k), *("-" if np.isnan(value) else f"{value:.6g}" for value in row))
        return shown
