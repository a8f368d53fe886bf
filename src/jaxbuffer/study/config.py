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

from ..choosing.catalogue import TOTALS, PartsCatalogue
from ..errors import InputError, check_whole, shown
from ..fields import (
    SCENARIO,
    Curve,
    Part,
    as_written,
    by_path,
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
from ..tuning.tolerances import Tolerance
from ..value_text import unit_text
from .fit_toml import FIT, FitTable
from .mistaken import no_file, no_table, no_toml
from .model import (
    PROBLEM,
    ROUNDINGS,
    SAMPLE,
    SCENARIO_TABLE,
    SCENARIOS,
    SWEEP,
    TOLERANCES,
    ProblemTable,
    SampleTable,
    StudyOptions,
)
from .parts_toml import PARTS, ChoiceSettings, Selection, check_no_sums, sums
from .problem_toml import check_table, read_problem
from .tables import PartTable, StudyNames, read_keys, replaced, subtable
from .values import TOLERANCED, as_table

T = TypeVar("T", bound=eqx.Module)

DEFAULT_KIND = "probe_cone"


@dataclasses.dataclass(frozen=True)
class Config:
    """A study: one design, the scenario to simulate, the scenarios to tune for (default: that one), and settings.

    ``table``: of which the `problem` is made; ``sweep``: values by path, as `grid` reads them; ``folder``: the file's
    own, where the Python files lie that it names; ``texts``: typed with a unit, by address; ``units``: those that
    numbers were typed with, by address, in which people are told them; ``given``: addresses of the fields that the
    file gives, those of [options] and [tune] among them; ``usual_duration``: whether ``options.duration`` is what is
    usual for the design, as none is given.
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
    parts: tuple[PartsCatalogue, ...] = subtable(PARTS, "catalogues that jaxbuffer choose chooses from", tuple)
    roundings: Mapping[str, Any] = subtable(
        ROUNDINGS, "values that can be built: an E series or a step, for jaxbuffer choose", dict
    )
    choosing: ChoiceSettings = subtable(
        PartTable(lambda names: ChoiceSettings()), "how jaxbuffer choose ranks", ChoiceSettings, key="choose"
    )
    tolerances: Mapping[str, Tolerance] = subtable(
        TOLERANCES, "how far built numbers may be from the drawn ones; tune keeps every limit in their corners", dict
    )
    fit: FitTable = subtable(FIT, "what jaxbuffer fit finds from measured tests", FitTable)
    folder: Path = Path()
    texts: Mapping[str, str] = dataclasses.field(default_factory=dict, compare=False)
    given: frozenset[str] = dataclasses.field(default=frozenset(), compare=False)
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
        check_no_sums(self.table.objective.weights if self.table.objective else {})
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
                tolerances=self.tolerances,
            )

    def selection(self) -> Selection:
        """Read what parts are chosen by: without [problem.variables] nothing else is to be tuned."""
        given, table = self.table.objective, self.table
        study = self.varying([path for catalogue in self.parts for path in catalogue.paths])
        if given is not None and set(given.weights) & set(TOTALS):
            weights = {name: weight for name, weight in given.weights.items() if name not in TOTALS}
            of_runs = dataclasses.replace(given, weights=weights) if weights else None
            table = dataclasses.replace(table, objective=of_runs)
        if self.parts and table.variables is None:
            table = dataclasses.replace(table, variables={})
        limits = {} if table.constraints is None else table.constraints.at_most
        at_most = {name: bound for name, bound in limits.items() if name in TOTALS}
        return Selection(dataclasses.replace(study, table=table).problem(), given, at_most)


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
            points = points_text(value, f"{prefix}{name}", units)
            lines.append(f"{name} = {points}  # " + (f"{x}, {y}" if '"' in points else f"{x} {first}, {y} {second}"))
            continue
        written = as_written(float(value), symbol, units.get(f"{prefix}{name}", "")) if symbol else value
        entry = tomli_w.dumps({name: written}).rstrip()
        lines.append(entry if isinstance(written, str) else f"{entry}{unit_text(symbol, '  # ')}")
    return lines


def points_text(curve: Curve, path: str, units: Mapping[str, str]) -> str:
    """Return a curve's points as a study writes them, in the ``units`` that were typed with ``path[0]`` and
    ``path[1]``, its two axes."""
    columns = []
    for k, ((_, symbol), numbers) in enumerate(zip(curve.axes, (curve.places, curve.values), strict=True)):
        written = [as_written(float(number), symbol, units.get(f"{path}[{k}]", "")) for number in numbers]
        if not all(isinstance(it, str) for it in written):  # one cannot be written in its unit exactly
            written = [float(number) for number in numbers]
        columns.append([f'"{it}"' if isinstance(it, str) else repr(it) for it in written])
    return "[" + ", ".join(f"[{place}, {number}]" for place, number in zip(*columns, strict=True)) + "]"


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
    data = _with_tolerances(data, (*parts, "scenario"))
    typed = {f"{part}.{key}": value for part in parts for key, value in as_table(part, data.get(part, {})).items()}
    design, rest = replaced(mechanism.design(), typed, folder=folder), dict(tables)
    names = StudyNames(design, mechanism.scenario(), folder=folder)
    # One after the other, since the scenario is what [[scenarios]] begin with, and all tables name its fields.
    scenario, listed = {"scenario": rest.pop("scenario")}, {"scenarios": rest.pop("scenarios")}
    read = read_keys("", data, scenario, names)
    names = names._replace(**read)
    read |= read_keys("", data, listed, names)
    # Commands of one run need one scenario: without a [scenario] it is the first that is listed.
    if "scenarios" in read and "scenario" not in read:
        names = names._replace(scenario=read["scenarios"][0])
    # Objective and limits may name price and mass where the parts have them.
    read |= read_keys("", data, {"parts": rest.pop("parts")}, names)
    names = names._replace(own=sums(read.get("parts", ()), design))
    read |= read_keys("", data, rest, names) | {"scenario": names.scenario}
    typed |= {f"{SCENARIO}{name}": value for name, value in data.get("scenario", {}).items()}
    typed |= {f"{name}.{key}": it for name in ("options", "tune") for key, it in data.get(name, {}).items()}
    texts = {path: value for path, value in typed.items() if isinstance(value, str)}
    values = {tables[name]["field"]: value for name, value in read.items()}
    config = Config(names.design, folder=folder, texts=texts, given=frozenset(typed), **values)
    check_table(config.table, names.design, names.scenario, read.get("scenarios", ()))
    return config


def _with_tolerances(data: dict[str, Any], parts: Iterable[str]) -> dict[str, Any]:
    """Return a study's tables in which the tolerances that stand with a number are among its [tolerances]."""
    data, found = dict(data), dict[str, Any]()
    for part in parts:
        table = dict(as_table(part, data.get(part, {})))
        for name, given in table.items():
            if not isinstance(given, Mapping):
                continue
            where = f"{part}.{name}"
            if set(given) != set(TOLERANCED):
                raise InputError(f'{where} = {shown(given)}; write {name} = {{value = …, tolerance = "10 %"}}')
            table[name], found[where] = given["value"], given["tolerance"]
        if part in data:
            data[part] = table
    if not found:
        return data
    others = by_path(as_table("tolerances", data.get("tolerances", {})), where="tolerances")
    for where in found:
        if where in others:
            raise InputError(f"{where} has a tolerance in its own table and in [tolerances]; keep one")
    return data | {"tolerances": others | found}


def _typed_units(value: Any, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield the unit that was typed with each number, by the address of its field, wherever it is set, tuned, swept or
    sampled. ``path``: of ``value`` in the file."""
    if isinstance(value, Mapping):
        for name, inner in value.items():
            yield from _typed_units(inner, f"{path}.{name}".lstrip("."))
    elif path == "scenarios" and isinstance(value, list):
        for inner in value:
            yield from _typed_units(inner, "scenario")
    elif isinstance(value, list) and value and all(isinstance(point, list) and len(point) == 2 for point in value):
        for k, column in enumerate(zip(*value, strict=True)):  # of a curve
            if symbol := typed_unit(column):
                yield f"{path}[{k}]", symbol
    elif symbol := typed_unit(value):
        # From the number's place in the file to the address of the field that it is about.
        path = re.sub(r"^(.*)\.tolerance$", r"tolerances.\1", path)
        path = re.sub(r"\.(from|to|uniform|normal|value)$", "", path)
        path = re.sub(r"^(problem\.variables|sweep|sample\.ranges|fit\.parameters)\.", "", path)
        path = re.sub(r"^problem\.grid\.(?=\w+\.)", "", path)
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
