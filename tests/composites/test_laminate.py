"""Laminates against Aerospatiale's printed reserve factors and ply stresses, and what theory says of lay-ups."""

import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.composites import Laminate, Ply, Strength, hoffman, tsai_hill, tsai_wu

TOPIC = "Composites"
HALF = (45.0, -45.0, 0.0, 90.0, 0.0, 90.0, 45.0, -45.0, 0.0, 90.0)
PANEL = Laminate(Ply(130e9, 4.65e9, 4.65e9, 0.35, 0.13e-3), (*HALF, *HALF[::-1]))
STRENGTH = Strength(1200e6, 1000e6, 50e6, 120e6, 75e6)
FORCES = 1e3 * jnp.array([308.3, -22.2, 449.2])  # N/m
PLIES = {0.0: 2, 45.0: 0, -45.0: 1, 90.0: 3}  # where each angle first is


@pytest.mark.parametrize(
    ("criterion", "factors"),
    [
        (tsai_hill, {0.0: 1.4016, 45.0: 1.4216, -45.0: 1.3139, 90.0: 1.4248}),
        (hoffman, {0.0: 1.4269, 45.0: 1.5351, -45.0: 1.1917, 90.0: 1.3317}),
        (tsai_wu, {0.0: 1.4294, 45.0: 1.4030, -45.0: 1.0679, 90.0: 1.3206}),
    ],
)
def test_reserve_factors_of_aerospatiales_lay_up(criterion, factors, evidence):
    """MTS 006 prints 1.40, 1.42, 1.31 and 1.42 by Tsai-Hill."""
    found = PANEL.reserve_factors(FORCES, jnp.zeros(3), STRENGTH, criterion)
    for angle, factor in factors.items():
        off = abs(float(found[PLIES[angle]]) - factor)
        evidence(TOPIC, "reserve factors of a lay-up of 20 plies", off, 6e-5, "Aerospatiale's MTS 006, recomputed")


@pytest.mark.parametrize(
    ("angle", "megapascal"),
    [
        (0.0, (294.237, 0.554, 50.251)),
        (45.0, (801.720, -11.394, -13.647)),
        (-45.0, (-591.661, 21.412, 13.647)),
        (90.0, (-84.178, 9.464, -50.251)),
    ],
)
def test_ply_stresses_of_aerospatiales_lay_up(angle, megapascal, evidence):
    stresses = PANEL.stresses(*PANEL.strains(FORCES, jnp.zeros(3)))
    off = np.max(np.abs(1e-6 * stresses[PLIES[angle], 0] - np.array(megapascal)))
    evidence(TOPIC, "ply stresses of a lay-up of 20 plies", off, 6e-4, "Aerospatiale's MTS 006, recomputed", "MPa")


def test_one_isotropic_ply_bends_as_a_plate():
    young, poisson, thickness = 70e9, 0.3, 2e-3
    sheet = Laminate(Ply(young, young, young / 2.6, poisson, thickness), (30.0,))
    a, b, d = sheet.stiffness()
    plate = young * thickness**3 / 12.0 / (1.0 - poisson**2)
    np.testing.assert_allclose(d[0, 0], plate, rtol=1e-13)
    np.testing.assert_allclose(d, a * thickness**2 / 12.0, atol=1e-12 * plate)
    np.testing.assert_allclose(b, 0.0, atol=1e-9)


@pytest.mark.parametrize("angle", [30.0, -70.0])
def test_a_turned_ply_pulled_along_its_fibres_carries_along_them_only(angle, evidence):
    """σ (c², s², cs) in the laminate's axes; it stretches along the fibres by σ/E1 and narrows by ν12 of that."""
    ply, pull = PANEL.ply, 1e8
    c, s = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    one = Laminate(ply, (angle,))
    strain, curvature = one.strains(pull * ply.thickness * jnp.array([c * c, s * s, c * s]), jnp.zeros(3))
    np.testing.assert_allclose(one.stresses(strain, curvature)[0, 0], [pull, 0.0, 0.0], atol=1e-9 * pull)
    along, across = pull / ply.along, -ply.poisson * pull / ply.along
    exact = [along * c * c + across * s * s, along * s * s + across * c * c, 2.0 * (along - across) * c * s]
    off = np.max(np.abs(strain / np.array(exact) - 1.0))
    evidence(TOPIC, "strains of a turned ply", off, 1e-11, "a ply pulled along its fibres, closed form")


def test_bending_stretches_the_two_faces_against_each_other():
    sheet = Laminate(Ply(70e9, 70e9, 70e9 / 2.6, 0.3, 1e-3), (0.0, 0.0))
    moment = jnp.array([100.0, 0.0, 0.0])  # N
    strain, curvature = sheet.strains(jnp.zeros(3), moment)
    stresses = sheet.stresses(strain, curvature)
    np.testing.assert_allclose(stresses[0, 0, 0], -6.0 * 100.0 / 2e-3**2, rtol=1e-12)  # 6 M/t²
    np.testing.assert_allclose(stresses[1, 1, 0], 6.0 * 100.0 / 2e-3**2, rtol=1e-12)


def test_a_symmetric_lay_up_bent_the_other_way_changes_its_faces():
    moment = jnp.array([50.0, 0.0, 0.0])
    one, other = (PANEL.reserve_factors(jnp.zeros(3), sign * moment, STRENGTH) for sign in (1.0, -1.0))
    np.testing.assert_allclose(one, other[::-1], rtol=1e-9)
    assert float(jnp.abs(one - other).max()) > 1.0, "tension and compression are told apart"


def test_the_thickness_is_that_of_all_plies():
    assert float(PANEL.thickness) == pytest.approx(2.6e-3)
    assert PANEL.interfaces.shape == (21,)
    assert float(PANEL.interfaces[0]) == pytest.approx(-1.3e-3)
