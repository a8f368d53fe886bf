"""Rods and sliders of any planar shape in the slider-crank: meshes against bars, beam theory and closed forms."""

import dataclasses

import numpy as np
import pytest
import skfem
from scipy.linalg import eigh
from scipy.special import eval_legendre

import jaxbuffer as jb
from jaxbuffer.mechanisms.slider_crank.assembly import slider_crank

TOPIC = "planar shapes"
LENGTH, DEPTH, WIDTH, DENSITY, MODULUS = 0.12, 0.004, 0.015, 7850.0, 207e9
SOFT = {"rod.width": WIDTH, "rod.damping_ratio": 0.05, "piston_pin.stiffness": 1e7}


def rod(half=lambda x: 0.5 * DEPTH + 0.0 * x, cells=60, turn=0.0, unit=1.0, kind=skfem.MeshQuad):
    """Between two end faces, ``half`` [m] as deep as at each place along it; turned, in another unit of length."""
    mesh = kind.init_tensor(np.linspace(0.0, LENGTH, cells + 1), np.linspace(-1.0, 1.0, 3))
    mesh = mesh.with_boundaries(
        {"crank_pin": lambda x: np.isclose(x[0], 0.0), "piston_pin": lambda x: np.isclose(x[0], LENGTH)}
    )
    x, y = mesh.p[0], mesh.p[1] * half(mesh.p[0])
    cos, sin = np.cos(turn), np.sin(turn)
    return dataclasses.replace(mesh, doflocs=np.stack([cos * x - sin * y, sin * x + cos * y]) / unit)


def column(length=0.06, depth=0.02):
    """A slider like a pile: guided at one end, the pin at the other."""
    mesh = skfem.MeshQuad.init_tensor(np.linspace(0.0, length, 13), np.linspace(-0.5 * depth, 0.5 * depth, 5))
    return mesh.with_boundaries(
        {"guide": lambda x: np.isclose(x[0], 0.0), "piston_pin": lambda x: np.isclose(x[0], length)}
    )


def with_shape(**changes):
    return jb.replace(jb.SliderCrank(), {name.replace("__", "."): value for name, value in changes.items()})


@pytest.mark.long
def test_a_straight_mesh_runs_as_the_bar_does(evidence):
    """Turned and in millimetres, past the first impact. It also stretches, and its sections shear and turn: that is the
    difference."""
    scenario, duration = jb.SliderCrankScenario(crank_speed=200.0), 0.003
    bar = jb.replace(jb.SliderCrank(), {**SOFT, "rod.depth": DEPTH, "rod.modes": 4})
    shape = jb.replace(jb.SliderCrank(), {**SOFT, "rod.shape": rod(turn=0.3, unit=1e-3), "rod.modes": 5})
    runs = [jb.simulate(design, scenario, duration, solver="explicit") for design in (bar, shape)]
    for name in ("impact.1.peak_force", "rod_deflection", "slider_acceleration", "drive_torque"):
        off = abs(float(runs[1].quantity(name)) / float(runs[0].quantity(name)) - 1.0)
        evidence(TOPIC, f"straight mesh: {name}", off, 1e-2, "the bar's modes")
    balance = runs[1].balance
    evidence(TOPIC, "straight mesh with play: energy", abs(float(balance.energy)), 1e-6, "the drive's work")
    evidence(TOPIC, "straight mesh with play: joints", float(balance.drift), 1e-8, "constraints")


@pytest.mark.quick
def test_stress_and_deflection_under_end_couples(evidence):
    """M D/2I on the surface, M L²/8EI in the middle; exact but for Poisson's ratio at the tied ends."""
    body = with_shape(rod__shape=rod(kind=skfem.MeshTri), rod__width=WIDTH, rod__modes=9).rod.form
    second = WIDTH * DEPTH**3 / 12.0
    load = np.asarray(body.second.rotation - body.first.rotation)  # 1 N m at either end
    q = load / np.diag(np.asarray(body.modes.stiffness))
    stress = np.abs(np.asarray(body.stress) @ q) * 2.0 * second / DEPTH
    evidence(TOPIC, "shape under end couples: stress", np.abs(stress - 1.0).max(), 1e-3, "M D/2I")
    deflection = abs(float(np.asarray(body.deflection) @ q)) * 8.0 * MODULUS * second / LENGTH**2
    evidence(TOPIC, "shape under end couples: deflection", abs(deflection - 1.0), 1e-2, "M L²/8EI")


def tapered(x):
    return 0.00075 - 0.004 * (x - 0.5 * LENGTH)  # m: from 1.0 to 0.5 mm either side


def rayleigh_ritz(terms=14, points=60):
    """First three frequencies [Hz] of a free Euler and Bernoulli beam of the tapered depth, Legendre polynomials."""
    place, weight = np.polynomial.legendre.leggauss(points)
    half = tapered(0.5 * LENGTH * (1.0 + place))
    area, second = 2.0 * half * WIDTH, WIDTH * (2.0 * half) ** 3 / 12.0
    polynomials = [np.polynomial.Legendre.basis(n) for n in range(terms)]
    values = np.array([eval_legendre(n, place) for n in range(terms)])
    curvatures = np.array([p.deriv(2)(place) for p in polynomials]) * (2.0 / LENGTH) ** 2
    mass = (values * weight * DENSITY * area) @ values.T
    stiffness = (curvatures * weight * MODULUS * second) @ curvatures.T
    return np.sqrt(eigh(stiffness, mass, eigvals_only=True)[2:5]) / (2.0 * np.pi)


@pytest.mark.parametrize("kind", [skfem.MeshQuad, skfem.MeshTri])
def test_a_tapered_rod_vibrates_as_beam_theory_says(kind, evidence):
    found = with_shape(rod__shape=rod(tapered, kind=kind), rod__width=WIDTH, rod__modes=9).rod.bent
    frequencies = np.asarray(found.modes.frequencies())[:3]
    off = np.abs(frequencies / rayleigh_ritz() - 1.0)
    evidence(TOPIC, f"tapered rod, {kind.__name__}: frequencies", off.max(), 1e-2, "Rayleigh and Ritz")


def test_mass_and_centre_of_a_tapered_rod(evidence):
    """In closed form; the mechanism starts on its constraints, the centre beside the pins' line too."""
    design = with_shape(rod__shape=rod(tapered, turn=0.7), rod__width=WIDTH)
    mass = DENSITY * WIDTH * LENGTH * 2.0 * 0.00075
    centre = LENGTH * (0.5 - 0.004 * LENGTH / (12.0 * 0.00075))
    (rear, _), (front, _) = design.rod.ends
    off = max(
        abs(float(design.rod.body.mass) / mass - 1.0), abs(-rear / centre - 1.0), abs((front - rear) / LENGTH - 1)
    )
    evidence(TOPIC, "tapered rod: mass, centre, length", off, 1e-9, "closed form")
    bowed = rod(lambda x: 0.002 + 0.0 * x)
    bowed = dataclasses.replace(
        bowed, doflocs=bowed.p + np.array([[0.0], [0.02]]) * np.sin(np.pi * bowed.p[0] / LENGTH)
    )
    design = with_shape(rod__shape=bowed, slider__shape=column(), piston_pin__joint="pinned")
    assert abs(design.rod.ends[0][1]) > 0.01
    start = slider_crank(design, jb.SliderCrankScenario(crank_angle=0.4))
    kin = start.kinematics(start.start()[0])
    errors = np.abs(np.asarray(start.constraint_errors(kin))).max()
    rates = [sum(np.dot(row.blocks[body], kin.v[3 * body : 3 * body + 3]) for body in row.blocks) + row.rate
             for joint in start.system.joints for row in joint.rows(kin)]  # fmt: skip
    evidence(TOPIC, "bowed rod, shaped slider: start", max(errors, np.abs(rates).max()), 1e-10, "constraints")


@pytest.mark.long
def test_a_slider_like_a_pile_is_squeezed_by_its_own_inertia(evidence):
    """Its pin pulls m a, the guided end is free along the line: m a L/2EA."""
    length, depth, modulus = 0.06, 0.02, 1e8
    design = with_shape(
        slider__shape=column(length, depth),
        slider__modes=3,
        slider__width=0.02,
        slider__young_modulus=modulus,
        slider__damping_ratio=0.3,
        piston_pin__joint="pinned",
    )
    run = jb.simulate(design, jb.SliderCrankScenario(crank_speed=20.0), np.pi / 20.0, history=True, solver="explicit")
    seen = run.history.others
    found = float(seen["slider_deflection"][-1] / seen["slider_acceleration"][-1])
    closed = 2700.0 * length**2 / (2.0 * modulus)
    evidence(TOPIC, "slider squeezed by its inertia", abs(found / closed - 1.0), 1e-2, "m a L/2EA")
    evidence(TOPIC, "slider that bends: energy", abs(float(run.balance.energy)), 1e-6, "the drive's work")
    evidence(TOPIC, "slider that bends: joints", float(run.balance.drift), 1e-8, "constraints")


def test_files_and_studies(tmp_path):
    """A mesh file beside a study; a saved design holds the mesh itself."""
    skfem.io.json.to_file(rod(tapered), tmp_path / "rod.json")
    study = tmp_path / "crank.toml"
    study.write_text('kind = "slider_crank"\n[rod]\nshape = "rod.json"\nmodes = 5\n')
    design, scenarios = jb.load_design(study)
    assert float(design.rod.body.mass) == pytest.approx(DENSITY * 0.015 * LENGTH * 0.0015)
    (tmp_path / "rod.json").unlink()
    jb.save_design(tmp_path / "saved.toml", design, scenarios)
    assert jb.load_design(tmp_path / "saved.toml") == (design, scenarios)
    assert len(repr(design)) < 4000
    with pytest.raises(jb.InputError, match=r"rod\.shape = .*: no such file"):
        jb.load_design(study)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"rod.shape": 3}, r"rod\.shape = 3 is no planar mesh"),
        ({"rod.shape": __file__}, "cannot be read as a mesh"),
        ({"rod.shape": skfem.MeshTri()}, "has no boundary crank_pin; name a physical line"),
        ({"rod.shape": rod(), "rod.modes": 2}, r"rod\.modes = 2: .* takes 3 modes"),
        ({"rod.shape": rod(), "rod.depth": 0.01}, "keep one"),
        ({"slider.shape": rod()}, "has no boundary guide"),
        ({"slider.modes": 3}, r"give slider\.shape too"),
    ],
)
def test_bad_input(fields, message):
    with pytest.raises(jb.InputError, match=message):
        jb.replace(jb.SliderCrank(), fields)
