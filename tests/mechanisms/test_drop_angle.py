"""The whole section of a tank under a slider at an angle: against half of it, by its mirror image, by momentum."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jaxbuffer as jb
from jaxbuffer.mechanisms.tank_drop.assembly import assembled
from jaxbuffer.mechanisms.tank_drop.design import valid
from jaxbuffer.mechanisms.tank_drop.drawing import drawing
from jaxbuffer.mechanisms.tank_drop.meshes import meshes
from jaxbuffer.mechanisms.tank_drop.quantities import QUANTITIES
from jaxbuffer.mechanisms.tank_drop.run import rows_of
from jaxbuffer.mechanisms.tank_drop.section import section, wall_mass

TOPIC = "Drop onto a tank"
WHOLE = {"mesh.extent": "whole"}
EMPTY = {"contents.kind": "none"}
FULL = {"contents.kind": "full"}
PLATES = {"plates.kind": "perforated"}
RIBS = {"ribs.kind": "rings"}
ANGLE = 0.1  # rad


def tank(*changes):
    return jb.replace(jb.TankDrop(), {name: value for change in changes for name, value in change.items()})


def drop(design, duration, angle=0.0, **options):
    fill = 1.0 if design.contents.kind == "full" else 0.6
    scenario = jb.TankDropScenario(height=0.3, fill=fill, angle=angle)
    return jb.simulate(design, scenario, duration, **options)


def long(*values):
    return pytest.param(*values, marks=pytest.mark.long)


@pytest.mark.parametrize(
    ("changes", "duration"),
    [
        (PLATES | {"contents.air": "trapped"}, 1e-3),
        long(PLATES | {"plates.aperture": 0.3}, 3e-3),
        long(PLATES | FULL | {"plates.aperture": 0.3, "mesh.refinement": 2}, 1e-3),
        long(EMPTY, 8e-3),
        long({}, 4e-3),
        long(FULL | {"support.method": "multiplier"}, 2e-3),
        long(RIBS | {"cushion.kind": "none"}, 2e-3),
        long({"material.kind": "composite", "support.method": "defence node"}, 1e-3),
    ],
)
def test_the_whole_section_does_what_its_half_says(changes, duration, evidence):
    """Both are computed by the same elements, added up in another order."""
    half, whole = (drop(tank(changes, extent), duration) for extent in ({}, WHOLE))
    assert half.outcome == whole.outcome and int(half.accepted) == int(whole.accepted)
    worst = 0.0
    for name, quantity in QUANTITIES.items():
        one, both = float(quantity.of(half)), float(quantity.of(whole))
        if name != "slide" and not (np.isnan(one) and np.isnan(both)):
            worst = max(worst, abs(both - one) / max(abs(one), 1e-12))
    evidence(TOPIC, "the whole section against its half", worst, 1e-8, "half of the section")
    assert abs(float(whole.slide)) < 1e-9  # m


meshed = eqx.filter_jit(section)  # one program in place of its many operations


@pytest.mark.parametrize("changes", [{}, FULL, PLATES, RIBS | EMPTY])
def test_the_whole_section_has_the_whole_mass_and_is_enclosed(changes):
    design = tank(changes, WHOLE)
    fill = 1.0 if design.contents.kind == "full" else 0.5
    seen = meshed(design, fill)
    areas = [_areas(np.asarray(at)[corners]) for at, corners in ((seen.positions, seen.sets.corners),)]
    assert min(area.min() for area in areas) > 0.0
    share = np.ones(len(seen.sets.corners) // 2)
    if len(seen.numbers.ribs):
        share[-(len(seen.numbers.ribs) - 1) :] = 0.1
    mass = 0.7 * 950.0 * np.sum(areas[0] * np.tile(share, 2))
    assert float(eqx.filter_jit(wall_mass)(design)) == pytest.approx(mass, rel=1e-2), "chords of arcs"
    if design.contents.kind != "none":
        liquid = _areas(np.asarray(seen.liquid)[seen.sets.liquid_corners])
        edge = np.asarray(seen.positions)[seen.sets.wetted]
        assert liquid.min() > 0.0
        assert liquid.sum() == pytest.approx(_areas(edge[None])[0], rel=1e-12), "up to the level, from wall to wall"


def _areas(corners):
    """Of polygons (…, corners, 2), by the shoelace formula [m²]."""
    x, y = np.moveaxis(corners, -1, 0)
    return 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)


@pytest.mark.quick
@pytest.mark.parametrize("cushion", ["layer", "none"])
def test_the_slider_just_touches_the_tank_at_the_start(cushion):
    """At a corner, whose nodes are 22.5° of its radius from each other."""

    @jax.jit
    def pressed(angle):
        parts = assembled(tank(WHOLE, EMPTY, {"cushion.kind": cushion}), jb.TankDropScenario(angle=angle))
        positions = parts.system.positions
        return positions[parts.slider, 1], jnp.max(parts.compression(positions))

    for angle in (0.0, ANGLE, -ANGLE):
        height, deepest = map(float, pressed(angle))
        thick = 0.15 if cushion == "layer" else 0.0
        touching = (0.26 * abs(np.sin(angle)) + 0.26 * np.cos(angle) + 0.04 + thick) / np.cos(angle)
        chord = 0.04 * (1.0 - np.cos(np.pi / 16.0))
        assert abs(deepest) < 1e-15
        assert touching - chord / np.cos(angle) - 1e-12 < height < touching + 1e-12


@pytest.fixture(scope="module")
def both_ways():
    """Drops at opposite angles, every step of them kept."""
    return [drop(tank(WHOLE, EMPTY), 1.5e-3, angle, history=True) for angle in (ANGLE, -ANGLE)]


def test_a_drop_at_an_angle_keeps_energy_and_momentum(both_ways):
    """As a straight drop does; the slider's momentum is that along its fall."""
    for run in both_ways:
        assert run.outcome.name == "whole" and int(run.accepted) < 800
        assert float(run.balance.energy) < 1e-8
        assert float(run.balance.linear_momentum) < 1e-10


@pytest.mark.slow
def test_a_drop_at_an_angle_on_liquid_keeps_energy(evidence):
    """As long as the surface has not met the top: that costs some 1e-4 of it, in a straight drop as well."""
    run = drop(tank(WHOLE), 0.02, ANGLE)
    assert run.outcome.name == "whole" and float(run.balance.linear_momentum) < 1e-10
    evidence(TOPIC, "a drop at an angle keeps its energy", float(run.balance.energy), 1e-8, "sum of all energies")


def test_the_tank_takes_the_tangent_of_the_angle_sideways(both_ways, evidence):
    """Nothing but the slider pushes an empty tank sideways: its momentum is tan a times the slider's impulse."""
    for run, angle in zip(both_ways, (ANGLE, -ANGLE), strict=True):
        rows = slice(rows_of(run))
        time = np.asarray(run.history.time)[rows]
        moved = np.asarray(run.history.others["displacement"])[rows, :-2, 0]
        mass = 0.7 * _nodal_masses(run.design)
        momentum = np.diff(moved, axis=0) @ mass / np.diff(time)
        impulse = np.cumsum(np.asarray(run.history.contact_force)[rows, 0][:-1] * np.diff(time))
        off = np.max(np.abs(momentum - np.tan(angle) * impulse)) / np.max(np.abs(momentum))
        evidence(TOPIC, "sideways momentum of a tank at an angle", off, 1e-6, "tan a times the slider's impulse")


def _nodal_masses(design):
    """A quarter of each element's mass at each of its corners [kg/m]."""
    seen = meshed(design, 0.6)
    areas = _areas(np.asarray(seen.positions)[seen.sets.corners])
    mass = np.zeros(len(seen.positions))
    np.add.at(mass, seen.sets.corners, 0.25 * 950.0 * areas[:, None])
    return mass


def test_the_opposite_angle_is_the_mirror_image(both_ways):
    right, left = both_ways
    other = np.asarray(meshed(right.design, 0.6).positions)
    image = np.argmin(np.linalg.norm(other[:, None] * [-1.0, 1.0] - other[None], axis=-1), axis=1)
    moved, back = (np.asarray(run.history.others["displacement"])[:, :-2] for run in both_ways)
    np.testing.assert_allclose(moved[:, image] * [-1.0, 1.0], back, atol=1e-12)
    np.testing.assert_allclose(right.history.contact_force, left.history.contact_force, atol=1e-6)
    assert float(right.slide) == pytest.approx(-float(left.slide), rel=1e-9) and float(right.slide) > 0.0


def test_it_is_drawn_at_its_angle_on_the_whole_section(both_ways):
    for run, angle in zip(both_ways, (ANGLE, -ANGLE), strict=True):
        frames = drawing(run.design).frames(run.history)
        assert np.all(frames[:, 0, 2] == angle)
        wall = frames[0, 1:, :2]
        assert wall[0] == pytest.approx(wall[-1]) and wall[0, 1] < 0.01 and _areas(wall[None])[0] > 0.16
        assert [len(mesh.cells) for mesh in meshes(run)] == [len(meshed(run.design, 0.6).sets.corners)] * 2


def test_the_drawn_liquid_goes_with_a_wall_that_moves_to_one_side():
    """Sheared and turned, its nodes stay on the wall's, its cells fill what the wall encloses."""
    design = tank(WHOLE, FULL)
    seen = meshed(design, 1.0)
    x, y = np.asarray(seen.positions).T
    moved = np.zeros((1, len(x) + 2, 2))
    moved[0, :-2] = np.stack([0.02 + 0.3 * y**2, 0.05 * x - 0.2 * x * y], axis=1)
    cells, liquid = len(seen.sets.corners), len(seen.liquid)

    class Kept:
        history = time = None

    run = Kept()
    run.design, run.scenario, run.history, run.time = design, jb.TankDropScenario(fill=1.0), run, np.zeros(1)
    run.others = {"displacement": moved, "peak_stress": np.ones(1), "stress": np.ones((1, cells))}
    run.others |= {"plastic_strain": np.zeros((1, cells)), "pressure": np.ones((1, liquid))}
    (mesh,) = meshes(run, times=[0.0])
    np.testing.assert_allclose(mesh.nodes[len(x) :][seen.sets.wet], mesh.nodes[seen.sets.wetted], atol=1e-14)
    inside = _areas(mesh.nodes[mesh.cells[cells:]])
    assert inside.min() > 0.0
    assert inside.sum() == pytest.approx(_areas(mesh.nodes[seen.sets.wetted][None])[0], rel=1e-12)


@pytest.mark.long
def test_a_rigid_tank_slides_under_a_cushion_at_an_angle(evidence):
    """A mass that falls onto one that slides without friction, with a cushion between them, by SciPy."""
    angle, mass, soft, damping = 0.03, 60.0, 1e6, 1e3
    zones = ("bottom", "lower_corner", "lower_side", "upper_side", "upper_corner", "top")
    stiff = {f"wall.{zone}": 0.02 for zone in zones} | {"material.young_modulus": 1e11, "material.yield_stress": 1e12}
    bed = {"cushion.stiffness": soft, "cushion.damping": damping, "slider.mass": mass}
    found = drop(tank(WHOLE, EMPTY, stiff, bed), 0.03, angle)
    turned = np.linspace(-0.5, 0.5, 2001)[:, None] * np.pi  # of the outward normal, from the right wall to the left
    corner = np.array([0.26, 0.0])
    arc = 0.04 * np.hstack([-np.sin(turned), np.cos(turned)]) + np.array([0.0, 0.26])
    flat = np.linspace([0.26, 0.3], [-0.26, 0.3], 4001)
    outline = np.concatenate([arc[:1000] + corner, flat, arc[1001:] - corner])
    normal = np.array([np.sin(angle), -np.cos(angle)])
    middle, along = 0.5 * (outline[1:] + outline[:-1]), np.diff(outline, axis=0)
    strip = np.maximum(-np.stack([along[:, 1], -along[:, 0]], axis=1) @ normal, 0.0)
    above = middle @ normal - np.min(outline @ normal)
    ring = (0.6 * 0.3 - (4.0 - np.pi) * 0.04**2) - (0.56 * 0.26 - (4.0 - np.pi) * 0.02**2)
    tank_mass = 950.0 * 0.7 * ring

    def pressing(y):
        depth = np.cos(angle) * y[0] - np.sin(angle) * y[2] - above
        rate = np.cos(angle) * y[1] - np.sin(angle) * y[3]
        pressure = np.maximum(soft * depth + damping * rate, 0.0) * (depth > 0.0)
        return 0.7 * np.sum(strip * pressure)

    def course(_, y):
        force = pressing(y)
        return [y[1], 9.81 - np.cos(angle) * force / mass, y[3], np.sin(angle) * force / tank_mass]

    start = [0.0, np.sqrt(2.0 * 9.81 * 0.3), 0.0, 0.0]
    expected = solve_ivp(course, [0.0, 0.03], start, max_step=5e-5, rtol=1e-8)
    peak = np.cos(angle) * max(pressing(y) for y in expected.y.T)
    off = abs(float(found.peak_force) / peak - 1.0)
    evidence(TOPIC, "largest force on a rigid tank at an angle", off, 0.01, "SciPy, two masses and a cushion")
    assert float(found.travel) == pytest.approx(expected.y[0].max(), rel=5e-3)
    assert float(found.slide) == pytest.approx(expected.y[2, -1], rel=0.01)
    assert float(found.rebound_speed) == pytest.approx(-expected.y[1, -1], rel=0.02)


@pytest.mark.long
def test_derivatives_by_the_angle_are_those_of_differences():
    design = tank(WHOLE, {"material.yield_stress": 2e6})
    names = ("impulse", "smooth_stress", "deflection", "slide")

    def quantities(angle):
        run = jb.simulate(design, jb.TankDropScenario(height=0.1, fill=0.6, angle=angle), 0.004)
        return jnp.stack([getattr(run, name) for name in names])

    exact, small = np.asarray(jax.jit(jax.jacrev(quantities))(ANGLE)), 1e-7
    compiled = jax.jit(quantities)
    slope = np.asarray(compiled(ANGLE + small) - compiled(ANGLE - small)) / (2.0 * small)
    np.testing.assert_allclose(exact, slope, rtol=2e-4)


NEEDS = 'an angle other than 0 needs mesh.extent = "whole"'


@pytest.mark.quick
@pytest.mark.parametrize(
    ("extent", "angle", "said"),
    [
        ("half", 0.1, rf"scenario.angle = 0.1 rad \(5.73°\): {NEEDS}"),
        ("half", np.array([0.0, -0.05]), rf"scenario.angle = -0.05 rad \(-2.86°\): {NEEDS}"),
        ("whole", 0.6, r"scenario.angle = 0.6 rad is out of range; allowed: \[-0.5, 0.5\] rad"),
        ("whole", "40°", r"scenario.angle = 40° is out of range; allowed: \[-28.6479, 28.6479\]°"),
        ("wohle", 0.0, "mesh.extent = 'wohle' is unknown; choose one of half, whole; did you mean whole"),
    ],
)
def test_an_angle_that_does_not_fit_is_refused(extent, angle, said):
    with pytest.raises(jb.InputError, match=said):
        jb.simulate(tank({"mesh.extent": extent}), jb.TankDropScenario(angle=angle), 1e-3)


@pytest.mark.parametrize(("extent", "fits"), [({}, [True, False, False]), (WHOLE, [True, True, False])])
def test_an_angle_on_half_a_section_is_not_valid_in_compiled_code(extent, fits):
    seen = jax.jit(lambda angle: valid(tank(extent), eqx.tree_at(lambda s: s.angle, jb.TankDropScenario(), angle)))
    assert [bool(seen(angle)) for angle in (0.0, 0.1, 0.6)] == fits
