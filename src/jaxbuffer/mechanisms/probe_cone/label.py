"""A scenario in a few words."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...fields import as_typed, unit
from ...value_text import degrees_text, with_unit
from .design import Scenario
from .parts import PARTS

OF_FREE_START = {  # the unit in which each is shown
    "offset": "mm",
    "standoff": "mm",
    "active_angle": "deg",
    "active_rate": "deg/s",
    "passive_rate": "deg/s",
    "lateral_speed": "mm/s",
}


def scenario_label(scenario: Scenario, among: Sequence[Scenario] = ()) -> str:
    """Return what people call a scenario: "0.1 m/s, +3°", its approach speed and misalignment; contact distance and
    passive rate too where those differ ``among`` several. Of a free start and of parts, what is not at its default;
    that all of several start free is not repeated in each."""
    angle = np.degrees(float(scenario.misalignment))
    label = f"{speed_in_words(scenario, among)}, {degrees_text(angle)}"
    for name, shown in (("contact_distance", "mm"), ("passive_rate", "deg/s")):
        named_below = scenario.start == "free" and name in OF_FREE_START
        differs = len({float(getattr(other, name)) for other in among}) > 1
        if differs and not named_below and name not in scenario.without_effect:
            label += field_in_words(scenario, name, shown)
    if scenario.start == "free":
        label += free_in_words(among)
        for name, shown in OF_FREE_START.items():
            if float(getattr(scenario, name)) != 0.0:
                label += field_in_words(scenario, name, shown)
    return label + parts_in_words(scenario)


def speed_in_words(scenario: Any, among: Sequence[Any]) -> str:
    """Return the approach speed: two speeds ``among`` several that are alike in four digits are told apart by nine."""
    speed = float(scenario.approach_speed)
    alike = any(f"{other.approach_speed:.4g}" == f"{speed:.4g}" and other.approach_speed != speed for other in among)
    return with_unit(speed, "m/s", 9 if alike else 4)


def free_in_words(among: Sequence[Any]) -> str:
    """Return ", free start", which is not repeated in each where all of several start free."""
    all_free = len(among) > 1 and all(other.start == "free" for other in among)
    return "" if all_free else ", free start"


def parts_in_words(scenario: Any) -> str:
    """Return what parts a scenario has: ", thrust 1 N for 0.4 s"."""
    return "".join(part.label(scenario) for part in PARTS if part.present(None, scenario))


def field_in_words(scenario: Any, name: str, shown: str) -> str:
    """Return a field behind others, in the unit in which it is shown: ", offset -20 mm"."""
    number = as_typed(float(getattr(scenario, name)), unit(scenario, name), shown)
    return f", {name.replace('_', ' ')} {with_unit(*number)}"
