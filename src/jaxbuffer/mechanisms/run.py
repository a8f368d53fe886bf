"""A simulated run of any mechanism."""

import functools
from collections import Counter
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._types import DataFrame, Dataset, Scalar
from ..errors import InputError, check_choice, suggest
from ..fields import Part, Portable
from ..hybrid import Kind, Log, Result, moving
from ..labelled.arrays import frame
from ..labelled.saved import Saved
from ..programs.cache import Static, stored
from ..tables import summary_html
from ..value_text import range_text
from .cautions import cautions
from .energy import Balance, Energy
from .history import History
from .impacts import Impacts
from .loads import load
from .mechanism import Mechanism
from .outcome import RunOutcome
from .plain_summary import plain_summary
from .quantity import LOAD_UNITS, NEGLIGIBLE, OfImpact, check_quantities, of_impact
from .reading import Reading
from .registry import mechanism_of
from .run_arrays import history_columns, run_dataset

QUICK = 0.3  # s, to compile what assembles a mechanism
TOGETHER = 8  # impacts whose loads are computed in one call
ROUNDING = 1e-6  # relative, of a maximum that is evaluated again with derivatives


class Maxima(NamedTuple):
    """Largest values over a run: contact force [N] with its time [s] and contact, and those of the other observables
    by name."""

    peak_force: Float[Array, ""]
    peak_time: Float[Array, ""]
    peak_contact: Int[Array, ""]
    others: dict[str, Float[Array, ""]]


class Run(Portable, Saved):
    """A simulated run. Print it for a summary.

    Numbers are 0-d arrays, differentiable with respect to design and scenario; in a failed run they are NaN.

    - ``design``, ``scenario``: what was simulated.
    - ``code``: the outcome's.
    - ``peak_force``: largest force of any contact [N].
    - ``peak_time``: when that is [s], NaN where nothing touches.
    - ``peak_contact``: the number of that contact, -1 where nothing touches.
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
    _located: Log  # `log` with derivatives at fixed times; None of a tank, whose events are not located
    # The names of the log's ``values``: to ask the system for them would trace it.
    _observed: tuple[str, ...] = eqx.field(static=True)

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism that this is a run of."""
        return mechanism_of(self.design)

    @property
    def outcome(self) -> RunOutcome | Any:
        """Return how the run ended; of a batch an array of that, and inside compiled code the integer code, which
        compares with the outcomes alike."""
        if isinstance(self.code, jax.core.Tracer):
            return self.code
        if not np.ndim(self.code):
            return self.mechanism.outcomes(int(self.code))
        # Objects in an array of the batch's shape: NumPy would make plain integers of outcomes.
        codes = np.asarray(self.code)
        return np.array([self.mechanism.outcomes(int(code)) for code in codes.flat], object).reshape(codes.shape)

    if not TYPE_CHECKING:  # which would take any attribute for one that there is

        def __getattr__(self, name):
            """Return a quantity of the mechanism's catalogue that the run has not as a field, by name."""
            if not name.startswith("_") and "design" in vars(self):
                catalogue = self.mechanism.quantities
                if name in catalogue:
                    return catalogue[name].of(self)
                hint = suggest(name, [*vars(self), *catalogue])
                raise AttributeError(f"{type(self).__name__} has no {name!r}{hint}")
            raise AttributeError(f"{type(self).__name__} has no {name!r}")

    def __dir__(self) -> list[str]:
        return sorted({*super().__dir__(), *self.mechanism.quantities})

    @property
    def diagnosis(self) -> list[str]:
        """Return what held the run back, a line each; nothing of one that succeeded or failed."""
        mechanism, outcome = self.mechanism, self.outcome
        if mechanism.succeeded(int(outcome)) or outcome.failed or not (reasons := mechanism.view.diagnosis(self)):
            return []
        return [
            f"why it was not {mechanism.success_of(self.design)}",
            *(f"  {heading:20} {text}" for heading, text in reasons.items()),
        ]

    @property
    def log(self) -> Log:
        """Return located events, differentiable as they move with design and scenario: see `hybrid.moving`."""
        return moving(self._located, (self.design, self.scenario, self.stabilisation), self.mechanism.system)

    @property
    def maximum_times(self) -> dict[str, float]:
        """Return when each of the ``maxima`` is reached [s], by name; they have no derivatives.

        NaN of one that stays zero, of a quantity but for rounding, or where events are not located.

        **Raises:** `InputError` for a batch of runs, and inside compiled code.

        **Example:**

        >>> run = jb.simulate(jb.table2(), jb.Scenario())
        >>> f"{1e3 * float(run.stroke):.2f} mm at {run.maximum_times['stroke']:.4f} s"
        '7.50 mm at 0.1337 s'
        """
        if self._many:
            raise InputError(
                "the times of maxima are those of one run that is solved, not of a batch or a traced one: they have no"
                " derivatives"
            )
        log = self._located
        if not self.maxima or log is None or not int(log.count):
            return dict.fromkeys(self.maxima, float("nan"))
        # `Log.used` by NumPy: any operation of JAX would be a program of its own.
        kind = np.asarray(log.kind)[: int(log.count)]
        used = kind != Kind.NONE
        time, values = (np.asarray(it)[: len(kind)][used] for it in (log.time, log.values))
        # The entry of a start in contact does not know what depends on the state's rate.
        starts = (kind[used] == Kind.TOUCHDOWN) & (time == 0.0)
        values = np.where(starts[:, None], -np.inf, values)

        def reached(name: str) -> float:
            column, largest = values[:, self._observed.index(name)], float(self.maxima[name])
            slot = int(np.argmax(column))
            quantity = self.mechanism.quantities.get(name)
            if not abs(largest) > (0.0 if quantity is None else NEGLIGIBLE.get(quantity.unit, 0.0)):
                return float("nan")
            # What no event comes up to was largest at the start.
            return float(time[slot]) if column[slot] >= largest * (1.0 - ROUNDING) else 0.0

        return {name: reached(name) for name in self.maxima}

    @property
    def switch_times(self) -> dict[str, float]:
        """Return when each contact and each switch of an element closed first [s], by name; of those that did not,
        nothing."""
        log = self._located
        if log is None or not int(log.count):
            return {}
        given = (self.design, self.scenario, self.stabilisation)
        names = eqx.filter_eval_shape(self.mechanism.system, *given).contact_names
        count = min(int(log.count), int(log.room))
        kind, which, time = (np.asarray(it)[:count] for it in (log.kind, log.which, log.time))
        closing = kind == Kind.TOUCHDOWN
        first = {name: time[closing & (which == k)] for k, name in enumerate(names)}
        return {name: float(times[0]) for name, times in first.items() if times.size}

    @property
    def elements(self) -> tuple[Any, ...]:
        """Return the elements of the mechanism that was run, which say what they have to say of it; none of one that is
        not assembled from any."""
        if self.mechanism.stepper is not None:
            return ()
        return tuple(_elements((self.design, self.scenario, self.stabilisation)))

    def quantity(self, name: str) -> Float[Array, ""]:
        """Return a quantity of the mechanism's catalogue by name, or of an impact, as in "impact.3.peak_force".

        **Raises:** `InputError` with the nearest name for one that is unknown.
        """
        catalogue = self.mechanism.quantities
        check_quantities(catalogue, (name,))
        address = of_impact(name)
        if address is None:
            return catalogue[name].of(self)
        return jnp.where(address.slot < self.impacts.count, self.of_impact(address), jnp.nan)

    def of_impact(self, address: OfImpact) -> Float[Array, ""]:
        """Return one number of one impact; in a slot beyond the last impact it means nothing."""
        if address.field in LOAD_UNITS:
            # A finished run's loads are computed for a block of impacts at once, whose program serves them all.
            own = 0 if self._many else address.slot % TOGETHER
            return self.loads(address.field, address.slot - own + np.arange(1 if self._many else TOGETHER))[own]
        return getattr(self.impacts, address.field)[address.slot]

    def loads(
        self, name: str, numbers: Int[Array, " impacts"] | Int[np.ndarray, " impacts"] | None = None
    ) -> Float[Array, " impacts"]:
        """Return how hard impacts are, computed after the run: ``effective_energy`` T_c⁻ [J] or ``compression_end``
        [s].

        **Arguments:** ``name``; ``numbers``: which impacts, from 0 (default: all of a run that is solved).

        **Returns:** an entry for each; NaN where it is not known. As a quantity: "impact.1.effective_energy".

        **Example:** the first impact of a drop is that of a third of the bar's mass at the speed of its end.

        >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22)
        >>> print(f"{1e3 * float(run.loads('effective_energy')[0]):.3f} mJ")
        22.528 mJ
        """
        check_choice("name", name, tuple(LOAD_UNITS))
        if numbers is None:
            if self._many:
                raise InputError("all loads are those of one run that is solved; of others, name the impacts' numbers")
            count = int(self.impacts.count)
            if self._located is None or not np.any(np.asarray(self._located.kind) == Kind.TOUCHDOWN):
                return jnp.full(count, jnp.nan)
            firsts = range(0, count, TOGETHER)  # one compiled program serves any number of impacts
            parts = [np.asarray(self.loads(name, first + np.arange(TOGETHER))) for first in firsts]
            return jax.device_put(np.concatenate([np.zeros(0), *parts])[:count])
        if self._located is None:
            return jnp.full(len(numbers), jnp.nan)
        return load(Static(name), (self.design, self.scenario, self.stabilisation), self._located, numbers)

    @property
    def _many(self) -> bool:
        """Return whether this is a batch, or traced."""
        return isinstance(self.code, jax.core.Tracer) or bool(np.ndim(self.code))

    def to_xarray(self) -> Dataset:
        """Return the run as labelled arrays, each with its unit in the attribute ``units``.

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
        if self._many:
            raise InputError(
                "to_xarray takes one run that is solved, not a batch or a traced one; sweep many with jb.sweep"
            )
        return run_dataset(self)

    def to_dataframe(self) -> DataFrame:
        """Return the history as a table: a row a step, columns named with their units, as in ``"time [s]"``.

        **Raises:** `InputError` for a run without a history.

        **Example:**

        >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22, history=True)
        >>> f"{run.to_dataframe()['contact_force plate [N]'].max():.1f} N"
        '1831.5 N'
        """
        columns = history_columns(self)
        return frame(list(columns), np.column_stack(list(columns.values())).tolist())

    def __repr__(self) -> str:
        if isinstance(self.code, jax.core.Tracer):
            return f"{type(self).__name__}(traced, code={self.code})"
        if self._many:
            return self._batch_text()
        summary = self.mechanism.view.summary or plain_summary
        first, *rest = summary(self).split("\n")
        said = [*cautions(((self.design, self.scenario),), measured=False), *self.balance.warnings]
        notes = [f"  note: {line}" for line in said]
        return "\n".join([first, *notes, *rest, *(f"  {line}" for line in self.diagnosis)])

    def _batch_text(self) -> str:
        """Return how many runs ended how, and the range of the main quantity."""
        outcomes, codes = self.mechanism.outcomes, np.asarray(self.code)
        ends = ", ".join(
            f"{count} {outcomes(code).name}" for code, count in sorted(Counter(codes.ravel().tolist()).items())
        )
        text = f"{type(self).__name__}: a batch of {codes.size} runs: {ends}"
        if not (name := self.mechanism.main_quantity(self.mechanism.swept)):
            return text
        quantity = self.mechanism.quantities[name]
        values = np.asarray(quantity.of(self))
        known, (symbol, factor) = values[np.isfinite(values)], quantity.in_figures
        if not known.size:
            return text
        return f"{text}; {name.replace('_', ' ')} {range_text(factor * known.min(), factor * known.max(), symbol)}"

    def _repr_html_(self) -> str:
        return summary_html(repr(self))


@functools.partial(stored, seconds=QUICK, what="the parts of a mechanism")
def _elements(parameters: tuple[Any, Any, Any]) -> Any:
    """Return the elements of a mechanism in numbers: assembled one operation after the other, it would compile a dozen
    programs."""
    elements = getattr(mechanism_of(parameters[0]).system(*parameters), "elements", ())
    # A function among the fields of a user's element is no result of a program.
    return eqx.filter(elements, eqx.is_array_like)


R = TypeVar("R", bound=Run)


class DesignOf(Part, Generic[R]):
    """A design whose runs are of the class `R`, as a type checker is to know: ``class BarDrop(DesignOf[BarDropRun])``.

    A design may be a plain `Part`; its runs are then `Run` to a type checker.
    """


class Solved(NamedTuple):
    """What the time stepping found of a run, and what was read off: for `Mechanism.run`.

    ``parameters``: design, scenario and Baumgarte's gain [1/s]; ``duration`` [s]; ``start``, ``end``, ``event``: what
    is read off at start and end of the run, and at the event of the mechanism's `Reader` (the end without one);
    ``result`` of the time stepping; ``log``: its events with derivatives as they move; ``code`` of the outcome;
    ``known``: 1, or NaN for a failed run, a factor so that derivatives are NaN too; ``common``: the fields of every
    `Run`, by name.
    """

    parameters: tuple[Any, Any, Scalar]
    duration: Scalar
    start: Reading
    end: Reading
    event: Reading
    result: Result
    log: Log
    code: Int[Array, ""]
    known: Float[Array, ""]
    maxima: Maxima
    common: dict[str, Any]


def plain_run(system: Any, solved: Solved) -> Run:
    """Return the run of a mechanism that adds nothing of its own."""
    return Run(**solved.common)


def value_of(run: Run, name: str) -> float:
    """Return a quantity of a finished run; NaN if it failed or has no such impact."""
    address = of_impact(name)
    if address is None:
        return float(run.mechanism.quantities[name].of(run))
    present = address.slot < int(run.impacts.count) and not run.outcome.failed
    return float(run.of_impact(address)) if present else float("nan")
