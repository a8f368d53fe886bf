"""What a study says, in words: what differs from the defaults, and what each command would do with it."""

import dataclasses
from collections.abc import Mapping

from ..fields import Part, ends_as_typed, field_text, get, metadata, paths, unit
from ..mechanisms.cautions import cautions
from ..mechanisms.limit import both_sides
from ..sweeps.grid import Grid, grid
from ..tuning.problem import Problem, Variable
from ..value_text import interval_text, with_unit
from .config import Config
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
    usable, missing = _variables_with_start(study)
    problem = study.problem() if (study.table or study.tolerances) and not missing else None
    if study.table and missing and usable:  # everything else of the problem
        problem = dataclasses.replace(study, table=dataclasses.replace(study.table, variables=usable)).problem()
    own = {} if problem is None else problem.quantities
    swept = grid(study.sweep or mechanism.defaults.grid, study.design, study.scenario)
    parts = {
        "mechanism": [f'{mechanism.view.title}, kind = "{mechanism.name}"'],
        "differs from default": _differences(study) or ["nothing"],
        "worth a look": [
            *cautions(study.design, study.scenarios, study.varied),
            *mechanism.view.sanity_checks(study.design),
        ],
        "scenario": [mechanism.view.label(study.scenario)],
        "scenarios": _scenarios(study) if len(study.scenarios) > 1 else [],
        "options": [", ".join(_shown(study.options, path) for path in paths(study.options))],
        "variables": missing or ([] if problem is None else _variables(problem)),
        "objective": [] if problem is None else [problem.format(problem.objective)],
        "own quantities": [f"{name} [{it.unit}] = {it.signature}" for name, it in own.items()],
        "limits": [] if problem is None else _limits(problem),
        "tolerances": [] if problem is None else _tolerances(problem),
        "then": [] if problem is None or problem.then is None else [problem.format(problem.then.objective)],
        "sweep": [f"{axis.path} {axis.spanned()}" for axis in swept.axes] if study.sweep else [],
        "commands": _commands(study, name, problem, swept, bool(missing)),
    }
    lines = [f"Study {name}: valid"]
    for heading, part in parts.items():
        lines += [f"  {heading if k == 0 else '':22} {line}" for k, line in enumerate(part)]
    return "\n".join(lines)


def _differences(study: Config) -> list[str]:
    """Return a line for each field that is not at its default: "buffer.k_A 0.8 kN/m = 800 N/m (default 500 N/m)"."""
    mechanism, differences = study.mechanism, []
    usual = {"": mechanism.design(), "scenario.": mechanism.scenario()}
    for (prefix, default), part in zip(usual.items(), (study.design, study.scenario), strict=True):
        for path in paths(part):
            if get(part, path) != get(default, path):
                text = study.texts.get(prefix + path, "")
                typed = f"{text} = " if text and unit(part, path) else ""
                differences.append(
                    f"{prefix}{path} {typed}{_value(part, path)} ({_beside_default(part, default, path)})"
                )
    # What is usual for this very design, so that a duration that nobody typed is no difference.
    default_options = StudyOptions(duration=mechanism.duration(study.design))
    for path in paths(study.options):
        if get(study.options, path) != get(default_options, path):
            differences.append(f"{_shown(study.options, path, 'options.')} (default {_value(default_options, path)})")
    return differences


def _beside_default(part: Part, default: Part, path: str) -> str:
    """Say the default, and by which factor a number is away from it, where that is large."""
    value, usual = get(part, path), get(default, path)
    if isinstance(value, float) and isinstance(usual, float) and value and usual:
        ratio = abs(value / usual)
        # So far from the default a unit may be mistyped, which a factor shows.
        if max(ratio, 1.0 / ratio) > FAR:
            times = f"{ratio:.4g} times" if ratio > 1.0 else f"1/{1.0 / ratio:.4g} of"
            return f"{times} the default {_value(default, path)}"
    return f"default {_value(default, path)}"


def _scenarios(study: Config) -> list[str]:
    label, all_of_them = study.mechanism.view.label, study.scenarios
    listed = [f"{k}: {label(scenario, all_of_them)}" for k, scenario in enumerate(all_of_them[:SHOWN], 1)]
    left = len(all_of_them) - len(listed)
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
    if study.table.variables is not None:
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
        ends = mechanism.successes if problem.end is None else (problem.end.name,)
        lines.append(f"every case must end {' or '.join(ends)}")
    return lines


def _tolerances(problem: Problem) -> list[str]:
    """Return a line for each tolerance, and how many corners they have."""
    lines = [f"{address} {problem.tolerance_text(address)}" for address in problem.tolerances]
    if not lines:
        return []
    each = f"{2 ** len(lines)} corners at each of {len(problem.drawn)} scenarios"
    return [*lines, f"{each}, of which the worst are searched for" if problem.needs_search else each]


def _commands(study: Config, name: str, problem: Problem | None, swept: Grid, missing: bool) -> list[str]:
    """Say what each command would do. ``missing``: whether a tuning needs bounds that the study has not."""
    mechanism = study.mechanism
    run = mechanism.view.run_name
    counts = f"{' × '.join(map(str, swept.shape))} = {len(swept)}" if len(swept.shape) > 1 else str(len(swept))
    of = ", ".join(mechanism.defaults_for(study.design).differentiated)
    by = ", ".join(mechanism.parameters(study.design))
    commands = [
        f"jaxbuffer simulate {name}     one {run}: {mechanism.view.label(study.scenario)}",
        f"jaxbuffer sensitivity {name}  {of}",
        f"{'':{len(name) + 23}} by {by}",
        f"jaxbuffer sweep {name}        {counts} {run}s{'' if study.sweep else ', the default grid'}",
    ]
    if missing:
        return [*commands, f"jaxbuffer tune {name}         needs [problem.variables] first"]
    if problem is None:
        return [*commands, f"jaxbuffer tune {name}         the default problem; it has no [problem]"]
    cases = f"{len(problem.cases)} scenario{'s' if len(problem.cases) > 1 else ''}"
    cases += ", corners of tolerances among them" if problem.corners else ""
    return [*commands, f"jaxbuffer tune {name}         {len(problem.variables)} variables over {cases}"]


def _shown(part: Part, path: str, prefix: str = "") -> str:
    return f"{prefix}{path} {_value(part, path)}"


def _value(part: Part, path: str) -> str:
    """Say a field's value with its unit."""
    return field_text(get(part, path), _unit(part, path))


def _unit(part: Part, path: str) -> str:
    return str(metadata(part, path).get("unit", ""))
