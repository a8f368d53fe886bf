"""What a study says, in words: what differs from the defaults, and what each command would do with it."""

import dataclasses
import math
from collections.abc import Iterator, Mapping

from ..choosing.catalogue import PartsCatalogue
from ..choosing.choose import selection
from ..choosing.criterion import Criterion
from ..experiments.ranges import ranges
from ..fields import SCENARIO, Curve, Part, as_displayed, ends_as_typed, field_text, get, metadata, paths, unit
from ..fitting.fit import checked
from ..mechanisms.cautions import cautions
from ..mechanisms.limit import both_sides
from ..sweeps.grid import Grid, grid
from ..tuning.problem.cases import Case
from ..tuning.problem.problem import Problem
from ..tuning.problem.settings import Settings
from ..tuning.problem.variable import Variable
from ..value_text import interval_text, with_unit
from .config import Config
from .design_toml import points_text
from .model import StudyOptions
from .problem_toml import default_variables

SHOWN = 12  # scenarios that are listed one by one
FAR = 100.0  # a factor to the default from which on it is told: a unit may be mistyped


def explained(study: Config, name: str) -> str:
    """Explain a study in some twenty lines.

    **Arguments:** ``name``: of its file, as the commands take it.

    **Raises:** `InputError` where its problem can't be tuned.
    """
    mechanism = study.mechanism
    # A study that is not to be tuned may start outside the default bounds: that is said, and no error.
    usable, missing = _variables_with_start(study)
    problem = _problem(study) if (study.table or study.tolerances) and not missing else None
    if study.table and missing and usable:  # everything else of the problem
        problem = dataclasses.replace(study, table=dataclasses.replace(study.table, variables=usable)).problem()
    own = {} if problem is None else problem.quantities
    over = study.sweep or mechanism.defaults.grid
    swept = grid(over, study.design, study.scenario) if over else None
    parts = {
        "mechanism": [f'{mechanism.view.title}, kind = "{mechanism.name}"'],
        "differs from default": _differences(study) or ["nothing"],
        "given as by default": [
            f"{address} {_as_read(study, address, path, part)}"
            for address, path, part, default in _compared(study)
            if address in study.given and get(part, path) == get(default, path)
        ],
        "worth a look": [*_cautions(study, problem), *mechanism.view.sanity_checks(study.design)],
        "scenario": [mechanism.view.label(study.scenario)],
        "scenarios": _scenarios(study) if len(study.cases) > 1 else [],
        "options": [", ".join(_shown(study.options, path) for path in paths(study.options))],
        "variables": missing or ([] if problem is None else _variables(problem)),
        "objective": [] if problem is None else [_objective(study, problem)],
        "own quantities": [f"{name} [{it.unit}] = {it.signature}" for name, it in own.items()],
        "limits": [] if problem is None else _limits(problem),
        "tolerances": [] if problem is None else _tolerances(problem),
        "then": [] if problem is None else _then(study, problem),
        "parts": _parts(study),
        "roundings": [
            f"{path} to {rule}"
            if isinstance(rule, str)
            else f"{path} to steps of {with_unit(rule, _unit(study.design, path))}"
            for path, rule in study.roundings.items()
        ],
        "fit": _fit(study),
        "sweep": [f"{axis.path} {axis.spanned()}" for axis in swept.axes] if swept and study.sweep else [],
        "sample": _sample(study),
        "commands": _commands(study, name, problem, swept, bool(missing)),
    }
    lines = [f"Study {name}: valid"]
    for heading, part in parts.items():
        lines += [f"  {heading if k == 0 else '':22} {line}" for k, line in enumerate(part)]
    return "\n".join(lines)


def _compared(study: Config) -> Iterator[tuple[str, str, Part, Part]]:
    """Yield the address of each field, its path, the part that it belongs to, and that part with its defaults."""
    mechanism = study.mechanism
    # What is usual for this very design, so that a duration that nobody typed is no difference.
    usual_options = StudyOptions(duration=mechanism.duration(study.design))
    for prefix, part, default in (
        ("", study.design, mechanism.design()),
        (SCENARIO, study.scenario, mechanism.scenario()),
        ("options.", study.options, usual_options),
        ("tune.", study.tuning, Settings()),
    ):
        for path in paths(part):
            yield prefix + path, path, part, default


def _problem(study: Config) -> Problem:
    """Return the problem that parts are chosen by, or that is tuned."""
    return study.selection().problem if study.parts else study.problem()


def _parts(study: Config) -> list[str]:
    """Return a line for each catalogue, and one for limits on price and mass."""
    lines = [
        f"{it.role}: {len(it.parts)}, each with {', '.join((*it.paths, *it.totals))}: {_listed(it)}"
        for it in study.parts
    ]
    if not study.parts:
        return lines
    criterion = _criterion(study)
    return lines + [f"{it.line(criterion.catalogue[it.name])} of all parts" for it in criterion.limits]


def _criterion(study: Config) -> Criterion:
    """Return what a study's parts are chosen by."""
    chosen_by = study.selection()
    return selection(chosen_by.problem, study.parts, chosen_by.objective, chosen_by.at_most, chosen_by.then)[0]


def _objective(study: Config, problem: Problem) -> str:
    """Return the objective in words; price and mass of parts are in that of a choice alone."""
    return str(_criterion(study)) if study.parts else problem.format(problem.objective)


def _then(study: Config, problem: Problem) -> list[str]:
    """Return the second objective in words, if there is one."""
    if study.parts:
        criterion = _criterion(study)
        then, words = criterion.then, criterion.in_words
    else:
        then, words = problem.then, problem.format
    if then is None:
        return []
    return [f"{words(then.objective)}, among those within {100.0 * then.tolerance:g} % of the least objective"]


def _listed(catalogue: PartsCatalogue) -> str:
    """Return the names of a catalogue's parts, the first ones."""
    names = [part.name for part in catalogue.parts[:SHOWN]]
    left = len(catalogue.parts) - len(names)
    return ", ".join(names) + (f" and {left} more" if left else "")


def _fit(study: Config) -> list[str]:
    """Return a line for each number that is fitted, each test and each of its columns."""
    table, design = study.fit, study.design
    if not table.parameters and not table.tests:
        return []
    recordings = table.recordings(design, study.scenario, study.folder)
    parameters, options = dict(table.parameters or {}), study.options
    variables, tests = checked(design, study.scenario, recordings, parameters, options.duration, options.rtol)
    lines = []
    for v in variables:
        # Bounds in the unit that the start was typed with, where it has one.
        ends = ends_as_typed(v.low, v.high, _unit(design, v.path), study.units.get(v.path, ""))
        lines.append(f"{v.path} in {interval_text(*ends)}, {v.scale}, from {_value(design, v.path)}")
    for test in tests:
        rows, (first, *_, last) = len(test.times), test.times
        lines.append(f"{test.recording.name}: {rows} rows from {first:.4g} to {last:.4g} s")
        for column, sensor in test.sensors.items():
            shown = as_displayed(sensor.noise or 0.0, test.units[sensor.quantity])
            noise = "noise estimated" if sensor.noise is None else f"noise {with_unit(*shown, 4)}"
            lines.append(f"  {column} is {sensor.quantity}, {noise}")
        for name, it in test.unknowns.items():
            lines.append(
                f"  {name} in {interval_text(it.low, it.high, '-' if name.endswith('gain') else 's')}, unknown"
            )
    return lines


def _differences(study: Config) -> list[str]:
    """Return a line for each field that is not at its default: "buffer.k_A 0.8 kN/m = 800 N/m (default 500 N/m)"."""
    lines = []
    for address, path, part, default in _compared(study):
        value, usual = get(part, path), get(default, path)
        if value != usual:
            beside = f"default {_value(default, path)}"
            if isinstance(value, float) and isinstance(usual, float) and value and usual:
                ratio = abs(value / usual)
                # So far from the default a unit may be mistyped, which a factor shows.
                if max(ratio, 1.0 / ratio) > FAR:
                    beside = f"{f'{ratio:.4g} times' if ratio > 1.0 else f'1/{1.0 / ratio:.4g} of'} the {beside}"
            lines.append(f"{address} {_as_read(study, address, path, part)} ({beside})")
    return lines


def _as_read(study: Config, address: str, path: str, part: Part) -> str:
    """Say a field's value, behind what was typed if that has a unit."""
    value = get(part, path)
    if isinstance(value, Curve):
        return points_text(value, address, study.units)
    text = study.texts.get(address, "")
    shown = _value(part, path)
    return f"{text} = {shown}" if text and unit(part, path) and text != shown else shown


def _sample(study: Config) -> list[str]:
    """Say what [sample] spreads, if it spreads anything."""
    if study.sample.ranges is None:
        return []
    spread = ranges(study.sample.ranges, study.design, study.scenario)
    return [*(f"{it.path} {it}" for it in spread), f"{study.sample.count} points, seed {study.sample.seed}"]


def _cautions(study: Config, problem: Problem | None) -> list[str]:
    """Return what is to be said before anything is computed, of [scenario] and of all that a tuning runs."""
    tuned = cautions(study.runs, study.varied, units=study.units, corners=problem.corner_runs if problem else ())
    if Case(study.scenario) in study.cases:
        return tuned
    return list(dict.fromkeys([*cautions([(study.design, study.scenario)], study.varied, units=study.units), *tuned]))


def _scenarios(study: Config) -> list[str]:
    cases = study.cases
    listed = [f"{k}: {case.label(cases)}" for k, case in enumerate(cases[:SHOWN], 1)]
    left = len(cases) - len(listed)
    return [*listed, f"and {left} more"] if left else listed


def _variables(problem: Problem) -> list[str]:
    lines = []
    for v in problem.variables:
        ends = ends_as_typed(v.low, v.high, _unit(problem.design, v.path), problem.units.get(v.path, ""))
        start = with_unit(*problem.shown(v.path, get(problem.design, v.path)))
        lines.append(f"{v.path} in {interval_text(*ends)}, {v.scale}, from {start}")
    return lines


def _variables_with_start(study: Config) -> tuple[Mapping[str, Variable], list[str]]:
    """Return, for a study without bounds of its own, the default ones that hold the start, and a line for each
    other."""
    # Bounds of the study's own that do not hold its start are an error, which `read_problem` raises.
    if study.table.variables is not None or study.parts:
        return {}, []
    design, usual = study.design, default_variables(study.mechanism, study.design)
    usable = {path: it for path, it in usual.items() if it.low <= get(design, path) <= it.high}
    return usable, [
        f"{path} = {_value(design, path)} is outside the default bounds {interval_text(it.low, it.high, '')}: tune"
        " needs [problem.variables]"
        for path, it in usual.items()
        if path not in usable
    ]


def _limits(problem: Problem) -> list[str]:
    limits, mechanism = problem.limits, problem.mechanism
    lines = limits.lines(problem.catalogue)
    always = both_sides(mechanism.always(problem.design), {})
    lines += [f"{it.line(problem.catalogue[it.name])}, always" for it in always if it.name not in limits.at_most]
    if limits.impacts is not None:
        lines.append(f"at most {limits.impacts} impacts")
    if limits.require_success and mechanism.successes:
        ends = mechanism.possible_successes(problem.design) if problem.end is None else (problem.end.name,)
        lines.append(f"every load case must end {' or '.join(ends)}")
    return lines


def _tolerances(problem: Problem) -> list[str]:
    """Return a line for each tolerance, and how many corners they have."""
    lines = [f"{address} {problem.tolerance_text(address)}" for address in problem.tolerances]
    if not lines:
        return []
    each = f"{2 ** len(lines)} corners at each of {len(problem.drawn)} scenarios"
    return [*lines, f"{each}, of which the worst are searched for" if problem.needs_search else each]


def _commands(study: Config, name: str, problem: Problem | None, swept: Grid | None, missing: bool) -> list[str]:
    """Say what each command would do. ``missing``: whether a tuning needs bounds that the study has not."""
    mechanism = study.mechanism
    run = mechanism.view.run_name
    sweeps = "needs [sweep] or --over first"
    if swept is not None:
        counts = f"{' × '.join(map(str, swept.shape))} = {len(swept)}" if len(swept.shape) > 1 else str(len(swept))
        sweeps = f"{counts} {run}s{'' if study.sweep else ', the default grid'}"
    of = ", ".join(mechanism.defaults_for(study.design).differentiated)
    by = ", ".join(mechanism.parameters(study.design))
    commands = [
        f"jaxbuffer simulate {name}     one {run}: {mechanism.view.label(study.scenario)}",
        f"jaxbuffer sensitivity {name}  {of}",
        f"{'':{len(name) + 23}} by {by}",
        f"jaxbuffer sweep {name}        {sweeps}",
    ]
    if study.parts or study.roundings:
        commands.append(f"jaxbuffer choose {name}       {_choice(study)}")
    if study.fit.tests:
        count, tests = len(study.fit.parameters or {}), len(study.fit.tests)
        commands.append(f"jaxbuffer fit {name}          {count} numbers from {tests} test{'s' if tests > 1 else ''}")
    if missing or (study.parts and study.table.variables is None):
        return [*commands, f"jaxbuffer tune {name}         needs [problem.variables] first"]
    if not (mechanism.variables(study.design) if problem is None else problem.variables):
        return [*commands, f"jaxbuffer tune {name}         needs [problem.variables] first"]
    if problem is None:
        return [*commands, f"jaxbuffer tune {name}         the default problem; it has no [problem]"]
    return [*commands, f"jaxbuffer tune {name}         {len(problem.variables)} variables over {problem.over}"]


def _choice(study: Config) -> str:
    """Say what `jaxbuffer choose` would do."""
    if study.parts and study.roundings:
        return "needs either [parts] or [roundings]; keep one"
    if study.roundings:
        return f"a tuning, then values near it for {', '.join(study.roundings)}"
    problem, sizes = _problem(study), [len(it.parts) for it in study.parts]
    counts = f"{' × '.join(map(str, sizes))} = {math.prod(sizes)}" if len(sizes) > 1 else str(sizes[0])
    return f"{counts} combinations over {problem.over}"


def _shown(part: Part, path: str, prefix: str = "") -> str:
    return f"{prefix}{path} {_value(part, path)}"


def _value(part: Part, path: str) -> str:
    """Say a field's value with its unit."""
    return field_text(get(part, path), _unit(part, path))


def _unit(part: Part, path: str) -> str:
    return str(metadata(part, path).get("unit", ""))
