"""The published slider-crank: IMPACT by components, exponents below 1, a motor's torque."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.slider_crank.blunt_impact import BluntImpact
from mechanisms.published_crank_peer import Crank

REST = jb.SliderCrankScenario(crank_speed=0.0)
CYCLE = 2.0 * np.pi / 10.0  # s


@pytest.mark.quick
@pytest.mark.parametrize("exponent", [0.01, 0.1, 0.2, 1.5])
def test_onset_leaves_the_power_law(exponent):
    """Depth of a lossless impact, ((e+1) m v²/2k)^{1/(e+1)}, and the force there; energy is the force's integral."""
    law = BluntImpact(1e4 * 1000.0**exponent, exponent, 0.0, 1e-6, 1e-8)
    depth = ((exponent + 1.0) * 0.14 * 0.25**2 / (2.0 * law.stiffness)) ** (1.0 / (exponent + 1.0))
    assert -1e-5 * depth < law.max_penetration(0.14, 0.25) - depth < 1e-8  # the onset is softer: by less than itself
    assert float(law.elastic(depth)) == pytest.approx(law.stiffness * depth**exponent, rel=1e-3)
    at = np.concatenate([np.linspace(0.0, 1e-6, 200_001), np.linspace(1e-6, 1e-4, 100_001)[1:]])
    force = np.asarray(law.elastic(at))
    work = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(at))
    assert float(law.energy(1e-4)) == pytest.approx(work, rel=1e-4)
    assert float(law.elastic(-1e-9)) == 0.0
    assert float(law.energy(-1e-9)) == pytest.approx(0.0, abs=1e-18)


@pytest.mark.long
@pytest.mark.parametrize("exponent", [0.01, 0.1, 0.2])
def test_it_runs_over_a_cycle(exponent):
    """One turn takes 2π/10 s, the torque is largest at the start, and no contact pushes but along its component."""
    run = jb.simulate(jb.published_slider_crank(exponent), REST, CYCLE + 1e-4, history=True)
    assert run.outcome.name == "finished"
    assert float(run.quantity("drive_torque")) == 1e4
    turned = np.asarray(run.history.position)[-1, 0, 2]
    assert turned == pytest.approx(2.0 * np.pi, rel=1e-3)
    along, across = jb.journal_path(run).T
    gap = np.asarray(run.history.gap)
    for k, component in enumerate((-along, along, -across, across)):  # the pin is on the rod here
        np.testing.assert_allclose(gap[:, k], 1.1e-3 - component, atol=1e-9)
    assert float(run.balance.drift) < 1e-8
    assert any("exponent below 1" in line for line in run.mechanism.view.warnings(run))


@pytest.mark.long
def test_the_onset_matters_little():
    """A tenth of it changes the first peaks by less than a per cent."""
    design = jb.published_slider_crank(0.1)
    runs = [jb.simulate(jb.replace(design, {"piston_pin.onset_depth": e}), REST, 0.06) for e in (1e-8, 1e-9)]
    one, other = (np.asarray(run.impacts.peak_force)[:5] for run in runs)
    np.testing.assert_allclose(one, other, rtol=1e-2)


def test_force_grows_with_stiffness_and_falls_with_the_exponent():
    """In millimetres δ < 1, so that δ^e falls as e grows: the seed says the opposite."""

    def largest(*numbers):
        return float(jb.simulate(jb.published_slider_crank(*numbers), REST, 0.1).peak_force)

    assert largest(0.01) > largest(0.1) > largest(0.2)
    assert largest(0.2, 1e5) > largest(0.2, 1e4)


@pytest.mark.parametrize("numbers", [(0.01, 1e4, 1e7), (0.1, 1e4, 1e7), (0.2, 1e4, 1e7), (0.1, 2e4, 1e5)])
def test_a_second_program_has_the_same_first_impacts(numbers):
    """SciPy's Radau and DOP853 in minimal coordinates: times, approach speeds and peaks of the first four."""
    exponent, stiffness, torque = numbers
    design = jb.replace(jb.published_slider_crank(exponent, stiffness), {"drive.torque": 1e-3 * torque})
    impacts = jb.simulate(design, REST, 0.06, rtol=1e-8).impacts
    ours = np.stack(
        [np.asarray(part)[:4] for part in (impacts.time, impacts.approach_speed, impacts.peak_force)], axis=1
    )
    np.testing.assert_allclose(ours, Crank(*numbers).run(4, 0.06), rtol=1e-5)
