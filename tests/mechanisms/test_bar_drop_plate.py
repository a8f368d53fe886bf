"""The dropped bar where the plate or the bar bends: an independent program in minimal coordinates, limits, energy."""

import numpy as np
import pytest

import jaxbuffer as jb
from mechanisms.bar_drop_peer import Drop

SCENARIO = jb.BarDropScenario(height=0.194)
PEER = "an independent program in minimal coordinates (SciPy, located events)"
TOPIC = "The dropped bar"
DURATION = 0.216  # s
PATHS = {
    "plate.thickness": ("thickness", 0.006),
    "impact.stiffness": ("stiffness", 48_049.0 * 1000.0**2.2),
    "impact.damping": ("damping", 1000.0),
    "scenario.height": ("height", 0.194),
}


def design(**changes):
    """A bar drop with changes such as plate__modes=8."""
    return jb.replace(jb.BarDrop(), {name.replace("__", "."): value for name, value in changes.items()})


def dropped(duration=DURATION, rtol=1e-9, solver="explicit", **changes):
    return jb.simulate(design(**changes), SCENARIO, duration, rtol=rtol, solver=solver)


@pytest.mark.long
def test_known_numbers_of_a_plate_in_eight_modes(evidence):
    """Peak 1810.679 N at 0.2114478 s, second touch 0.21474 s with 4.865 N, deflection 30.851 µm, printed beforehand."""
    tight = dropped(plate__modes=8)
    peak, touched = float(tight.peak_force), np.asarray(tight.impacts.peak_force)[1]
    assert peak == pytest.approx(1810.679, abs=6e-4)
    assert float(tight.peak_time) == pytest.approx(0.2114478, abs=6e-8)
    assert touched == pytest.approx(4.865, abs=6e-4)
    peer = Drop(plate_modes=8).run(DURATION)
    found = np.asarray(tight.impacts.time)[:2]
    evidence(TOPIC, "peak on a bending plate, 8 modes", abs(peak / peer.impacts[0, 1] - 1.0), 1e-6, PEER)
    evidence(TOPIC, "second touch's force", abs(touched / peer.impacts[1, 1] - 1.0), 1e-4, PEER)
    evidence(TOPIC, "times of both touchdowns", np.abs(found - peer.impacts[:2, 0]).max(), 1e-8, PEER, "s")
    bent = float(tight.quantity("plate_deflection"))
    evidence(TOPIC, "largest deflection of the plate", abs(bent / peer.deflection - 1.0), 1e-5, PEER)
    assert abs(float(tight.balance.energy)) < 1e-6 and float(tight.balance.drift) < 1e-8
    default = dropped(plate__modes=8, rtol=1e-6, solver=None)
    evidence(TOPIC, "the same peak at default settings", abs(float(default.peak_force) / peak - 1.0), 2e-6, PEER)
    assert abs(float(default.balance.energy)) < 1e-6
    text = repr(default)
    assert "plate modes              8, of which 4 move its middle" in text and "too few" in text


@pytest.mark.long
def test_elasticities_of_peak_and_deflection(evidence):
    """Against differences of the independent program's runs."""
    found = jb.sensitivity(
        design(plate__modes=8),
        SCENARIO,
        tuple(PATHS),
        quantities=("peak_force", "plate_deflection"),
        duration=DURATION,
        rtol=1e-9,
    )
    step, expected = 1e-3, []
    for name, value in PATHS.values():
        ends = [Drop(plate_modes=8, **{name: value * np.exp(sign * step)}).run(DURATION) for sign in (1.0, -1.0)]
        logs = np.log([[run.impacts[0, 1], run.deflection] for run in ends])
        expected.append((logs[0] - logs[1]) / (2.0 * step))
    off = np.abs(np.asarray(found.elasticities) - np.array(expected).T).max(axis=1)
    evidence(TOPIC, "elasticities of the peak on a bending plate", off[0], 1e-4, PEER)
    evidence(TOPIC, "elasticities of its deflection", off[1], 1e-3, PEER, detail=f"{np.array(expected).T.tolist()}")


def test_a_clamped_plate(evidence):
    found = dropped(plate__modes=8, plate__support="clamped")
    peer = Drop(plate_modes=8, support="clamped").run(DURATION)
    error = abs(float(found.peak_force) / peer.impacts[0, 1] - 1.0)
    evidence(TOPIC, "peak on a clamped plate, 8 modes", error, 1e-6, PEER)
    bent = float(found.quantity("plate_deflection"))
    evidence(TOPIC, "deflection of a clamped plate", abs(bent / peer.deflection - 1.0), 1e-5, PEER)


@pytest.mark.parametrize(("damping", "thicknesses"), [(0.0, (0.03, 0.12)), (1000.0, (0.06, 6.0))])
def test_a_thick_plate_is_a_rigid_one(damping, thicknesses):
    """What the bending takes from the peak falls off faster than 1/h, as it would with the plate's mass alone."""
    rigid = float(dropped(0.213, impact__damping=damping).peak_force)
    off = []
    for thickness in thicknesses:
        changes = {"plate__modes": 8, "impact__damping": damping, "plate__thickness": thickness}
        off.append(1.0 - float(dropped(0.213, 1e-8, None, **changes).peak_force) / rigid)
    assert 0.0 < off[1] < off[0] * thicknesses[0] / thicknesses[1], off


@pytest.mark.long
@pytest.mark.parametrize(("damping", "enough"), [(0.0, (16, 24)), (1000.0, (32, 48))])
def test_how_many_modes_the_peak_takes(damping, enough):
    """So many for 1e-3 and 1e-4 of the peak with 64, and no warning from there on; half as many are warned of."""

    def run(modes):
        return dropped(0.213, 1e-7, plate__modes=modes, impact__damping=damping)

    most = float(run(64).peak_force)
    for modes, tolerance in zip(enough, (1e-3, 1e-4), strict=True):
        found = run(modes)
        assert abs(float(found.peak_force) / most - 1.0) < tolerance
        assert "too few" not in repr(found)
    few = run(enough[0] // 2)
    assert abs(float(few.peak_force) / most - 1.0) > 1e-3 and "too few" in repr(few)


@pytest.mark.parametrize(("modes", "plate"), [(4, 0), (4, 4)])
def test_a_bar_that_bends(evidence, modes, plate):
    """The peer's modes are zero at the hinge, ours are a free bar's: their axes differ by squares of the deflection's
    slope, which grows with the first impact, and of the spin over the first frequency."""
    duration = 0.2135
    found = dropped(duration, bar__modes=modes, plate__modes=plate)
    peer = Drop(bar_modes=modes, plate_modes=plate).run(duration).impacts
    ours = np.array([found.impacts.time, found.impacts.peak_force])[:, : len(peer)]
    where = f"bar in {modes} modes, plate in {plate}"
    off, slope = np.abs(ours[1] / peer[:, 1] - 1.0), np.pi * float(found.quantity("bar_deflection")) / 0.24
    evidence(TOPIC, f"first peak: {where}", off[0], 1e-5, PEER)
    evidence(TOPIC, f"all peaks: {where}", off.max(), slope**2, PEER, detail="to the slope's square")
    evidence(TOPIC, f"first touchdown: {where}", abs(ours[0, 0] - peer[0, 0]), 1e-8, PEER, "s")
    evidence(TOPIC, f"all touchdowns: {where}", np.abs(ours[0] - peer[:, 0]).max(), 1e-6, PEER, "s")
    assert abs(float(found.balance.energy)) < 1e-6 and float(found.balance.drift) < 1e-8


@pytest.mark.slow
def test_a_plate_that_rings_for_thousands_of_steps_keeps_its_energy(evidence):
    """Without damping it rings on at full size, and each step loses a little."""
    found = dropped(0.4, 1e-6, None, plate__modes=8, plate__damping_ratio=0.0)
    assert int(found.accepted) > 5000
    evidence(TOPIC, "energy of a plate that rings undamped", abs(float(found.balance.energy)), 1e-6, "its balance")


def test_a_stiff_bar_is_a_rigid_one():
    """Without a damper, which would feel waves in any bar; the rest is the time a force takes along the bar."""
    rigid = float(dropped(0.213, impact__damping=0.0).peak_force)
    off = []
    for modulus in (2e17, 2e19):
        changes = {"bar__modes": 2, "bar__young_modulus": modulus, "impact__damping": 0.0}
        off.append(abs(float(dropped(0.213, 1e-7, None, **changes).peak_force) / rigid - 1.0))
    assert off[1] < 0.02 * off[0] and off[1] < 1e-4


@pytest.mark.quick
def test_one_mode_of_a_free_bar_is_refused():
    with pytest.raises(jb.InputError, match=r"bar.modes = 1: both ends move and turn, which takes 2 modes"):
        jb.replace(jb.BarDrop(), {"bar.modes": 1})


@pytest.mark.long
def test_history_figure_and_multipliers(tmp_path):
    from jaxbuffer.output.figures import run_figure
    from jaxbuffer.output.records import run_history, run_record

    run = jb.simulate(design(plate__modes=4, bar__modes=2), SCENARIO, 0.213, history=True)
    heads, _ = run_history(run)
    assert {"plate_deflection [m]", "bar_deflection [m]", "multiplier plate moment [N m]"} <= set(heads)
    assert run_record(run)["modes"] == {"plate": 4, "bar": 2}
    titles = [axes.get_title(loc="left") for axes in run_figure(run).axes]
    assert any("Deflection of the plate" in title and "4 modes" in title for title in titles)
    weight = 9.81 * float(run.design.bar.mass)
    assert np.asarray(run.history.multipliers)[0, 3] == pytest.approx(0.0, abs=1e-6 * weight)  # plate y, at the start
