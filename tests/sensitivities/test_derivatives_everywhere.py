"""Every number of a capture, its log and its history has the derivative that differences of tight solves have.

The differenced captures use the explicit solver at rtol 1e-12 and know nothing of sensitivities.
"""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.hybrid import ExplicitRungeKutta, Kind
from jaxbuffer.mechanisms.probe_cone.capture import Docking

PATHS = ("buffer.k_A", "scenario.approach_speed", "scenario.contact_distance")
VALUES = np.array([500.0, 0.1, 0.0435])
STEP = 6e-5  # relative; the other one is half as long
CLOSE = 2e-3  # relative to the largest entry; measured 6e-4
MOMENTS = (0.0, 0.02, 0.35, 0.6, 0.9)  # of the history's steps
# NaN of a run that ends with the capture
WITHOUT_LATCH = ("passive_force", "docking.latch_time", "docking.settling_time")
EXACT = ("design", "scenario", "stabilisation", "_located")  # what goes in, and the log's other self


def captured(values, **options):
    values = dict(zip(PATHS, values, strict=True))
    scenario = {path.removeprefix("scenario."): x for path, x in values.items() if path.startswith("scenario.")}
    design = {path: x for path, x in values.items() if not path.startswith("scenario.")}
    return jb.simulate(jb.replace(jb.table2(), design), jb.Scenario(**scenario), **options)


def floats(module, prefix=""):
    """Every number of a capture by its name."""
    numbers = {}
    for field in dataclasses.fields(module):
        value, name = getattr(module, field.name), prefix + field.name
        if name in EXACT or value is None or isinstance(value, tuple):  # names of what was watched
            continue
        if dataclasses.is_dataclass(value):
            numbers |= floats(value, name + ".")
        elif isinstance(value, dict):  # a part's own by name, which go as attributes where they can
            numbers |= {(prefix if prefix else f"{name}.") + key: number for key, number in value.items()}
        elif jnp.issubdtype(value.dtype, jnp.floating):
            numbers[name] = value
    return numbers


def everything(capture):
    return floats(capture) | floats(capture.log, "log.")


def tight(values, **options):
    return captured(map(float, values), rtol=1e-12, solver=ExplicitRungeKutta(), **options)


def differences(of):
    """By each parameter, central differences of named arrays, of two steps and extrapolated."""

    def central(move):
        above, below = of(VALUES + move), of(VALUES - move)
        return {name: (np.asarray(above[name]) - below[name]) / (2 * move.sum()) for name in above}

    columns = []
    for move in np.diag(STEP * VALUES):
        coarse, fine = central(move), central(move / 2)
        columns.append({name: (4 * fine[name] - coarse[name]) / 3 for name in fine})
    return {name: np.stack([column[name] for column in columns], axis=-1) for name in columns[0]}


@pytest.fixture(scope="module")
def solution():
    """A capture with its history, and derivatives of everything in it, by name."""

    def outputs(values):
        capture = captured(values, rtol=1e-9, history=True)
        return everything(capture), capture

    derivatives, capture = jax.jit(jax.jacfwd(outputs, has_aux=True))(list(VALUES))
    return capture, {name: np.stack(columns, axis=-1) for name, columns in derivatives.items()}


@pytest.fixture(scope="module")
def expected():
    """Solved with a history, as `test_history_at_its_fixed_times` does, so that one program serves both."""

    def outputs(values):
        numbers = everything(tight(values, history=True))
        return {name: number for name, number in numbers.items() if not name.startswith("history.")}

    return differences(outputs)


def assert_close(derivative, difference, values, name):
    """To a small part of the largest entry's, as changes with a relative change of a parameter; what a quantity changes
    by no more than the tight solves' own error counts as nothing."""
    changes, error = np.abs(difference) * VALUES, np.abs(derivative - difference) * VALUES
    allowed = CLOSE * np.max(changes, axis=tuple(range(changes.ndim - 1))) + 1e-6 * np.max(np.abs(values)) + 1e-11
    assert np.all(error <= allowed), (name, np.max(error / allowed))


OTHERS = (*EXACT, *WITHOUT_LATCH, "maxima")
NUMBERS = [
    *(f.name for f in dataclasses.fields(jb.Capture) if "Float" in str(f.type) and f.name not in OTHERS),
    *(f"maxima.{name}" for name in ("hinge_force", "buffer_force", "stroke", "extension", "hinge_angle")),
    "log.latest",
    "log.missed_time",
    "log.missed_values",
    *(f"impacts.{name}" for name in ("time", "approach_speed", "peak_force", "release_time")),
    *(f"first_impact.{f.name}" for f in dataclasses.fields(jb.FirstImpact)),
    *(name for f in dataclasses.fields(Docking) if (name := f"docking.{f.name}") not in WITHOUT_LATCH),
    *(f"energy.{name}" for name in ("kinetic", "spring", "contact", "stop", "axial_damper", "torsional_damper",
                                    "hysteresis", "friction", "stop_damper", "hinge_play", "bending")),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", NUMBERS)
def test_number(solution, expected, name):
    capture, derivatives = solution
    values = np.asarray(everything(capture)[name])
    used = np.isfinite(values)  # without the release of an impact under way at the end
    assert_close(derivatives[name][used], expected[name][used], values[used], name)


@pytest.mark.slow
def test_all_numbers_are_looked_at(solution):
    log = {f"log.{name}" for name in ("time", "values", "rows", "rates", "guard_rate", "active")}
    balance = {f"balance.{name}" for name in ("energy", "linear_momentum", "angular_momentum", "drift")}
    names = {name for name in solution[1] if not name.startswith("history.")}
    assert names == {*NUMBERS, *log, *balance, *WITHOUT_LATCH}
    # A release is NaN where there is no impact.
    without = ("log.guard_rate", "impacts.release_time", *WITHOUT_LATCH)
    assert all(np.all(np.isfinite(x)) for name, x in solution[1].items() if name not in without)


@pytest.mark.slow
def test_balance_is_constant_however_design_and_scenario_move(solution, expected):
    """The exact motion conserves all of it, whatever the parameters: differences are of the solves' own errors."""
    for name, derivative in solution[1].items():
        if name.startswith("balance."):
            assert np.all(derivative == 0.0)
            assert np.all(np.abs(expected[name]) * VALUES < 1e-6)


@pytest.mark.slow
def test_log(solution, expected):
    """Touchdowns, releases and the end with their states and their rates, maxima with their values."""
    capture, derivatives = solution
    count = int(capture.log.count)
    kind, which = np.asarray(capture.log.kind)[:count], np.asarray(capture.log.which)[:count]
    crossed, peaks = kind != Kind.PEAK, np.flatnonzero(kind == Kind.PEAK)
    for name in ("log.time", "log.rows", "log.rates", "log.values"):
        values = np.asarray(everything(capture)[name])[:count]
        pair = derivatives[name][:count], expected[name][:count]
        assert_close(*(x[crossed] for x in pair), values[crossed], name)
    # a maximum is found by its value: when it is, and what else is then, is known less well
    values = np.asarray(capture.log.values)
    for column in range(values.shape[1]):
        own = peaks[which[peaks] == column]
        pair = derivatives["log.values"], expected["log.values"]
        assert own.size, column
        assert_close(*(x[own, column] for x in pair), values[own, column], column)
    late = derivatives["log.time"][peaks], expected["log.time"][peaks]
    assert np.max(np.abs(late[0] - late[1]) * VALUES) < 1e-2 * np.max(np.abs(late[1]) * VALUES)


@pytest.mark.slow
def test_what_has_no_derivative_is_nan(solution):
    count = int(solution[0].log.count)
    assert np.all(np.isnan(solution[1]["log.guard_rate"][:count]))


@pytest.mark.slow
@pytest.mark.parametrize("moment", MOMENTS)
def test_history_at_its_fixed_times(solution, moment):
    """A state of the history is the end of a run that lasts as long; the first one, the start of any run."""
    capture, derivatives = solution
    slot = int(moment * int(capture.accepted))
    time = float(capture.history.time[slot])
    row = -1 if slot else 0
    at = {"duration": time or 1e-4, "history": True}
    difference = differences(lambda values: {
        name: value[row] for name, value in floats(tight(values, **at).history, "history.").items()
    })  # fmt: skip
    for name, value in floats(capture.history, "history.").items():
        largest = np.max(np.abs(value[: int(capture.accepted)]), axis=0)
        assert_close(derivatives[name][slot], difference[name], largest, name)


@pytest.mark.long
def test_the_history_holds_the_largest_stroke_with_its_derivative(solution, expected):
    """As a user asks for it, without jit, in reverse."""

    def largest(stiffness):
        history = captured((stiffness, *VALUES[1:]), history=True).history
        assert history.time.shape[0] < 5000, "cut to the steps taken"
        return jnp.max(history.stroke)

    np.testing.assert_allclose(jax.grad(largest)(500.0), expected["stroke"][0], rtol=1e-3)


@pytest.mark.parametrize(
    "twice",
    [
        pytest.param(jax.hessian, marks=pytest.mark.long),
        pytest.param(lambda f: jax.grad(jax.grad(f)), marks=pytest.mark.long),
        lambda f: jax.jit(jax.hessian(f)),
    ],
)
def test_second_derivatives_are_refused_in_words(twice):
    with pytest.raises(jb.InputError, match=r"second derivatives are not offered.*take differences of first"):
        twice(lambda x: captured((x, *VALUES[1:])).peak_force)(500.0)


@pytest.mark.parametrize("option", ["duration", "rtol", "atol"])
def test_derivatives_by_options_are_refused_in_words(option):
    with pytest.raises(jb.InputError, match=r"can't be differentiated by its duration, rtol or atol"):
        jax.grad(lambda x: captured(VALUES, **{option: x}).throat_distance)(1e-4)
