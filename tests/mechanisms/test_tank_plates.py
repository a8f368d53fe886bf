"""The tank with baffle plates inside: its mesh, and how it stands, against a frame of beams."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from in_short import often
from jaxbuffer.mechanisms.tank_drop.assembly import assembled
from jaxbuffer.mechanisms.tank_drop.design import ZONES, valid
from jaxbuffer.mechanisms.tank_drop.numbering import Numbering
from jaxbuffer.mechanisms.tank_drop.section import section, wall_mass
from jaxbuffer.mechanisms.tank_drop.start import at_rest

PLATES = {"plates.kind": "perforated", "plates.thickness": 0.004, "plates.position": 0.13}
WIDE, TALL, ROUND, THICK = 0.6, 0.3, 0.04, 0.005  # m, the default tank
BED = 1e4  # Pa/m: so soft that all of the bottom presses on it
FINE = 2  # elements across
TOPIC = "Drop onto a tank"


def tank(changes=None):
    return jb.replace(jb.TankDrop(), {**PLATES, **(changes or {})})


@pytest.mark.parametrize("refinement", [1, 2])
@pytest.mark.parametrize("fill", [0.2, 0.9])
def test_the_mesh_is_the_whole_section_and_hangs_together(fill, refinement):
    """Elements with positive areas, those of the plate together as large as it; the edges of one element alone are on a
    face: outside, in the middle, inside, or of the plate."""
    design = tank({"mesh.refinement": refinement})
    found = section(design, fill)
    x, y = np.moveaxis(np.asarray(found.positions)[found.numbers.corners], -1, 0)
    areas = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
    assert areas.min() > 0.0
    assert areas[-14 * refinement**2 :].sum() == pytest.approx(0.004 * 0.29, rel=1e-9)
    more = float(wall_mass(design)) - float(wall_mass(jb.TankDrop()))
    assert more == pytest.approx(2.0 * 0.7 * 950.0 * 0.004 * 0.29, rel=1e-9)
    at_ends = (np.abs(x - 0.13) < 0.0021) & (np.abs(y - 0.15) > 0.1449)
    joints = [found.numbers.at_a_joint(element) for element in range(len(areas))]
    assert np.array_equal(joints, at_ends.any(axis=1)) and any(joints)
    assert not any(map(Numbering.of(jb.TankDrop()).at_a_joint, range(43)))
    edges = np.sort(
        np.stack([found.numbers.corners, np.roll(found.numbers.corners, -1, axis=1)], axis=-1).reshape(-1, 2), axis=1
    )
    single = [pair for pair, count in zip(*np.unique(edges, axis=0, return_counts=True), strict=True) if count == 1]
    columns, rows = len(found.numbers.outer) - 1, len(found.numbers.plate) - 1
    assert len(single) == 2 * columns + 2 * rows  # the middle's add as many as foot and head cover
    plate = np.asarray(found.positions)[found.numbers.plate]
    assert np.allclose(plate[:, 0, 0], 0.128) and np.allclose(plate[:, -1, 0], 0.132)
    assert np.allclose(plate[[0, -1], :, 1], [[0.005] * (refinement + 1), [0.295] * (refinement + 1)])


def stiffnesses(thickness, high=0.0, share=0.0):
    """Depth of the neutral line [m], E A, E I and mass over length of a wall with ribs, which alone are free to
    narrow."""
    wide, rib = 1e9 / (1.0 - 0.4**2), share * 1e9
    axial = wide * thickness + rib * high
    middle, middle_of_rib = 0.5 * thickness, thickness + 0.5 * high
    depth = (wide * thickness * middle + rib * high * middle_of_rib) / axial
    bending = wide * thickness * (thickness**2 / 12.0 + (middle - depth) ** 2)
    bending += rib * high * (high**2 / 12.0 + (middle_of_rib - depth) ** 2)
    return depth, axial, bending, 950.0 * (thickness + share * high)


def frame(plate, *ribs):
    """Top, plate's head and bottom of half of the empty tank under its own weight on a bed of springs, downwards [m]:
    straight beams between points of the neutral line, small displacements, and a ``plate`` [m], or 0 for none, whose
    ends are rigid within the wall; ``ribs``: height and share of them, if any."""
    half, *wall = stiffnesses(THICK, *ribs)
    turn = np.linspace(-0.5 * np.pi, 0.0, 40)
    middle = ROUND - half  # radius
    flat, side = 0.5 * WIDE - ROUND, np.linspace(ROUND, TALL - ROUND, 100)[1:-1]
    places = np.unique(np.concatenate([np.linspace(0.0, flat, 131), [0.13]]))
    corner = np.stack([flat + middle * np.cos(turn), ROUND + middle * np.sin(turn)], axis=1)[1:]
    bottom = np.stack([places, np.full(len(places), half)], axis=1)
    up = np.concatenate([bottom, corner])
    other = up[::-1] * [1.0, -1.0] + [0.0, TALL]
    points = np.concatenate([up, np.stack([np.full(len(side), 0.5 * WIDE - half), side], axis=1), other])
    foot = int(np.argmin(np.abs(bottom[:, 0] - 0.13)))
    head = len(points) - 1 - foot
    bars = [(k, k + 1, *wall) for k in range(len(points) - 1)]
    if plate:
        more = np.stack([np.full(59, 0.13), np.linspace(THICK, TALL - THICK, 59)], axis=1)
        first = len(points)
        points = np.concatenate([points, more])
        bars += [(k, k + 1, *stiffnesses(plate)[1:]) for k in range(first, len(points) - 1)]
        bars += [(a, b, *stiffnesses(1.0)[1:3], 0.0) for a, b in ((foot, first), (len(points) - 1, head))]  # rigid
    stiffness, load = np.zeros((3 * len(points),) * 2), np.zeros(3 * len(points))
    for a, b, axial, bending, mass in bars:
        where = np.r_[3 * a : 3 * a + 3, 3 * b : 3 * b + 3]
        length, matrix = beam(points[b] - points[a], axial, bending)
        stiffness[np.ix_(where, where)] += matrix
        load[[3 * a + 1, 3 * b + 1]] -= 0.5 * 9.81 * mass * length
    strip = 0.5 * np.diff(places, prepend=0.0)
    strip[:-1] += 0.5 * np.diff(places)
    strip[-1] += ROUND * np.sin(np.pi / 16.0 / FINE)  # half of a chord: the bed goes as far up the corner as the mesh
    below = 3 * np.arange(len(places)) + 1
    stiffness[below, below] += BED * strip
    ends = [0, len(up) + len(side) + len(other) - 1]
    held = [3 * k + j for k in ends for j in (0, 2)]
    free = np.setdiff1d(np.arange(len(load)), held)
    moved = np.zeros(len(load))
    moved[free] = np.linalg.solve(stiffness[np.ix_(free, free)], load[free])
    assert np.all(moved[below] < 0.0)
    return -moved[[3 * ends[1] + 1, 3 * head + 1, 1]]


def beam(along, axial, bending):
    """Length [m] and stiffness of a straight beam of E A and E I."""
    length = np.hypot(*along)
    c, s = along / length
    a, b = axial / length, bending / length**3
    own = np.zeros((6, 6))
    own[np.ix_([0, 3], [0, 3])] = a * np.array([[1.0, -1.0], [-1.0, 1.0]])
    own[np.ix_([1, 2, 4, 5], [1, 2, 4, 5])] = b * np.array(
        [
            [12.0, 6.0 * length, -12.0, 6.0 * length],
            [6.0 * length, 4.0 * length**2, -6.0 * length, 2.0 * length**2],
            [-12.0, -6.0 * length, 12.0, -6.0 * length],
            [6.0 * length, 2.0 * length**2, -6.0 * length, 4.0 * length**2],
        ]
    )
    turn = np.kron(np.eye(2), np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]))
    return length, turn.T @ own @ turn


def ours(changes):
    """The same three of the assembled tank."""
    design = tank({"contents.kind": "none", "support.stiffness": BED, "mesh.refinement": FINE, **changes})

    @jax.jit
    def found():
        parts = assembled(design, jb.TankDropScenario(fill=0.5))
        return parts.section.positions[:, 0], -at_rest(parts).displacement[:, 1]

    (x, down), numbers = map(np.asarray, found()), Numbering.of(design)
    top = numbers.outer[: numbers.level : -1][: 12 * FINE]  # from the middle outwards
    return np.array([down[top[0]], np.interp(0.13, x[top], down[top]), down[numbers.outer[0]]])


@pytest.mark.parametrize(("kind", "plate", "within"), [("none", 0.0, 0.006), ("perforated", 0.004, 0.03)])
def test_it_sags_under_its_own_weight_as_a_frame_of_beams(kind, plate, within, evidence):
    """Top and plate's head against the bottom: 8.4 mm without plates and 0.27 mm with them, whose joints in the mesh
    are stiffer than points."""
    top, head, bottom = ours({"plates.kind": kind})
    expected = frame(plate)
    assert bottom == pytest.approx(expected[2], rel=3e-3)
    off = abs((top - bottom) / (expected[0] - expected[2]) - 1.0)
    claim = "sag of the top" + (", with plates" if plate else "")
    evidence(TOPIC, claim, off, within, "a frame of beams")
    assert head - bottom == pytest.approx(expected[1] - expected[2], rel=within)


def test_a_plate_makes_a_drop_harder_and_keeps_energy_and_momentum():
    """The wall's own ledger, with a plate that bends: force and deflection go the ways they must."""
    drop = jb.TankDropScenario(height=0.1)
    without, found = (
        jb.simulate(tank({"plates.kind": kind}), drop, 0.02, history=True) for kind in ("none", "perforated")
    )
    assert found.outcome.name == "whole" and float(found.balance.energy) < 1e-4
    assert float(found.peak_force) > 3.0 * float(without.peak_force)
    assert float(found.deflection) < 0.6 * float(without.deflection)
    assert float(found.balance.linear_momentum) < 1e-10
    assert "plate_x" not in without.history.others
    assert found.history.others["plate_x"].shape == (len(found.history.time), 15)


@pytest.mark.slow
@pytest.mark.parametrize(("contents", "fill"), often([("liquid", 0.6), ("full", 1.0)], ("liquid", 0.6)))
def test_a_liquid_feels_a_plate_by_its_aperture(contents, fill):
    """A plate all holes is not felt; the smaller the open share, the stiffer the tank, as its halves keep their liquid;
    what the holes take is in the ledger."""
    drop = jb.TankDropScenario(height=0.1, fill=fill)
    changes = {"contents.kind": contents, **dict.fromkeys((f"wall.{zone}" for zone in ZONES), 0.01)}

    def run(aperture):
        return jb.simulate(tank({**changes, "plates.aperture": aperture}), drop, 8e-3)

    unfelt, whole, *shares = map(run, (None, 1.0, 0.5, 0.2, 0.01))
    for name in ("peak_force", "impulse", "deflection"):
        assert float(getattr(whole, name)) == pytest.approx(float(getattr(unfelt, name)), rel=3e-3), name
    assert float(whole.energy.lost["holes"]) == 0.0
    forces = [float(run.peak_force) for run in (whole, *shares)]
    assert forces == sorted(set(forces))
    for each in shares:
        assert float(each.balance.energy) < 2e-4 and float(each.balance.linear_momentum) < 1e-10
        assert float(each.energy.lost["holes"]) > 0.0


@pytest.mark.long
@pytest.mark.parametrize("contents", [pytest.param("liquid", marks=pytest.mark.long), "full"])
def test_derivatives_by_holes_are_those_of_differences(contents):
    """Aperture and diameter, over 4 ms: of the force, the stress and the energy lost in the holes."""
    drop = jb.TankDropScenario(height=0.1, fill=1.0 if contents == "full" else 0.6)

    def of(values):
        changes = {"contents.kind": contents, "plates.aperture": values[0], "plates.hole_diameter": values[1]}
        run = jb.simulate(tank(changes), drop, 4e-3)
        numbers = jnp.stack([run.peak_force, run.smooth_stress, run.energy.lost["holes"]])
        return numbers, numbers

    both = jax.jit(jax.jacrev(of, has_aux=True))
    at = np.array([0.3, 0.03])
    slopes, values = both(at)
    for k, step in enumerate(np.diag(1e-4 * at)):
        change = (both(at + step)[1] - both(at - step)[1]) / (2.0 * step[k])
        elasticity, expected = slopes[:, k] * at[k] / values, change * at[k] / values
        np.testing.assert_allclose(elasticity, expected, rtol=1e-3, atol=1e-6)


@pytest.mark.slow
def test_plates_of_a_composite_wall_are_of_its_plies():
    """Its run always says that joints have no fillet, since it does not tell where the least reserve is."""
    run = jb.simulate(tank({"material.kind": "composite"}), jb.TankDropScenario(height=0.1), 5e-4)
    assert run.outcome.name == "whole" and float(run.balance.energy) < 1e-6
    without = jb.replace(run.design, {"plates.kind": "none"})
    more = 2.0 * 0.7 * float(run.design.composite.density) * 0.004 * 0.29
    assert float(run.wall_mass) - float(wall_mass(without)) == pytest.approx(more, rel=1e-9)
    assert sum("may be where a plate meets the wall" in line for line in run.mechanism.view.warnings(run)) == 1


@pytest.mark.long
def test_derivatives_by_a_plate_are_those_of_differences():
    """Thickness and position, over 4 ms: of the force and the stress."""

    def seen(values):
        design = tank({"plates.thickness": values[0], "plates.position": values[1]})
        run = jb.simulate(design, jb.TankDropScenario(height=0.1), 4e-3)
        found = jnp.stack([run.peak_force, run.smooth_stress, run.wall_mass])
        return found, found

    both = jax.jit(jax.jacrev(seen, has_aux=True))
    at = np.array([0.004, 0.13])
    slopes, _ = both(at)
    for k, step in enumerate(np.diag(1e-6 * at)):
        change = (both(at + step)[1] - both(at - step)[1]) / (2.0 * step[k])
        np.testing.assert_allclose(slopes[:, k], change, rtol=1e-4, atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        (
            {"plates.position": 0.27},
            r"plates.position = 0.27 m is out of range; allowed: \(0.002, 0.258\) m, where the",
        ),
        ({"plates.position": 0.001}, r"plates.position = 0.001 m is out of range"),
        ({"plates.kind": "solid"}, "plates.kind"),
        ({"plates.aperture": 0.0}, r"plates.aperture = 0 is out of range; allowed: \(0, 1\]"),
        ({"plates.aperture": 1.2}, r"plates.aperture = 1.2 is out of range"),
        ({"plates.hole_diameter": -0.01}, r"plates.hole_diameter = -0.01 m is out of range"),
        ({"plates.thickness": 0.05}, r"plates.thickness = 0.05 m is out of range; allowed: \(0, 0.03\] m"),
    ],
)
def test_a_plate_that_does_not_fit_is_refused(changes, said):
    with pytest.raises(jb.InputError, match=said):
        jb.simulate(tank(changes), jb.TankDropScenario(height=0.1), 1e-3)


def test_a_plate_in_the_corner_is_not_valid_in_compiled_code():
    seen = jax.jit(lambda at: valid(tank({"plates.position": at}), jb.TankDropScenario()))
    assert [bool(seen(at)) for at in (0.001, 0.13, 0.27)] == [False, True, False]
