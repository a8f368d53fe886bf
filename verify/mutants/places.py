"""Which files are tried, and a random choice among the faults that they could hold."""

import random
from pathlib import Path

from .changes import Mutant, mutants

ROOMS = ("contact", "multibody", "mechanisms", "hybrid", "sensitivities", "run")
# What draws, words, lists or hands on; it computes nothing of a motion.
LEFT_OUT = {
    "__init__", "advice", "comparison", "dataset", "described", "diagnosis", "drawing", "history_table", "journal",
    "label", "mechanism", "outcome", "panels", "picture", "problem", "published", "registry", "request", "summary",
}  # fmt: skip


def sources(package: Path) -> list[str]:
    """Files of the rooms that compute, relative to the package."""
    found = [path for room in ROOMS for path in sorted((package / room).rglob("*.py")) if path.stem not in LEFT_OUT]
    return [str(path.relative_to(package)) for path in found]


def chosen(package: Path, count: int, seed: int) -> list[Mutant]:
    """So many faults, as many from each room, in turns; at most one of each operator or constant."""
    rooms: dict[str, list[Mutant]] = {room: [] for room in ROOMS}
    for path in sources(package):
        rooms[path.split("/")[0]] += mutants(package, path)
    drawn = []
    for room, found in rooms.items():
        order = random.Random(f"{seed} {room}")
        shuffled = order.sample(found, len(found))
        places: dict[tuple[str, int], Mutant] = {}
        for mutant in shuffled:
            places.setdefault((mutant.path, mutant.start), mutant)
        drawn.append(list(places.values()))
    turns = [
        mutant for turn in zip(*(row[: -(-count // len(ROOMS))] for row in drawn), strict=False) for mutant in turn
    ]
    return turns[:count]
