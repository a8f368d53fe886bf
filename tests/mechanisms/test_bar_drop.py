"""The bar dropped on a plate: an independent program's numbers, closed forms, and everything that serves it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.cli.entry import run as command
from jaxbuffer.output.records import run_record

DROP = jb.BarDropScenario(height=0.194)
LENGTH, GRAVITY, EXPONENT = 0.24, 9.81, 2.2
STIFFNESS = 48_049.0 * 1000.0**EXPONENT  # N/m^2.2
EFFECTIVE = 7850.0 * np.pi / 4.0 * 0.004**2 * LENGTH / 3.0  # kg, at the ball end


def dropped(damping, **options):
    return jb.simulate(jb.replace(jb.BarDrop(), {"impact.damping": damping}), DROP, **options)


@pytest.mark.parametrize(
    ("damping", "peak", "peak_time", "duration"),
    [
        (0.0, 550.2013, 0.2115196, 0.1514104e-3),
        (1.0, 545.9592, None, None),
        (1000.0, 1831.464, 0.2114478, None),
    ],
)
def test_an_independent_programs_numbers(damping, peak, peak_time, duration):
    """Computed in minimal coordinates with located events, to the digits shown."""
    found = dropped(damping)
    first = jax.tree.map(lambda x: float(x[0]) if x.ndim else float(x), found.impacts)
    assert first.time == pytest.approx(0.2114438851, abs=2e-10)
    assert first.approach_speed == pytest.approx(2.3894393, abs=1e-7)
    assert float(found.peak_force) == pytest.approx(peak, rel=5e-7)
    if peak_time is not None:
        assert float(found.peak_time) == pytest.approx(peak_time, abs=5e-8)
    if duration is not None:
        assert first.release_time - first.time == pytest.approx(duration, abs=2e-10)
    stays = damping == 1000.0
    assert np.isnan(first.release_time) == stays
    assert abs(float(found.balance.energy)) < 1e-6
    assert float(found.balance.drift) < 1e-8
    assert float(found.stabilisation) == 20.0


def test_closed_forms_without_a_damper():
    """δ = ((e+1) m v²/2k)^{1/(e+1)} and F = k δ^e, but for the weight's work during the impact; the ball rises again to
    the height it fell from, and F ∝ k^{1/(e+1)} m^{e/(e+1)} H^{e/(e+1)}."""
    found = dropped(0.0)
    speed = np.sqrt(3.0 * GRAVITY * 0.194)
    depth = ((EXPONENT + 1.0) * EFFECTIVE * speed**2 / (2.0 * STIFFNESS)) ** (1.0 / (EXPONENT + 1.0))
    assert float(found.quantity("penetration")) == pytest.approx(depth, rel=1e-3)
    assert float(found.peak_force) == pytest.approx(STIFFNESS * depth**EXPONENT, rel=1e-3)
    assert float(found.quantity("rebound_height")) == pytest.approx(0.194, rel=1e-6)
    assert float(found.quantity("restitution")) == pytest.approx(1.0, rel=1e-6)
    wrt = ("impact.stiffness", "bar.density", "scenario.height")
    quantities = ("peak_force", "rebound_height")
    lossless = jb.replace(jb.BarDrop(), {"impact.damping": 0.0})
    share = EXPONENT / (EXPONENT + 1.0)
    # A height moves the touchdown by 0.3 s for each unit of its logarithm, two thousand times an impact's duration: at
    # the default tolerance that leaves 1e-3 of an elasticity by it, which the certificate says.
    for rtol, of_height in ((1e-6, 2e-3), (1e-8, 2e-5)):
        certified = jb.sensitivity(lossless, DROP, wrt, quantities=quantities, rtol=rtol)
        expected = [1.0 / (EXPONENT + 1.0), share, share]
        np.testing.assert_allclose(certified.elasticities[0], expected, rtol=2e-3)  # but for the weight
        np.testing.assert_allclose(certified.elasticities[1, :2], 0.0, atol=1e-5)
        assert certified.elasticities[1, 2] == pytest.approx(1.0, abs=of_height)
        said = certified.certificate
        assert said.verdict.name == "trusted" and said.error[1, 2] > 0.9 * abs(certified.elasticities[1, 2] - 1.0)


def test_gradients_where_the_damper_decides():
    """Against differences of solves at rtol 1e-11, through jax.grad."""

    def peak(damping, rtol=1e-6):
        return jb.simulate(jb.replace(jb.BarDrop(), {"impact.damping": damping}), DROP, 0.25, rtol=rtol).peak_force

    step = 0.1
    ends = [float(peak(1000.0 + sign * step, 1e-11)) for sign in (1.0, -1.0)]
    assert float(jax.grad(peak)(1000.0)) == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=1e-4)


def test_long_steps_do_not_see_the_damper():
    """Read at a step of 1e-4 s, half of all grids see less than a hundredth of the peak of 1831 N."""
    seen = dropped(1000.0, history=True, duration=0.25, rtol=1e-9)
    time, force = np.asarray(seen.history.time), np.asarray(seen.history.contact_force[:, 0])
    largest = [np.interp(np.arange(p * 1e-4, 0.25, 1e-4), time, force).max() for p in np.linspace(0.0, 1.0, 100)]
    assert np.median(largest) < 18.3 and max(largest) > 1000.0


def test_many_at_once_and_under_vmap():
    heights = np.linspace(0.05, 0.2, 4)
    found = jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=heights))
    assert [outcome.name for outcome in found.outcomes] == ["finished"] * 4
    one = jax.vmap(lambda h: jb.simulate(jb.BarDrop(), jb.BarDropScenario(height=h)).peak_force)(jnp.asarray(heights))
    np.testing.assert_allclose(found.peak_force, one, rtol=1e-9)
    assert "drops" in repr(found) and "penetration [µm]" in repr(found)


@pytest.mark.long
def test_tuned_under_a_limit_on_penetration():
    """The least worst peak over three heights keeps to the limit, and no smaller force can: to stop the ball within
    the limit takes at least the mean force m v²/2δ."""
    problem = jb.Problem(
        jb.BarDrop(),
        [jb.BarDropScenario(height=h) for h in (0.05, 0.1, 0.194)],
        [
            jb.Variable("impact.stiffness", 1e10, 1e12),
            jb.Variable("impact.damping", 1.0, 6000.0),
            jb.Variable("impact.ramp_depth", 1e-6, 1e-4),
            jb.Variable("impact.exponent", 1.5, 2.5),
        ],
        limits=jb.Limits(at_most={"penetration": 1e-4}),
    )
    tuned = jb.tune(problem, starts=8, searches=2, rounds=2)
    least = 1.5 * GRAVITY * 0.194 * EFFECTIVE / 1e-4
    assert tuned.feasible
    assert least < tuned.objective[1] < 1.4 * least < tuned.objective[0]


def test_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drop.toml").write_text('kind = "bar_drop"\n[scenario]\nheight = 0.1\n')
    assert command(["simulate", "drop.toml", "--impact.damping", "0", "--output", "out"]) == 0
    shown = capsys.readouterr().out
    assert "from 100 mm" in shown and "delivered restitution" in shown
    assert (tmp_path / "out" / "drop.png").stat().st_size > 1000
    header = (tmp_path / "out" / "history.csv").read_text().splitlines()[0]
    assert "contact_force plate [N]" in header and "penetration [m]" in header


@pytest.mark.quick
@pytest.mark.parametrize(
    ("text", "words", "message"),
    [
        (
            'kind = "bar_dorp"',
            [],
            "choose one of bar_drop, docking3d, probe_cone, slider_crank, tank_drop; did you mean bar_drop?",
        ),
        ('kind = "bar_drop"', ["--impact.dampin", "1"], "impact.dampin is unknown; did you mean impact.damping?"),
        ('kind = "bar_drop"', ["--scenario.height", "0.3"], "scenario.height = 0.3 m is out of range"),
        ('kind = "bar_drop"', ["--impact.law", "hertz"], "has the exponent 1.5; give impact.exponent = 1.5"),
        ('kind = "bar_drop"', ["--buffer.k_A", "1"], "buffer.k_A is unknown"),
        ('kind = "bar_drop"\n[problem.objective]\nstroke = 1.0', [], "problem.objective.stroke is unknown"),
    ],
)
def test_bad_input(tmp_path, monkeypatch, capsys, text, words, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drop.toml").write_text(text + "\n")
    assert command(["simulate", "drop.toml", *words]) == 2
    assert message in capsys.readouterr().err


def test_hertz_from_the_materials():
    """A steel ball on a steel plate: K = 4/3 E* √R with E* = E/2(1-ν²)."""
    design = jb.BarDrop()
    expected = 4.0 / 3.0 * 2.07e11 / (2.0 * (1.0 - 0.3**2)) * np.sqrt(0.002)
    assert float(design.hertz_stiffness) == pytest.approx(expected, rel=1e-12)
    law = {"impact.law": "hertz", "impact.exponent": 1.5, "impact.stiffness": float(design.hertz_stiffness)}
    found = jb.simulate(jb.replace(design, law), DROP)
    energy = 0.5 * EFFECTIVE * 3.0 * GRAVITY * 0.194
    assert float(found.peak_force) == pytest.approx(expected**0.4 * (2.5 * energy) ** 0.6, rel=1e-3)


def test_a_scenario_of_another_mechanism_is_refused():
    with pytest.raises(jb.InputError, match=r"scenario = .* is not a BarDropScenario"):
        jb.simulate(jb.BarDrop(), jb.Scenario())


def test_a_bar_that_is_still_falling_has_touched_nothing():
    """From 0.194 m it touches after 0.2114 s: at 0.1 s nothing is largest, and no depth is negative."""
    run = dropped(1000.0, duration=0.1)
    assert (int(run.impact_count), int(run.peak_contact), float(run.peak_force)) == (0, -1, 0.0)
    assert float(run.quantity("penetration")) == 0.0
    assert (
        np.isnan(run.peak_time) and np.isnan(run.quantity("restitution")) and np.isnan(run.maximum_times["penetration"])
    )
    data = run.to_xarray()
    assert str(data.peak_plate.values) == "" and data.sizes["impact"] == 0
    record = run_record(run)
    assert record["peak_plate"] is None and record["peak_time"]["value"] is None
    table = jb.sweep(jb.BarDrop(), jb.BarDropScenario(height=np.array([0.05, 0.194])), duration=0.15)
    assert list(table.to_xarray().peak_plate.values) == ["plate", ""]
    assert np.isfinite(table.peak_time[0]) and np.isnan(table.peak_time[1])
    assert "-194" not in repr(run)
