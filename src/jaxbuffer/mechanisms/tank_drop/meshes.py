"""Wall and liquid at instants of a run, both halves of the section."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from jaxtyping import Array, Float

from ...programs.cache import stored
from ..picture import Meshed
from .design import TankDrop, TankDropScenario
from .numbering import Numbering
from .section import liquid_within, section

ACROSS, ALONG = "across the impact [mm]", "along the impact, downwards [mm]"
STRESS = "stress after von Mises [MPa]"


def meshes(run: Any, times: Sequence[float] | None = None) -> list[Meshed]:
    """Of a run with a history, at the rows next to some ``times`` [s], or at the largest stress and the end."""
    kept = {name: np.asarray(values) for name, values in run.history.others.items()}
    time, found = np.asarray(run.history.time), []
    for words, name, row in _instants(time, kept["peak_stress"], times):
        wall, liquid = map(np.asarray, _moved(run.design, run.scenario, kept["displacement"][row]))
        title = f"{words}{1e3 * time[row]:.4g} ms"
        numbers, now = Numbering.of(run.design), {key: values[row] for key, values in kept.items()}
        found.append(_mirrored(title, name, *_whole(numbers, wall, liquid, now)))
    return found


def displaced(run: Any) -> tuple[Meshed, Meshed]:
    """The wall before the impact, and at the largest force, with how far it has moved since [mm].

    The liquid's mesh goes along by interpolation, so that it has no displacement of its own."""
    kept = np.asarray(run.history.others["displacement"])
    row = int(np.argmax(np.asarray(run.history.contact_force)[:, 0]))
    numbers, made = Numbering.of(run.design), []
    since = kept[row, numbers.corners].mean(axis=1) - kept[0, numbers.corners].mean(axis=1)
    for words, place in (("before", 0), (f"{1e3 * float(run.history.time[row]):.4g} ms", row)):
        wall, _ = map(np.asarray, _moved(run.design, run.scenario, kept[place]))
        across, down = 1e3 * since[:, 0] * (place > 0), -1e3 * since[:, 1] * (place > 0)
        both = _mirrored(words, "", wall, numbers.corners, {ACROSS: across, ALONG: down})
        both.values[ACROSS][len(across) :] *= -1.0
        made.append(both)
    return made[0], made[1]


@stored
def _moved(
    design: TankDrop, scenario: TankDropScenario, displacement: Float[Array, "nodes 2"]
) -> tuple[Float[Array, "nodes 2"], Float[Array, "liquid 2"]]:
    """The nodes of wall and plate, and the liquid's, whose mesh goes with the wall [m]."""
    seen = section(design, scenario.fill)
    at = seen.positions + displacement[: len(seen.positions)]
    return at, liquid_within(at, seen.numbers)


def _instants(time: np.ndarray, stress: np.ndarray, times: Sequence[float] | None) -> list[tuple[str, str, int]]:
    """Words before the time, name of the file and row."""
    if times is None:
        return [("largest stress, ", "fields", int(np.argmax(stress))), ("end, ", "fields_end", int(np.argmax(time)))]
    return [("", f"fields_{k}", int(np.argmin(np.abs(time - at)))) for k, at in enumerate(times)]


def _whole(
    numbers: Numbering, wall: np.ndarray, liquid: np.ndarray, kept: dict[str, Any]
) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
    """Nodes, cells and values of the right half: wall and plate, then the liquid."""
    nodes, cells = wall, numbers.corners
    values = {STRESS: 1e-6 * kept["stress"], "equivalent plastic strain [-]": kept["plastic_strain"]}
    if "pressure" in kept:
        corners = numbers.liquid_corners
        pressure = 1e-3 * kept["pressure"][corners].mean(axis=1)
        values = {name: np.concatenate([one, np.full(len(corners), np.nan)]) for name, one in values.items()}
        values["pressure of the liquid [kPa]"] = np.concatenate([np.full(len(cells), np.nan), pressure])
        cells = np.concatenate([cells, corners + len(nodes)])
        nodes = np.concatenate([nodes, liquid])
    return nodes, cells, values


def _mirrored(title: str, name: str, nodes: np.ndarray, cells: np.ndarray, values: dict[str, np.ndarray]) -> Meshed:
    """Both halves; corners stay counter-clockwise."""
    other = nodes * np.array([-1.0, 1.0])
    both = np.concatenate([cells, cells[:, ::-1] + len(nodes)])
    twice = {key: np.concatenate([one, one]) for key, one in values.items()}
    return Meshed(title, name, np.concatenate([nodes, other]), both, twice)
