"""What is taken although it could have been refused, and what is said of a choice that the program made."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import Outcome, Scenario, replace, sensitivity, table2
from jaxbuffer.cli.entry import run
from jaxbuffer.errors import nearest, suggest
from jaxbuffer.hybrid import DiagonallyImplicit, solver_named
from jaxbuffer.mechanisms.probe_cone.label import scenario_label
from jaxbuffer.mechanisms.probe_cone.quantities import QUANTITIES
from jaxbuffer.sensitivities.gradients import Gradients
from jaxbuffer.sensitivities.result import sensitivity_rows
from jaxbuffer.study.load import load
from made_up import made_up_capture

FORTY = "\n".join(f"[[scenarios]]\napproach_speed = {0.1 + k / 400}\nmisalignment = 0.01" for k in range(40))


def test_a_byte_order_mark_is_no_part_of_a_study(tmp_path):
    (tmp_path / "study.toml").write_bytes(b"\xef\xbb\xbf[buffer]\r\nk_A = 800\r\n")
    assert load(tmp_path / "study.toml").design.buffer.k_A == 800.0


def test_lists_and_tuples_are_arrays_and_all_kinds_of_numbers_floats():
    design = replace(table2(), {"buffer.k_A": [400, 500.0], "buffer.c_A": 7, "probe.tip_mass": np.float32(0.5)})
    np.testing.assert_array_equal(design.buffer.k_A, np.array([400.0, 500.0]))
    assert type(design.buffer.c_A) is float and type(design.probe.tip_mass) is float
    assert design.probe.tip_mass == 0.5
    speeds = Scenario(approach_speed=(jnp.asarray(0.1), 0.2)).approach_speed
    np.testing.assert_array_equal(np.asarray(speeds), [0.1, 0.2])


def test_a_solver_may_be_named():
    assert isinstance(solver_named("implicit"), DiagonallyImplicit)
    own = DiagonallyImplicit(safety_factor=3.0)
    assert solver_named(own) is own


@pytest.mark.parametrize(
    ("typed", "known", "meant"),
    [
        ("kA", ("k_A", "c_A", "k_T"), "k_A"),
        ("speed", ("approach_speed", "misalignment"), "approach_speed"),
        ("buffer.kA", ("buffer.k_A", "contact.law"), "buffer.k_A"),
        ("k_A", ("buffer.k_A", "probe.length"), "buffer.k_A"),
        ("options.foo", ("options.rtol", "options.duration"), None),
        ("engine.k_A", ("buffer.k_A",), None),
        ("", ("a", "b"), None),
    ],
)
def test_only_close_names_are_advised(typed, known, meant):
    assert nearest(typed, known) == meant
    if meant is None:
        assert suggest(typed, known).startswith("; known: ")


def test_scenarios_are_told_apart_by_their_values():
    slow, fast = Scenario(approach_speed=0.1), Scenario(approach_speed=0.2, misalignment=np.radians(3.0))
    assert (scenario_label(slow), scenario_label(fast)) == ("0.1 m/s, 0°", "0.2 m/s, +3°")
    turning = Scenario(passive_rate=0.05)
    assert scenario_label(turning, (slow, turning)) == "0.1 m/s, 0°, passive rate 2.86479 deg/s"
    assert scenario_label(Scenario(misalignment=-0.0)) == "0.1 m/s, 0°"


@pytest.mark.parametrize("command", ["simulate", "sensitivity"])
def test_which_of_several_scenarios_is_run(computed, capsys, tmp_path, command):
    (tmp_path / "study.toml").write_text(FORTY)
    assert run([command, "study.toml"]) == 0
    shown = capsys.readouterr()
    assert "note: running the first of 40 scenarios, 0.1 m/s, +0.573°; --scenario-number N takes another" in shown.err
    assert computed.calls[-1][1]["scenario"].approach_speed == 0.1
    assert run([command, "study.toml", "--scenario-number", "40"]) == 0
    shown = capsys.readouterr()
    assert "note" not in shown.err and "0.1975 m/s, +0.573°" in shown.out
    assert computed.calls[-1][1]["scenario"].approach_speed == 0.1975


def test_a_scenario_of_its_own_comes_before_the_list(computed, capsys, tmp_path):
    (tmp_path / "study.toml").write_text(f"[scenario]\napproach_speed = 0.3\n{FORTY}")
    assert run(["simulate", "study.toml"]) == 0
    assert "note: running [scenario], 0.3 m/s, 0°; --scenario-number N" in capsys.readouterr().err


def test_the_summary_says_which_scenario_it_is_of(computed, capsys):
    assert run(["simulate", "--scenario.approach_speed", "0.2", "--scenario.misalignment", "0.05235987755982988"]) == 0
    shown = capsys.readouterr()
    assert "scenario             0.2 m/s, +3°" in shown.out and "note" not in shown.err


@pytest.fixture
def escaped(monkeypatch):
    """A sensitivity of an escaped run, margin -0.3 m, by k_A = 500 N/m: 2 a unit for every quantity."""
    capture = eqx.tree_at(lambda c: c.capture_margin, made_up_capture(outcome=Outcome.escaped), jnp.asarray(-0.3))
    results = jnp.stack([jnp.asarray(quantity.of(capture), float) for quantity in QUANTITIES.values()])
    found = Gradients(capture, results, jnp.full((len(QUANTITIES), 1), 2.0), {"peak_force": jnp.zeros((3, 1))})
    monkeypatch.setattr("jaxbuffer.sensitivities.sensitivity.gradients", lambda *_, **__: found)
    names = ("peak_force", "capture_margin", "throat_distance")
    return sensitivity(table2(), wrt=("buffer.k_A",), quantities=names, certify="none")


def test_quantities_that_can_change_sign_have_derivatives_and_no_elasticities(escaped):
    """dp/dk k/p = 2 · 500/250 of the force; of a margin of -0.3 m it would be negative where the margin grows."""
    assert escaped.elasticities[0, 0] == pytest.approx(2.0 * 500.0 / 250.0)
    assert np.isnan(escaped.elasticities[1:]).all() and (escaped.gradients == 2.0).all()
    shown = repr(escaped)
    elasticities, derivatives = shown.split("Derivatives of quantities that can change sign")
    assert "capture_margin" not in elasticities and "peak_force" in elasticities
    assert "capture_margin" in derivatives and "+2000 mm/(N/m)" in derivatives and "-300 mm" in derivatives
    header, rows = sensitivity_rows(escaped)
    by_name = {row[0]: dict(zip(header, row, strict=True)) for row in rows}
    assert by_name["peak_force"]["elasticity [-]"] == pytest.approx(4.0)
    assert by_name["capture_margin"]["elasticity [-]"] is None and by_name["capture_margin"]["gradient"] == 2.0


def test_a_scenario_of_a_grid_is_run_by_its_number(computed, tmp_path, capsys):
    """Grids set numbers of the design too: the run is that of the load case of this number of the problem."""
    path = tmp_path / "study.toml"
    grid = '[problem.grid]\napproach_speed = [0.1, 0.2]\n"buffer.k_A" = [300, 900]\n'
    path.write_text(f"{grid}[problem.variables]\nbuffer.c_A = [1, 50]\n")
    assert run(["simulate", str(path), "--scenario-number", "3"]) == 0
    case = load(path).problem().cases[2]
    asked = computed.calls[-1][1]
    assert (asked["scenario"], asked["design"]) == (case.scenario, case.of(table2()))
    assert asked["scenario"].approach_speed == 0.2 and asked["design"].buffer.k_A == 300.0
    assert run(["simulate", str(path), "--scenario-number", "5"]) == 2
    assert "--scenario-number 5 must be a whole number from 1 to 4" in capsys.readouterr().err
