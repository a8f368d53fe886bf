"""Studies as TOML: read into a `Config`, override fields by dotted path, write a design back."""

import dataclasses
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import equinox as eqx
import tomli_w

from .capture import DEFAULT_DURATION, DEFAULT_TOLERANCE
from .errors import InputError, check_number, suggest
from .grid import by_path, grid
from .integrate import Automatic, ExplicitRungeKutta, LinearlyImplicit, Solver
from .mechanisms import Design, Scenario, check_fit, get, paths, replace, unit
from .mechanisms.design import POSITIVE, Part, choice, number
from .mechanisms.paths import check_path

if TYPE_CHECKING:
    from .tune import Problem

T = TypeVar("T", bound=eqx.Module)

SECTIONS = tuple(field.name for field in dataclasses.fields(Design))
SOLVERS: Mapping[str, type[Solver]] = {
    "automatic": Automatic,
    "implicit": LinearlyImplicit,
    "explicit": ExplicitRungeKutta,
}
VARIABLES = {
    "buffer.k_A": (100.0, 2000.0),  # N/m
    "buffer.c_A": (1.0, 60.0),  # N s/m
    "buffer.k_T": (50.0, 1500.0),  # N m/rad
    "buffer.c_T": (0.2, 20.0),  # N m s/rad
    "probe.tip_mass": (0.02, 0.2),  # kg
}


class Options(Part):
    """How to simulate: ``duration`` [s], ``rtol`` [-], ``solver``, a name in `SOLVERS`."""

    section = "options"
    duration: float = number(DEFAULT_DURATION, "s", **POSITIVE)
    rtol: float = number(DEFAULT_TOLERANCE, "-", low=1e-13, high=1e-2)
    solver: str = choice("automatic", *SOLVERS)

    def stepper(self) -> Solver:
        """The solver that ``solver`` names."""
        return SOLVERS[self.solver]()


class Tuning(Part):
    """What to tune: ``iterations``, ``stroke_limit`` [m], ``variables``: path to (low, high) in the path's unit."""

    section = "tune"
    iterations: int = eqx.field(default=40, static=True)
    stroke_limit: float = number(0.025, "m", **POSITIVE)
    variables: Mapping[str, tuple[float, float]] = eqx.field(default_factory=lambda: dict(VARIABLES), static=True)

    def __check_init__(self) -> None:
        if isinstance(self.iterations, bool) or not isinstance(self.iterations, int) or self.iterations < 1:
            raise InputError(f"tune.iterations = {self.iterations!r} must be a whole number of at least 1")
        if not self.variables:
            raise InputError("tune.variables is empty; name a field and its bounds, such as buffer.k_A = [100, 2000]")


@dataclasses.dataclass(frozen=True)
class Config:
    """A study: one design, the scenario to simulate, the scenarios to tune for (default: that one), and settings."""

    design: Design = dataclasses.field(default_factory=Design)
    scenario: Scenario = dataclasses.field(default_factory=Scenario)
    scenarios: tuple[Scenario, ...] = ()
    options: Options = dataclasses.field(default_factory=Options)
    tuning: Tuning = dataclasses.field(default_factory=Tuning)
    sweep: Mapping[str, Any] = dataclasses.field(default_factory=dict)  # path to values, as `grid` reads them

    def __post_init__(self) -> None:
        check_fit(self.design, self.scenario)
        for i, scenario in enumerate(self.scenarios, 1):
            try:
                check_fit(self.design, scenario)
            except InputError as error:
                raise InputError(f"[[scenarios]] number {i}: {error}") from None
        if not self.scenarios:
            object.__setattr__(self, "scenarios", (self.scenario,))

    def problem(self) -> "Problem":
        """The tuning problem; its start must lie within the bounds."""
        from .tune import Problem, Variable

        if self.options.solver != Options.solver:
            raise InputError(f"options.solver = {self.options.solver!r}: tuning has the {Options.solver} solver only")
        for path, (low, high) in self.tuning.variables.items():
            try:
                check_number(path, get(self.design, path), unit(self.design, path), low=low, high=high)
            except InputError as error:
                raise InputError(f"{error} (the bounds in [tune.variables])") from None
        return Problem(
            design=self.design,
            scenarios=self.scenarios,
            variables=tuple(Variable(path, low, high) for path, (low, high) in self.tuning.variables.items()),
            stroke_limit=self.tuning.stroke_limit,
            duration=self.options.duration,
            rtol=self.options.rtol,
        )


def load(path: str | Path | None) -> Config:
    """Read a study; without a file, Table 2's. Raises `InputError` with one line that starts with the file's name."""
    if path is None:
        return Config()
    try:
        content = Path(path).read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    return loads(content, path)


def loads(content: bytes, name: str | Path) -> Config:
    """Read a study from a file's content; ``name`` starts an error's line."""
    try:
        data = tomllib.loads(content.decode("utf-8"))
    except ValueError as error:  # TOML syntax, with line and column, or bytes that are not UTF-8
        raise InputError(f"{name} is not valid TOML: {error}") from None
    try:
        return _config(data)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def apply_overrides(config: Config, values: Mapping[str, str]) -> Config:
    """A copy with fields replaced, as typed on a command line: ``{"buffer.k_A": "800"}``.

    A scenario's field holds for every scenario of the study; scenarios that thereby become equal count once.
    """
    known = [*paths(config.design), *(f"scenario.{name}" for name in paths(config.scenario))]
    for path in values:
        if path not in known:
            raise InputError(f"{path} is unknown{suggest(path, known)}")
    fields = {path: _literal(text) for path, text in values.items()}
    meeting = {path.removeprefix("scenario."): v for path, v in fields.items() if path.startswith("scenario.")}
    design = {path: value for path, value in fields.items() if not path.startswith("scenario.")}
    scenarios = (_replaced(scenario, meeting, "scenario.") for scenario in config.scenarios)
    return dataclasses.replace(
        config,
        design=_replaced(config.design, design),
        scenario=_replaced(config.scenario, meeting, "scenario."),
        scenarios=tuple(dict.fromkeys(scenarios)),
    )


def design_toml(design: Design, scenarios: Iterable[Scenario] = (), comment: str = "") -> str:
    """A study that `load` reads back to exactly the same numbers, units as comments."""
    blocks = [f"# {line}".rstrip() for line in comment.splitlines()]
    for section in SECTIONS:
        blocks += ["", f"[{section}]", *_lines(getattr(design, section))]
    for scenario in scenarios:
        blocks += ["", "[[scenarios]]", *_lines(scenario)]
    return "\n".join(blocks).lstrip("\n") + "\n"


def write_design(design: Design, path: str | Path, comment: str = "", scenarios: Iterable[Scenario] = ()) -> None:
    """Write `design_toml` to a file, over any that is there."""
    Path(path).write_text(design_toml(design, scenarios, comment), encoding="utf-8")


def _lines(part: eqx.Module) -> list[str]:
    lines = []
    for name in (field.name for field in dataclasses.fields(part)):
        value, symbol = getattr(part, name), unit(part, name)
        if value is None:  # a stiffness to be computed: TOML has no word for it, leaving it out says it
            continue
        entry = tomli_w.dumps({name: float(value) if symbol else value}).rstrip()
        lines.append(f"{entry}  # {symbol}" if symbol not in ("", "-") else entry)
    return lines


def _config(data: dict[str, Any]) -> Config:
    known = (*SECTIONS, "scenario", "scenarios", "options", "tune", "sweep")
    for name in data:
        if name not in known:
            raise InputError(f"[{name}] is unknown{suggest(name, known)}")
    fields = {f"{section}.{key}": value for section in SECTIONS for key, value in _table(data, section).items()}
    design = _replaced(Design(), fields)
    scenario = _replaced(Scenario(), _table(data, "scenario"), "scenario.")
    listed = data.get("scenarios", [])
    if not isinstance(listed, list) or not all(isinstance(entry, dict) for entry in listed):
        raise InputError("scenarios is not a list of tables; write each under its own [[scenarios]]")
    scenarios = tuple(_replaced(scenario, entry, f"scenarios[{i}].") for i, entry in enumerate(listed, 1))
    if scenarios and "scenario" not in data:
        scenario = scenarios[0]
    options = _replaced(Options(), _table(data, "options"), "options.")
    sweep = by_path(_table(data, "sweep"))
    if sweep:
        grid(sweep, design, scenario)  # checks it
    return Config(design, scenario, scenarios, options, _tuning(_table(data, "tune"), design), sweep)


def _tuning(table: dict[str, Any], design: Design) -> Tuning:
    if "variables" in table:
        bounds = _flat(_table(table, "variables", "tune.variables"))
        table = {**table, "variables": {path: _bounds(design, path, value) for path, value in bounds.items()}}
    return _replaced(Tuning(), table, "tune.")


def _bounds(design: Design, path: str, value: Any) -> tuple[float, float]:
    check_path(design, path)
    where, symbol = f"tune.variables.{path}", unit(design, path)
    if not symbol:
        raise InputError(f"{where}: {path} is a choice; only numbers can be tuned")
    if not isinstance(value, list) or len(value) != 2:
        raise InputError(f"{where} = {value} must be two numbers, [low, high] in {symbol}")
    low, high = (_number(where, v, symbol, **_metadata(design, path)["limits"]) for v in value)
    if not low < high:
        raise InputError(f"{where} = [{low:g}, {high:g}] {symbol}: the low bound must be below the high one")
    return low, high


def _replaced(module: T, values: Mapping[str, Any], prefix: str = "") -> T:
    """`replace` with values from TOML or the command line, ``prefix`` completing the paths shown to the user."""
    known = [prefix + path for path in paths(module)]
    checked = {}
    for path, value in values.items():
        if prefix + path not in known:
            raise InputError(f"{prefix}{path} is unknown{suggest(prefix + path, known)}")
        symbol = unit(module, path)
        checked[path] = _number(prefix + path, value, symbol, **_metadata(module, path)["limits"]) if symbol else value
    return replace(module, checked)


def _number(path: str, value: Any, unit: str, **limits: Any) -> float:
    """A float from an integer or float in range; everything else TOML knows is an error."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        value = str(value).lower() if isinstance(value, bool) else str(value)  # as TOML spells it
    else:
        value = float(value)
    check_number(path, value, unit, **limits)
    return value


def _literal(text: str) -> bool | float | str:
    """What a word on the command line would be in TOML."""
    if text in ("true", "false"):
        return text == "true"
    try:
        return float(text)
    except ValueError:
        return text


def _table(data: Mapping[str, Any], name: str, path: str = "") -> dict[str, Any]:
    table, path = data.get(name, {}), path or name
    if not isinstance(table, dict):
        raise InputError(f"{path} = {table!r} is not a table; write [{path}] and its fields below it")
    return table


def _flat(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested tables as dotted paths: TOML reads an unquoted ``buffer.k_A = …`` as a table in a table."""
    flat: dict[str, Any] = {}
    for name, value in table.items():
        flat |= _flat(value, f"{prefix}{name}.") if isinstance(value, dict) else {prefix + name: value}
    return flat


def _metadata(module: eqx.Module, path: str) -> Mapping[str, Any]:
    *owners, name = path.split(".")
    for owner in owners:
        module = getattr(module, owner)
    return {field.name: field.metadata for field in dataclasses.fields(module)}[name]
