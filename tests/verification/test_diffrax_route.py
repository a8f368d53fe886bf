"""Whole captures through `diffrax.diffeqsolve`, against the loop with the same smooth law and against the reference."""

from functools import cache

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run
from verification.cases import CASES, PARAMETERS, PATHS

TOPIC, SAME_LAW = "Regularisation and stabilisation", "the loop with located events, same law, rtol 1e-10"
EXACT = "reference capture of the exact model"
QUANTITIES = ("peak_force", "end_time", "stroke", "hinge_angle")
TSIT5 = jb.Diffrax(diffrax.Tsit5())


@cache
def capture(name, rtol=1e-8, solver=TSIT5):
    """Of a reference case, with the smooth law; arrays, so that all cases share one program."""
    case = CASES[name]
    design, scenario = jax.tree.map(lambda leaf: jnp.asarray(leaf, float), (case.design, case.scenario))
    memory = "event" if solver else "smooth"
    return jb.simulate(jb.replace(design, {"contact.memory": memory}), scenario, rtol=rtol, solver=solver)


@pytest.mark.long
@pytest.mark.parametrize("name", ["table2", "table2-fast", "random-1-4", "random-1-12"])
def test_captures_are_those_of_the_loop(name, evidence):
    """Of the same law; measured 2e-6, of which the interpolation between steps has the most."""
    ours, theirs = capture(name, 1e-10, None), capture(name)
    assert theirs.design.contact.memory == "smooth"
    assert theirs.outcome.name == ours.outcome.name == CASES[name].values["outcome"]
    assert int(theirs.impact_count) == int(ours.impact_count)
    for quantity in QUANTITIES:
        off = abs(float(getattr(theirs, quantity)) / float(getattr(ours, quantity)) - 1.0)
        evidence(TOPIC, f"through diffrax.diffeqsolve (Tsit5, rtol 1e-8): {quantity}", off, 1e-5, SAME_LAW, detail=name)
    np.testing.assert_allclose(theirs.contact_time, ours.contact_time, rtol=1e-4)
    np.testing.assert_allclose(theirs.impacts.peak_force[:4], ours.impacts.peak_force[:4], rtol=1e-4)


@pytest.mark.parametrize("name", ["table2", "table2-fast", "random-1-4"])
def test_captures_are_within_the_laws_bias_of_the_reference(name, evidence):
    """Which is 1e-5 in these cases (`test_smooth_law`), 5e-5 in the stroke."""
    for quantity, bias in (("peak_force", 1e-5), ("end_time", 1e-5), ("stroke", 5e-5)):
        off = abs(float(getattr(capture(name), quantity)) / CASES[name].values[quantity] - 1.0)
        claim = f"through diffrax.diffeqsolve, smooth law: {quantity}"
        evidence(TOPIC, claim, off, bias, EXACT, detail=name)


IMPLICIT = {
    "Kvaerno5, Table 2": (diffrax.Kvaerno5, jb.table2(), jb.Scenario(), None),
    "Kvaerno3, Table 2": (diffrax.Kvaerno3, jb.table2(), jb.Scenario(), None),
    "KenCarp4, Table 2": (diffrax.KenCarp4, jb.table2(), jb.Scenario(), None),
    "Kvaerno5, rigid probe": (diffrax.Kvaerno5, jb.rigid_probe(), jb.Scenario(), 0.05),
    "Kvaerno5, sticking free tip": (
        *(diffrax.Kvaerno5, jb.replace(jb.table2(), {"probe.free_tip": True, "contact.friction": 1.0}), jb.Scenario()),
        None,
    ),
    "Kvaerno5, bar": (diffrax.Kvaerno5, jb.BarDrop(), jb.BarDropScenario(height=0.05), 0.2),
    "Kvaerno5, slider-crank": (diffrax.Kvaerno5, jb.SliderCrank(), jb.SliderCrankScenario(), 0.01),
}


@pytest.mark.long
@pytest.mark.parametrize("name", IMPLICIT)
def test_implicit_methods(name, evidence):
    """The first impact and the largest force are those of the loop with the same law."""
    method, design, scenario, duration = IMPLICIT[name]
    rtol = 1e-7 if method is diffrax.Kvaerno3 else 1e-8  # of order 3: 1e-8 takes more than 16 384 steps
    run = jb.simulate(design, scenario, duration, rtol=rtol, solver=jb.Diffrax(method()))
    exact = jb.simulate(run.design, scenario, duration, rtol=1e-10)
    assert run.outcome is exact.outcome and int(run.impact_count) == int(exact.impact_count)
    claim = "through diffrax.diffeqsolve, implicit methods: largest force"
    evidence(TOPIC, claim, abs(float(run.peak_force / exact.peak_force) - 1.0), 1e-5, SAME_LAW, detail=name)
    np.testing.assert_allclose(run.impacts.peak_force[0], exact.impacts.peak_force[0], rtol=1e-5)


@pytest.mark.long
def test_what_follows_from_a_capture():
    """A history, the energy and failures are those of any capture."""
    options = {"rtol": 1e-8, "solver": TSIT5, "history": True, "max_steps": 1000}
    short = jb.simulate(jb.table2(), duration=0.02, **options)
    assert short.outcome is jb.Outcome.timeout
    assert short.history.time[0] == 0.0
    np.testing.assert_allclose(short.history.time[-1], 0.02)
    np.testing.assert_allclose(np.max(short.history.contact_force), short.peak_force, rtol=1e-2)
    np.testing.assert_allclose(short.history.energy.total, CASES["table2"].values["initial_energy"], rtol=1e-6)
    whole = jb.simulate(jb.table2(), **options)
    assert whole.outcome is jb.Outcome.failed_steps
    assert np.isnan(whole.peak_force)


def solved(design, solver, **options):
    """Table 2's problem for a design, integrated."""
    problem = jb.as_diffrax(design)
    controller = diffrax.PIDController(rtol=1e-8, atol=1e-8 * problem.scales, pcoeff=0.3, icoeff=0.4)
    given = {"args": problem.args, "event": problem.event, "stepsize_controller": controller} | options
    end, method = given.pop("duration", 8.0), problem.method(solver)
    return diffrax.diffeqsolve(problem.term_for(solver), method, 0.0, end, problem.dt0, problem.y0, **given)


def test_the_literal_call():
    """Its event ends the solve as captured, at the capture's time; observables are saved by name."""
    problem, whole = jb.as_diffrax(jb.table2()), capture("table2")
    saved = [diffrax.SubSaveAt(t1=True), diffrax.SubSaveAt(steps=True, fn=problem.observe)]
    solution = solved(jb.table2(), diffrax.Tsit5(), saveat=diffrax.SaveAt(subs=saved), max_steps=8192)
    assert bool(solution.event_mask)
    assert int(problem.ended_by(solution.ys[0][0], problem.args)) == jb.Outcome.captured
    # Both are solves at rtol 1e-8, of other steps, after two dozen impacts.
    np.testing.assert_allclose(solution.ts[0], whole.end_time, rtol=1e-7)
    stroke = solution.ys[1]["stroke"]
    np.testing.assert_allclose(np.max(stroke[np.isfinite(stroke)]), whole.stroke, rtol=1e-5)


@pytest.mark.long
def test_adjoints():
    """Backwards through checkpoints and forwards, the derivative of the first impact's force is the same."""
    duration, paths = 2e-4, [PATHS[parameter] for parameter in PARAMETERS]
    values = jnp.array([jb.get(jb.table2(), path) for path in paths])

    def force(values, adjoint):
        design = jb.replace(jb.table2(), dict(zip(paths, values, strict=True)))
        saveat = diffrax.SaveAt(ts=[7e-5], fn=jb.as_diffrax(design).normal_forces)
        options = {"duration": duration, "saveat": saveat, "adjoint": adjoint, "max_steps": 512}
        return solved(design, diffrax.Bosh3(), **options).ys[0, 0]

    direction = values * jnp.arange(1.0, 6.0)
    backwards = jax.grad(force)(values, diffrax.RecursiveCheckpointAdjoint()) @ direction
    forwards = jax.jvp(lambda values: force(values, diffrax.ForwardMode()), (values,), (direction,))[1]
    np.testing.assert_allclose(forwards, backwards, rtol=1e-8)


@pytest.mark.long
def test_elasticities_under_error_control():
    """Of Table 2's peak force; differentiated through the solve, Tsit5's would be off by 0.2 at rtol 1e-8."""
    reference = np.array([CASES["table2"].values["elasticity"][parameter] for parameter in PARAMETERS])
    paths = [PATHS[parameter] for parameter in PARAMETERS]
    logs = jnp.log(jnp.array([jb.get(jb.table2(), path) for path in paths]))

    def log_peak(logs):
        design = jb.replace(jb.table2(), dict(zip(paths, jnp.exp(logs), strict=True)))
        return jnp.log(jb.simulate(design, rtol=1e-8, solver=jb.Diffrax(diffrax.Kvaerno5())).peak_force)

    assert np.max(np.abs(jax.jit(jax.jacfwd(log_peak))(logs) / reference - 1.0)) < 5e-3


def test_the_command_line(capsys):
    assert run(["simulate", "--solver", "diffrax:Tsit5", "--rtol", "1e-8"]) == 0
    assert "captured" in (told := capsys.readouterr().out)
    assert f"peak contact force   {capture('table2').peak_force:.2f} N" in told


@pytest.mark.parametrize("call", [jb.as_diffrax, lambda design: jb.simulate(design, solver=TSIT5)])
def test_a_force_that_jumps_has_no_smooth_law(call):
    with pytest.raises(jb.InputError, match=r"contact\.law = 'kelvin-voigt': its force jumps at touchdown"):
        call(jb.replace(jb.table2(), {"contact.law": "kelvin-voigt"}))
