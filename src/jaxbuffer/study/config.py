"""Studies as TOML: read into a `Config`, override fields by dotted path, write a design back."""

import contextlib
import dataclasses
import re
import tomllib
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import equinox as eqx
import tomli_w

from ..errors import InputError, check_whole
from ..fields import (
    SCENARIO,
    Curve,
    Part,
    as_written,
    check_address,
    declared,
    errors_in_typed_units,
    metadata,
    typed_unit,
    unit,
)
from ..files import user_path
from ..mechanisms import mechanism_named
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.registry import mechanism_of
from ..run.request import check_pair
from ..sweeps.axis import literal
from ..tuning.problem import Problem, Settings
from ..value_text import unit_text
from .fit_toml import FIT, FitTable
from .mistaken import no_file, no_table, no_toml
from .model import PROBLEM, SAMPLE, SCENARIO_TABLE, SCENARIOS, SWEEP, ProblemTable, SampleTable, StudyOptions
from .problem_toml import check_table, read_problem
from .tables import PartTable, StudyNames, read_keys, replaced, subtable
from .values import as_table

T = TypeVar("T", bound=eqx.Module)

DEFAULT_KIND = "probe_cone"


@dataclasses.dataclass(frozen=True)
class Config:
    """A study: one design, the scenario to simulate, the scenarios to tune for (default: that one), and settings.

    ``table``: of which the `problem` is made; ``sweep``: values by path, as `grid` reads them; ``folder``: the file's
    own, where the Python files lie that it names; ``texts``: typed with a unit, by address; ``units``: those that
    numbers were typed with, by address, in which people are told them; ``usual_duration``: whether
    ``options.duration`` is what is usual for the design, as none is given.
    """

    design: Part = dataclasses.field(default_factory=lambda: mechanism_named(DEFAULT_KIND).design())
    scenario: Part = subtable(SCENARIO_TABLE, "what is simulated", lambda: mechanism_named(DEFAULT_KIND).scenario())
    scenarios: tuple[Part, ...] = subtable(SCENARIOS, "what is tuned for: fields that differ from [scenario]", tuple)
    options: StudyOptions = subtable(PartTable(lambda names: StudyOptions()), "how", StudyOptions)
    table: ProblemTable = subtable(PROBLEM, "what jaxbuffer tune is to do", ProblemTable, key="problem")
    tuning: Settings = subtable(
        PartTable(lambda names: Settings()), "how jaxbuffer tune searches", Settings, key="tune"
    )
    sweep: Mapping[str, Any] = subtable(
        SWEEP, "what jaxbuffer sweep combines: a list, or from, to, count and scale", dict
    )
    sample: SampleTable = subtable(SAMPLE, "what jaxbuffer sample spreads runs over", SampleTable)
    fit: FitTable = subtable(FIT, "what jaxbuffer fit finds from measured tests", FitTable)
    folder: Path = Path()
    texts: Mapping[str, str] = dataclasses.field(default_factory=dict, compare=False)
    units: Mapping[str, str] = dataclasses.field(default_factory=dict, compare=False)
    usual_duration: bool = dataclasses.field(default=False, compare=False)

    def __post_init__(self) -> None:
        mechanism = self.mechanism
        check_pair(mechanism, self.design, self.scenario)
        if self.options.duration is None:
            filled = dataclasses.replace(self.options, duration=mechanism.duration(self.design))
            # Frozen for everyone else: what was left out is filled in here, once.
            object.__setattr__(self, "options", filled)
            object.__setattr__(self, "usual_duration", True)
        for i, scenario in enumerate(self.scenarios, 1):
            try:
                check_pair(mechanism, self.design, scenario)
            except InputError as error:
                raise error.between(f"[[scenarios]] number {i} ({mechanism.view.label(scenario)}): ") from None
        if not self.scenarios:
            object.__setattr__(self, "scenarios", (self.scenario,))

    @property
    def mechanism(self) -> Mechanism:
        """Return the mechanism whose design it is."""
        return mechanism_of(self.design)

    @property
    def varied(self) -> set[str]:
        """Return the paths that the study's tuning, sweep or sample gives values."""
        return {*(self.table.variables or ()), *self.sweep, *(self.sample.ranges or ())}

    def varying(self, paths: Collection[str]) -> "Config":
        """Return the study for runs in which the numbers at some paths vary: its duration, unless one is given, is what
        is usual for what they make of the design."""
        if not self.usual_duration:
            return self
        duration = self.mechanism.duration(self.design, paths)
        return dataclasses.replace(self, options=dataclasses.replace(self.options, duration=duration))

    def problem(self) -> Problem:
        """Read the design problem, whose start must lie within the bounds."""
        # Messages say numbers in the units that they were typed with.
        with errors_in_typed_units(self.units):
            return read_problem(
                self.table,
                self.design,
                self.scenario,
                listed=self.scenarios,
                duration=self.options.duration,
                rtol=self.options.rtol,
                folder=self.folder,
                units=self.units,
            )


def load(path: str | Path | None) -> Config:
    """Read a study; without a file, Table 2's. Raises `InputError` with one line that starts with the file's name."""
    if path is None:
        return Config()
    try:
        path = file = user_path(path)
        content = file.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file{no_file(file)}") from None
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    return loads(content, path)


def loads(content: bytes, name: str | Path) -> Config:
    """Read a study from a file's content; ``name`` starts an error's line."""
    # For the message, where the bytes are no text.
    text = ""
    try:
        # Some editors begin a file with a byte order mark, which TOML does not allow.
        text = content.decode("utf-8-sig")
        data = tomllib.loads(text)
    except ValueError as error:  # TOML syntax, with line and column, or bytes that are not UTF-8
        raise InputError(f"{name} is not valid TOML: {no_toml(text, error)}") from None
    try:
        units = dict(_typed_units(data))
        with errors_in_typed_units(units):
            return dataclasses.replace(_config(data, Path(name).parent), units=units)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def apply_overrides(config: Config, values: Mapping[str, str]) -> Config:
    """Return a copy with fields replaced, as typed on a command line: ``{"buffer.k_A": "800"}``.

    A scenario's field holds for every scenario of the study; scenarios that thereby become equal count once.
    """
    # First of all, so that a mistyped address is not blamed on its value.
    for path in values:
        check_address(config.design, config.scenario, path)
    meeting = {path.removeprefix(SCENARIO): text for path, text in values.items() if path.startswith(SCENARIO)}
    meeting = {path: _typed(config.scenario, path, text) for path, text in meeting.items()}
    design = {p: _typed(config.design, p, text) for p, text in values.items() if not p.startswith(SCENARIO)}
    scenarios = (replaced(scenario, meeting, "scenario.") for scenario in config.scenarios)
    units = {**config.units, **{path: typed for path, text in values.items() if (typed := typed_unit(text))}}
    # What duration is usual depends on the design: one that gets a latch runs on for longer.
    options = dataclasses.replace(config.options, duration=None) if config.usual_duration else config.options
    with errors_in_typed_units(units):
        return dataclasses.replace(
            config,
            options=options,
            design=replaced(config.design, design),
            scenario=replaced(config.scenario, meeting, "scenario."),
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


def design_toml(
    design: Part,
    scenarios: Iterable[Part] = (),
    comment: str = "",
    units: Mapping[str, str] = MappingProxyType({}),
    heading: str = "[[scenarios]]",
) -> str:
    """Write a study that `load` reads back to exactly the same numbers.

    **Arguments:** ``units``: those that numbers were typed with, by address, in which they are written; others have
    theirs as a comment; ``heading``: of the table of each scenario.
    """
    blocks = [f"# {line}".rstrip() for line in comment.splitlines()]
    mechanism = mechanism_of(design)
    if mechanism.name != DEFAULT_KIND:
        blocks += ["", f'kind = "{mechanism.name}"']
    for section in sections(mechanism):
        blocks += ["", f"[{section}]", *_lines(getattr(design, section), f"{section}.", units)]
    for scenario in scenarios:
        blocks += ["", heading, *_lines(scenario, SCENARIO, units)]
    return "\n".join(blocks).lstrip("\n") + "\n"


def _lines(part: eqx.Module, prefix: str, units: Mapping[str, str]) -> list[str]:
    """Return a line for each field; ``prefix`` makes its address of its name."""
    lines = []
    for name in (field.name for field in dataclasses.fields(part)):
        value, symbol = getattr(part, name), unit(part, name)
        if value is None:  # a stiffness to be computed: TOML has no word for it, leaving it out says it
            continue
        if isinstance(value, Curve):
            (x, first), (y, second) = value.axes
            points = ", ".join(f"[{float(place)!r}, {float(number)!r}]" for place, number in value.points())
            lines.append(f"{name} = [{points}]  # {x} {first}, {y} {second}")
            continue
        written = as_written(float(value), symbol, units.get(f"{prefix}{name}", "")) if symbol else value
        entry = tomli_w.dumps({name: written}).rstrip()
        lines.append(entry if isinstance(written, str) else f"{entry}{unit_text(symbol, '  # ')}")
    return lines


def study_tables() -> dict[str, Mapping[str, Any]]:
    """Return what is declared of the tables that stand beside a design's own, by their names in a study."""
    tables = {name: known for name, known in declared(Config).items() if "table" in known}
    return {known["key"] or name: {**known, "field": name} for name, known in tables.items()}


def _config(data: dict[str, Any], folder: Path) -> Config:
    mechanism, tables = mechanism_named(data.get("kind", DEFAULT_KIND)), study_tables()
    parts = sections(mechanism)
    known = (*parts, "kind", *tables)
    for name in data:
        if name not in known:
            raise InputError(f"[{name}] is unknown{no_table(name, known)}")
    typed = {f"{part}.{key}": value for part in parts for key, value in as_table(part, data.get(part, {})).items()}
    names, rest = StudyNames(replaced(mechanism.design(), typed, folder=folder), mechanism.scenario()), dict(tables)
    # One after the other, since the scenario is what [[scenarios]] begin with, and all tables name its fields.
    scenario, listed = {"scenario": rest.pop("scenario")}, {"scenarios": rest.pop("scenarios")}
    read = read_keys("", data, scenario, names)
    names = names._replace(**read)
    read |= read_keys("", data, listed, names)
    # Commands of one run need one scenario: without a [scenario] it is the first that is listed.
    if "scenarios" in read and "scenario" not in read:
        names = names._replace(scenario=read["scenarios"][0])
    read |= read_keys("", data, rest, names) | {"scenario": names.scenario}
    typed |= {f"{SCENARIO}{name}": value for name, value in data.get("scenario", {}).items()}
    texts = {path: value for path, value in typed.items() if isinstance(value, str)}
    values = {tables[name]["field"]: value for name, value in read.items()}
    config = Config(names.design, folder=folder, texts=texts, **values)
    check_table(config.table, names.design, names.scenario, read.get("scenarios", ()))
    return config


def _typed_units(value: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield the unit that was typed with each number, by the address of its field, wherever it is set, tuned, swept or
    sampled. ``path``: of ``value`` in the file."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _typed_units(inner, f"{path}.{name}".lstrip("."))
    elif path == "scenarios" and isinstance(value, list):
        for inner in value:
            yield from _typed_units(inner, "scenario")
    elif symbol := typed_unit(value):
        # From the number's place in the file to the address of the field that it is about.
        path = re.sub(r"\.(from|to|uniform|normal)$", "", path)
        path = re.sub(r"^(problem\.variables|sweep|sample\.ranges|fit\.parameters)\.", "", path)
        yield re.sub(r"^problem\.(grid|sample\.scenario)\.", "scenario.", path), symbol


def sections(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the names of the parts of a mechanism's designs."""
    return tuple(f.name for f in dataclasses.fields(mechanism.design) if isinstance(f.default, Part))


def _typed(owner: eqx.Module, path: str, text: str) -> Any:
    """Read what was typed for a field: "2" is a whole number where it takes such, "[[1, 2], [3, 4]]" the points of a
    curve."""
    value = text == "true" if text in ("true", "false") else literal(text)
    known = metadata(owner, path)
    if "curve" in known:
        with contextlib.suppress(ValueError):  # the check of the field says what it takes
            return tomllib.loads(f"points = {text}")["points"]
    return int(value) if "least" in known and isinstance(value, float) and value.is_integer() else value
