"""A run as labelled arrays, and its history as a table's columns."""

from typing import Any

import jax
import numpy as np

from .._types import Dataset
from ..errors import InputError
from ..labelled.arrays import Labelled, dataset
from .dataset import attributes
from .history import History
from .quantity import IMPACT_UNITS
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
    "effective_energy": "kinetic energy before it along the normals of the closed contacts",
    "compression_end": "when the contact no longer closes",
}


def history_columns(run: Any) -> dict[str, np.ndarray]:
    """Return columns of shape (steps,) by heading: times, contacts, the mechanism's own, motion, multipliers, energies.

    **Raises:** `InputError` for a run without a history.
    """
    if run.history is None:
        raise InputError("the run has no history; jb.simulate(…, history=True) keeps one")
    history: Any = jax.tree.map(np.asarray, run.history)
    names = run.mechanism.view.names(run.design)
    columns: dict[str, Any] = {"time [s]": history.time}
    for name, symbol in CONTACT_UNITS.items():
        value = getattr(history, name)
        columns |= {f"{name} {contact} [{symbol}]": value[:, k] for k, contact in enumerate(names.contacts)}
    columns |= {f"{name} [{symbol}]": values for name, symbol, values in names.series(history.others)}
    for name, axes in COORDINATES.items():
        for k, body in enumerate(names.bodies):
            columns |= {
                f"{body} {name} {axis} [{s}]": getattr(history, name)[:, k, i] for i, (axis, s) in enumerate(axes)
            }
    for k, (name, symbol) in enumerate(names.multipliers.items()):
        columns[f"multiplier {name} [{symbol}]"] = history.multipliers[:, k]
    columns |= {f"energy {name} [J]": getattr(history.energy, name) for name in history.energy.names}
    return {name: np.asarray(column) for name, column in columns.items()}


def run_dataset(run: Any) -> Dataset:
    """Return a run that is solved as a dataset, as `Run.to_xarray` says."""
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
        history: Any = jax.tree.map(np.asarray, run.history)
        variables |= _history(history, names)
        coordinates |= {
            "time": Labelled(("step",), history.time, "s", "time of an accepted step"),
            "contact": Labelled(("contact",), list(names.contacts), "", mechanism.view.contact),
            "body": Labelled(("body",), list(names.bodies), "", "body"),
        }
    return dataset(variables, coordinates, {**attributes(mechanism, run.design, run.scenario), **_ended(run)})


def _ended(run: Any) -> dict[str, Any]:
    return {"outcome": run.outcome.name, "outcome_meaning": run.outcome.reason, "warnings": "\n".join(_warnings(run))}


def _warnings(run: Any) -> list[str]:
    return [] if run.outcome.failed else run.mechanism.view.warnings(run)


def _quantities(run: Any, names: Names) -> dict[str, Labelled]:
    """Return the single numbers of the whole run."""
    mechanism = run.mechanism
    catalogue = mechanism.quantities
    arrays = {
        name: Labelled(
            (), float(np.asarray(catalogue[name].of(run))), catalogue[name].unit, catalogue[name].description
        )
        for name in mechanism.swept
    }
    # The number is -1 where nothing touches.
    largest = names.contacts[int(run.peak_contact)] if int(run.peak_contact) >= 0 else ""
    counts = {"impact_count": run.impact_count, "steps_accepted": run.accepted, "steps_attempted": run.attempts}
    return {
        **arrays,
        f"peak_{mechanism.view.contact}": Labelled((), largest, "", f"{mechanism.view.contact} with the largest force"),
        **{name: Labelled((), int(count), "-", name.replace("_", " ")) for name, count in counts.items()},
    }


def _impacts(run: Any, names: Names) -> dict[str, Labelled]:
    """Return arrays with one entry for each impact that happened."""
    count, hits = int(run.impacts.count), run.impacts
    contacts = [names.contacts[int(k)] for k in np.asarray(hits.contact)[:count]]
    arrays = {"impact_contact": Labelled(("impact",), np.array(contacts, str), "", run.mechanism.view.contact)}
    for name, unit in IMPACT_UNITS.items():
        values = np.asarray(getattr(hits, name))[:count]
        arrays[f"impact_{name}"] = Labelled(("impact",), values, unit, IMPACT_MEANING[name])
    return arrays


def _history(history: History, names: Names) -> dict[str, Labelled]:
    """Return everything along the accepted steps."""
    arrays = {
        name: Labelled(("step", "contact"), getattr(history, name), unit, name.replace("_", " "))
        for name, unit in CONTACT_UNITS.items()
    }
    bodies = len(names.bodies)
    for name, axes in COORDINATES.items():
        for i, (axis, unit) in enumerate(axes):
            values = getattr(history, name)[:, :bodies, i]
            arrays[f"{name}_{axis}"] = Labelled(("step", "body"), values, unit, f"{name}: {axis}")
    for name, unit, values in names.series(history.others):
        arrays[f"{name}_history"] = Labelled(("step",), values, unit, name.replace("_", " "))
    for k, (name, unit) in enumerate(names.multipliers.items()):
        arrays[f"multiplier_{name.replace(' ', '_')}"] = Labelled(("step",), history.multipliers[:, k], unit, name)
    energies = np.stack([np.asarray(getattr(history.energy, name)) for name in history.energy.names], axis=1)
    arrays["energy_history"] = Labelled(("step", "energy"), energies, "J", "energy, or lost so far")
    return arrays
