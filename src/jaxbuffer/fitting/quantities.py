"""What a history records of a mechanism, by name: the quantities that a test may have measured."""

import jax
import jax.numpy as jnp

from ..errors import InputError
from ..fields import Part
from ..mechanisms.registry import mechanism_of
from ..mechanisms.run_arrays import series
from ..run.history import history_at
from ..run.request import check_pair


def recorded_quantities(design: Part, scenario: Part | None = None) -> dict[str, str]:
    """Return the quantities that a history of a design has, each with its unit.

    Their names are those of the columns of history.csv, with underscores: "active_acceleration_x" is the acceleration
    of the active vehicle's centre of mass along x, against the ground.

    **Arguments:** ``design``; ``scenario``: of its mechanism (default: the mechanism's own).

    **Raises:** `InputError` for a mechanism whose runs have no states between steps.

    **Example:**

    >>> units = jb.recorded_quantities(jb.table2())
    >>> units["stroke"], units["active_acceleration_x"], units["contact_force_lower"]
    ('m', 'm/s²', 'N')
    """
    mechanism = mechanism_of(design)
    scenario = mechanism.scenario() if scenario is None else scenario
    check_pair(mechanism, design, scenario)
    if mechanism.stepper is not None:
        raise InputError(f"a test of {mechanism.name} cannot be fitted: its runs are not stepped from event to event")
    units: dict[str, str] = {}

    def at_start() -> None:
        system = mechanism.system(design, scenario, 20.0)
        at, closed = system.first_evaluation()
        history = jax.tree.map(lambda x: jnp.asarray(x)[None], history_at(system, jnp.zeros(()), closed, at.state))
        names = mechanism.names(design)
        units.update({column_name(it.name): it.unit for it in series(history, names)})

    # Traced without numbers: names and units are known before anything is compiled or run.
    jax.eval_shape(at_start)
    return units


def column_name(name: str) -> str:
    """Return a column of a history as the name of a quantity."""
    return name.replace(" ", "_")
