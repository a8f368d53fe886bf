"""Mechanisms, a folder each, and what they are made from.

A folder registers its `Mechanism` when it is imported; this is the list of those that come with the package, with the
public names of each.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .mechanism import Mechanism

FOLDERS: dict[str, tuple[str, ...]] = {
    "probe_cone": (
        *("Capture", "Design", "FirstImpact", "Outcome", "Scenario"),
        *("first_impact", "rigid_probe", "table2"),
        *("bending_frequencies", "with_bending"),
    ),
    "bar_drop": ("BarDrop", "BarDropScenario"),
    "slider_crank": (
        *("SliderCrank", "SliderCrankScenario", "journal_path", "published_slider_crank", "turn_statistics"),
    ),
    "tank_drop": ("TankDrop", "TankDropScenario"),
}


def all_mechanisms() -> "tuple[Mechanism, ...]":
    """All that come with the package, in the order above, and then those that were registered besides."""
    for folder in FOLDERS:
        importlib.import_module(f".{folder}", __name__)
    from .registry import all_registered

    names = list(FOLDERS)
    return tuple(sorted(all_registered(), key=lambda it: names.index(it.name) if it.name in names else len(names)))


def mechanism_named(name: Any) -> "Mechanism":
    """The mechanism of a name, such as "probe_cone". **Raises:** `InputError` that lists those there are."""
    all_mechanisms()
    from .registry import registered

    return registered(name)
