"""The history of a run as named columns, each with its unit."""

from typing import TYPE_CHECKING, Any

import jax
import numpy as np

from ..errors import InputError

if TYPE_CHECKING:
    from .run import Run

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


def history_columns(run: "Run") -> dict[str, np.ndarray]:
    """Columns of shape (steps,) by heading: times, contacts, the mechanism's own, motion, multipliers, energies.

    **Raises:** `InputError` for a run without a history.
    """
    if run.history is None:
        raise InputError("the run has no history; jb.simulate(…, history=True) keeps one")
    seen: Any = jax.tree.map(np.asarray, run.history)
    names = run.mechanism.names(run.design)
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
