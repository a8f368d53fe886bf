"""The design problem as data: what it accepts, what it refuses, and what its parts mean."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest

from jaxbuffer import (
    Case,
    InputError,
    Limits,
    Objective,
    Problem,
    Scenario,
    SecondObjective,
    Variable,
    get,
    replace,
    table2,
)
from jaxbuffer.tuning import Distribution, Scatter, grid

K = Variable("buffer.k_A", 100.0, 2000.0)


def stated(**fields):
    return Problem(**{"design": table2(), "scenarios": [Scenario()], "variables": [K], **fields})


@pytest.mark.parametrize("scale", ["log", "linear"])
def test_places_and_values_are_inverse_and_exact_at_the_bounds(scale):
    variable = Variable("buffer.k_A", 0.1, 0.3, scale)
    assert variable.value(0.0) == 0.1 and variable.value(1.0) == 0.3
    for scaled in (0.1, 0.5, 0.9):
        assert variable.scaled(variable.value(scaled)) == pytest.approx(scaled, abs=1e-14)
    middle = np.sqrt(0.1 * 0.3) if scale == "log" else 0.2
    assert variable.value(0.5) == pytest.approx(middle, rel=1e-14)
    slope = (variable.value(0.5 + 1e-6) - variable.value(0.5 - 1e-6)) / 2e-6
    assert variable.slope(variable.value(0.5)) == pytest.approx(slope, rel=1e-9)


def test_aggregates_are_what_their_names_say():
    values = np.array([3.0, 10.0, 1.0, 7.0, 5.0])
    assert Objective(over="worst").aggregate(values) == 10.0
    assert Objective(over="mean").aggregate(values) == pytest.approx(values.mean())
    assert Objective(over="cvar", level=0.6).aggregate(values) == pytest.approx((10.0 + 7.0) / 2)
    assert Objective(over="cvar", level=0.5).aggregate(values) == pytest.approx((10.0 + 7.0 + 0.5 * 5.0) / 2.5)
    assert Objective(over="cvar", level=0.0).aggregate(values) == pytest.approx(values.mean())
    assert Objective(over="cvar", level=0.99).aggregate(values) == 10.0


@pytest.mark.parametrize(
    ("weights", "unit"),
    [
        ({"hinge_angle": 1.0}, "rad"),
        ({"peak_force": 1.0}, "N"),
        ({"stroke": 2.0}, "N"),
        ({"peak_force": 1.0, "stroke": 1.0}, "N"),
    ],
)
def test_an_objective_of_one_quantity_is_in_its_unit(weights, unit):
    problem = Problem(table2(), [Scenario()], [Variable("buffer.k_A", 100.0, 2000.0)], Objective(weights))
    assert problem.objective.unit(problem.catalogue) == unit


def test_the_start_and_the_built_case():
    problem = stated(scenarios=[Case(Scenario(), (("buffer.k_A", 1.1), ("contact.friction", 0.9)))])
    assert problem.values(problem.start()) == pytest.approx([500.0], rel=1e-14)
    built = problem.cases[0].of(problem.built([1.0]))
    assert (get(built, "buffer.k_A"), get(built, "contact.friction")) == pytest.approx((2200.0, 0.9 * 0.33))


def sampled(*numbers, seed=0):
    return Scatter(*numbers, seed).cases([Case(Scenario())], table2())


def test_grid_and_sample():
    cases = grid({"approach_speed": [0.1, 0.2], "misalignment": [-0.05, 0.0, 0.05]}, Scenario(passive_rate=0.01))
    assert len(cases) == 6 and {case.scenario.passive_rate for case in cases} == {0.01}
    assert (cases[5].scenario.approach_speed, cases[5].scenario.misalignment) == (0.2, 0.05)
    spread = {"approach_speed": Distribution("uniform", 0.1, 0.3), "misalignment": Distribution("normal", 0.0, 0.02)}
    factors = {"buffer.k_A": Distribution("uniform", 0.9, 1.1)}
    drawn = sampled(100, spread, factors, seed=3)
    assert drawn == sampled(100, spread, factors, seed=3) != sampled(100, spread, factors, seed=4)
    speeds = np.sort([case.scenario.approach_speed for case in drawn])
    assert np.all(np.abs(speeds - np.linspace(0.101, 0.299, 100)) < 0.0011), "one in every hundredth: a Latin hypercube"
    angles = np.array([case.scenario.misalignment for case in drawn])
    assert abs(angles.mean()) < 1e-3 and angles.std() == pytest.approx(0.02, rel=0.05)
    assert all(0.9 <= dict(case.factors)["buffer.k_A"] <= 1.1 for case in drawn)


BAD = [
    ({"scenarios": []}, "scenarios is empty"),
    ({"variables": [Variable("buffer.k_A", 600.0, 2000.0)]}, r"the start, buffer\.k_A = 500 N/m, .*\[600, 2000\] N/m"),
    (
        {"variables": [Variable("buffer.k_A", 2000.0, 100.0)]},
        r"low bound of \[2000, 100\] N/m must be less than the high one; are they swapped",
    ),
    ({"variables": [Variable("buffer.k_A", 0.0, 900.0)]}, r"low bound = 0 N/m .*\(0, inf\)"),
    ({"variables": [Variable("contact.restitution", 0.5, 1.5)]}, r"contact\.restitution = 1\.5 .*\(0, 1\]"),
    ({"variables": [Variable("buffer.kA", 1.0, 2.0)]}, r"buffer\.kA is unknown; did you mean buffer\.k_A\?"),
    ({"variables": [K, K]}, r"buffer\.k_A is named twice"),
    ({"variables": [Variable("buffer.damping", 1.0, 2.0)]}, "not a number that can be tuned"),
    ({"variables": [Variable("contact.stiffness", 1e9, 1e10)]}, "not a number that can be tuned"),
    ({"variables": [dataclasses.replace(K, scale="cubic")]}, "scale = 'cubic' is unknown"),
    (
        {"scenarios": [Scenario(), Scenario(contact_distance=0.08)]},
        r"scenario 2 \(0\.1 m/s, 0°, .*\): scenario\.contact_distance = 0\.08 m",
    ),
    (
        {"scenarios": [Case(Scenario(), (("buffer.k_B", 1.1),))]},
        r"1 \(0\.1 m/s, 0°, 1\.1 buffer\.k_B\): buffer\.k_B is unknown",
    ),
    (
        {"scenarios": [Case(Scenario(), (("contact.restitution", 1.2),))]},
        r"1 \(0\.1 m/s, 0°, 1\.2 contact\.restitution\): contact\.restitution = 1\.08",
    ),
    ({"duration": 0.0}, "duration = 0 s"),
]


@pytest.mark.parametrize(("fields", "message"), BAD, ids=[message for _, message in BAD])
def test_bad_problems(fields, message):
    with pytest.raises(InputError, match=message):
        stated(**fields)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: stated(objective=Objective({"peak": 1.0})), "objective.peak is unknown; did you mean peak_force?"),
        (lambda: stated(limits=Limits(at_least={"strok": 1.0})), "constraints.strok is unknown; did you mean stroke?"),
        (lambda: Objective({"peak_force": 0.0}), r"objective\.peak_force = 0 N/N"),
        (lambda: Objective({}), "no quantity is given"),
        (lambda: Objective(over="best"), "objective.over = 'best' is unknown"),
        (lambda: Limits(at_most={"stroke": 0.0}), r"constraints\.stroke = 0 m"),
        (lambda: Limits(impacts=0), r"constraints\.impacts = 0"),
        (lambda: SecondObjective(Objective(), tolerance=0.0), r"then\.tolerance = 0"),
        (lambda: Distribution("uniform", 2.0, 1.0), r"uniform, second number = 1"),
        (lambda: Distribution("triangle", 2.0, 1.0), "'triangle' is unknown"),
        (lambda: grid({"speed": [1.0]}), "speed is unknown"),
        (lambda: grid({"approach_speed": []}), r"grid\.approach_speed is empty"),
        (lambda: sampled(0, {"approach_speed": Distribution("uniform", 1.0, 2.0)}), r"sample\.count = 0"),
        (
            lambda: sampled(2, {}, {"buffer.damping": Distribution("uniform", 1.0, 2.0)}),
            "not a number that can scatter",
        ),
    ],
)
def test_bad_parts(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_the_fingerprint_tells_problems_apart():
    problem = stated()
    assert problem.fingerprint() == stated().fingerprint()
    others = [
        stated(design=replace(table2(), {"contact.friction": 0.3})),
        stated(scenarios=[Scenario(approach_speed=0.11)]),
        stated(scenarios=[Case(Scenario(), (("buffer.k_A", 1.1),))]),
        stated(variables=[dataclasses.replace(K, high=1999.0)]),
        stated(objective=Objective(over="mean")),
        stated(limits=Limits(impacts=9)),
        stated(then=SecondObjective(Objective())),
        stated(rtol=1e-8),
    ]
    assert len({problem.fingerprint(), *(other.fingerprint() for other in others)}) == 9


def test_quantities_are_known_before_any_design_is_made():
    code = "import jaxbuffer as jb; jb.Objective({'peak_force': 1.0}); jb.Limits(at_most={'stroke': 0.025})"
    subprocess.run([sys.executable, "-c", code], check=True)
