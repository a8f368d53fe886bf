"""A scenario in space in a few words."""

from collections.abc import Sequence

from ...fields import paths, unit
from ..probe_cone.label import field_in_words, free_in_words, parts_in_words, speed_in_words
from .design import Scenario3D

SHOWN = {"m": "mm", "rad": "deg", "rad/s": "deg/s", "m/s": "mm/s"}
NAMED = ("approach_speed", "contact_distance", "azimuth", "start", "thrust", "thrust_time")  # in their own way


def scenario_label(scenario: Scenario3D, among: Sequence[Scenario3D] = ()) -> str:
    """Return what people call a scenario: "0.1 m/s, azimuth 40 deg, passive yaw 1 deg": its approach speed, and what is
    not zero; contact distance too where that differs ``among`` several."""
    label = speed_in_words(scenario, among)
    if scenario.start == "free":
        label += free_in_words(among)
    elif len({float(other.contact_distance) for other in among}) > 1:
        label += field_in_words(scenario, "contact_distance", "mm")
    names = [name for name in paths(scenario) if name not in (*NAMED, *scenario.without_effect)]
    names = names if scenario.start == "free" else ["azimuth", *names]
    given = [name for name in names if float(getattr(scenario, name)) != 0.0]
    return (
        label
        + "".join(field_in_words(scenario, name, SHOWN[unit(scenario, name)]) for name in given)
        + parts_in_words(scenario)
    )
