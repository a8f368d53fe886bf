"""A scenario in a few words."""

from collections.abc import Sequence

import numpy as np

from ...fields import in_words, unit
from .design import Scenario


def scenario_label(scenario: Scenario, among: Sequence[Scenario] = ()) -> str:
    """What people call a scenario: "0.1 m/s, +3°", its approach speed and misalignment; its contact distance and the
    passive rate too where those differ ``among`` several."""
    angle = np.degrees(float(scenario.misalignment)) + 0.0
    speed = float(scenario.approach_speed)
    alike = any(f"{other.approach_speed:.4g}" == f"{speed:.4g}" and other.approach_speed != speed for other in among)
    label = f"{speed:{'.9g' if alike else '.4g'}} m/s, {angle:{'+' if angle else ''}.4g}°"
    for name, shown in (("contact_distance", "mm"), ("passive_rate", "deg/s")):
        if len({float(getattr(other, name)) for other in among}) > 1:
            label += (
                f", {name.replace('_', ' ')} {in_words(float(getattr(scenario, name)), unit(scenario, name), shown)}"
            )
    return label
