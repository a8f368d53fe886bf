"""A choice with more tolerances than all corners of which are run: against every corner of every combination."""

import itertools

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.choosing.store import FOLDER, round_folder

PARTS = {
    "spring": {"soft": {"k_A": 300.0}, "stiff": {"k_A": 700.0}},
    "damper": {"weak": {"c_A": 5.0}, "strong": {"c_A": 20.0}},
    "tip": {"light": {"tip_mass": 0.03}, "heavy": {"tip_mass": 0.06}},
}
SCATTER = {  # shares of the numbers
    "buffer.k_A": 0.1,
    "buffer.c_A": 0.2,
    "buffer.k_T": 0.1,
    "buffer.c_T": 0.2,
    "probe.tip_mass": 0.1,
    "probe.tip_radius": 0.02,
    "probe.rod_mass": 0.05,
}
SCENARIO = jb.Scenario(approach_speed=0.12, misalignment=0.02)
STROKE = 0.012  # m


def every_corner(combinations):
    """Peak force and stroke of combinations of parts, numbers by address, in all 128 corners; infinite where a run is
    no capture."""
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=len(SCATTER))))
    numbers = {}
    for place, (path, share) in enumerate(SCATTER.items()):
        base = [it.get(path, jb.get(jb.table2(), path)) for it in combinations]
        numbers[path] = np.outer(base, 1.0 + share * signs[:, place]).ravel()
    swept = jb.sweep(jb.replace(jb.table2(), numbers), SCENARIO, 8.0)
    captured = np.array([outcome.name == "captured" for outcome in swept.outcomes])
    shape = (len(combinations), len(signs))
    return [np.where(captured, it, np.inf).reshape(shape) for it in (swept.peak_force, swept.stroke)]


def with_seven_tolerances():
    """The problem whose designs have to hold in 128 corners."""
    tolerances = {path: f"{100.0 * share:g} %" for path, share in SCATTER.items()}
    limits = jb.Limits(at_most={"stroke": STROKE})
    return jb.Problem(jb.table2(), [SCENARIO], [], limits=limits, tolerances=tolerances)


@pytest.mark.long
def test_the_best_of_seven_tolerances_is_the_best_in_all_128_corners(tmp_path, evidence):
    problem = with_seven_tolerances()
    (tmp_path / round_folder(7)).mkdir()  # of an earlier choice
    choice = jb.choose(problem, PARTS, optimum=False, folder=tmp_path)
    sections = {"k_A": "buffer.k_A", "c_A": "buffer.c_A", "tip_mass": "probe.tip_mass"}
    combinations = itertools.product(*(part.values() for part in PARTS.values()))
    force, stroke = every_corner([{sections[k]: v for it in parts for k, v in it.items()} for parts in combinations])
    keeps = np.all(stroke <= STROKE, axis=1)
    worst = np.where(keeps, np.max(force, axis=1), np.inf)
    assert 1 < keeps.sum() < 8, "some combinations keep the limit and some do not"
    names = list(itertools.product(*PARTS.values()))
    assert choice.feasible and choice.best.names == names[int(np.argmin(worst))]
    assert choice.tally.runs < force.size / 2 and "no proof" in str(choice)
    assert (tmp_path / FOLDER).is_dir() and (tmp_path / round_folder(1)).is_dir()
    assert not (tmp_path / round_folder(7)).exists()
    again = jb.choose(problem, PARTS, optimum=False, folder=tmp_path, resume=True)
    assert [it.value for it in again.ranked] == [it.value for it in choice.ranked]
    # The sweep's runs have rtol 1e-6, those that are told 1e-9.
    error = abs(choice.best.value / np.min(worst) - 1.0)
    evidence(
        "choices", "worst force of the best of seven tolerances' choice", error, 1e-5, "all 128 corners by jb.sweep"
    )


@pytest.mark.long
def test_a_rounding_and_the_continuous_design_hold_in_all_128_corners(evidence):
    """Both sides of the price of a rounding are forces in the worst corner, not one of them as drawn."""
    drawn = {"buffer.k_A": 520.0, "buffer.c_A": 14.3}
    choice = jb.buildable(
        with_seven_tolerances(), {"buffer.k_A": "E6", "buffer.c_A": "E6"}, jb.replace(jb.table2(), drawn)
    )
    values = list(itertools.product((330.0, 470.0, 680.0, 1000.0), (6.8, 10.0, 15.0, 22.0)))  # two on either side
    force, stroke = every_corner([drawn, *({"buffer.k_A": k, "buffer.c_A": c} for k, c in values)])
    keeps, worst = np.all(stroke <= STROKE, axis=1), np.max(force, axis=1)
    assert 0 < keeps[1:].sum() < len(values), "some roundings keep the limit and some do not"
    best = min((worst[number + 1], pair) for number, pair in enumerate(values) if keeps[number + 1])
    assert choice.best.names == tuple(
        f"{value:g} {unit}" for value, unit in zip(best[1], ("N/m", "N s/m"), strict=True)
    )
    assert choice.continuous is not None
    for what, told, exact in (("rounding", choice.best.value, best[0]), ("design", choice.continuous.value, worst[0])):
        evidence("choices", f"worst force of a {what} of seven tolerances", abs(told / exact - 1.0), 1e-5, "jb.sweep")
