"""Wall and liquid at instants of a run, both halves of the section."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..picture import Meshed
from .assembly import assembled
from .section import Section, liquid_mesh

STRESS = "stress after von Mises [MPa]"


def meshes(run: Any, times: Sequence[float] | None = None) -> list[Meshed]:
    """Of a run with a history, at the rows next to some ``times`` [s], or at the largest stress and the end."""
    parts, seen = assembled(run.design, run.scenario), run.history
    time = np.asarray(seen.time)
    rest = np.asarray(parts.system.positions)
    kept = {name: np.asarray(values) for name, values in seen.others.items()}
    found = []
    for words, name, row in _instants(time, kept["peak_stress"], times):
        at = (rest + kept["displacement"][row])[: len(parts.section.positions)]
        title = f"{words}{1e3 * time[row]:.4g} ms"
        found.append(_mirrored(title, name, *_whole(parts.section, at, {k: v[row] for k, v in kept.items()})))
    return found


def _instants(time: np.ndarray, stress: np.ndarray, times: Sequence[float] | None) -> list[tuple[str, str, int]]:
    """Words before the time, name of the file and row."""
    if times is None:
        return [("largest stress, ", "fields", int(np.argmax(stress))), ("end, ", "fields_end", int(np.argmax(time)))]
    return [("", f"fields_{k}", int(np.argmin(np.abs(time - at)))) for k, at in enumerate(times)]


def _whole(section: Section, at: np.ndarray, kept: dict[str, Any]) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
    """Nodes, cells and values of the right half: the wall, then the liquid, whose mesh goes with the wall."""
    wall = len(section.numbers.corners)
    nodes, cells = at, np.asarray(section.numbers.corners)
    values = {STRESS: 1e-6 * kept["stress"], "equivalent plastic strain [-]": kept["plastic_strain"]}
    if "pressure" in kept:
        inner = section.numbers.inner[: section.numbers.level + 1]
        liquid, _ = liquid_mesh(at[inner], int(section.numbers.corner))
        corners = np.asarray(section.liquid_corners)
        pressure = 1e-3 * kept["pressure"][corners].mean(axis=1)
        values = {name: np.concatenate([one, np.full(len(corners), np.nan)]) for name, one in values.items()}
        values["pressure of the liquid [kPa]"] = np.concatenate([np.full(wall, np.nan), pressure])
        cells = np.concatenate([cells, corners + len(nodes)])
        nodes = np.concatenate([nodes, np.asarray(liquid)])
    return nodes, cells, values


def _mirrored(title: str, name: str, nodes: np.ndarray, cells: np.ndarray, values: dict[str, np.ndarray]) -> Meshed:
    """Both halves; corners stay counter-clockwise."""
    other = nodes * np.array([-1.0, 1.0])
    both = np.concatenate([cells, cells[:, ::-1] + len(nodes)])
    twice = {key: np.concatenate([one, one]) for key, one in values.items()}
    return Meshed(title, name, np.concatenate([nodes, other]), both, twice)
