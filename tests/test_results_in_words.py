"""What people read of results in Python: outcomes by name, numbers with units, quantities as attributes."""

import json

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.outcome import Simulated
from jaxbuffer.mechanisms.probe_cone.capture import Docking
from jaxbuffer.mechanisms.slider_crank.statistics import Mean, TurnStatistics
from jaxbuffer.sensitivities.certificate import Certificate, Peaks

HEIGHT = 0.194  # m


def drop(height, **options):
    return jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=height), 0.16, **options)


@pytest.fixture(scope="module")
def dropped():
    return drop(HEIGHT)


def test_an_outcome_prints_its_name_and_stays_a_number(dropped):
    assert str(dropped.outcome) == f"{dropped.outcome}" == "finished"
    assert f"{jb.Outcome.latched:d}" == "5" and f"{jb.Outcome.latched:>8}" == " latched"
    assert json.dumps({"code": jb.Outcome.latched}) == '{"code": 5}'
    assert str(jb.Verdict.trusted) == "trusted"
    assert int(jb.Outcome.latched) == 5 == jb.Outcome.latched
    assert bool(jnp.asarray(5) == jb.Outcome.latched)


def test_outcomes_of_a_batch_are_named_and_those_inside_compiled_code_are_codes(dropped):
    batch = jax.tree.map(lambda *each: np.stack(each), dropped, dropped)
    assert batch.outcome.tolist() == [Simulated.finished, Simulated.finished]
    assert [str(end) for end in batch.outcome] == ["finished", "finished"]
    assert np.all(batch.outcome == Simulated.finished)
    assert "2 runs: 2 finished" in repr(batch)
    ends = jax.jit(lambda run: run.outcome == Simulated.finished)
    assert bool(ends(dropped))


def test_every_quantity_of_a_mechanism_is_an_attribute_of_its_run(dropped):
    catalogue = dropped.mechanism.quantities
    for name in set(catalogue) - set(vars(dropped)):
        np.testing.assert_array_equal(getattr(dropped, name), dropped.quantity(name), err_msg=name)
    assert set(catalogue) <= set(dir(dropped))
    assert not hasattr(dropped, "settling_time")  # a capture's
    with pytest.raises(AttributeError, match=r"has no 'peak_froce'; did you mean peak_force\?"):
        _ = dropped.peak_froce


@pytest.mark.whole
def test_every_quantity_of_a_capture_is_an_attribute_of_it():
    capture = jb.simulate(jb.table2(), jb.Scenario())
    for name in capture.mechanism.quantities:
        np.testing.assert_array_equal(getattr(capture, name), capture.quantity(name), err_msg=name)
    assert np.isnan(capture.settling_time)  # nothing latches


def test_the_first_impact_prints_numbers_with_units():
    said = repr(jb.first_impact(jb.table2()))
    assert "f64" not in said
    # 0.4891 mJ and 0.1956 kg: M79 of the model page, as in the docstring
    assert "effective mass" in said and "0.195634 kg" in said and "0.489084 mJ" in said


def test_parts_of_a_run_print_numbers_with_units(dropped):
    for part, unit in ((dropped.energy, " J"), (dropped.balance, "m or rad"), (dropped.impacts, "[N]")):
        assert unit in repr(part) and "f64" not in repr(part)
    docked = Docking(*map(jnp.asarray, (0.5, np.nan, 0.2, 0.001, 0.25, 0.01, 0.002, 0.0, np.pi / 180.0, 0.0, 4.0)))
    lines = {line.split("  ")[1]: line.split("  ")[-1].strip() for line in repr(docked).splitlines()[1:]}
    assert lines["attitude miss"] == "1 deg" and lines["lateral miss"] == "2 mm"
    assert lines["relative energy"] == "0.1 %" and lines["settling time"] == "not known s"


def test_a_certificate_prints_its_verdict_and_its_peaks():
    error = np.array([[1e-4, 2e-3]])
    peaks = Peaks(250.0, 0.1, 0, 3, 0, 200.0, 0.2, "", np.inf)
    made = Certificate(error, error, error, error, peaks, (jb.Verdict.trusted,), jb.Verdict.trusted, "fine", False, 4)
    said = repr(made)
    assert said.startswith("Certificate: TRUSTED: fine")
    assert "2.0e-03" in said and "250 N at 0.1 s, impact 4" in said and "200 N, impact 1, 20 % below" in said


def test_means_over_turns_print_their_errors_and_units():
    force, share = Mean(120.0, 2.5, "N", np.zeros(4)), Mean(0.5, 0.01, "-", np.zeros(4))
    said = str(TurnStatistics(4, share, force, force, share)).splitlines()
    assert said[0] == "Means over 4 turns"
    assert said[2].split() == ["largest", "force", "120", "±", "2.5", "N"]
    assert said[4].split() == ["contact", "share", "0.5", "±", "0.01"]


def test_limits_and_bounds_are_given_with_units():
    variable = jb.Variable("buffer.k_A", "0.1 kN/m", "3 kN/m")
    limits = jb.Limits(at_most={"stroke": "25 mm", "hinge_angle": "2 deg"}, at_least={"end_time": "100 ms"})
    assert limits.at_most == pytest.approx({"stroke": 0.025, "hinge_angle": np.radians(2.0)})
    assert limits.at_least == {"end_time": 0.1}
    problem = jb.Problem(jb.table2(), [jb.Scenario(approach_speed="20 cm/s")], [variable], limits=limits)
    assert problem.variables == (jb.Variable("buffer.k_A", 100.0, 3000.0),)
    assert problem.shown("buffer.k_A", 1500.0) == (1.5, "kN/m")


def test_limits_on_quantities_of_ones_own_are_read_in_their_unit():
    own = {"effort": jb.CustomQuantity(lambda peak_force, stroke: peak_force * stroke, "N m")}
    variables, limits = [jb.Variable("buffer.k_A", 100.0, 3000.0)], jb.Limits(at_most={"effort": "2 kN m"})
    problem = jb.Problem(jb.table2(), [jb.Scenario()], variables, limits=limits, quantities=own)
    assert problem.limits.at_most == {"effort": 2000.0}


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: jb.Limits(at_most={"stroke": "25 kN"}), "constraints.stroke = '25 kN': kN is a force, expected a"),
        (lambda: jb.Limits(at_most={"stroke": "25"}), "a text needs a unit; write 25 without quotes"),
        (
            lambda: jb.Limits(at_most={"stroke": "-1 mm"}),
            "constraints.stroke = -1 mm is out of range; allowed: (0, inf)",
        ),
        (lambda: jb.Limits(at_most={"stroke": "1 mm"}, at_least={"stroke": "2 mm"}), "contradict"),
        (lambda: bounded("1 kN", "3 kN"), "buffer.k_A low bound = '1 kN': kN is a force"),
        (lambda: bounded(100.0, "3 kN/m"), "100 has no unit; give each value one"),
        (lambda: bounded("1 kN/m", "3 kN/m"), "the start, buffer.k_A = 0.5 kN/m, is outside its bounds [1, 3] kN/m"),
        (lambda: bounded("soft", "3 kN/m"), "'soft'"),
    ],
)
def test_units_that_do_not_fit_are_refused(make, said):
    with pytest.raises(jb.InputError) as error:
        make()
    assert said in str(error.value)


def bounded(low, high):
    return jb.Problem(jb.table2(), [jb.Scenario()], [jb.Variable("buffer.k_A", low, high)])


@pytest.mark.long
def test_a_history_between_its_steps_is_differentiated():
    """Before the touchdown a bar about its end falls as a pendulum does: its derivatives come from differences too."""
    times = np.array([0.05, 0.1, 0.15])

    def gap(height):
        return jb.at_times(drop(height, history=True), times).gap[:, 0]

    step = 1e-4
    differences = (np.asarray(gap(HEIGHT + step)) - np.asarray(gap(HEIGHT - step))) / (2.0 * step)
    np.testing.assert_allclose(jax.jacfwd(gap)(HEIGHT), differences, rtol=1e-4)
    np.testing.assert_allclose(jax.jit(gap)(HEIGHT), gap(HEIGHT), rtol=1e-9)
