"""Wall and liquid at instants of a run, in the whole section."""

import functools
from collections.abc import Sequence
from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from ...programs.cache import stored
from ..picture import Meshed
from .design import TankDrop, TankDropScenario
from .node_sets import FLIP, NodeSets, mirrors
from .numbering import Numbering
from .section import liquid_within, section

ACROSS, ALONG = "across the impact [mm]", "along the impact, downwards [mm]"
STRESS = "stress after von Mises [MPa]"


def meshes(run: Any, times: Sequence[float] | None = None) -> list[Meshed]:
    """Return the meshes of a run with a history, at the rows next to some ``times`` [s], or at the largest stress and
    the end."""
    fields = {name: np.asarray(values) for name, values in run.history.others.items()}
    time, snapshots = np.asarray(run.history.time), []
    for words, name, row in _instants(time, fields["peak_stress"], times):
        wall, liquid = map(np.asarray, _moved(run.design, run.scenario, fields["displacement"][row]))
        title = f"{words}{1e3 * time[row]:.4g} ms"
        now = {key: values[row] for key, values in fields.items()}
        snapshots.append(_completed(run.design, Meshed(title, name, *_together(run.design, wall, liquid, now))))
    return snapshots


def displaced(run: Any) -> tuple[Meshed, Meshed]:
    """Return the wall before the impact, and at the largest force, with how far it has moved since [mm].

    The liquid's mesh goes along by interpolation, so that it has no displacement of its own."""
    displacement = np.asarray(run.history.others["displacement"])
    row = int(np.argmax(np.asarray(run.history.contact_force)[:, 0]))
    corners, made = NodeSets.of(run.design).corners, []
    # A run starts in equilibrium under weight and liquid (M167): what they have bent is no part of the impact.
    since = displacement[row, corners].mean(axis=1) - displacement[0, corners].mean(axis=1)
    for words, place in (("before", 0), (f"{1e3 * float(run.history.time[row]):.4g} ms", row)):
        wall, _ = map(np.asarray, _moved(run.design, run.scenario, displacement[place]))
        across, down = 1e3 * since[:, 0] * (place > 0), -1e3 * since[:, 1] * (place > 0)
        both = _completed(run.design, Meshed(words, "", wall, corners, {ACROSS: across, ALONG: down}))
        # What moves to the right moves to the left in the mirror image.
        image = np.where(np.arange(len(both.cells)) < len(corners), 1.0, -1.0)
        made.append(both._replace(values={**both.values, ACROSS: image * both.values[ACROSS]}))
    return made[0], made[1]


@functools.partial(stored, what="a moved mesh")
def _moved(
    design: TankDrop, scenario: TankDropScenario, displacement: Float[Array, "nodes 2"]
) -> tuple[Float[Array, "nodes 2"], Float[Array, "liquid 2"]]:
    """Return the nodes of wall and plate, and the liquid's, whose mesh goes with the wall [m]."""
    mesh = section(design, scenario.fill)
    # A history's last two nodes are the slider and the baffle, which the section does not have.
    at = mesh.positions + displacement[: len(mesh.positions)]
    within = liquid_within if design.mesh.extent == "half" else _within_whole
    return at, within(at, mesh.numbers)


def _within_whole(wall: Float[Array, "nodes 2"], numbers: Numbering) -> Float[Array, "liquid 2"]:
    """Return what `liquid_within` does, where the whole wall moves: its even part, as half of a wall, with the odd part
    that both sides share; the surface is straight between them [m]."""
    of_wall, of_liquid = mirrors(numbers)
    right, left = wall[: len(of_wall.image)], wall[of_wall.image] * FLIP
    even, odd = 0.5 * (right + left), 0.5 * (right - left)
    # On the axis the slope is 0/0; whatever stands there is multiplied by x = 0.
    middle = jnp.abs(even[:, 0]) < 1e-9
    slope = jnp.where(middle, 0.0, odd[:, 1] / jnp.where(middle, 1.0, even[:, 0]))
    along = lambda values: liquid_within(jnp.stack([even[:, 0], values], axis=1), numbers)[:, 1]  # noqa: E731
    liquid = liquid_within(even, numbers)
    shared = jnp.stack([along(odd[:, 0]), along(slope) * liquid[:, 0]], axis=1)
    return jnp.concatenate([liquid + shared, ((liquid - shared) * FLIP)[of_liquid.others]])


def _instants(time: np.ndarray, stress: np.ndarray, times: Sequence[float] | None) -> list[tuple[str, str, int]]:
    """Return words before the time, name of the file and row."""
    if times is None:
        return [("largest stress, ", "fields", int(np.argmax(stress))), ("end, ", "fields_end", int(np.argmax(time)))]
    return [("", f"fields_{k}", int(np.argmin(np.abs(time - at)))) for k, at in enumerate(times)]


def _together(
    design: TankDrop, wall: np.ndarray, liquid: np.ndarray, fields: dict[str, Any]
) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
    """Return nodes, cells and values of what is computed: wall and plate, then the liquid."""
    sets = NodeSets.of(design)
    nodes, cells = wall, sets.corners
    values = {STRESS: 1e-6 * fields["stress"], "equivalent plastic strain [-]": fields["plastic_strain"]}
    if "pressure" in fields:
        corners = sets.liquid_corners
        # Values belong to cells, as the stress does, and the liquid's pressure is known at nodes.
        pressure = 1e-3 * fields["pressure"][corners].mean(axis=1)
        # Wall and liquid are the cells of one mesh: a cell has NaN for what it does not have.
        values = {name: np.concatenate([one, np.full(len(corners), np.nan)]) for name, one in values.items()}
        values["pressure of the liquid [kPa]"] = np.concatenate([np.full(len(cells), np.nan), pressure])
        cells = np.concatenate([cells, corners + len(nodes)])
        nodes = np.concatenate([nodes, liquid])
    return nodes, cells, values


def _completed(design: TankDrop, mesh: Meshed) -> Meshed:
    """Return a mesh with its mirror image, where half of the section is computed; corners stay counter-clockwise."""
    if design.mesh.extent == "whole":
        return mesh
    both = np.concatenate([mesh.cells, mesh.cells[:, ::-1] + len(mesh.nodes)])
    twice = {key: np.concatenate([one, one]) for key, one in mesh.values.items()}
    return mesh._replace(nodes=np.concatenate([mesh.nodes, mesh.nodes * FLIP]), cells=both, values=twice)
