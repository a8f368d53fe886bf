"""The tank with ribs: its mesh, how it stands, against a frame of beams, and what a drop onto it does."""

import jax
import numpy as np
import pytest
from test_tank_plates import THICK, frame, ours, stiffnesses, tank

import jaxbuffer as jb
from in_short import quick
from jaxbuffer.mechanisms.tank_drop.assembly import assembled
from jaxbuffer.mechanisms.tank_drop.design import valid
from jaxbuffer.mechanisms.tank_drop.numbering import Numbering
from jaxbuffer.mechanisms.tank_drop.section import section, wall_mass

HIGH, SHARE = 0.005, 0.3
RIBS = {"plates.kind": "none", "ribs.kind": "rings", "ribs.height": HIGH, "ribs.share": SHARE}


@pytest.mark.quick
@pytest.mark.parametrize("refinement", quick([1, 2], 1))
def test_the_ribs_elements_have_their_mass(refinement):
    design = tank(RIBS | {"mesh.refinement": refinement})
    positions, whole = jax.jit(lambda: (section(design, 0.5).positions, wall_mass(design)))()
    numbers = Numbering.of(design)
    x, y = np.moveaxis(np.asarray(positions)[numbers.corners], -1, 0)
    areas = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
    assert areas.min() > 0.0
    count = (len(numbers.ribs) - 1) * refinement
    exact = 2.0 * 0.7 * 950.0 * (areas[:-count].sum() + SHARE * areas[-count:].sum())  # chords
    assert float(whole) == pytest.approx(exact, rel=7e-3 / refinement**2), "of arcs"

    @jax.jit
    def mass():
        parts = assembled(design, jb.TankDropScenario(fill=0.5))
        return parts.factor * parts.system.mass[: parts.slider, 1].sum()

    assert float(mass()) == pytest.approx(exact, rel=1e-9)


def test_it_sags_under_its_own_weight_as_a_frame_of_ribbed_beams(evidence):
    """The frame's corners are thin, the tank's with their ribs are not: of ribs of 10 mm the sag is 3 % less."""
    top, _, bottom = ours(RIBS)
    expected = frame(0.0, HIGH, SHARE)
    assert stiffnesses(THICK, HIGH, SHARE)[2] > 2.5 * stiffnesses(THICK)[2]
    assert bottom == pytest.approx(expected[2], rel=3e-3)
    off = abs((top - bottom) / (expected[0] - expected[2]) - 1.0)
    evidence("Drop onto a tank", "sag of the top, with ribs", off, 0.02, "a frame of beams")


def test_a_drop_on_ribs_keeps_energy_and_momentum():
    run = jb.simulate(tank(RIBS), jb.TankDropScenario(height=0.1), 0.01)
    assert run.outcome.name == "whole" and float(run.balance.energy) < 1e-4
    assert float(run.balance.linear_momentum) < 1e-10


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"ribs.height": 0.036}, r"ribs.height = 0.036 m is out of range; allowed: \(0, 0.035\) m, less than tank"),
        ({"plates.kind": "perforated"}, 'ribs.kind = "rings" and plates.kind = "perforated" are not computed together'),
        ({"material.kind": "composite"}, 'material.kind = "composite" are not computed together'),
        ({"ribs.kind": "ring"}, "did you mean rings"),
        ({"ribs.share": 1.2}, r"ribs.share = 1.2 is out of range; allowed: \(0, 1\]"),
    ],
)
def test_ribs_that_do_not_fit_are_refused(changes, said):
    with pytest.raises(jb.InputError, match=said):
        jb.simulate(tank(RIBS | changes), jb.TankDropScenario(height=0.1), 1e-3)


def test_ribs_too_high_are_not_valid_in_compiled_code():
    seen = jax.jit(lambda high: valid(tank(RIBS | {"ribs.height": high}), jb.TankDropScenario()))
    assert [bool(seen(high)) for high in (0.034, 0.036)] == [True, False]
