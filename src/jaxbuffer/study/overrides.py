"""Fields and options of a study as typed on a command line."""

import contextlib
import dataclasses
import tomllib
from collections.abc import Mapping
from typing import Any, TypeVar

import equinox as eqx

from ..errors import check_whole
from ..fields import SCENARIO, check_address, errors_in_typed_units, metadata, typed_unit
from ..sweeps.axis import literal
from .config import Config
from .tables import replaced

T = TypeVar("T", bound=eqx.Module)


def apply_overrides(config: Config, values: Mapping[str, str]) -> Config:
    """Return a copy with fields replaced, as typed on a command line: ``{"buffer.k_A": "800"}``.

    A scenario's field holds for every scenario of the study; scenarios that thereby become equal count once.
    """
    # First of all, so that a mistyped address is not blamed on its value.
    for path in values:
        check_address(config.design, config.scenario, path)
    of_scenario = {path.removeprefix(SCENARIO): text for path, text in values.items() if path.startswith(SCENARIO)}
    of_scenario = {path: _typed(config.scenario, path, text) for path, text in of_scenario.items()}
    design = {p: _typed(config.design, p, text) for p, text in values.items() if not p.startswith(SCENARIO)}
    scenarios = (replaced(scenario, of_scenario, "scenario.") for scenario in config.scenarios)
    units = {**config.units, **{path: typed for path, text in values.items() if (typed := typed_unit(text))}}
    # What duration is usual depends on the design: one that gets some part runs on for longer.
    options = dataclasses.replace(config.options, duration=None) if config.usual_duration else config.options
    with errors_in_typed_units(units):
        return dataclasses.replace(
            config,
            options=options,
            design=replaced(config.design, design),
            scenario=replaced(config.scenario, of_scenario, "scenario."),
            scenarios=tuple(dict.fromkeys(scenarios)),
            units=units,
        )


def apply_options(settings: T, typed: Mapping[str, str]) -> T:
    """Return `StudyOptions` or `Settings` with fields replaced as typed on a command line: ``{"rtol": "1e-8"}`` of
    --rtol 1e-8."""
    values = {name: _typed(settings, name, text) for name, text in typed.items()}
    for name, value in values.items():
        if (least := metadata(settings, name).get("least")) is not None:
            check_whole(f"--{name}", value, least, metadata(settings, name)["most"])
    return replaced(settings, values, "--")


def _typed(owner: eqx.Module, path: str, text: str) -> Any:
    """Read what was typed for a field: "2" is a whole number where it takes such, "[[1, 2], [3, 4]]" the points of a
    curve."""
    # As TOML spells them; "True" stays a text, which the check of the field refuses.
    value = text == "true" if text in ("true", "false") else literal(text)
    known = metadata(owner, path)
    if "curve" in known:
        with contextlib.suppress(ValueError):  # the check of the field says what it takes
            return tomllib.loads(f"points = {text}")["points"]
    return int(value) if "least" in known and isinstance(value, float) and value.is_integer() else value
