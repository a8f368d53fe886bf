"""A study whose parts were sized, as text: for `simulate`, and for `tune` to go on from."""

import dataclasses

from ..fields import Part, get
from ..tuning.problem.variable import Variable
from .config import Config
from .design_toml import design_toml
from .problem_toml import default_variables
from .tuned_toml import tuned_toml

ROOM = (0.3, 3.0)  # times a sized number that is outside the bounds of a tuning: its new bounds reach as far


def sized_toml(study: Config, design: Part, duration: float, comment: str) -> str:
    """Return the study with a sized design. Bounds of [problem.variables] that do not hold it are widened."""
    if not study.table:
        listed = study.scenarios if len(study.scenarios) > 1 else ()
        whole = design_toml(design, listed, comment, study.units, first=study.scenario)
        return f"{whole}\n[options]\nduration = {duration!r}  # s\nrtol = {study.options.rtol!r}\n"
    given = study.table.variables
    variables = default_variables(study.mechanism, design) if given is None else given
    # As numbers, since bounds that are typed with a unit may have to be widened.
    read = {path: _around(it.read(design), get(design, path)) for path, it in variables.items()}
    sized = dataclasses.replace(
        study,
        design=design,
        table=dataclasses.replace(study.table, variables=read),
        options=dataclasses.replace(study.options, duration=duration),
    )
    return tuned_toml(design, sized.problem(), comment, first=study.scenario, settings=study.tuning)


def _around(variable: Variable, value: float) -> Variable:
    """Return a variable whose bounds hold a value."""
    if variable.low <= value <= variable.high:
        return variable
    low, high = min(variable.low, ROOM[0] * value), max(variable.high, ROOM[1] * value)
    return dataclasses.replace(variable, low=float(f"{low:.3g}"), high=float(f"{high:.3g}"))
