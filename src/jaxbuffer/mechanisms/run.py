"""A simulated run of any mechanism."""

from typing import Any, Generic, NamedTuple, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from .._types import DataFrame, Dataset, Scalar
from ..errors import InputError
from ..fields import Part, Portable, get
from ..hybrid import Log, Result, moving
from ..labelled.arrays import Labelled, dataset, frame
from ..labelled.saved import Saved
from ..tables import summary_html
from .dataset import attributes
from .energy import Balance, Energy
from .history import History
from .impacts import Impacts
from .mechanism import Mechanism
from .outcome import RunOutcome
from .quantity import IMPACT_UNITS, check_quantities, of_impact
from .registry import mechanism_of
from .view import Names

CONTACT_UNITS = {
    "gap": "m",
    "approach_speed": "m/s",
    "slip": "m/s",
    "contact_force": "N",
    "friction_force": "N",
}
COORDINATES = {
    "position": (("x", "m"), ("y", "m"), ("angle", "rad")),
    "velocity": (("x", "m/s"), ("y", "m/s"), ("angle", "rad/s")),
}
IMPACT_MEANING = {
    "peak_force": "largest force until the contact's next touchdown",
    "approach_speed": "normal speed at touchdown",
    "time": "touchdown",
    "release_time": "release, NaN where the run ended in contact",
}


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
    def mechanism(self) -> Mechanism:
        """What this is a run of."""
        return mechanism_of(self.design)

    @property
    def outcome(self) -> RunOutcome | Any:
        """How it ended; the integer code (an array) inside compiled code or for a batch."""
        return self.code if self._many else self.mechanism.outcomes(int(self.code))

    @property
    def diagnosis(self) -> list[str]:
        """What held the run back, a line each; nothing of one that succeeded or failed."""
        mechanism, outcome = self.mechanism, self.outcome
        succeeded = mechanism.success is None or outcome.name == mechanism.success
        if succeeded or outcome.failed or not (told := mechanism.view.diagnosis(self)):
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
        return jnp.where(asked.slot < self.impacts.count, asked.of(self.impacts), jnp.nan)

    @property
    def _many(self) -> bool:
        """Whether this is a batch, or traced."""
        return isinstance(self.code, jax.core.Tracer) or bool(np.ndim(self.code))

    def to_xarray(self) -> Dataset:
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
        return _dataset(self)

    def to_pandas(self) -> DataFrame:
        """The history as a table: a row a step, columns named with their units, as in ``"time [s]"``.

        **Raises:** `InputError` for a run without a history.

        **Example:**

        >>> run = jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=0.194), 0.22, history=True)
        >>> f"{run.to_pandas()['contact_force plate [N]'].max():.1f} N"
        '1831.5 N'
        """
        columns = history_columns(self)
        return frame(list(columns), np.column_stack(list(columns.values())).tolist())

    def __repr__(self) -> str:
        if self._many:
            return f"{type(self).__name__}(batch or traced, code={self.code})"
        summary = self.mechanism.view.summary or plain_summary
        return "\n".join([summary(self), *(f"  {line}" for line in self.diagnosis)])

    def _repr_html_(self) -> str:
        return summary_html(repr(self))


R = TypeVar("R", bound=Run)


class DesignOf(Part, Generic[R]):
    """A design whose runs are of the class `R`, as a type checker is to know: ``class BarDrop(DesignOf[BarDropRun])``.

    A design may be a plain `Part`; its runs are then `Run` to a type checker.
    """


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


def rising(run: Run) -> list[str]:
    """The quantities that are largest at the end of the run and would go on to rise."""
    catalogue = run.mechanism.quantities
    rates = {name: catalogue[quantity.rising] for name, quantity in catalogue.items() if quantity.rising}
    return [name for name, rate in rates.items() if float(rate.of(run)) > 0.0]


def value_of(run: Run, name: str) -> float:
    """A quantity of a finished run; NaN if it failed or has no such impact."""
    asked = of_impact(name)
    if asked is None:
        return float(run.mechanism.quantities[name].of(run))
    present = asked.slot < int(run.impacts.count) and not run.outcome.failed
    return float(asked.of(run.impacts)) if present else float("nan")


def plain_summary(run: Run) -> str:
    """Outcome, the quantities that sweeps have, energy and what numerical error did; units included."""
    mechanism, outcome, view = run.mechanism, run.outcome, run.mechanism.view
    if outcome.failed:
        return f"{view.title}: {outcome.reason} (after {int(run.attempts)} steps; {view.label(run.scenario)})"
    lines = [
        f"{view.title}: {outcome.reason}",
        f"  {'scenario':24} {view.label(run.scenario)}",
        f"  {'impacts':24} {int(run.impact_count)}",
    ]
    for name in mechanism.meant(lambda path: get(run.design, path)):
        quantity = mechanism.quantities[name]
        symbol, factor = quantity.in_figures
        value = factor * float(np.asarray(quantity.of(run)))
        lines.append(f"  {quantity.title or name:24} {value:.6g} {symbol}".rstrip(" -"))
    energy, balance = jax.tree.map(np.asarray, (run.energy, run.balance))
    lost = ", ".join(f"{name.replace('_', ' ')} {float(value):.3g}" for name, value in energy.lost.items())
    lines += [
        f"  {'energy':24} {float(energy.total):.6g} J, of which dissipated {float(energy.dissipated):.6g} J ({lost})",
        f"  {'numerical balance':24} energy {float(balance.energy):.1e}, constraint drift {float(balance.drift):.1e} m",
        f"  {'steps':24} {int(run.accepted)} accepted of {int(run.attempts)}",
    ]
    return "\n".join([*lines, *(f"  {line}" for line in mechanism.view.warnings(run))])


def history_columns(run: Run) -> dict[str, np.ndarray]:
    """Columns of shape (steps,) by heading: times, contacts, the mechanism's own, motion, multipliers, energies.

    **Raises:** `InputError` for a run without a history.
    """
    if run.history is None:
        raise InputError("the run has no history; jb.simulate(…, history=True) keeps one")
    seen: Any = jax.tree.map(np.asarray, run.history)
    names = run.mechanism.view.names(run.design)
    columns: dict[str, Any] = {"time [s]": seen.time}
    for name, symbol in CONTACT_UNITS.items():
        value = getattr(seen, name)
        columns |= {f"{name} {contact} [{symbol}]": value[:, k] for k, contact in enumerate(names.contacts)}
    columns |= {f"{name} [{symbol}]": seen.others[name] for name, symbol in names.others.items() if name in seen.others}
    for name, axes in COORDINATES.items():
        for k, body in enumerate(names.bodies):
            columns |= {f"{body} {name} {axis} [{s}]": getattr(seen, name)[:, k, i] for i, (axis, s) in enumerate(axes)}
    for k, (name, symbol) in enumerate(names.multipliers.items()):
        columns[f"multiplier {name} [{symbol}]"] = seen.multipliers[:, k]
    columns |= {f"energy {name} [J]": getattr(seen.energy, name) for name in seen.energy.names}
    return {name: np.asarray(column) for name, column in columns.items()}


def _dataset(run: Run) -> Dataset:
    """See `Run.to_xarray`."""
    if run._many:
        raise InputError(
            "to_xarray takes one run that is solved, not a batch or a traced one; sweep many with jb.sweep"
        )
    mechanism, names = run.mechanism, run.mechanism.view.names(run.design)
    variables = {**_quantities(run, names), **_impacts(run, names)}
    energies = tuple(run.energy.names)
    energy = jax.tree.map(np.asarray, run.energy)
    at_end = [float(getattr(energy, name)) for name in energies]
    variables["energy_at_end"] = Labelled(("energy",), at_end, "J", "energy at the end, or lost until then")
    coordinates = {
        "impact": Labelled(("impact",), np.arange(1, int(run.impacts.count) + 1), "", "impacts in order, from 1"),
        "energy": Labelled(("energy",), list(energies), "", "stored, lost, and total"),
    }
    if run.history is not None:
        seen: Any = jax.tree.map(np.asarray, run.history)
        variables |= _history(seen, names)
        coordinates |= {
            "time": Labelled(("step",), seen.time, "s", "time of an accepted step"),
            "contact": Labelled(("contact",), list(names.contacts), "", mechanism.view.contact),
            "body": Labelled(("body",), list(names.bodies), "", "body"),
        }
    return dataset(variables, coordinates, {**attributes(mechanism, run.design, run.scenario), **_ended(run)})


def _ended(run: Run) -> dict[str, Any]:
    return {"outcome": run.outcome.name, "outcome_meaning": run.outcome.reason, "warnings": "\n".join(_warnings(run))}


def _warnings(run: Run) -> list[str]:
    return [] if run.outcome.failed else run.mechanism.view.warnings(run)


def _quantities(run: Run, names: Names) -> dict[str, Labelled]:
    """Single numbers of the whole run."""
    mechanism = run.mechanism
    catalogue = mechanism.quantities
    found = {
        name: Labelled(
            (), float(np.asarray(catalogue[name].of(run))), catalogue[name].unit, catalogue[name].description
        )
        for name in mechanism.swept
    }
    largest = "" if run.outcome.failed else names.contacts[int(run.peak_contact)]
    counts = {"impact_count": run.impact_count, "steps_accepted": run.accepted, "steps_attempted": run.attempts}
    return {
        **found,
        f"peak_{mechanism.view.contact}": Labelled((), largest, "", f"{mechanism.view.contact} with the largest force"),
        **{name: Labelled((), int(count), "-", name.replace("_", " ")) for name, count in counts.items()},
    }


def _impacts(run: Run, names: Names) -> dict[str, Labelled]:
    """One entry for each impact that happened."""
    count, hits = int(run.impacts.count), run.impacts
    contacts = [names.contacts[int(k)] for k in np.asarray(hits.contact)[:count]]
    found = {"impact_contact": Labelled(("impact",), np.array(contacts, str), "", run.mechanism.view.contact)}
    for name, unit in IMPACT_UNITS.items():
        values = np.asarray(getattr(hits, name))[:count]
        found[f"impact_{name}"] = Labelled(("impact",), values, unit, IMPACT_MEANING[name])
    return found


def _history(seen: History, names: Names) -> dict[str, Labelled]:
    """Everything along the accepted steps."""
    found = {
        name: Labelled(("step", "contact"), getattr(seen, name), unit, name.replace("_", " "))
        for name, unit in CONTACT_UNITS.items()
    }
    bodies = len(names.bodies)
    for name, axes in COORDINATES.items():
        for i, (axis, unit) in enumerate(axes):
            values = getattr(seen, name)[:, :bodies, i]
            found[f"{name}_{axis}"] = Labelled(("step", "body"), values, unit, f"{name}: {axis}")
    for name, unit in names.others.items():
        if name in seen.others:
            found[f"{name}_history"] = Labelled(("step",), seen.others[name], unit, name.replace("_", " "))
    for k, (name, unit) in enumerate(names.multipliers.items()):
        found[f"multiplier_{name.replace(' ', '_')}"] = Labelled(("step",), seen.multipliers[:, k], unit, name)
    energies = np.stack([np.asarray(getattr(seen.energy, name)) for name in seen.energy.names], axis=1)
    found["energy_history"] = Labelled(("step", "energy"), energies, "J", "energy, or lost so far")
    return found
