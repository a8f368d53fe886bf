"""``[fit]`` in a study: the parameters that measured tests are to tell, and the tests."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InputError, check_known, shown
from ..fields import SCENARIO, Part, declared
from ..files import user_path
from ..fitting.quantities import recorded_quantities
from ..fitting.reading import read_recording
from ..fitting.recording import Channel, Recording
from ..tuning.problem.variable import Variable
from .tables import PartTable, PathTable, StudyNames, StudyTable, keys_schema, read_keys, replaced, subtable
from .values import BOUNDS, TEXT, Schema, as_table, as_tables, object_schema

PARAMETERS = PathTable(BOUNDS, "design", example="buffer.k_A = [100, 3000]")
ONE_OR_TWO: Schema = {
    "anyOf": [{"type": "number"}, TEXT, {"type": "array", "minItems": 2, "maxItems": 2}],
}
COLUMN = {
    "quantity": "a history's name: stroke, active_acceleration_x",
    "noise": "standard deviation; not set: estimated",
    "gain": "of the sensor, a number or [low, high] [-]",
    "offset": "which it adds besides, likewise, in the quantity's unit or with one",
    "filter": "time constant of its low-pass, a number or [low, high] [s]",
    "delay": "by which it is late besides [s], likewise; not set: within half an interval where filter is unknown",
}
TEST = {
    "file": "the table: commas, semicolons or tabs",
    "time": 'heading of the times; default: "time [s]"',
    "scenario": "this test's own fields of the scenario",
    "time_shift": "by which the record's time is ahead, a number or [low, high] [s]",
    "columns": "the sensors, by the headings of their columns",
}


@dataclasses.dataclass(frozen=True)
class TestTable:
    """One of ``[[fit.tests]]``; arguments as of `read_recording`."""

    file: str
    channels: Mapping[str, Channel]
    time: str
    fields: Mapping[str, Any]
    time_shift: Any

    def recording(self, design: Part, scenario: Part, folder: Path) -> Recording:
        """Read the test's file. ``scenario``: the study's, in which the test has ``fields`` of its own; ``folder``: the
        study's own."""
        own = replaced(scenario, self.fields, SCENARIO)
        return read_recording(
            # Relative to the study and not to the current folder, so that the study can be used from anywhere.
            folder / user_path(self.file),
            self.channels,
            time=self.time,
            scenario=own,
            time_shift=self.time_shift,
            units=recorded_quantities(design, own),
        )


def _channel(where: str, given: Any) -> Channel:
    if isinstance(given, str):
        return Channel(given)
    check_known(as_table(where, given), COLUMN, where)
    if not isinstance(given.get("quantity"), str):
        raise InputError(f'{where} names no quantity; write {{quantity = "stroke"}}')
    return Channel(**given)


class TestsKind(StudyTable):
    """``[[fit.tests]]``: the measured tests."""

    def read(self, where: str, given: Any, names: StudyNames) -> tuple[TestTable, ...]:
        return tuple(self.test(name, it, names) for name, it in as_tables(where, given))

    def test(self, where: str, given: Mapping[str, Any], names: StudyNames) -> TestTable:
        """Read one of them."""
        check_known(given, TEST, where)
        for key in ("file", "columns"):
            if key not in given:
                raise InputError(f"{where} has no {key}: {TEST[key]}")
        for key in ("file", "time"):
            if key in given and not isinstance(given[key], str):
                raise InputError(f"{where}.{key} = {shown(given[key])} is not text: {TEST[key]}")
        columns = as_table(f"{where}.columns", given["columns"])
        if not columns:
            raise InputError(f'{where}.columns is empty; write "stroke [mm]" = {{quantity = "stroke"}} below it')
        fields = as_table(f"{where}.scenario", given.get("scenario", {}))
        replaced(names.scenario, fields, f"{where}.scenario.")  # checks them
        return TestTable(
            file=given["file"],
            channels={name: _channel(f'{where}.columns."{name}"', it) for name, it in columns.items()},
            time=given.get("time", "time [s]"),
            fields=fields,
            time_shift=given.get("time_shift", 0.0),
        )

    def schema(self, names: StudyNames) -> Schema:
        quantity: Schema = {"type": "string", "description": COLUMN["quantity"]}
        others = {key: ONE_OR_TWO | {"description": words} for key, words in COLUMN.items() if key != "quantity"}
        column = object_schema({"quantity": quantity} | others, required=["quantity"])
        test = object_schema(
            {
                "file": {"type": "string", "description": TEST["file"]},
                "time": {"type": "string", "description": TEST["time"]},
                "scenario": PartTable(lambda names: names.scenario).schema(names) | {"description": TEST["scenario"]},
                "time_shift": ONE_OR_TWO | {"description": TEST["time_shift"]},
                "columns": {
                    "type": "object",
                    "additionalProperties": {"anyOf": [quantity, column]},
                    "description": TEST["columns"],
                },
            },
            required=["file", "columns"],
        )
        return {"type": "array", "items": test, "minItems": 1}


@dataclasses.dataclass(frozen=True)
class FitTable:
    """``[fit]``: what `jaxbuffer fit` is to find out."""

    parameters: Mapping[str, Variable] | None = subtable(
        PARAMETERS, "what is fitted: [low, high] or [low, high, scale]; the search starts at the design's numbers"
    )
    tests: tuple[TestTable, ...] = subtable(
        TestsKind(),
        "the measured tests, each under its own [[fit.tests]]",
        tuple,
    )

    def recordings(self, design: Part, scenario: Part, folder: Path) -> list[Recording]:
        """Read the tests' files. **Raises:** `InputError` for a study without a test or a parameter."""
        if not self.parameters or not self.tests:
            missing = "[[fit.tests]]" if self.parameters else "[fit.parameters]"
            raise InputError(f"fit needs {missing} in the study (docs/fit.md)")
        return [it.recording(design, scenario, folder) for it in self.tests]


class FitKind(StudyTable):
    """``[fit]``, of known keys alone."""

    def read(self, where: str, given: Any, names: StudyNames) -> FitTable:
        keys = declared(FitTable)
        check_known(as_table(where, given), keys, where)
        return FitTable(**read_keys(f"{where}.", given, keys, names))

    def schema(self, names: StudyNames) -> Schema:
        return keys_schema(declared(FitTable), names)


FIT = FitKind()
