"""A run of any mechanism as labelled arrays, by what the mechanism says of itself."""

from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from ..errors import InputError
from ..fields.record import json_record
from ..labelled.arrays import Labelled, dataset
from ..version import version
from .history_table import CONTACT_UNITS, COORDINATES
from .quantity import IMPACT_UNITS

if TYPE_CHECKING:
    import xarray as xr

    from .history import History
    from .mechanism import Mechanism, Names
    from .run import Run

IMPACT_MEANING = {
    "peak_force": "largest force until the contact's next touchdown",
    "approach_speed": "normal speed at touchdown",
    "time": "touchdown",
    "release_time": "release, NaN where the run ended in contact",
}


def run_dataset(run: "Run") -> "xr.Dataset":
    """See `Run.to_xarray`."""
    if run._many:
        raise InputError(
            "to_xarray takes one run that is solved, not a batch or a traced one; sweep many with jb.sweep"
        )
    mechanism, names = run.mechanism, run.mechanism.names(run.design)
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
            "contact": Labelled(("contact",), list(names.contacts), "", mechanism.contact),
            "body": Labelled(("body",), list(names.bodies), "", "body"),
        }
    return dataset(variables, coordinates, {**attributes(mechanism, run.design, run.scenario), **_ended(run)})


def attributes(mechanism: "Mechanism", design: Any, scenario: Any) -> dict[str, Any]:
    """What a dataset says of its origin: with it a file stands on its own."""
    return {
        "title": mechanism.title,
        "kind": mechanism.name,
        "design": json_record(design),
        "scenario": json_record(scenario),
        "jaxbuffer": version(),
    }


def _ended(run: "Run") -> dict[str, Any]:
    return {"outcome": run.outcome.name, "outcome_meaning": run.outcome.reason, "warnings": "\n".join(_warnings(run))}


def _warnings(run: "Run") -> list[str]:
    return [] if run.outcome.failed else run.mechanism.warnings(run)


def _quantities(run: "Run", names: "Names") -> dict[str, Labelled]:
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
        f"peak_{mechanism.contact}": Labelled((), largest, "", f"{mechanism.contact} with the largest force"),
        **{name: Labelled((), int(count), "-", name.replace("_", " ")) for name, count in counts.items()},
    }


def _impacts(run: "Run", names: "Names") -> dict[str, Labelled]:
    """One entry for each impact that happened."""
    count, hits = int(run.impacts.count), run.impacts
    contacts = [names.contacts[int(k)] for k in np.asarray(hits.contact)[:count]]
    found = {"impact_contact": Labelled(("impact",), np.array(contacts, str), "", run.mechanism.contact)}
    for name, unit in IMPACT_UNITS.items():
        values = np.asarray(getattr(hits, name))[:count]
        found[f"impact_{name}"] = Labelled(("impact",), values, unit, IMPACT_MEANING[name])
    return found


def _history(seen: "History", names: "Names") -> dict[str, Labelled]:
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
