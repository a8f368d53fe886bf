"""A run's quantities and history, listed once for its labelled arrays, the columns of its table and its record."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import jax
import numpy as np

from .._types import Dataset
from ..errors import InputError
from ..labelled.arrays import Labelled, dataset
from ..labelled.record import heading
from ..plane import PLANE
from .dataset import attributes
from .history import History
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
    "acceleration": (("x", "m/s²"), ("y", "m/s²"), ("angle", "rad/s²")),
}
IN_SPACE = {
    "position": (*((axis, "m") for axis in "xyz"), *((f"rotation_{axis}", "rad") for axis in "xyz")),
    "velocity": (*((axis, "m/s") for axis in "xyz"), *((f"spin_{axis}", "rad/s") for axis in "xyz")),
    "acceleration": (*((axis, "m/s²") for axis in "xyz"), *((f"spin_{axis}", "rad/s²") for axis in "xyz")),
}


class Series(NamedTuple):
    """A number along the steps of a run: a column of its table, and one entry of an array of its dataset, or all of it.

    - ``name`` in tables; ``unit``; ``values`` (steps,);
    - ``array``: the dataset's name for it; ``axis``: along which that has an entry for each contact, body or energy,
      "" for none; ``description`` of the array.
    """

    name: str
    unit: str
    values: Any
    array: str
    axis: str
    description: str


def series(history: History, names: Names) -> Iterator[Series]:
    """Yield contacts, the mechanism's own numbers, motion, multipliers and energies, in the order of a table."""
    for name, unit in CONTACT_UNITS.items():
        for k, contact in enumerate(names.of_contacts(history.gap.shape[1])):
            values = getattr(history, name)[:, k]
            yield Series(f"{name} {contact}", unit, values, name, "contact", name.replace("_", " "))
    for name, unit, values in names.series(history.others):
        yield Series(name, unit, values, f"{name}_history", "", name.replace("_", " "))
    for name, axes in (COORDINATES if history.velocity.shape[-1] == PLANE.velocities else IN_SPACE).items():
        for k, body in enumerate(names.bodies):
            for i, (axis, unit) in enumerate(axes):
                values = getattr(history, name)[:, k, i]
                yield Series(f"{body} {name} {axis}", unit, values, f"{name}_{axis}", "body", f"{name}: {axis}")
    for k, (name, unit) in enumerate(names.multipliers.items()):
        array = f"multiplier_{name.replace(' ', '_')}"
        yield Series(f"multiplier {name}", unit, history.multipliers[:, k], array, "", name)
    for name in history.energy.names:
        values = getattr(history.energy, name)
        yield Series(f"energy {name}", "J", values, "energy_history", "energy", "energy, or lost so far")


def history_columns(run: Any) -> dict[str, np.ndarray]:
    """Return columns of shape (steps,) by heading: times, contacts, the mechanism's own, motion, multipliers, energies.

    **Raises:** `InputError` for a run without a history.
    """
    if run.history is None:
        raise InputError("the run has no history; jb.simulate(…, history=True) keeps one")
    history: Any = jax.tree.map(np.asarray, run.history)
    columns = series(history, run.mechanism.names(run.design))
    return {heading("time", "s"): history.time} | {heading(it.name, it.unit): it.values for it in columns}


def run_dataset(run: Any) -> Dataset:
    """Return a run that is solved as a dataset, as `Run.to_xarray` says."""
    mechanism, names = run.mechanism, run.mechanism.names(run.design)
    variables = {**_numbers(run, names), **_impacts(run, names)}
    energies = tuple(run.energy.names)
    energy = jax.tree.map(np.asarray, run.energy)
    at_end = [float(getattr(energy, name)) for name in energies]
    variables["energy_at_end"] = Labelled(("energy",), at_end, "J", "energy at the end, or lost until then")
    coordinates = {
        "impact": Labelled(("impact",), np.arange(1, int(run.impacts.count) + 1), "", "impacts in order, from 1"),
        "energy": Labelled(("energy",), list(energies), "", "stored, lost, and total"),
    }
    if run.history is not None:
        history: Any = jax.tree.map(np.asarray, run.history)
        variables |= _history(history, names)
        coordinates |= {
            "time": Labelled(("step",), history.time, "s", "time of an accepted step"),
            "contact": Labelled(
                ("contact",), list(names.of_contacts(history.gap.shape[1])), "", mechanism.view.contact
            ),
            "body": Labelled(("body",), list(names.bodies), "", "body"),
        }
    return dataset(variables, coordinates, {**attributes(mechanism, run.design, run.scenario), **_ended(run)})


def _ended(run: Any) -> dict[str, Any]:
    warnings = [] if run.outcome.failed else [*run.balance.warnings, *run.mechanism.view.warnings(run)]
    return {"outcome": run.outcome.name, "outcome_meaning": run.outcome.reason, "warnings": "\n".join(warnings)}


def run_quantities(run: Any) -> dict[str, Labelled]:
    """Return the quantities of a run that sweeps and records have."""
    known = {name: run.mechanism.quantities[name] for name in run.mechanism.swept}
    return {name: Labelled((), float(np.asarray(it.of(run))), it.unit, it.description) for name, it in known.items()}


def _numbers(run: Any, names: Names) -> dict[str, Labelled]:
    """Return the single numbers of the whole run."""
    contact = run.mechanism.view.contact
    largest = names.contact(int(run.peak_contact))  # the number is -1 where nothing touches
    counts = {"impact_count": run.impact_count, "steps_accepted": run.accepted, "steps_attempted": run.attempts}
    return {
        **run_quantities(run),
        f"peak_{contact}": Labelled((), largest, "", f"{contact} with the largest force"),
        **{name: Labelled((), int(count), "-", name.replace("_", " ")) for name, count in counts.items()},
    }


def _impacts(run: Any, names: Names) -> dict[str, Labelled]:
    """Return arrays with one entry for each impact that happened."""
    contacts = [names.contact(int(k)) for k in np.asarray(run.impacts.contact)[: int(run.impacts.count)]]
    touched = Labelled(("impact",), np.array(contacts, str), "", run.mechanism.view.contact)
    return {f"impact_{name}": it for name, it in ({"contact": touched} | run.impacts.labelled()).items()}


def _history(history: History, names: Names) -> dict[str, Labelled]:
    """Return everything along the accepted steps."""
    entries: dict[str, list[Series]] = {}
    for it in series(history, names):
        entries.setdefault(it.array, []).append(it)
    return {name: _array(series) for name, series in entries.items()}


def _array(entries: Sequence[Series]) -> Labelled:
    """Return the array of the dataset that has these entries."""
    first, values = entries[0], np.stack([it.values for it in entries], axis=1)
    if first.axis:
        return Labelled(("step", first.axis), values, first.unit, first.description)
    return Labelled(("step",), values[:, 0], first.unit, first.description)
