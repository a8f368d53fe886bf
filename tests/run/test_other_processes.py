"""Every result goes to another process and comes back with the same numbers, and so does what interrupts a sweep."""

import dataclasses
import enum
import functools
import inspect
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import equinox as eqx
import jax
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms import all_mechanisms
from jaxbuffer.mechanisms.mechanism import Mechanism
from jaxbuffer.sweeps.result import Sweep, SweepInterrupted
from jaxbuffer.tuning.report.front import Front
from made_up import made_up_capture, made_up_sensitivity, made_up_tuning

SHORT = 0.06  # s, a drop from 10 mm and its impact
DESIGN, SCENARIO = jb.BarDrop(), jb.BarDropScenario(height=0.01)
OVER = {"scenario.height": [0.005, 0.01], "impact.stiffness": [1e11, 2e11]}  # m, N/m^e
RANGES = {"scenario.height": (0.005, 0.01), "impact.stiffness": (1e11, 2e11)}
FACTORIES = ("table2", "BarDrop", "SliderCrank", "TankDrop", "Scenario", "BarDropScenario", "SliderCrankScenario",
             "TankDropScenario")  # fmt: skip


@functools.cache
def drop():
    return jb.simulate(DESIGN, SCENARIO, SHORT, history=True)


@functools.cache
def swept():
    return jb.sweep(DESIGN, SCENARIO, SHORT, over=OVER)


@functools.cache
def sample():
    return jb.sample(DESIGN, SCENARIO, RANGES, 16, "saltelli", duration=SHORT)


def run_of(design, scenario):
    """A run with made-up numbers, for its classes."""
    shapes = eqx.filter_eval_shape(lambda: jb.simulate(design, scenario, 0.01))
    return jax.tree.map(
        lambda it: jax.numpy.ones(it.shape, it.dtype) if isinstance(it, jax.ShapeDtypeStruct) else it, shapes
    )


def effort(peak_force, stroke):
    return peak_force * stroke


def problem():
    own = {"effort": jb.CustomQuantity(effort, "N m")}
    variables = [jb.Variable("buffer.k_A", 100.0, 2000.0)]
    return jb.Problem(jb.table2(), [jb.Scenario()], variables, jb.Objective({"effort": 1.0}), quantities=own)


def front():
    return Front(problem(), ("peak_force", "stroke"), np.array([[np.inf]]), (made_up_tuning(problem()),))


def folder(tmp=Path("results")):
    return jb.Results(tmp, run=drop().to_xarray(), sweep=swept().to_xarray(), design=DESIGN)


RESULTS = {
    "run of a drop": drop,
    "capture": made_up_capture,
    "run of a slider-crank": lambda: run_of(jb.SliderCrank(), jb.SliderCrankScenario()),
    "run of a tank": lambda: run_of(jb.TankDrop(), jb.TankDropScenario()),
    "impacts": lambda: drop().impacts,
    "history": lambda: jb.at_times(drop(), np.array([0.01, 0.02])),
    "trust": lambda: jb.trust(drop(), drop()),
    "horizon": lambda: jb.horizon(drop()),
    "Sweep": lambda: jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=[0.1, 0.2]), 0.22),
    "Sweep over a grid": swept,
    "Sample": sample,
    "SafeRectangle": lambda: jb.safe_rectangle(swept(), jb.Limits(at_most={"peak_force": 1500.0})),
    "indices": lambda: jb.sobol_indices(sample(), ["peak_force"]),
    "surface": lambda: jb.response_surface(sample(), "penetration"),
    "sensitivity": made_up_sensitivity,
    "problem": problem,
    "tuned": lambda: made_up_tuning(problem()),
    "front": front,
    "first impact": lambda: jb.first_impact(jb.table2()),
    "results": folder,
    "an interrupted sweep": lambda: SweepInterrupted(swept(), np.array([True, False, False, False])),
    "an error": lambda: jb.InputError("scenario.height = -1 m is out of range"),
    **{name: getattr(jb, name) for name in FACTORIES},
    **{f"mechanism {known.name}": functools.partial(lambda it: it, known) for known in all_mechanisms()},
}


@pytest.fixture(scope="module")
def pool():
    """One other process, started anew, in which `jb.configure()` is not called."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as started:
        yield started


def back(result):
    """What is called in the other process."""
    return result


LONG = ("run of a slider-crank", "run of a tank")  # for `make test-long`: tracing them takes long


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long if name in LONG else ()) for name in RESULTS]
)
def test_a_result_comes_back_from_another_process_as_it_was(pool, name):
    result = RESULTS[name]()
    found = pool.submit(back, result).result(timeout=120)
    check_same(found, result)
    assert repr(found).replace("(numpy)", "") == repr(result).replace("(numpy)", "")


def check_same(found, expected):
    """Types, words and the bits of all numbers; JAX's arrays may have become NumPy's."""
    if isinstance(expected, (jax.Array, np.ndarray, float)):
        assert np.asarray(found).dtype == np.asarray(expected).dtype
        np.testing.assert_array_equal(np.asarray(found), np.asarray(expected))
        return
    assert type(found) is type(expected)
    pieces, others = parts(expected), parts(found)
    if pieces is None:
        assert found.identical(expected) if hasattr(expected, "identical") else found == expected
        return
    assert pieces.keys() == others.keys()
    for name, piece in pieces.items():
        check_same(others[name], piece)


def parts(value):
    """What a value is made of, by name; None where it is one piece."""
    module = type(value).__module__
    if isinstance(value, (dict, Mechanism, type)) or inspect.isroutine(value):
        return value if isinstance(value, dict) else None
    if isinstance(value, (tuple, list)):
        return dict(enumerate(value))
    if module.startswith("sklearn"):
        return {"prediction": value.predict(np.full((1, len(RANGES)), 0.3))}
    if dataclasses.is_dataclass(value):
        return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, BaseException):
        return {"message": str(value), **vars(value)}
    return vars(value) if module.startswith("jaxbuffer") and not isinstance(value, enum.Enum) else None


@pytest.mark.slow
def test_a_process_that_computes_in_single_precision_gets_every_digit(pool):
    """JAX itself would round there without a word."""
    assert pool.submit(digits, drop()).result(timeout=120) == repr(float(drop().peak_force))


def digits(run):
    assert not jax.config.jax_enable_x64
    return repr(float(run.peak_force))


@pytest.mark.slow
def test_a_problem_goes_on_working_in_the_other_process(pool):
    """Also one whose own quantity was compiled before."""
    tuned = made_up_tuning(problem())
    assert tuned.problem.quantities["effort"].linearised is not None
    assert pool.submit(repr, tuned).result(timeout=120) == repr(tuned)


def test_sweeps_of_a_sweep_made_there_know_their_mechanism(pool):
    found = pool.submit(back, swept()).result(timeout=120)
    assert found.mechanism is swept().mechanism and isinstance(found, Sweep)
    assert np.array_equal(found.shaped("peak_force"), swept().shaped("peak_force"))
