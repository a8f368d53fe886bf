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

from ..errors import InputError, as_number, check_choice, check_number, check_whole, shown, suggest
from ..experiments.points import METHODS, points
from ..experiments.ranges import ranges
from ..fields import (
    POSITIVE,
    SCENARIO,
    Curve,
    Part,
    as_written,
    by_path,
    check_address,
    choice,
    errors_in_typed_units,
    in_unit,
    meaning,
    metadata,
    number,
    paths,
    point_paths,
    replace,
    single_fields,
    typed_unit,
    unit,
    unknown,
)
from ..files import user_path
from ..hybrid import SOLVER_NAMES, Solver, solver_named
from ..mechanisms import mechanism_named
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.registry import mechanism_of
from ..run.request import DEFAULT_TOLERANCE, check_pair
from ..sweeps.axis import SPAN, literal
from ..sweeps.grid import grid
from ..tuning.problem import Problem, Settings
from ..value_text import unit_text
from .mistaken import no_file, no_table, no_toml
from .problem_toml import check_table, read_problem

T = TypeVar("T", bound=eqx.Module)

DEFAULT_KIND = "probe_cone"
SAMPLE = ("count", "method", "seed", "ranges")
KINDS = ("kind", "scenario", "scenarios", "options", "problem", "tune", "sweep", "sample")  # beside the design's own


class StudyOptions(Part):
    """How to simulate.

    - ``duration``: after which a run is over [s]; None: the mechanism's.
    - ``rtol``: relative error of a step [-].
    - ``solver``: a name in `SOLVER_NAMES`.
    """

    section = "options"
    duration: float | None = number(
        None, "s", **POSITIVE, doc="time after which a run is over; not set: the mechanism's"
    )
    rtol: float = number(DEFAULT_TOLERANCE, "-", low=1e-13, high=1e-2, doc="relative error of a step")
    solver: str = choice("automatic", *SOLVER_NAMES, doc="how runs are stepped")

    def stepper(self) -> Solver:
        """Return the solver that ``solver`` names."""
        return solver_named(self.solver)


@dataclasses.dataclass(frozen=True)
class Config:
    """A study: one design, the scenario to simulate, the scenarios to tune for (default: that one), and settings.

    ``table``: the ``[problem]`` section as read, checked when the `problem` is made; ``folder``: the file's own, where
    the Python files lie that it names; ``units``: those that numbers were typed with, by address, in which people are
    told them; ``usual_duration``: whether ``options.duration`` is what is usual for the design, as none is given.
    """

    design: Part = dataclasses.field(default_factory=lambda: mechanism_named(DEFAULT_KIND).design())
    scenario: Part = dataclasses.field(default_factory=lambda: mechanism_named(DEFAULT_KIND).scenario())
    scenarios: tuple[Part, ...] = ()
    options: StudyOptions = dataclasses.field(default_factory=StudyOptions)
    tuning: Settings = dataclasses.field(default_factory=Settings)
    table: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    sweep: Mapping[str, Any] = dataclasses.field(default_factory=dict)  # path to values, as `grid` reads them
    sample: Mapping[str, Any] = dataclasses.field(default_factory=dict)  # count, method, seed, and ranges by path
    folder: Path = Path()
    texts: Mapping[str, str] = dataclasses.field(default_factory=dict, compare=False)  # typed with a unit, by address
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
        ranges = self.sample.get("ranges", {})
        return {*self.table.get("variables", {}), *self.sweep, *(ranges if isinstance(ranges, Mapping) else ())}

    def varying(self, paths: Collection[str]) -> "Config":
        """Return the study for runs in which the numbers at some paths vary: its duration, unless one is given, is what
        is usual for what they make of the design."""
        if not self.usual_duration:
            return self
        duration = self.mechanism.duration(self.design, paths)
        return dataclasses.replace(self, options=dataclasses.replace(self.options, duration=duration))

    def problem(self) -> Problem:
        """Read the design problem, whose start must lie within the bounds."""
        options = self.options
        # Messages say numbers in the units that they were typed with.
        with errors_in_typed_units(self.units):
            return read_problem(
                self.table,
                self.design,
                self.scenario,
                self.scenarios,
                options.duration,
                options.rtol,
                self.folder,
                self.units,
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
    scenarios = (_replaced(scenario, meeting, "scenario.") for scenario in config.scenarios)
    units = {**config.units, **{path: typed for path, text in values.items() if (typed := typed_unit(text))}}
    # What duration is usual depends on the design: one that gets a latch runs on for longer.
    options = dataclasses.replace(config.options, duration=None) if config.usual_duration else config.options
    with errors_in_typed_units(units):
        return dataclasses.replace(
            config,
            options=options,
            design=_replaced(config.design, design),
            scenario=_replaced(config.scenario, meeting, "scenario."),
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
    return _replaced(settings, values, "--")


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


def _config(data: dict[str, Any], folder: Path) -> Config:
    mechanism = mechanism_named(data.get("kind", DEFAULT_KIND))
    parts = sections(mechanism)
    known = (*parts, *KINDS)
    for name in data:
        if name not in known:
            raise InputError(f"[{name}] is unknown{no_table(name, known)}")
    fields = {f"{section}.{key}": value for section in parts for key, value in _table(data, section).items()}
    design = _replaced(mechanism.design(), fields, folder=folder)
    scenario = _replaced(mechanism.scenario(), _table(data, "scenario"), "scenario.")
    listed = data.get("scenarios", [])
    if "scenarios" in data and not (isinstance(listed, list) and listed and all(isinstance(x, dict) for x in listed)):
        raise InputError("scenarios is not a list of tables; write each under its own [[scenarios]]")
    scenarios = tuple(_replaced(scenario, entry, f"scenarios[{i}].") for i, entry in enumerate(listed, 1))
    # Commands of one run need one scenario: without a [scenario] it is the first that is listed.
    if scenarios and "scenario" not in data:
        scenario = scenarios[0]
    options = _replaced(StudyOptions(), _table(data, "options"), "options.")
    sweep = by_path(_table(data, "sweep"), SPAN, "sweep", single_fields(design, scenario))
    if sweep:
        grid(sweep, design, scenario)  # checks it
    sample = _sample(_table(data, "sample"), design, scenario)
    tuning = _replaced(Settings(), _table(data, "tune"), "tune.")
    if table := _table(data, "problem"):
        check_table(table, design, scenario)
        for name in ("grid", "sample"):
            if scenarios and name in table:
                raise InputError(f"[[scenarios]] and [problem.{name}] both say which scenarios to tune for; keep one")
    typed = fields | {f"{SCENARIO}{name}": value for name, value in _table(data, "scenario").items()}
    texts = {path: value for path, value in typed.items() if isinstance(value, str)}
    return Config(design, scenario, scenarios, options, tuning, table, sweep, sample, folder, texts=texts)


def _sample(table: Mapping[str, Any], design: Part, scenario: Part) -> dict[str, Any]:
    """Return what [sample] gives of count, method, seed and ranges by dotted path, checked."""
    for name in table:
        if name not in SAMPLE:
            raise InputError(f"sample.{name} is unknown{suggest(name, SAMPLE)}; ranges go under [sample.ranges]")
    sample = dict(table)
    check_choice("sample.method", table.get("method", METHODS[0]), METHODS)
    if "ranges" in table:
        if not isinstance(table["ranges"], Mapping):
            raise InputError(f"sample.ranges = {shown(table['ranges'])} is not a table; write [sample.ranges]")
        sample["ranges"] = by_path(table["ranges"], where="sample.ranges", fields=single_fields(design, scenario))
        axes = ranges(sample["ranges"], design, scenario)
        # Made only to be checked: a sample is drawn when it is run.
        points(axes, table.get("count", 1), table.get("method", METHODS[0]), table.get("seed", 0))
    return sample


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
        path = re.sub(r"^(problem\.variables|sweep|sample\.ranges)\.", "", path)
        yield re.sub(r"^problem\.(grid|sample\.scenario)\.", "scenario.", path), symbol


def sections(mechanism: Mechanism) -> tuple[str, ...]:
    """Return the names of the parts of a mechanism's designs."""
    return tuple(f.name for f in dataclasses.fields(mechanism.design) if isinstance(f.default, Part))


def _replaced(module: T, values: Mapping[str, Any], prefix: str = "", folder: Path = Path()) -> T:
    """Do as `replace` with values from TOML or the command line. ``prefix``: of paths in messages; ``folder``: where
    mesh files lie."""
    known = [prefix + path for path in (*paths(module), *point_paths(module))]
    checked = {}
    for path, value in values.items():
        if prefix + path not in known:
            means = lambda it: meaning(module, it.removeprefix(prefix))  # noqa: E731
            raise InputError(f"{prefix}{path}{unknown(module, prefix + path, known, means)}")
        symbol = unit(module, path)
        checked[path] = _number(prefix + path, value, symbol, **metadata(module, path)["limits"]) if symbol else value
        if isinstance(value, str) and "mesh" in metadata(module, path) and not value.startswith("{"):
            checked[path] = str(folder / user_path(value))
    return replace(module, checked)


def _number(path: str, value: Any, unit: str, **limits: Any) -> float:
    """Read a float from an integer, a float or a text with a unit, in range; everything else TOML knows is an error."""
    number = as_number(in_unit(path, value, unit, **limits))
    if type(number) is not float:
        number = str(value).lower() if isinstance(value, bool) else str(value)  # as TOML spells it
    check_number(path, number, unit, **limits)
    return number


def _typed(owner: eqx.Module, path: str, text: str) -> Any:
    """Read what was typed for a field: "2" is a whole number where it takes such, "[[1, 2], [3, 4]]" the points of a
    curve."""
    value = text == "true" if text in ("true", "false") else literal(text)
    known = metadata(owner, path)
    if "curve" in known:
        with contextlib.suppress(ValueError):  # the check of the field says what it takes
            return tomllib.loads(f"points = {text}")["points"]
    return int(value) if "least" in known and isinstance(value, float) and value.is_integer() else value


def _table(data: Mapping[str, Any], name: str) -> dict[str, Any]:
    table = data.get(name, {})
    if not isinstance(table, dict):
        raise InputError(f"{name} = {shown(table)} is not a table; write [{name}] and its fields below it")
    return table
