"""Failure criteria against printed reserve factors, computed strengths and their own identities."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.composites import (
    CRITERIA,
    Strength,
    hoffman,
    in_ply_axes,
    is_bounded,
    maximum_stress,
    tsai_hill,
    tsai_wu,
)

TOPIC = "Composites"
KAW = Strength(1500e6, 1500e6, 40e6, 246e6, 68e6)
GLASS = Strength(1080e6, 620e6, 39e6, 128e6, 89e6)
SIXTY = 1e6 * jnp.array([1.714102, -2.714102, -4.165064])


@pytest.mark.parametrize("name", CRITERIA)
@pytest.mark.parametrize(
    ("part", "strength"),
    [(0, "along_tension"), (0, "along_compression"), (1, "across_tension"), (1, "across_compression")],
)
def test_each_uniaxial_strength_has_a_reserve_factor_of_one(name, part, strength, evidence):
    sign = -1.0 if strength.endswith("compression") else 1.0
    stress = jnp.zeros(3).at[part].set(sign * getattr(GLASS, strength))
    off = abs(float(CRITERIA[name](stress, GLASS)) - 1.0)
    evidence(TOPIC, "reserve at a ply's own strengths", off, 1e-14, "1, by each criterion's definition")


@pytest.mark.parametrize("name", CRITERIA)
def test_so_has_shear_and_a_stress_half_as_large_has_two(name):
    assert float(CRITERIA[name](jnp.array([0.0, 0.0, -GLASS.shear]), GLASS)) == pytest.approx(1.0, rel=1e-14)
    twice = CRITERIA[name](0.5 * SIXTY, KAW)
    assert float(twice) == pytest.approx(2.0 * float(CRITERIA[name](SIXTY, KAW)), rel=1e-13)


@pytest.mark.parametrize(
    ("criterion", "megapascal"),
    [(maximum_stress, 16.3263), (tsai_hill, 16.0607), (tsai_wu, 22.3887), (hoffman, 22.4894)],
)
def test_a_sixty_degree_ply_of_graphite(criterion, megapascal, evidence):
    """Kaw's example: 2, -3 and 4 MPa times what is found."""
    off = abs(float(criterion(SIXTY, KAW)) - megapascal)
    evidence(TOPIC, "strength of a graphite ply at 60°", off, 6e-5, "Kaw's example, recomputed", "MPa")


@pytest.mark.parametrize(
    ("criterion", "megapascal"),
    [
        (tsai_wu, (1080.0, 788.0133, 303.8796, 123.3232, 70.9916, 50.2641, 41.4849, 39.0)),
        (hoffman, (1080.0, 765.0139, 289.8220, 119.8239, 70.0000, 49.9853, 41.4312, 39.0)),
        (tsai_hill, (1080.0, 739.7191, 294.4568, 123.9545, 71.4418, 50.4185, 41.5167, 39.0)),
    ],
)
def test_tensile_strength_of_glass_off_its_axis(criterion, megapascal, evidence):
    """pycomposites' example 3.11, recomputed with the ½ it lost."""
    for angle, strength in zip((0.0, 5.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0), megapascal, strict=True):
        stress = jnp.linalg.inv(in_ply_axes(angle).T) @ jnp.array([1e6, 0.0, 0.0])
        off = abs(float(criterion(stress, GLASS)) - strength)
        evidence(TOPIC, "strength of glass off its axis", off, 6e-5, "pycomposites, its slip mended", "MPa")


def test_hoffman_is_tsai_wu_with_another_interaction():
    x_t, x_c, y_t, y_c, _ = GLASS
    interaction = -0.5 * np.sqrt(y_t * y_c / (x_t * x_c))
    assert float(hoffman(SIXTY, GLASS)) == pytest.approx(float(tsai_wu(SIXTY, GLASS, interaction)), rel=1e-13)


def test_where_hoffman_limits_nothing():
    assert bool(is_bounded(GLASS))
    lopsided = GLASS._replace(across_tension=1e9, across_compression=4e9)
    assert not bool(is_bounded(lopsided))


def test_without_stress_the_reserve_is_infinite_and_its_slope_is_known_elsewhere():
    for criterion in CRITERIA.values():
        assert float(criterion(jnp.zeros(3), GLASS)) == np.inf
        slope = jax.grad(lambda s, criterion=criterion: criterion(s, GLASS))(SIXTY)
        # a reserve factor is homogeneous of degree -1 (Euler)
        assert float(slope @ SIXTY) == pytest.approx(-float(criterion(SIXTY, GLASS)), rel=1e-12)
