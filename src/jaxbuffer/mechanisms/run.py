"""A simulated run of any mechanism."""

from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int
from rich.table import Table

from .._types import Scalar
from ..fields import Portable
from ..hybrid import Log, Result, moving
from ..tables import html, table, text
from .energy import Balance, Energy
from .history import History
from .quantity import check_quantities, of_impact
from .registry import mechanism_of

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from .mechanism import Mechanism
    from .outcome import RunOutcome


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
        """Whether these are one run's, with numbers."""
        return not isinstance(self.count, jax.core.Tracer) and np.ndim(self.count) == 0

    def _table(self) -> Table:
        """The impacts that happened, counted from 1."""
        count = int(self.count)
        shown = table(f"{count} impact{'' if count == 1 else 's'}")
        columns = {
            "contact": self.contact,
            "time [s]": self.time,
            "approach_speed [m/s]": self.approach_speed,
            "peak_force [N]": self.peak_force,
            "release_time [s]": self.release_time,
        }
        for heading in ("impact", *columns):
            shown.add_column(heading, justify="right")
        for k, row in enumerate(zip(*(np.asarray(it)[:count] for it in columns.values()), strict=True), 1):
            shown.add_row(str(k), *("-" if np.isnan(value) else f"{value:.6g}" for value in row))
        return shown


class Maxima(NamedTuple):
    """Largest values over a run: contact force [N] with its time [s] and contact, and those of the other observables
    by name."""

    peak_force: Float[Array, ""]
    peak_time: Float[Array, ""]
    peak_contact: Int[Array, ""]
    others: dict[str, Float[Array, ""]]


class Run(Portable):
    """A simulated run. Print it for a summary.

    Numbers are 0-d arrays, differentiable with respect to design and scenario; in a failed run they are NaN.

    - ``design``, ``scenario``: what was simulated.
    - ``code``: the outcome's.
    - ``peak_force``: largest force of any contact [N].
    - ``peak_time``: when that is [s].
    - ``peak_contact``: the number of that contact.
    - ``peak_impact``: index into ``impacts``, -1 if the impact is not listed there.
    - ``maxima``: largest values of the mechanism's other observables by name, in their units.
    - ``penetration``: the depth at which the contact's spring alone exerts the peak force, which the deepest
      penetration does not exceed [m] (M72).
    - ``end_time``: when the run ended [s].
    - ``contact_time``: how long at least one contact was closed [s].
    - ``impact_count``: number of touchdowns.
    - ``impacts``: touchdowns in order.
    - ``energy``: the energies at the end [J].
    - ``balance``: what numerical error did to conserved quantities.
    - ``history``: None unless asked for.
    - ``attempts``, ``accepted``: steps tried and taken.
    - ``stabilisation``: Baumgarte's gain [1/s].

    **Example:**

    >>> run = jb.simulate(jb.table2(), jb.Scenario())
    >>> first = run.quantity("impact.1.peak_force")
    >>> print(f"{float(first):.2f} N, the first of {int(run.impact_count)} impacts")
    141.58 N, the first of 24 impacts
    """

    design: Any
    scenario: Any
    code: Int[Array, ""]
    peak_force: Float[Array, ""]
    peak_time: Float[Array, ""]
    peak_contact: Int[Array, ""]
    peak_impact: Int[Array, ""]
    maxima: dict[str, Float[Array, ""]]
    penetration: Float[Array, ""]
    end_time: Float[Array, ""]
    contact_time: Float[Array, ""]
    impact_count: Int[Array, ""]
    impacts: Impacts
    energy: Energy
    balance: Balance
    history: History | None
    attempts: Int[Array, ""]
    accepted: Int[Array, ""]
    stabilisation: Float[Array, ""]
    _located: Log  # `log` with derivatives at fixed times

    @property
    def mechanism(self) -> "Mechanism":
        """What this is a run of."""
        return mechanism_of(self.design)

    @property
    def outcome(self) -> "RunOutcome | Any":
        """How it ended; the integer code (an array) inside compiled code or for a batch."""
        return self.code if self._many else self.mechanism.outcomes(int(self.code))

    @property
    def diagnosis(self) -> list[str]:
        """What held the run back, a line each; nothing of one that succeeded or failed."""
        mechanism, outcome = self.mechanism, self.outcome
        succeeded = mechanism.success is None or outcome.name == mechanism.success
        if succeeded or outcome.failed or not (told := mechanism.diagnosis(self)):
            return []
        return [f"why it was not {mechanism.success}", *(f"  {heading:20} {text}" for heading, text in told.items())]

    @property
    def log(self) -> Log:
        """Located events, differentiable as they move with design and scenario: see `hybrid.moving`."""
        return moving(self._located, (self.design, self.scenario, self.stabilisation), self.mechanism.system)

    def quantity(self, name: str) -> Float[Array, ""]:
        """A quantity of the mechanism's catalogue by name, or of an impact, as in "impact.3.peak_force".

        **Raises:** `InputError` with the nearest name for one that is unknown.
        """
        catalogue = self.mechanism.quantities
        check_quantities(catalogue, (name,))
        asked = of_impact(name)
        if asked is None:
            return catalogue[name].of(self)
        return jnp.where(asked.slot < self.impacts.count, asked.of(self), jnp.nan)

    @property
    def _many(self) -> bool:
        """Whether this is a batch, or traced."""
        return isinstance(self.code, jax.core.Tracer) or bool(np.ndim(self.code))

    def to_xarray(self) -> "xr.Dataset":
        """The run as labelled arrays, each with its unit in the attribute ``units``.

        - Without dimension: the quantities that sweeps have, such as ``peak_force``.
        - Along ``impact``, the impacts that happened: ``impact_time``, ``impact_contact``, ``impact_approach_speed``,
          ``impact_peak_force``, ``impact_release_time``.
        - Along ``energy``: ``energy_at_end``.
        - With a history along ``step``, whose coordinate is ``time``: ``gap``, ``contact_force`` and so on by
          ``contact``, ``position_x`` … ``velocity_angle`` by ``body``, ``energy_history`` by ``energy``, the joints'
          multipliers as ``multiplier_…`` and the mechanism's own as ``…_history``.
        - Attributes: ``kind`` of the mechanism, ``outcome``, version, ``design`` and ``scenario`` as JSON.

        **Raises:** `InputError` for a batch of runs.

        **Example:**

        >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22)
        >>> data = run.to_xarray()
        >>> f"{float(data.peak_force):.1f} {data.peak_force.units}, {data.sizes['impact']} impact, {data.outcome}"
        '1831.5 N, 1 impact, finished'
        """
        from .dataset import run_dataset

        return run_dataset(self)

    def to_pandas(self) -> "pd.DataFrame":
        """The history as a table: a row a step, columns named with their units, as in ``"time [s]"``.

        **Raises:** `InputError` for a run without a history.

        **Example:**

        >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22, history=True)
        >>> f"{run.to_pandas()['contact_force plate [N]'].max():.1f} N"
        '1831.5 N'
        """
        from ..labelled.arrays import frame
        from .history_table import history_columns

        columns = history_columns(self)
        return frame(list(columns), np.column_stack(list(columns.values())).tolist())

    def __repr__(self) -> str:
        if self._many:
            return f"{type(self).__name__}(batch or traced, code={self.code})"
        return "\n".join([self.mechanism.summary(self), *(f"  {line}" for line in self.diagnosis)])

    def _repr_html_(self) -> str:
        from ..tables import summary_html

        return summary_html(repr(self))


class Solved(NamedTuple):
    """What the time stepping found of a run, and what was read off: for `Mechanism.run`.

    ``parameters``: design, scenario and Baumgarte's gain [1/s]; ``duration`` [s]; ``start``: the first posture;
    ``result`` of the time stepping; ``log``: its events with derivatives as they move; ``code`` of the outcome;
    ``known``: 1, or NaN for a failed run, a factor so that derivatives are NaN too; ``common``: the fields of every
    `Run`, by name.
    """

    parameters: tuple[Any, Any, Scalar]
    duration: Scalar
    start: Any
    result: Result
    log: Log
    code: Int[Array, ""]
    known: Float[Array, ""]
    maxima: Maxima
    common: dict[str, Any]


def plain_run(system: Any, solved: Solved) -> Run:
    """The run of a mechanism that adds nothing of its own."""
    return Run(**solved.common)
