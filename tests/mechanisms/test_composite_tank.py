"""The composite wall of a tank against a calculation by hand: Q of a ply from its moduli, turned by 45° and 90°."""

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.tank_drop.laminate import Composite, equivalent, least_reserve
from jaxbuffer.mechanisms.tank_drop.section import wall_mass
from jaxbuffer.structures import Plane, Quads
from jaxbuffer.structures.materials import PlasticHistory

Q11, Q12, Q22, Q66 = 130572.2, 1634.70, 4670.58, 4650.0  # MPa: E1/(1 - ν12 ν21) and so on, ν21 = 0.35·4650/130000
QUARTER = (Q11 + 2 * Q12 + Q22) / 4  # of a ply at 45°, to which Q66 is added
STRETCHED = 1e-3
TOPIC = "Composites"
LONG, THICK = 0.02, 0.004  # m


def wall(fine: int = 1):
    """A straight piece of wall along x, its outside below, and its elements."""
    x, y = np.linspace(0.0, LONG, 2), THICK * np.linspace(1.0, 0.0, fine + 1)
    positions = np.array([[a, b] for a in x for b in y])
    node = np.arange(len(positions)).reshape(2, fine + 1)
    corners = np.stack([node[:-1, 1:], node[1:, 1:], node[1:, :-1], node[:-1, :-1]], axis=-1).reshape(-1, 4)
    return positions, Plane(Quads.of(positions, corners), equivalent(Composite()))


def reserve(stretch: float, bend: float, fine: int = 1, **changes) -> float:
    """Of the piece whose strain along it is ``stretch`` + ``bend``·(2 y/thickness - 1)."""
    return float(_reserve(np.float64(stretch), np.float64(bend), fine, Composite(**changes)))


@eqx.filter_jit
def _reserve(stretch, bend, fine, composite):
    positions, piece = wall(fine)
    high = 2.0 * positions[:, 1] / THICK - 1.0
    displacement = jnp.stack([(stretch + bend * high) * (positions[:, 0] - 0.5 * LONG), 0.0 * high], axis=1)
    stress = piece.resist(displacement, PlasticHistory.none(fine, 4)).stress
    return least_reserve(composite, fine, stress, piece.material)


def by_hand(along: float, across: float, shear: float, x: float, y: float) -> float:
    """Tsai and Hill, stresses in MPa."""
    return (along**2 / x**2 - along * across / x**2 + across**2 / y**2 + shear**2 / 75.0**2) ** -0.5


@jax.jit
def stress_when_stretched(stretch):
    """Of the wall, free to narrow."""
    material = wall()[1].material
    # coupling: strain across over strain along where no stress acts across
    return material.answer(jnp.stack([stretch, -stretch * material.coupling()[0], 0.0]), None).stress


@pytest.mark.quick
def test_its_membrane_is_as_stiff_as_the_laminate(evidence):
    stress = stress_when_stretched(1e-6)
    hand = 0.4 * (QUARTER + Q66) + 0.3 * Q11 + 0.3 * Q22  # of ten plies four are at ±45°, three at 0°, three at 90°
    assert float(stress[1]) == pytest.approx(0.0, abs=1e-3)
    off = abs(float(stress[0]) / hand - 1.0)
    evidence(TOPIC, "membrane stiffness of a tank's wall", off, 1e-5, "hand calculation by plies")


def test_a_stretched_wall_fails_first_at_0_degrees():
    strain = np.log1p(STRETCHED)
    hand = by_hand(Q11 * strain, Q12 * strain, 0.0, 1200.0, 50.0)
    other = by_hand((Q11 + Q12) / 2 * strain, (Q12 + Q22) / 2 * strain, Q66 * strain, 1200.0, 50.0)
    assert hand == pytest.approx(8.857, rel=1e-3) and hand < other
    assert reserve(STRETCHED, 0.0) == pytest.approx(hand, rel=1e-5)


def test_a_pressed_wall_fails_at_the_strengths_of_compression():
    strain = np.log1p(-STRETCHED)
    hand = by_hand(Q11 * strain, Q12 * strain, 0.0, 1000.0, 120.0)
    assert reserve(-STRETCHED, 0.0) == pytest.approx(hand, rel=1e-5)


def test_a_bent_wall_fails_first_where_the_outermost_0_degrees_are_pressed(evidence):
    strain = 1e-5  # small, so that logarithmic strains are linear across the thickness
    outer = by_hand((Q11 + Q12) / 2 * strain, (Q12 + Q22) / 2 * strain, Q66 * strain, 1200.0, 50.0)
    third = by_hand(0.8 * Q11 * strain, 0.8 * Q12 * strain, 0.0, 1000.0, 120.0)  # two plies further in
    assert third < outer
    off = abs(reserve(0.0, strain) / third - 1.0)
    evidence(TOPIC, "reserve of a bent wall", off, 1e-4, "hand calculation by plies")
    assert reserve(0.0, -strain) == pytest.approx(third, rel=1e-4)


def test_two_elements_across_see_the_same():
    assert reserve(2e-5, 1e-5, fine=2) == pytest.approx(reserve(2e-5, 1e-5), rel=1e-4)


def test_the_criterion_is_chosen():
    strain = np.log1p(STRETCHED)
    hand = min(1200.0 / (Q11 * strain), 50.0 / (Q22 * strain), 75.0 / (Q66 * strain))
    assert reserve(STRETCHED, 0.0, criterion="maximum-stress") == pytest.approx(hand, rel=1e-5)


def test_bending_is_nearly_as_stiff_as_the_laminate():
    # 12 D11/(A11 t²) of the lay-up, by the plies' distances from the middle: the elements are softer by 1.5 %
    stiff = {45.0: QUARTER + Q66, -45.0: QUARTER + Q66, 0.0: Q11, 90.0: Q22}
    half = (45.0, -45.0, 0.0, 90.0, 0.0, 90.0, 45.0, -45.0, 0.0, 90.0)
    d11 = sum(stiff[angle] * ((10 - k) ** 3 - (9 - k) ** 3) for k, angle in enumerate(half)) * 8.0 / 20.0**3
    a11 = sum(stiff[angle] for angle in half) / 10.0
    assert d11 / a11 == pytest.approx(1.0147, abs=1e-4)


@pytest.mark.quick
def test_unknown_criteria_and_kinds_are_refused():
    with pytest.raises(jb.InputError, match="criterion"):
        Composite(criterion="hope")
    with pytest.raises(jb.InputError, match="kind"):
        jb.replace(jb.TankDrop(), {"material.kind": "wood"})


def test_its_density_makes_the_mass():
    plastic, composite = jb.TankDrop(), jb.replace(jb.TankDrop(), {"material.kind": "composite"})
    assert float(wall_mass(composite)) / float(wall_mass(plastic)) == pytest.approx(1580.0 / 950.0)
