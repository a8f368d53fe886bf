"""An example study of a mechanism: every field with its unit, default, range and meaning, most of them as comments."""

import dataclasses
import itertools
import keyword
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import tomli_w

from ..errors import InputError
from ..fields import Part, declared, get, metadata, replace, unit_at
from ..fitting.quantities import recorded_quantities
from ..labelled.record import heading as heading_of
from ..mechanisms import all_mechanisms
from ..mechanisms.mechanism import Mechanism
from ..mechanisms.quantity import END_TIME
from ..tuning.problem.cases import Scatter
from ..tuning.problem.objective import Objective, SecondObjective
from ..tuning.problem.settings import Settings
from ..value_text import interval_text
from .config import sections, study_tables
from .fit_toml import FitTable
from .model import ProblemTable, Scattered, StudyOptions, limit_keys
from .parts_toml import ChoiceSettings
from .tables import Keys

WIDTH, LONGEST = 34, 118  # columns before a comment, and of a line
OTHERS = 4  # quantities that are named beside the main one
VARIED = 2  # numbers that an example varies of a mechanism that names none
SCHEMA = "jaxbuffer.schema.json"
TOLERANCE_WORDS = 'of the drawn number; or "0.5 mm", or ["-1 mm", "2 mm"]; scenario.FIELD for one of the scenario'
EXAMPLES = {"count": {"default": 24}}  # what the example has for a default


def own_mechanism(name: str) -> str:
    """Return a Python file that defines and runs a mechanism of one's own called ``name``.

    **Raises:** `InputError` for what is no name of a Python module, or that of a mechanism there is.
    """
    if not name.isidentifier() or keyword.iskeyword(name) or not name.islower():
        raise InputError(
            f"--own {name}: not a name of a Python module; take small letters, digits and _, such as gripper"
        )
    if name in [known.name for known in all_mechanisms()]:
        raise InputError(f"--own {name}: there is a mechanism of this name; take another one")
    # No module: whoever imported it would register an example among the mechanisms.
    text = Path(__file__).with_name("example_mechanism.txt").read_text(encoding="utf-8")
    # The template has its name as that of the mechanism, as a constant and as a class.
    for form in (str.lower, str.upper, lambda word: word.title().replace("_", "")):
        text = text.replace(form("example"), form(name))
    return text


def example_toml(mechanism: Mechanism) -> str:
    """Write a study that `load` reads to the mechanism's defaults and what its example has beside them, with a problem
    and a sweep of its own."""
    design, scenario, example = mechanism.design(), mechanism.scenario(), mechanism.defaults.example
    lines = [
        f"#:schema ./{SCHEMA}",
        f"# A study of {mechanism.view.title};"
        " 'jaxbuffer check FILE' says what it holds and what the commands would do.",
        "# A line that begins with # shows a default: take the # away to set the field.",
        '# Numbers are in the unit of their comment; text with another unit is fine: "0.5 kN/m", "3 deg", "20 cm/s".',
        "# Editors complete and check this file with the schema of the first line, which is written by",
        f"#   jaxbuffer schema --kind {mechanism.name} > {SCHEMA}",
        "",
        f'kind = "{mechanism.name}"',
    ]
    for section in sections(mechanism):
        own = {path.partition(".")[2]: it for path, it in example.items() if path.startswith(f"{section}.")}
        lines += ["", f"[{section}]", *_fields(declared(getattr(design, section)), own=own)]
    heading = {name: f"[{name}]  # {known['doc']}" for name, known in study_tables().items()}
    options = StudyOptions(duration=mechanism.duration(replace(design, example)))
    lines += ["", heading["scenario"], *_fields(declared(scenario), commented=False)]
    lines += ["", heading["options"], *_fields(declared(options)), "", heading["tune"], *_fields(declared(Settings))]
    swept = ((entry_of(path, it), unit_at(design, scenario, path)) for path, it in mechanism.defaults.grid.items())
    lines += ["", *_problem(mechanism, design), "", heading["sweep"], *itertools.starmap(line_of, swept)]
    # Without a number in the design there is nothing to tolerate, to choose and to fit.
    for path in mechanism.parameters(design)[:1]:
        tolerance = line_of(f'# {path} = "10 %"', TOLERANCE_WORDS)
        lines += ["", f"# {heading['tolerances']}", tolerance, *_choice(mechanism, design, path, heading)]
        lines += _fit(mechanism, design, path)
    return "\n".join(lines) + "\n"


def _choice(mechanism: Mechanism, design: Part, path: str, heading: Mapping[str, str]) -> Iterator[str]:
    """Yield the tables of jaxbuffer choose, for parts that set the number at a ``path``."""
    section, value = path.partition(".")[0], float(get(design, path))
    yield f"# {heading['parts'].replace('parts', f'parts.{section}', 1)}"
    for name, share in (("P1", 1.0), ("P2", 1.2)):
        words = 'what a part sets together; or file = "parts.csv"' if share == 1.0 else ""
        yield line_of(f"# {name} = {{{path} = {share * value:g}, price = {10.0 * share:g}}}", words)
    yield f"# {heading['choose']}"
    yield from _fields(declared(ChoiceSettings))
    yield f"# {heading['roundings']}"
    yield line_of(f'# {path} = "E24"', f"E3 to E96; or a step in {unit_at(design, mechanism.scenario(), path)}")


def _fit(mechanism: Mechanism, design: Part, path: str) -> Iterator[str]:
    """Yield the tables of jaxbuffer fit for the number at a ``path``, of a mechanism whose tests can be fitted."""
    if mechanism.stepper is not None:
        return
    recorded, doc = recorded_quantities(design), {name: known["doc"] for name, known in declared(FitTable).items()}
    quantity = next((name for name in mechanism.tuned if name in recorded), next(iter(recorded)))
    value = float(get(design, path))
    yield f"# [fit.parameters]  # {doc['parameters']}"
    yield line_of(f"# {path} = [{0.5 * value:g}, {2.0 * value:g}]", metadata(design, path)["unit"])
    yield f"# [[fit.tests]]  # {doc['tests']}"
    yield line_of('# file = "test.csv"', 'with a column "time [s]"; beside it time_shift, and scenario.FIELD')
    yield "# [fit.tests.columns]"
    yield line_of(
        f'# "{heading_of(quantity, recorded[quantity])}" = {{quantity = "{quantity}"}}', "and noise, gain, filter"
    )


def _fields(keys: Keys, commented: bool = True, own: Mapping[str, Any] = MappingProxyType({})) -> Iterator[str]:
    """Yield a line for each key; ``commented``: whether one that has a value is a comment too; ``own``: values that the
    example has beside the defaults."""
    for name, known in keys.items():
        words = [_allowed(known), known.get("doc") or name.replace("_", " ")]
        if name in own:
            yield line_of(entry_of(name, own[name]), ": ".join(words))
        elif known["default"] is None:
            yield line_of(f"# {name} = ", f"not set; {': '.join(words)}")
        else:
            yield line_of(("# " if commented else "") + entry_of(name, known["default"]), ": ".join(words))


def _allowed(known: Mapping[str, Any]) -> str:
    """Say unit and range of a field, or its choices."""
    if "choices" in known:
        return f"one of {', '.join(known['choices'])}"
    if "curve" in known:
        return "points that rise in both numbers, [[0.01, 2.0], [0.02, 6.0]] say"
    if "mesh" in known:
        return f"a mesh file with the boundaries {' and '.join(known['mesh'])}"
    if "limits" in known:
        symbol = "" if known["unit"] == "-" else f"{known['unit']}, "
        return symbol + interval_text(**known["limits"])
    return f"whole numbers from {known['least']}" if "least" in known else "true or false"


def _problem(mechanism: Mechanism, design: Part) -> Iterator[str]:
    """Yield the sections of jaxbuffer tune."""
    catalogue, defaults = mechanism.quantities, mechanism.defaults
    heading = {name: f"[problem.{name}]  # {known['doc']}" for name, known in declared(ProblemTable).items()}
    # `tune` refuses a start outside its bounds, so only bounds that hold it are offered.
    starts_inside = {
        path: bounds
        for path, bounds in (mechanism.variables(design) or _variables(mechanism, design)).items()
        if bounds[0] <= get(design, path) <= bounds[1]
    }
    if starts_inside:
        yield heading["variables"]
        for path, bounds in starts_inside.items():
            yield line_of(entry_of(path, bounds), metadata(design, path)["unit"])
        for path, bounds in defaults.example_variables.items():
            yield line_of(f"# {entry_of(path, bounds)}", metadata(design, path)["unit"])
        yield ""
    yield heading["objective"]
    known = [name for name in mechanism.tuned if mechanism.has(name, design)]
    main = mechanism.main_quantity(known, design)
    if main:
        others = [name for name in mechanism.tuned if name != main][:OTHERS]
        yield line_of(
            f"{main} = 1.0", f"N/{catalogue[main].unit}" + (f"; or any of {', '.join(others)}" if others else "")
        )
    yield from _fields(declared(Objective))
    yield ""
    yield heading["constraints"]
    for name, limit in {**defaults.limits, **defaults.example_limits}.items():
        yield line_of(entry_of(name, limit), f"{catalogue[name].unit}, {catalogue[name].description}")
    if limited := mechanism.name_of(END_TIME) or main:
        yield line_of(f"# {limited} = {{min = 0.1, max = 1.0}}", f"{catalogue[limited].unit}, both sides")
    other_ends = {end.name for end in mechanism.tuning.ends} - {
        getattr(mechanism.strictest_end(lambda path: get(design, path)), "name", "")
    }
    yield from _fields({name: known for name, known in limit_keys(mechanism).items() if name not in other_ends})
    yield ""
    numbers = [f.name for f in dataclasses.fields(mechanism.scenario) if "unit" in f.metadata]
    for field in numbers[:1]:
        yield f"# {heading['grid']}"
        yield f"# {field} = {[float(getattr(mechanism.scenario(), field))]}"
        yield f"# {heading['sample']}"
        yield from _sampled(mechanism, design, field)
    yield f"# {heading['then']}"
    yield from (f"# {name} = 1.0" for name in known[-1:])
    yield from _fields(declared(SecondObjective))


def _variables(mechanism: Mechanism, design: Part) -> dict[str, list[float]]:
    """Return bounds about the first positive numbers of a mechanism that has no variables of its own."""
    values = {path: float(get(design, path)) for path in mechanism.parameters(design)[:VARIED]}
    return {path: [0.5 * value, 2.0 * value] for path, value in values.items() if value > 0.0}


def _sampled(mechanism: Mechanism, design: Part, field: str) -> Iterator[str]:
    """Yield the lines of tolerances; ``field``: of the scenario."""
    value = float(getattr(mechanism.scenario(), field))
    low, high = 0.9 * value, 1.1 * value
    yield from _fields({name: known | EXAMPLES.get(name, {}) for name, known in declared(Scatter).items()})
    yield "# [problem.sample.scenario]"
    yield line_of(
        f"# {field} = {{uniform = [{low:g}, {high:g}]}}", "or {normal = [mean, deviation]}, in the field's unit"
    )
    yield f"# [problem.sample.factors]  # {declared(Scattered)['factors']['doc']}"
    for path in mechanism.parameters(design)[:1]:
        yield line_of(f"# {path} = {{uniform = [0.9, 1.1]}}", "a tolerance of 10 %")


def entry_of(name: str, value: Any) -> str:
    """Return a line of TOML that sets a name."""
    if isinstance(value, Mapping):
        return f"{name} = {{{', '.join(entry_of(key, entry) for key, entry in value.items())}}}"
    if isinstance(value, (list, tuple)):
        return f"{name} = [{', '.join(entry_of('', entry).removeprefix(' = ') for entry in value)}]"
    return f"{name} = " + tomli_w.dumps({"x": value}).strip().removeprefix("x = ")


def line_of(entry: str, comment: str) -> str:
    """Return an entry with its comment behind it or, where that is too long, in lines of their own above it."""
    line = f"{entry:{WIDTH}}  # {comment}" if comment else entry
    if len(line) <= LONGEST:
        return line
    # Behind two signs an explanation stays a comment where the # of all lines below a heading is taken away.
    above = textwrap.wrap(comment, LONGEST - 5, break_on_hyphens=False)
    return "\n".join([*(f"## {'  ' if k else ''}{part}" for k, part in enumerate(above)), entry])
