"""The study of the docking standard's initial conditions: how they are drawn, what is read off the runs, the search."""

from types import SimpleNamespace

import numpy as np
import pytest

from jaxbuffer import Outcome
from optimise import initial_conditions as study
from optimise.study import Sweeps, config

LIMITS = {  # of the standard (lateral misalignment: as scaled to the cone), in the units of the table
    "closing rate [mm/s]": (50.0, 100.0),
    "lateral misalignment [mm]": (0.0, 40.0),
    "pitch and yaw [deg]": (0.0, 4.0),
    "lateral rate [mm/s]": (0.0, 40.0),
    "pitch and yaw rate [deg/s]": (0.0, 0.2),
    "roll rate [deg/s]": (0.0, 0.2),
}
RNG = np.random.default_rng(5)


def test_conditions_fill_the_standard_s_ranges_evenly():
    """Of points spread evenly over a circle, the squared distance from its centre is spread evenly from 0 to 1."""
    named = study.sizes(study.drawn(config("initial_conditions"), 2000, 1))
    for name, (low, high) in LIMITS.items():
        values = named[name]
        assert low <= values.min() and values.max() <= high * (1.0 + 1e-12) and values.max() > 0.97 * high, name
        shares = (values - low) / (high - low)
        shares = shares**2 if name in study.VECTORS else shares
        assert np.mean(shares) == pytest.approx(0.5, abs=0.02) and np.std(shares) == pytest.approx(12**-0.5, abs=0.02)


def test_another_seed_draws_other_conditions():
    first, second = (study.drawn(config("initial_conditions"), 50, seed) for seed in (1, 101))
    assert not set(first["scenario.approach_speed"]) & set(second["scenario.approach_speed"])


def test_a_drift_outwards_is_the_lateral_rate_along_the_offset():
    def of(name):
        return {"offset_y": 0.03, "offset_z": -0.04, "lateral_speed_y": 0.01, "lateral_speed_z": 0.02}.get(name, 0.05)

    values = {f"scenario.{path.split('.')[1]}": np.array([of(path.split(".")[1])]) for path in paths()}
    (outwards,) = study.sizes(values)["lateral rate outwards [mm/s]"]
    assert outwards == pytest.approx(1e3 * (0.6 * 0.01 - 0.8 * 0.02))


def paths():
    """The paths that the study varies."""
    return config("initial_conditions").sample.ranges


def test_shares_are_the_first_order_indices_of_a_known_function():
    """Of y = 2 a + b with a and b spread evenly these are 4/5 and 1/5; bins keep all but their width squared of it."""
    a, b, idle = RNG.uniform(size=(3, 40_000))
    y = 2.0 * a + b
    kept = 1.0 - study.BINS**-2
    assert study.share(a, y) == pytest.approx(0.8 * kept, abs=0.01)
    assert study.share(b, y) == pytest.approx(0.2 * kept, abs=0.01)
    assert study.share(idle, y) == pytest.approx(0.0, abs=1e-3)


def test_shares_of_what_has_no_effect_are_zero_on_average_in_few_runs_too():
    shares = [study.share(*RNG.uniform(size=(2, 200))) for _ in range(400)]
    assert abs(np.mean(shares)) < 4.0 * np.std(shares) / 20.0 and np.std(shares) > 0.01


def test_an_interval_is_wilson_s():
    """Wilson 1927: (p + z²/2n ± z √(p q/n + z²/4n²))/(1 + z²/n), by hand for 3 of 10."""
    z, p, n = 1.959964, 0.3, 10
    middle, half = p + z**2 / (2 * n), z * (p * (1 - p) / n + z**2 / (4 * n**2)) ** 0.5
    low, high = (100 * (middle + side * half) / (1 + z**2 / n) for side in (-1, 1))
    assert study.interval(3, 10) == f"30.0 % ({low:.1f} to {high:.1f} %)"


@pytest.fixture
def made_up(monkeypatch):
    """Sweeps without the wait: a run is held where torsion is soft, and captured where the closing rate is high."""

    def stands_in(design, scenario, duration, rtol):
        speed = np.asarray(scenario.approach_speed, float)
        soft = np.broadcast_to(design.buffer.k_T, speed.shape) < 100.0
        code = np.where(soft, Outcome.held, np.where(speed > 0.08, Outcome.latched, Outcome.escaped))
        columns = {"peak_force": 1e3 * speed, "stroke": 0.1 * speed, "peak_hinge_force": 2e3 * speed}

        class Made(SimpleNamespace):
            def __len__(self):
                return len(speed)

        return Made(outcomes=[Outcome(int(it)) for it in code], columns=columns, **columns)

    monkeypatch.setattr("optimise.study.sweep", stands_in)
    monkeypatch.setattr(study, "RUNS", 64)


def test_the_search_finds_a_design_that_holds(made_up, tmp_path):
    found = study.searched(config("initial_conditions"), Sweeps(tmp_path, False, None), 1)
    assert found["buffer.k_T"] < 100.0 and set(found) == {
        it.path for it in config("initial_conditions").problem().variables
    }


def test_it_writes_what_both_designs_hold(made_up, tmp_path):
    study.main(tmp_path)
    lines = (tmp_path / "table2.txt").read_text()
    speeds = study.drawn(config("initial_conditions"), 64, 1)["scenario.approach_speed"]
    assert f"captured {study.interval(int((speeds > 0.08).sum()), 64)}" in lines
    assert f"held     {study.interval(0, 64)}" in lines
    assert f"worst stroke {100 * speeds.max():.4g} mm at closing rate [mm/s] {1e3 * speeds.max():.3g}" in lines
    assert f"held     {study.interval(64, 64)}" in (tmp_path / "tuned.txt").read_text()
    assert (tmp_path / "initial_conditions.png").read_bytes().startswith(b"\x89PNG")
