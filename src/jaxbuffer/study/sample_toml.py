"""The ``[sample]`` section of a study."""

from collections.abc import Mapping
from typing import Any

from ..errors import InputError, check_choice, shown, suggest
from ..experiments.points import METHODS, points
from ..experiments.ranges import ranges
from ..fields import Part, by_path

KEYS = ("count", "method", "seed", "ranges")


def read_sample(table: Mapping[str, Any], design: Part, scenario: Part) -> dict[str, Any]:
    """Count, method, seed and ranges by dotted path, those that are given, checked."""
    for name in table:
        if name not in KEYS:
            raise InputError(f"sample.{name} is unknown{suggest(name, KEYS)}; ranges go under [sample.ranges]")
    sample = dict(table)
    check_choice("sample.method", table.get("method", METHODS[0]), METHODS)
    if "ranges" in table:
        if not isinstance(table["ranges"], Mapping):
            raise InputError(f"sample.ranges = {shown(table['ranges'])} is not a table; write [sample.ranges]")
        sample["ranges"] = by_path(table["ranges"], where="sample.ranges")
        axes = ranges(sample["ranges"], design, scenario)
        points(axes, table.get("count", 1), table.get("method", METHODS[0]), table.get("seed", 0))
    return sample
