"""Play in the hinge (M109): first impact, limits, gradients and balance against an independent program."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.testing import assert_allclose

import jaxbuffer as jb
from in_short import often
from jaxbuffer import InputError, replace, table2
from jaxbuffer.contact.laws import DampedHertz, free_impact
from verification.exact_bending import BendingModel

FIRST = 1e-3  # s, longer than a first impact
SOURCE = "Lagrange's equations in SciPy, tests/verification/exact_bending.py"
TOPIC = "Play in the hinge"


def loose(play, **changes):
    return replace(table2(), {"hinge.play": play} | changes)


def first(design, rtol=1e-9):
    return jb.simulate(design, duration=FIRST, rtol=rtol)


@pytest.mark.parametrize("play", [1e-5, 1e-6, 1e-8])
def test_first_impact_of_an_independent_program(evidence, play):
    design = loose(play)
    run = first(design)
    contact, hinge = BendingModel(design, jb.Scenario()).impacts(FIRST)
    evidence(TOPIC, "first impact's peak", abs(float(run.peak_force) / contact - 1.0), 1e-6, SOURCE, "relative")
    evidence(TOPIC, "hinge force in it", abs(float(run.peak_hinge_force) / hinge - 1.0), 1e-6, SOURCE, "relative")


def test_less_play_tends_to_none(evidence):
    """The first peak and the time of capture; the force in the hinge does not: the pin bounces."""
    held, plays = jb.simulate(table2()), (1e-7, 1e-8, 1e-9)
    rigid = float(first(table2()).peak_force)
    off = [abs(float(first(loose(play)).peak_force) / rigid - 1.0) for play in plays]
    assert off[0] > 3.0 * off[1] > 9.0 * off[2]
    ends = [float(jb.simulate(loose(play)).end_time) for play in plays]
    times = [abs(end / float(held.end_time) - 1.0) for end in ends]
    assert times[0] > 3.0 * times[1] > 9.0 * times[2]
    shown = ", ".join(f"{x:.1e}" for x in (*off, *times))
    evidence(TOPIC, "first peak with 1 nm of play", off[2], 2e-3, "the hinge that holds", "relative", shown)
    evidence(TOPIC, "time of capture with 1 nm of play", times[2], 2e-4, "the hinge that holds", "relative", shown)


@pytest.mark.slow
@pytest.mark.parametrize("play", often([1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9], 1e-4, 1e-7))
def test_runs_are_solved_with_hardly_any_play(play):
    runs = [
        jb.simulate(loose(play * factor), rtol=rtol) for factor in np.geomspace(0.8, 1.25, 20) for rtol in (1e-6, 5e-7)
    ]
    assert [run.outcome.name for run in runs if run.outcome.failed] == []


def test_first_impact_without_the_vehicle_meets_the_closed_form(evidence):
    """Until the pin has crossed its play, no force but the torsional spring's ties the vehicle to the cylinder."""
    buffer = {"buffer.k_A": 1.0, "buffer.c_A": 0.0, "buffer.k_T": 1.0, "buffer.c_T": 0.0}
    design = loose(1e-3, **{"contact.friction": 0.0}, **buffer)
    expected = float(jb.first_impact(design).predicted_peak)
    error = abs(float(first(design).peak_force) / expected - 1.0)
    evidence(TOPIC, "first peak before the pin touches", error, 1e-6, "closed form (M79, M81)", "relative")


@pytest.mark.long
def test_elasticities_of_the_first_impact(evidence):
    """Hinge force and contact force by play and by a buffer's number."""
    design, names = loose(1e-8), ("peak_force", "peak_hinge_force")
    paths = ["hinge.play", "hinge.damping", "buffer.k_T"]
    found = jb.sensitivity(design, duration=2.4e-4, wrt=paths, quantities=names, rtol=1e-9, certify="none")

    def peaks(path, factor):
        changed = replace(design, {path: jb.get(design, path) * factor})
        return np.array(BendingModel(changed, jb.Scenario()).impacts(2.4e-4, rtol=1e-12, max_step=5e-6))

    for path, mine in zip(paths, found.elasticities.T, strict=True):
        narrow, wide = (
            np.log(peaks(path, 1.0 + s) / peaks(path, 1.0 - s)) / np.log((1.0 + s) / (1.0 - s)) for s in (3e-3, 6e-3)
        )
        expected = (4.0 * narrow - wide) / 3.0
        for name, elasticity, other in zip(names, mine, expected, strict=True):
            evidence(TOPIC, f"elasticity of {name} by {path}", abs(elasticity - other), 1e-4, SOURCE, "",
                     f"{elasticity:.6g}")  # fmt: skip


@pytest.mark.parametrize("play", [1e-5, 1e-4, 2e-4])
def test_a_whole_capture_conserves(evidence, play):
    run = jb.simulate(loose(play))
    assert run.outcome.name == "captured"
    for name, tolerance in (("energy", 1e-6), ("linear_momentum", 1e-8), ("angular_momentum", 1e-8), ("drift", 1e-8)):
        error = abs(float(getattr(run.balance, name)))
        evidence(TOPIC, f"{name} of whole captures", error, tolerance, "conservation", "m" if name == "drift" else "")


@pytest.mark.long
def test_the_pin_stays_in_its_bush_and_its_force_is_the_vehicles():
    run = jb.simulate(loose(1e-4), history=True)
    gap, force = np.asarray(run.history.hinge_gap), np.asarray(run.history.hinge_force)
    pin, bush, play = 0.0049, 0.005, 1e-4
    stiffness = 4.0 / 3.0 * 71.7e9 / (2.0 * (1.0 - 0.3**2)) * np.sqrt(pin * bush / play)
    deepest = (np.max(force) / stiffness) ** (2.0 / 3.0)  # the damping vanishes where the pin is deepest
    assert_allclose(-np.min(gap), deepest, rtol=0.03)
    assert np.max(gap) <= 1e-4 * (1.0 + 1e-9)
    assert np.all(force[gap > 1e-9] < 1e-6)
    assert np.max(force) > 100.0
    assert int(run.impact_count) == len([k for k in np.asarray(run.impacts.contact) if k >= 0])
    text = str(run)
    assert "play in the hinge    0.1 mm; the pin goes up to" in text
    assert "hinge's play " in text
    assert "the play is too small for Hertz's law" not in text
    assert "the play is too small for Hertz's law" in str(jb.simulate(loose(1e-6)))


@pytest.mark.parametrize("speed", [0.01, 0.3])
def test_the_pins_law_against_its_integration(speed):
    law = DampedHertz(2.6e10, 5.0)
    run = free_impact(law, 0.7, speed)
    assert_allclose(law.delivered_restitution(0.7, speed), run.restitution, rtol=1e-8)
    assert_allclose(law.max_penetration(0.7, speed), run.max_penetration, rtol=1e-8)
    assert_allclose(run.restitution, 1.0 - 2.0 / 3.0 * 5.0 * speed, atol=0.5 * (5.0 * speed) ** 2)


@pytest.mark.long
def test_many_plays_at_once():
    plays = np.array([1e-7, 1e-5])
    one = [[float(x) for x in (run.peak_force, run.peak_hinge_force)] for run in (first(loose(p), 1e-6) for p in plays)]

    def peaks(play):
        run = jb.simulate(loose(play), duration=FIRST)
        return jnp.stack([run.peak_force, run.peak_hinge_force])

    assert_allclose(jax.vmap(peaks)(jnp.asarray(plays)), one, rtol=1e-5)
    found = jb.sweep(loose(plays), jb.Scenario(), FIRST)
    assert_allclose(found.peak_force, [row[0] for row in one], rtol=1e-6)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"hinge.play": 0.0}, "hinge.play = 0 m is out of range; allowed: (0, inf) m"),
        (
            {"hinge.play": 0.005},
            "hinge.play = 0.005 m is out of range; allowed: (0, 0.005) m; below hinge.bush_radius",
        ),
        ({"hinge.play": -1e-4}, "hinge.play = -0.0001 m is out of range; allowed: (0, inf) m"),
        ({"hinge.damping": -1.0}, "hinge.damping = -1 s/m is out of range; allowed: [0, inf) s/m"),
        ({"hinge.bush_radius": 0.0}, "hinge.bush_radius = 0 m is out of range; allowed: (0, inf) m"),
        ({"hinge.poisson_ratio": 0.6}, "hinge.poisson_ratio = 0.6 is out of range; allowed: (-1, 0.5]"),
    ],
)
def test_bad_numbers_are_named(values, message):
    with pytest.raises(InputError) as caught:
        replace(table2(), values)
    assert str(caught.value) == message
