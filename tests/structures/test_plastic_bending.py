"""A wall of one element that is bent until it yields, against fibres without stress across the wall."""

import functools

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer.structures import Plane, Plastic, Quads, at_faces
from jaxbuffer.structures.mapping import Rule

TOPIC = "Finite elements, liquid and contact"
YOUNG, YIELD, THICKNESS, LENGTH = 1e9, 1e5, 0.7, 1.1  # so stiff that strains are small
STEPS = 600
CURVATURES = np.linspace(0.0, 6.0, STEPS + 1)[1:]  # of that at which the faces begin to yield


POINTS = {2: np.inf, 4: 0.16, 8: 0.032, 16: 0.01}  # across the wall: how far from the exact moment, in shares of it


def first_yield(poisson):
    """Curvature [1/m] and moment [N m/m] at which the faces of a plate reach the yield stress, nothing across it."""
    stress = YIELD / np.sqrt(1.0 - poisson + poisson**2)
    return 2.0 * stress * (1.0 - poisson**2) / (YOUNG * THICKNESS), stress * THICKNESS**2 / 6.0


def bent(poisson, hardening, across):
    """By our element: moment over curvature [N m/m], energy it stores and loses [J/m], stress on the faces [Pa]."""
    curvature = CURVATURES * first_yield(poisson)[0]
    return tuple(map(np.asarray, bent_by(curvature, poisson, hardening, across)))


@functools.partial(jax.jit, static_argnames="across")
def bent_by(curvatures, poisson, hardening, across):
    """The same of the wall that is bent by each of the curvatures [1/m] in turn."""
    x, y = 0.5 * LENGTH, 0.5 * THICKNESS
    positions = jnp.array([[-x, -y], [x, -y], [x, y], [-x, y]])
    material = Plastic(1.0, YOUNG, poisson, YIELD, hardening, 1e9)
    wall = Plane(Quads.of(positions, np.array([[0, 1, 2, 3]]), across), material)
    along = positions[:, 0] * positions[:, 1]

    def one(history, curvature):
        found = wall.resist(jnp.stack([curvature * along, jnp.zeros(4)], axis=1), history)
        moment = y * (found.forces[2, 0] - found.forces[1, 0])
        stress = jnp.max(jnp.abs(at_faces(found.stress)[..., 0]))
        return found.history, (moment, found.stored, found.plastic, stress)

    return jax.lax.scan(one, wall.start(), curvatures)[1]


def fibres(poisson, hardening, heights, widths):
    """Moments [N m/m] of fibres at ``heights`` over the middle, as high as ``widths``, in shares of half the thickness;
    each is as strained across as makes its stress there vanish."""
    y, count = 0.5 * THICKNESS * heights, len(heights)
    shear, bulk = 0.5 * YOUNG / (1.0 + poisson), YOUNG / (3.0 * (1.0 - 2.0 * poisson))
    plastic, equivalent, moments = np.zeros((3, count)), np.zeros(count), []

    def returned(along, across):
        volume = along + across
        trial = 2.0 * shear * (np.stack([along, across, 0.0 * along]) - plastic - volume / 3.0)
        mises = np.sqrt(1.5 * np.sum(trial**2, axis=0))
        flow = np.maximum(mises - YIELD - hardening * equivalent, 0.0) / (3.0 * shear + hardening)
        change = 1.5 * flow * trial / np.where(mises > 0.0, mises, 1.0)
        return trial - 2.0 * shear * change + bulk * volume, change, flow

    for curvature in CURVATURES * first_yield(poisson)[0]:
        along = curvature * y
        low, high = -3.0 * np.abs(along), 3.0 * np.abs(along)
        for _ in range(60):
            middle = 0.5 * (low + high)
            pulls = returned(along, middle)[0][1] > 0.0
            low, high = np.where(pulls, low, middle), np.where(pulls, middle, high)
        stress, change, flow = returned(along, 0.5 * (low + high))
        plastic, equivalent = plastic + change, equivalent + flow
        moments.append(0.5 * THICKNESS * np.sum(stress[0] * y * widths))
    return np.array(moments)


def many():
    """Heights and widths of so many fibres that more change nothing."""
    return (np.arange(400) + 0.5) / 200.0 - 1.0, np.full(400, 1.0 / 200.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("poisson", "hardening", "points"),
    [
        pytest.param(0.0, 0.0, POINTS, marks=pytest.mark.long),
        pytest.param(0.0, 0.05 * YOUNG, POINTS, marks=pytest.mark.long),
        pytest.param(0.4, 0.0, POINTS, marks=pytest.mark.long),
        (0.4, 0.05 * YOUNG, [4]),
        pytest.param(0.4, 0.05 * YOUNG, POINTS, marks=pytest.mark.slow),
        pytest.param(0.49, 0.0, POINTS, marks=pytest.mark.long),
        pytest.param(0.49, 0.05 * YOUNG, POINTS, marks=pytest.mark.long),
    ],
)
def test_moments_are_those_of_fibres(poisson, hardening, points, evidence):
    """Of fibres where the element has its points, however far the wall is bent: no stress across it grows with the
    plastic strain, though the elastic narrowing of the element is less. The more points, the nearer the exact moment:
    four are off by up to a sixth."""
    exact = fibres(poisson, hardening, *many())
    for across in points:
        rule = Rule.of(across)
        moments = bent(poisson, hardening, across)[0]
        same = np.max(np.abs(moments / fibres(poisson, hardening, rule.points[::2, 1], rule.weights[::2]) - 1.0))
        evidence(TOPIC, "moment of a wall bent far beyond yielding", same, 6e-3, "fibres, integrated by themselves")
        assert np.abs(moments / exact - 1.0).max() < POINTS[across]


def test_the_fully_plastic_moment():
    """Without hardening, of a material that keeps its volume, in closed form: what checks the fibres."""
    exact = np.where(CURVATURES < 1.0, CURVATURES, 1.5 - 0.5 / CURVATURES**2)
    np.testing.assert_allclose(fibres(0.4999, 0.0, *many()) / first_yield(0.4999)[1], exact, rtol=2e-3)


@pytest.mark.parametrize("across", [4, 6])
def test_yielding_begins_where_the_faces_reach_the_yield_stress(across):
    moments, _, plastic, stress = bent(0.4, 0.0, across)
    _, first = first_yield(0.4)
    before = CURVATURES < 0.999
    np.testing.assert_allclose(moments[before], CURVATURES[before] * first, rtol=2e-4)
    assert np.all(plastic[before] == 0.0) and np.all(plastic[CURVATURES > 1.03] > 0.0)
    assert np.all(stress < 2.0 / np.sqrt(3.0) * YIELD * 1.02), "what a plane can carry"


def test_work_is_stored_or_lost():
    moments, stored, plastic, _ = bent(0.4, 0.05 * YOUNG, 4)
    curvature = np.concatenate([[0.0], CURVATURES]) * first_yield(0.4)[0]
    along = np.concatenate([[0.0], moments])
    work = LENGTH * np.cumsum(0.5 * (along[1:] + along[:-1]) * np.diff(curvature))
    np.testing.assert_allclose(stored + plastic, work, rtol=1e-3)
