"""`fit`: the numbers of a design that measured tests tell."""

import dataclasses
import itertools
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .._types import Scalar
from ..errors import InputError, check_type, suggest
from ..fields import Part, get, in_unit, limits_of, unit
from ..mechanisms.registry import mechanism_of
from ..run.request import DEFAULT_TOLERANCE, check_pair
from ..tuning.problem.variable import SCALES, Variable
from .estimation import Estimation, Report
from .fitted import Fitted
from .prediction import Prediction
from .quantities import recorded_quantities
from .recording import Recording
from .signals import Parameters


def fit(
    design: Part,
    scenario: Part | None,
    measurements: Recording | Sequence[Recording],
    parameters: Mapping[str, Any],
    *,
    duration: Scalar | None = None,
    rtol: float = DEFAULT_TOLERANCE,
    report: Report = lambda line: None,
) -> Fitted:
    """Fit numbers of a design to measured tests, all together, by least squares.

    Levenberg and Marquardt's method runs on exact derivatives. It begins with the first rows of the records, up to
    shortly after the first impact, and goes on with more and more of them; where it does not come down to the noise
    it begins at further points.

    **Arguments:**

    - ``design``: its own numbers are where the search starts.
    - ``scenario``: of the tests that have none of their own (default: the mechanism's).
    - ``measurements``: a `Recording`, or several of tests of one design.
    - ``parameters``: bounds by path: ``{"buffer.k_A": (100.0, 3000.0)}``, also with units, or with a scale, "linear" or
      "log" (default where the low bound is above zero).
    - ``duration``: after which a run is over [s] (default: the mechanism's).
    - ``rtol``: local error allowed in a step [-].
    - ``report``: is told in a line how far the search is.

    **Returns:** a `Fitted`: estimates with 95 % intervals, residuals, correlation, the fitted design.

    **Raises:** `InputError` for paths, quantities and bounds that are not right, and for a record that is longer than
    its run.

    **Example:** what is mistyped is said before anything is computed (docs/fit.md has a whole fit).

    >>> import numpy as np
    >>> test = jb.Recording("bench", np.linspace(0.0, 0.1, 50), {"s": np.zeros(50)}, {"s": jb.Channel("strok")})
    >>> try:
    ...     jb.fit(jb.table2(), None, test, {"buffer.k_A": ("100 N/m", "3 kN/m")})
    ... except jb.InputError as error:
    ...     print(error)
    bench: column "s": quantity strok is unknown; did you mean stroke?
    """
    scenario = mechanism_of(design).scenario() if scenario is None else scenario
    variables, predictions = checked(design, scenario, measurements, parameters, duration, rtol)
    return Estimation(design, scenario, variables, predictions, report).fitted()


def checked(
    design: Part,
    scenario: Part,
    measurements: Recording | Sequence[Recording],
    parameters: Mapping[str, Any],
    duration: Scalar | None = None,
    rtol: float = DEFAULT_TOLERANCE,
) -> tuple[list[Variable], list[Prediction]]:
    """Return what a fit is of, before anything is computed. Arguments and errors are those of `fit`."""
    mechanism = mechanism_of(design)
    recordings = [measurements] if isinstance(measurements, Recording) else list(measurements)
    duration = float(in_unit("duration", mechanism.duration(design) if duration is None else duration, "s"))
    variables = [_variable(design, path, given) for path, given in parameters.items()]
    if not recordings or not variables:
        raise InputError(
            "a fit needs a test and a parameter: fit(design, scenario, [test], {'buffer.k_A': (100, 3000)})"
        )
    return variables, [
        _prediction(design, scenario, recording, [it.path for it in variables], duration, rtol)
        for recording in _distinct(recordings)
    ]


def _distinct(recordings: Sequence[Recording]) -> list[Recording]:
    """Return the tests with a number behind each name that several have: results go by a test's name."""
    for recording in recordings:
        check_type("measurements", recording, Recording, "jb.read_recording(file, channels)")
    counts = Counter(it.name for it in recordings)
    taken = {name for name, count in counts.items() if count == 1}
    distinct = []
    for recording in recordings:
        numbered = (f"{recording.name} ({k})" for k in itertools.count(1))
        name = recording.name if counts[recording.name] == 1 else next(it for it in numbered if it not in taken)
        taken.add(name)
        distinct.append(dataclasses.replace(recording, name=name))
    return distinct


def _variable(design: Part, path: str, given: Any) -> Variable:
    """Return a parameter with its bounds, between which the design's own number must lie."""
    if isinstance(given, Variable):
        variable = given
    else:
        parts = list(given) if isinstance(given, (list, tuple)) else []
        scale = parts.pop() if len(parts) == 3 else None
        if len(parts) != 2 or scale not in (None, *SCALES):
            raise InputError(f"{path}: expected two bounds, (100.0, 3000.0) say, and perhaps a scale, found {given!r}")
        variable = Variable(path, *parts)
        if scale is not None:
            variable = dataclasses.replace(variable, scale=scale)
    start = get(design, path)
    variable = variable.read(design)
    if unit(design, path) and start is None:
        raise InputError(f"{path} is not set: give the design a number there, at which the search starts")
    if not unit(design, path):
        raise InputError(f"{path} = {start!r} is not a number that can be fitted")
    low, high = float(variable.low), float(variable.high)
    # A variable is logarithmic by default, and a bound of zero has no logarithm.
    if variable.scale == "log" and low <= 0.0:
        variable = dataclasses.replace(variable, scale="linear")
    limits = limits_of(design, path)
    for side, end in (("low", low), ("high", high)):
        in_unit(f"{path}: {side} bound", end, unit(design, path), **limits)
    if not low < high:
        raise InputError(f"{path}: the low bound {low:g} must be below the high one, {high:g}")
    if not low <= float(start) <= high:
        raise InputError(
            f"{path} = {float(start):g} is outside of its bounds {low:g} and {high:g}: the search starts there"
        )
    return dataclasses.replace(variable, low=low, high=high)


def _prediction(
    design: Part, scenario: Part, recording: Recording, paths: Sequence[str], duration: float, rtol: float
) -> Prediction:
    """Return a test's prediction, once its quantities and its length are known to be right."""
    own = scenario if recording.scenario is None else recording.scenario
    mechanism = mechanism_of(design)
    check_pair(mechanism, design, own)
    units = recorded_quantities(design, own)
    for column, channel in recording.channels.items():
        if channel.quantity not in units:
            hint = suggest(channel.quantity, units)
            raise InputError(f'{recording.name}: column "{column}": quantity {channel.quantity} is unknown{hint}')
    prediction = Prediction(Parameters(mechanism, design, own, tuple(paths), rtol), recording, units)
    # With the largest shift the rows are earliest in the run: one that is too late even then has no prediction at all.
    shift = prediction.shift.high if isinstance(prediction.shift, Variable) else prediction.shift
    if (late := int(np.searchsorted(recording.times - shift, duration, side="right"))) < len(recording.times):
        raise InputError(
            f"{recording.row(late)}: the time {recording.times[late]:g} s is after the end of the run at {duration:g} s"
            " (duration in [options])"
        )
    return prediction
