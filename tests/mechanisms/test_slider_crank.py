"""The slider-crank with play: independent programs' impacts, closed forms without play, both drives, both pins."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from slider_cranks import (
    DESIGNS,
    REFERENCE,
    SPEED,
    TURN,
    built,
    first_impact,
    pinned,
    slider_acceleration,
    slider_position,
)

import jaxbuffer as jb

TOPIC = "Slider-crank"
PROGRAMS = "programs in minimal coordinates (DOP853) and with multipliers; their own spread is below 1e-9"
# number, touchdown [ms], approach speed [m/s], largest force [N], when [ms]: two programs, digits shown; Exudyn's force
TABLE = [
    (0.227286, 4.385783, 45872.27, 0.251373, 45872.37),
    (0.637056, 2.756949, 20869.93, 0.659842, 20869.82),
    (0.749700, 1.826699, 25926.15, 0.779906, 25927.53),
    (1.085947, 1.101851, 6557.87, 1.111845, 6559.61),
    (1.205816, 0.823801, 12915.66, 1.245797, 12918.40),
    (1.551486, 0.270939, 1672.21, 1.584912, 1671.90),
]


def crank(speed=SPEED, angle=0.0, gravity=0.0):
    return jb.SliderCrankScenario(crank_speed=speed, crank_angle=angle, gravity=gravity)


def changed(**values):
    return jb.replace(jb.SliderCrank(), {name.replace("__", "."): value for name, value in values.items()})


@pytest.mark.quick
def test_six_impacts_of_the_table():
    """Two programs to every digit shown, and Exudyn to what its steps of 2.5e-8 s leave."""
    found = jax.tree.map(np.asarray, jb.simulate(jb.SliderCrank(), crank(), 2e-3, rtol=1e-9).impacts)
    for k, (time, speed, force, _, exudyn) in enumerate(TABLE):
        assert 1e3 * found.time[k] == pytest.approx(time, abs=6e-7)
        assert found.approach_speed[k] == pytest.approx(speed, abs=6e-7)
        assert found.peak_force[k] == pytest.approx(force, abs=6e-3)
        assert found.peak_force[k] == pytest.approx(exudyn, rel=4e-4)


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
@pytest.mark.parametrize("name", DESIGNS)
def test_four_impacts_of_independent_programs(name, rtol, evidence):
    """Speeds, weight, friction, restitution, play in either pin and in both, and a motor's torque."""
    design, scenario = built(DESIGNS[name]["numbers"])
    impacts = DESIGNS[name]["impacts"]
    run = jb.simulate(design, scenario, 1.0001 * max(i["release_time"] for i in impacts), rtol=rtol)
    found = jax.tree.map(np.asarray, run.impacts)
    pins = run.mechanism.view.names(design).contacts
    worst = 0.0
    for k, impact in enumerate(impacts):
        assert pins[found.contact[k]] == ("crank", "piston")[impact["contact"]]
        for field in ("time", "approach_speed", "peak_force", "release_time"):
            worst = max(worst, abs(getattr(found, field)[k] / impact[field] - 1.0))
    claim = f"eleven designs: times, speeds and forces of four impacts at rtol {rtol:g}"
    evidence(TOPIC, claim, worst, {1e-6: 5e-6, 1e-9: 1e-6}[rtol], PROGRAMS, detail=name)
    evidence(TOPIC, "drift of the joints", run.balance.drift, 1e-9, "constraints", "m")
    evidence(TOPIC, "energy with the drive's work over four impacts", abs(run.balance.energy), 1e-6, "conservation")


@pytest.mark.parametrize("name", DESIGNS)
def test_largest_acceleration_and_torque_of_independent_programs(name, evidence):
    design, scenario = built(DESIGNS[name]["numbers"])
    maxima = DESIGNS[name]["maxima"]
    run = jb.simulate(design, scenario, maxima["window"], rtol=1e-9)
    for quantity in ("slider_acceleration", "drive_torque"):
        error = abs(float(run.quantity(quantity)) / maxima[quantity] - 1.0)
        evidence(TOPIC, f"largest {quantity.replace('_', ' ')}, rtol 1e-9", error, 1e-6, PROGRAMS, detail=name)


@pytest.mark.long
def test_elasticities_of_independent_programs(evidence):
    """Of three peaks and the first touchdown, at default settings; all trusted."""
    stiffness = DESIGNS["reference"]["numbers"]["stiffness"]
    paths = {
        "clearance": "piston_pin.clearance",
        "speed": "scenario.crank_speed",
        "slider_mass": "slider.mass",
        "rod_mass": "rod.mass",
        "restitution": "piston_pin.restitution",
    }
    given = {"stiffness": "piston_pin.stiffness", "clearance alone": "piston_pin.clearance"}
    quantities = (*(f"impact.{k}.peak_force" for k in (1, 2, 3)), "impact.1.time")
    for design, named in ((jb.SliderCrank(), paths), (changed(piston_pin__stiffness=stiffness), given)):
        found = jb.sensitivity(design, crank(), tuple(named.values()), 1.5e-3, quantities=quantities)
        for k, name in enumerate(named):
            expected = [
                REFERENCE["elasticities"][name][q]["value"] for q in ("first_peak", "second_peak", "third_peak")
            ]
            expected.append(REFERENCE["elasticities"][name]["first_time"]["value"])
            error = np.max(np.abs(found.elasticities[:, k] - expected))
            evidence(TOPIC, "elasticities of three peaks and a time", error, 1e-4, PROGRAMS, detail=f"by {name}")
        assert found.certificate.verdict is jb.Verdict.trusted


def test_first_touchdown_at_one_angle_and_flights_scale_with_speed(evidence):
    """Without weight only the contact knows of time: the same angle, speeds in proportion, whatever the speed."""
    first = [jb.simulate(jb.SliderCrank(), crank(w), 0.3 / w).impacts for w in (1.0, 20.944, 523.6, 3000.0)]
    speeds = np.array([1.0, 20.944, 523.6, 3000.0])
    angles = np.degrees([float(i.time[0]) for i in first] * speeds)
    evidence(TOPIC, "angle of the first touchdown, 6.8186°", np.ptp(angles) / 6.8186, 1e-8, "speed scaling")
    assert angles[0] == pytest.approx(6.8186, abs=5e-5)
    per_speed = np.array([float(i.approach_speed[0]) for i in first]) / speeds
    np.testing.assert_allclose(per_speed, per_speed[0], rtol=1e-7)


@pytest.mark.parametrize(("centre", "gravity", "angle"), [(0.5, 0.0, 0.0), (0.3, 0.0, 1.0), (0.5, 2e4, -0.7)])
def test_without_play_it_is_the_mechanism_of_the_textbook(centre, gravity, angle, evidence):
    """Slider's position and acceleration, the drive's torque in closed form, and its work."""
    design = changed(piston_pin__joint="pinned", rod__centre=centre)
    run = jb.simulate(design, crank(angle=angle, gravity=gravity), TURN, rtol=1e-9, history=True)
    at = angle + SPEED * np.asarray(run.history.time)
    error = np.max(np.abs(np.asarray(run.history.position)[:, 2, 0] - slider_position(at)))
    evidence(TOPIC, "slider of the pinned mechanism", error, 1e-8, "closed form", "m")
    _, torque = pinned(at, centre, gravity)
    size = np.max(np.abs(torque))
    error = np.max(np.abs(np.asarray(run.history.drive_torque) - torque)) / size
    evidence(TOPIC, "torque that keeps the speed of the pinned mechanism", error, 1e-6, "closed form")
    fine_energy, fine = pinned(angle + SPEED * np.linspace(0.0, TURN, 200_001), centre, gravity)
    assert float(run.quantity("drive_torque")) == pytest.approx(np.max(fine), rel=1e-6)
    assert float(run.quantity("torque_ripple")) == pytest.approx(np.ptp(fine), rel=1e-6)
    largest = np.max(np.abs(slider_acceleration(angle + SPEED * np.linspace(0.0, TURN, 200_001))))
    assert float(run.quantity("slider_acceleration")) == pytest.approx(largest, rel=1e-6)
    assert float(run.energy.drives) == pytest.approx(0.0, abs=1e-6 * np.ptp(fine_energy))


def test_small_clearances_tend_to_the_mechanism_without_play():
    """The slider keeps within the clearance and its penetration, and so the drive's work tends to the textbook's."""
    speed, duration = 1000.0 * np.pi / 30.0, 0.018
    work = np.subtract(*(pinned(angle, speed=speed)[0] for angle in (speed * duration, 0.0)))
    off = []
    for clearance in (5e-4, 1e-4, 2e-5, 4e-6, 1e-6):
        design = changed(piston_pin__clearance=clearance, piston_pin__restitution=0.5)
        run = jb.simulate(design, crank(speed), duration, history=True)
        place = np.asarray(run.history.position)[:, 2, 0]
        away = np.max(np.abs(place - slider_position(speed * np.asarray(run.history.time))))
        deep = float(run.quantity("penetration"))
        assert away < 1.2 * (clearance + deep)  # the rod is not along the line
        off.append(abs(-float(run.energy.drives) / work - 1.0))
    assert off[-1] < 1e-4 and max(off[2:]) < 1e-3 and max(off) < 0.05


def test_energy_and_drift_over_a_turn(evidence):
    stiff = {f"{pin}.stiffness": DESIGNS["reference"]["numbers"]["stiffness"] for pin in ("piston_pin", "crank_pin")}
    both = stiff | {"crank_pin.joint": "clearance", "piston_pin.friction": 0.1}
    for values in ({}, both, stiff | {"drive.kind": "torque"}):
        run = jb.simulate(jb.replace(jb.SliderCrank(), values), crank(gravity=9.81))
        assert run.outcome.name == "finished"
        evidence(TOPIC, "energy with the drive's work over a turn", abs(run.balance.energy), 1e-6, "conservation")
        evidence(TOPIC, "drift of the joints", run.balance.drift, 1e-8, "constraints", "m")


def test_a_motor_from_rest():
    """M_0 (1 - ω/ω_0) is largest at the start, and the steady speed is ω_0: what a crank of inertia J without rod to
    speak of does is ω = ω_0 (1 - exp(-M_0 t/(J ω_0)))."""
    light = {"rod.mass": 1e-6, "rod.inertia": 1e-10, "slider.mass": 1e-6}
    drive = {"drive.kind": "torque", "drive.torque": 2.0, "drive.no_load_speed": 50.0, "crank.inertia": 0.01}
    run = jb.simulate(jb.replace(jb.SliderCrank(), light | drive), crank(0.0), 0.5, history=True)
    time, spin = np.asarray(run.history.time), np.asarray(run.history.velocity)[:, 0, 2]
    np.testing.assert_allclose(spin, 50.0 * -np.expm1(-2.0 * time / (0.01 * 50.0)), atol=0.05)
    assert float(run.quantity("drive_torque")) == 2.0


@pytest.mark.parametrize(
    "law",
    [
        "johnson",
        "liu",
        pytest.param("pereira", marks=pytest.mark.slow),
        *(
            pytest.param(name, marks=pytest.mark.long)
            for name in ("radzimovsky", "goldsmith", "dubowsky-freudenstein", "esdu-78035")
        ),
    ],
)
def test_first_impact_of_every_law(law, evidence):
    """Against SciPy's DOP853 in minimal coordinates, given each law's force."""
    design = changed(piston_pin__law=law, piston_pin__damping="exact", piston_pin__restitution=0.8)
    run = jb.simulate(design, crank(), 3e-4)
    force, time = first_impact(design.piston_pin.contact_law)
    evidence(TOPIC, "first peak of other laws", abs(float(run.peak_force) / force - 1.0), 1e-6, "DOP853", detail=law)
    assert float(run.peak_time) == pytest.approx(time, abs=5e-9)


@pytest.mark.long
def test_damping_factors_are_the_authors():
    """ "exact" delivers what it is asked for, so less than Lankarani and Nikravesh's for the same restitution."""
    ends = {}
    for damping in ("none", "lankarani-nikravesh", "exact"):
        run = jb.simulate(changed(piston_pin__damping=damping, piston_pin__restitution=0.5), crank(), 4e-4)
        ends[damping] = float(run.energy.hysteresis)
    assert ends["none"] == 0.0 < 1.2 * ends["lankarani-nikravesh"] < ends["exact"]


def test_both_pins_with_play():
    design = changed(crank_pin__joint="clearance", crank_pin__clearance=3e-4, piston_pin__clearance=3e-4)
    run = jb.simulate(design, crank(), history=True)
    assert run.outcome.name == "finished"
    assert set(np.asarray(run.impacts.contact)[: int(run.impacts.count)]) == {0, 1}
    for pin in ("piston_pin", "crank_pin"):
        eccentricity = np.hypot(*jb.journal_path(run, pin).T)
        contact = ("piston_pin", "crank_pin").index(pin)
        gap = np.asarray(run.history.gap)[:, contact]
        np.testing.assert_allclose(eccentricity, 3e-4 - gap, atol=1e-12)


@pytest.mark.long
def test_horizon():
    """The first three peaks can be differentiated and trusted, the twenty-fourth is refused; the horizon lies
    between."""
    names = [f"impact.{k}.peak_force" for k in (1, 2, 3, 24)]
    found = jb.sensitivity(jb.SliderCrank(), crank(), quantities=names)
    verdicts = found.certificate.verdicts
    assert verdicts[:3] == (jb.Verdict.trusted,) * 3
    assert verdicts[3] is jb.Verdict.refused and found.certificate.verdict is jb.Verdict.refused
    run = jb.simulate(jb.SliderCrank(), crank())
    horizon = jb.horizon(run)
    assert 12 <= horizon.trusted < 28 == horizon.impacts
    assert np.all(horizon.changes[: horizon.trusted] <= 1e-3)
    assert horizon.changes[horizon.trusted] > 1e-3
    growth = REFERENCE["growth"]["peaks"]  # an independent program's peaks of the same turn
    off = np.abs(np.asarray(run.impacts.peak_force)[: horizon.impacts] / growth - 1.0)
    assert np.all(off[: horizon.trusted] < 1.5e-3)
    assert "impacts can be trusted one by one" in str(horizon)


def test_digits_lost_at_every_impact(evidence):
    """Two runs whose clearance differs by 1e-9: their peaks part by the factor that an independent program finds."""
    nearby = changed(piston_pin__clearance=5e-4 * (1.0 + 1e-9), piston_pin__stiffness=66101983978.96845)
    here = changed(piston_pin__stiffness=66101983978.96845)
    one, other = (np.asarray(jb.simulate(d, crank(), rtol=1e-12).impacts.peak_force)[:28] for d in (here, nearby))
    lost = np.polyfit(np.arange(28), np.log10(np.abs(other / one - 1.0) / 1e-9), 1)[0]
    error = abs(lost - REFERENCE["growth"]["digits_lost_per_impact"])
    evidence(TOPIC, "digits lost at each impact", error, 0.02, PROGRAMS, "digits", f"{lost:.3f}")


@pytest.mark.long
def test_gradients_where_play_decides():
    """Against differences of solves at rtol 1e-11, through jax.grad."""

    def peak(clearance, rtol=1e-6):
        return jb.simulate(changed(piston_pin__clearance=clearance), crank(), 9e-4, rtol=rtol).impacts.peak_force[2]

    step = 1e-8
    ends = [float(peak(5e-4 + sign * step, 1e-11)) for sign in (1.0, -1.0)]
    assert float(jax.grad(peak)(5e-4)) == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=1e-4)


@pytest.mark.long
def test_many_at_once_and_under_vmap():
    clearances = np.linspace(1e-4, 5e-4, 4)
    found = jb.sweep(changed(piston_pin__clearance=clearances), crank(), duration=1e-3)
    assert [outcome.name for outcome in found.outcomes] == ["finished"] * 4
    one = jax.vmap(lambda c: jb.simulate(changed(piston_pin__clearance=c), crank(), 1e-3).peak_force)
    np.testing.assert_allclose(found.peak_force, one(jnp.asarray(clearances)), rtol=1e-9)
    assert "slider_acceleration [m/s²]" in repr(found)


@pytest.mark.long
def test_no_run_of_thirty_wide_designs_fails():
    """Play from 20 µm to 1 mm in one pin or both, slow and fast, light and heavy, with weight and friction."""
    random = np.random.default_rng(7)
    failed = []
    for k in range(30):
        clearance = 10.0 ** random.uniform(-4.7, -3.0)
        values = {
            "piston_pin.law": ("sphere", "johnson", "liu")[k % 3],
            "piston_pin.damping": "exact",
            "crank_pin.joint": ("pinned", "clearance")[k % 2],
            "piston_pin.clearance": clearance,
            "crank_pin.clearance": clearance,
            "piston_pin.restitution": random.uniform(0.2, 1.0),
            "piston_pin.friction": random.choice([0.0, 0.1, 0.5]),
            "piston_pin.slip_speed": 10.0 ** random.uniform(-3.0, -1.0),
            "slider.mass": 10.0 ** random.uniform(-2.0, 1.0),
            "rod.mass": 10.0 ** random.uniform(-2.0, 1.0),
            "rod.inertia": 10.0 ** random.uniform(-5.0, -2.0),
            "rod.centre": random.uniform(0.1, 0.9),
        }
        speed = 10.0 ** random.uniform(0.5, 3.0)
        scenario = crank(speed, random.uniform(-3.0, 3.0), random.choice([0.0, 9.81]))
        run = jb.simulate(jb.replace(jb.SliderCrank(), values), scenario, 6.0 / speed)
        if run.outcome.failed or not abs(float(run.balance.energy)) < 1e-4:
            failed.append((k, run.outcome.name, float(run.balance.energy)))
    assert failed == []


def test_numbers_out_of_range_inside_compiled_code_fail():
    wrong = {"crank.length": 0.2, "piston_pin.clearance": 0.02, "piston_pin.exponent": 0.5}
    usual = {path: jb.get(jb.SliderCrank(), path) for path in wrong}

    given = [(usual | {path: value}, 1e-4, 1e-6) for path, value in wrong.items()]

    @jax.jit
    def simulated(values, duration, rtol):
        return jb.simulate(jb.replace(jb.SliderCrank(), values), crank(), duration, rtol=rtol)

    for values, duration, rtol in [*given, (usual, -1.0, 1e-6), (usual, 1e-4, 0.5)]:
        run = simulated(values, duration, rtol)
        assert run.mechanism.outcomes(int(run.code)).name == "failed_input"
        assert int(run.attempts) == 0, "costs no step"
