"""Bodies of any planar shape by scikit-fem, against bars, closed forms of elasticity and the shape's own symmetry."""

import builtins
import importlib
import sys

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.spatial import KDTree
from skfem import Basis, ElementQuad2, ElementVector, MeshQuad, MeshTri

from jaxbuffer.multibody import FlexibleBody, System
from jaxbuffer.multibody.flexible import Attachment, Bar, free_bar, planar_modes
from jaxbuffer.multibody.flexible.planar import _elasticity
from multibody.particles import Particles, dense_mass

TOPIC = "Modes of bars and shapes"
STEEL = {"thickness": 0.01, "density": 7850.0, "youngs_modulus": 2.07e11}


def rectangle(length, depth, cells=80, kind=MeshQuad):
    return kind.init_tensor(np.linspace(0.0, length, cells + 1), np.linspace(0.0, depth, 3))


def both_ends(length, depth):
    start = Attachment((0.0, depth / 2), lambda x: np.isclose(x[0], 0.0))
    return start, Attachment((length, depth / 2), lambda x: np.isclose(x[0], length))


def slender(depth, interior=6, ratio=0.3, kind=MeshQuad):
    return planar_modes(rectangle(1.0, depth, kind=kind), both_ends(1.0, depth), interior, ratio)


@pytest.mark.quick
@pytest.mark.parametrize("kind", [MeshQuad, MeshTri])
def test_a_slender_rectangle_is_a_bar(kind, evidence):
    """The difference from Euler and Bernoulli's bar is shear and rotary inertia: it falls with (depth/length)²."""
    errors = []
    for depth in (0.04, 0.02, 0.01):
        modes, _ = slender(depth, kind=kind).body(**STEEL)
        bar = free_bar(Bar.rectangle(1.0, 0.01, depth, 7850.0, 2.07e11), 6)
        errors.append(1.0 - np.asarray(modes.frequencies())[:2] / np.asarray(bar.modes.frequencies())[:2])
    errors = np.array(errors)
    evidence(TOPIC, "frequencies of a rectangle of 1 : 100, relative", np.abs(errors[-1]).max(), 2e-3, "the bar")
    orders = np.log2(errors[:-1, 0] / errors[1:, 0])
    evidence(TOPIC, "order of the difference in depth/length", np.abs(orders - 2.0).max(), 0.1, "theory: 2")


def test_shape_integrals_of_a_slender_rectangle(evidence):
    """Mass, inertia, and what a bar that stretches has: radial and gyroscopic terms of its first axial mode.

    With 40 interior modes, of which some are along the bar. ψ = √2 cos πξ has ∫ (ξ - ½) ψ dξ = -2√2/π².
    """
    modes, markers = slender(0.01, 40, 0.0).body(**STEEL)
    bar = eqx.filter_jit(free_bar)(Bar.rectangle(1.0, 0.01, 0.01, 7850.0, 2.07e11), 12, 12)
    assert modes.mass == pytest.approx(0.785) and modes.translation is None and modes.rotation is None
    assert modes.inertia == pytest.approx(0.785 * (1.0 + 1e-4) / 12.0, rel=1e-12)
    axial = int(np.argmax(np.abs(np.asarray(modes.radial))))
    closed = 0.785 * 2.0 * np.sqrt(2.0) / np.pi**2
    found = abs(float(modes.radial[axial])) / closed
    evidence(TOPIC, "radial coupling of a rectangle, relative", abs(found - 1.0), 5e-4, "a bar in closed form")
    found = abs(float(bar.modes.radial[bar.lateral])) / closed
    evidence(TOPIC, "radial coupling of a bar, relative", abs(found - 1.0), 5e-5, "closed form")
    squared = float(modes.stiffness[axial, axial] / modes.mass_matrix[axial, axial])
    found = np.sqrt(squared) / (np.pi * np.sqrt(2.07e11 / 7850.0))
    evidence(TOPIC, "first axial frequency of a rectangle, relative", abs(found - 1.0), 5e-4, "½ √(E/ρ)/L")
    assert [float(m.x) for m in markers] == pytest.approx([-0.5, 0.5])
    np.testing.assert_allclose(modes.gyroscopic + modes.gyroscopic.T, 0.0, atol=1e-12)


def test_gyroscopic_coupling_of_slender_rectangles(evidence):
    """Of the first axial and the second bending mode: shear makes the difference from the bar, as (depth/length)²."""
    bar = eqx.filter_jit(free_bar)(Bar.rectangle(1.0, 0.01, 0.01, 7850.0, 2.07e11), 40, 40)
    expected = abs(float(bar.modes.gyroscopic[bar.lateral, 1])) / bar.modes.mass
    errors = []
    for depth in (0.04, 0.02):
        modes, _ = slender(depth, 80, 0.0).body(**STEEL)
        axial = int(np.argmax(np.abs(np.asarray(modes.radial))))
        errors.append(abs(float(modes.gyroscopic[axial, 1])) / modes.mass / expected - 1.0)
    evidence(TOPIC, "gyroscopic coupling of a rectangle of 1 : 50, relative", abs(errors[1]), 3e-3, "a bar, 40 modes")
    order = np.log2(errors[0] / errors[1])
    evidence(TOPIC, "its order in depth/length", abs(order - 2.0), 0.2, "theory: 2")


def test_statics_through_markers(evidence):
    """End couples bend a rectangle to M L/EI, end forces stretch it by N L/EA: exact for ν = 0."""
    modes, (start, end) = slender(0.1, interior=0, ratio=0.0).body(**STEEL)
    stiffness = np.diag(np.asarray(modes.stiffness))
    second_moment, area = 0.01 * 0.1**3 / 12, 1e-3
    load = np.asarray(end.rotation - start.rotation)
    turned = load @ (load / stiffness)
    evidence(TOPIC, "rectangle under end couples, relative", abs(turned * 2.07e11 * second_moment - 1), 1e-8, "M L/EI")
    load = np.asarray(end.displacement_x - start.displacement_x)
    stretched = load @ (load / stiffness)
    evidence(TOPIC, "rectangle under end forces, relative", abs(stretched * 2.07e11 * area - 1), 1e-8, "N L/EA")


def l_shape(turn=0.0, shift=(0.0, 0.0)):
    """Two legs of 0.3 × 0.06 and 0.06 × 0.2 m, turned and moved; attachments at the ends of both."""
    x = np.concatenate([np.linspace(0.0, 0.06, 3), np.linspace(0.06, 0.3, 9)[1:]])
    y = np.concatenate([np.linspace(0.0, 0.06, 3), np.linspace(0.06, 0.26, 8)[1:]])
    mesh = MeshQuad.init_tensor(x, y)
    mesh = mesh.remove_elements(np.flatnonzero((mesh.p[:, mesh.t].mean(1) > 0.06).all(0)))
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    shift = np.array(shift)

    def attached(point, axis, value):
        def nodes(places):
            return np.isclose((rotation.T @ (places - shift[:, None]))[axis], value)

        return Attachment(tuple(rotation @ np.array(point) + shift), nodes)

    moved = MeshQuad(rotation @ mesh.p + shift[:, None], mesh.t)
    return moved, (attached((0.3, 0.03), 0, 0.3), attached((0.03, 0.26), 1, 0.26))


def test_an_l_shape_wherever_it_lies(evidence):
    """Centre and inertia in closed form; neither frequencies nor couplings know where the mesh lies."""
    mesh, attachments = l_shape()
    found = planar_modes(mesh, attachments, 4, 0.3)
    legs = np.array([[0.018, 0.15, 0.03], [0.012, 0.03, 0.16]])
    area, centre = legs[:, 0].sum(), legs[:, 0] @ legs[:, 1:] / 0.03
    own = 0.018 * (0.3**2 + 0.06**2) / 12 + 0.012 * (0.06**2 + 0.2**2) / 12
    inertia = own + legs[:, 0] @ ((legs[:, 1:] - centre) ** 2).sum(1)
    evidence(
        TOPIC,
        "an L's area, centre, inertia",
        max(abs(found.area / area - 1), abs(found.inertia / inertia - 1), np.abs(found.centre - centre).max()),
        1e-12,
        "closed form",
    )
    other = planar_modes(*l_shape(0.7, (1.0, -2.0)), 4, 0.3)
    evidence(
        TOPIC,
        "an L turned: eigenvalues",
        np.abs(other.eigenvalues / found.eigenvalues - 1).max(),
        1e-8,
        "the same, not turned",
    )
    radial = np.abs(np.abs(other.radial) - np.abs(found.radial)).max() / np.abs(found.radial).max()
    evidence(TOPIC, "an L turned: radial coupling", radial, 1e-7, "the same, not turned")
    gyroscopic = np.abs(np.abs(other.gyroscopic) - np.abs(found.gyroscopic)).max() / np.abs(found.gyroscopic).max()
    evidence(TOPIC, "an L turned: gyroscopic coupling", gyroscopic, 1e-7, "the same, not turned")


def test_reduced_frequencies_tend_to_those_of_the_mesh(evidence):
    """From above, as the number of fixed-interface modes grows; the ends are not tied in the mesh, which is softer."""
    mesh, attachments = l_shape()
    mass, stiffness = (m.toarray() for m in _elasticity(Basis(mesh, ElementVector(ElementQuad2())), 0.3)[:2])
    free = eigh(stiffness, mass, eigvals_only=True)[3:6]
    errors = np.array([planar_modes(mesh, attachments, n, 0.3).eigenvalues[:3] / free - 1 for n in (0, 4, 12, 30)])
    assert (errors > 0).all() and (np.diff(errors, axis=0) < 0).all()
    evidence(TOPIC, "an L, 30 modes: eigenvalues, relative", errors[-1].max(), 0.02, "the whole mesh")


def test_attachments_lie_where_they_were_put():
    found = planar_modes(*l_shape(), 4, 0.3)
    modes, markers = found.body(**STEEL)
    arms = np.array([[m.x, m.y] for m in markers], float)
    np.testing.assert_allclose(arms, np.array([[0.3, 0.03], [0.03, 0.26]]) - found.centre, atol=1e-12)
    assert modes.size == 7 and float(modes.frequencies()[0]) > 100.0


def gauss_points(mesh, shape):
    """The quadrature's points of an L of steel as particles: quadratic elements, each node known by its place."""
    basis = Basis(mesh, ElementQuad2(), intorder=8)
    distance, node = KDTree((shape.nodes + shape.centre[:, None]).T).query(basis.doflocs.T)
    assert distance.max() < 1e-12
    values = shape.shapes[:, node].transpose(0, 2, 1)
    shapes = np.array([[np.asarray(basis.interpolate(mode)).ravel() for mode in part] for part in values])
    place = np.asarray(basis.global_coordinates()).reshape(2, -1) - shape.centre[:, None]
    return Particles(STEEL["density"] * STEEL["thickness"] * basis.dx.ravel(), place, shapes.transpose(0, 2, 1))


@eqx.filter_jit
def of_motion(system, particles, q, v):
    """Energy and both momenta by the system and by particles; its kinematics; the particles' mass matrix."""
    kin = system.kinematics(q, v)
    found = system.kinetic_energy(kin), system.linear_momentum(kin), system.angular_momentum(kin)
    expected = particles.kinetic_energy(q, v), *particles.momenta(q, v)
    return found, expected, kin, jax.hessian(particles.kinetic_energy, 1)(q, v)


def test_energy_and_momenta_of_an_l_that_moves_and_bends(evidence):
    """Kinetic energy, mass matrix and both momenta by quadrature of the velocity over the shape."""
    mesh, attachments = l_shape(0.7, (1.0, -2.0))
    shape = planar_modes(mesh, attachments, 4, 0.3)
    particles, system = gauss_points(mesh, shape), System((FlexibleBody(shape.body(**STEEL)[0]),))
    rng = np.random.default_rng(11)
    q, v = np.append(rng.normal(size=3), 0.05 * rng.normal(size=7)), rng.normal(size=10)
    by_system, by_particles, kin, mass = of_motion(system, particles, q, v)
    pairs = [*zip(by_system, by_particles, strict=True), (dense_mass(system, kin), mass)]
    names = ("kinetic energy", "linear momentum", "angular momentum", "mass matrix")
    for name, (found, expected) in zip(names, pairs, strict=True):
        off = np.max(np.abs(np.asarray(found) - np.asarray(expected))) / np.max(np.abs(np.asarray(expected)))
        evidence(TOPIC, f"an L in motion, {name}, relative", off, 1e-11, "quadrature over the shape")


def test_scales_flow_through(evidence):
    """Frequencies go with size⁻¹ ρ^-½ E^½ and not with the thickness; radial coupling with size³."""
    shape = planar_modes(*l_shape(), 2, 0.3)

    @jax.jit
    @jax.jacfwd
    def slopes_of(log):
        modes, markers = shape.body(*jnp.exp(log))
        omega = 0.5 * jnp.log(modes.stiffness[1, 1] / modes.mass_matrix[1, 1])
        return jnp.stack(
            [omega, jnp.log(jnp.abs(modes.radial[0])), jnp.log(modes.inertia), jnp.log(jnp.abs(markers[1].rotation[0]))]
        )

    slopes = slopes_of(np.log([0.01, 7850.0, 2e11, 1.3]))
    expected = np.array([[0, -0.5, 0.5, -1], [1, 1, 0, 3], [1, 1, 0, 4], [0, 0, 0, -1]])
    evidence(TOPIC, "derivatives to size, thickness, material", np.abs(slopes - expected).max(), 1e-9, "similarity")


@pytest.mark.quick
def test_attachments_that_cannot_be():
    mesh = rectangle(1.0, 0.1, 4)
    start, end = both_ends(1.0, 0.1)
    with pytest.raises(ValueError, match="give at least one"):
        planar_modes(mesh, (), 2, 0.3)
    with pytest.raises(ValueError, match=r"attachments\[1\]: its nodes are shared"):
        planar_modes(mesh, (start, Attachment((0.0, 0.0), lambda x: x[0] < 0.3)), 2, 0.3)
    with pytest.raises(ValueError, match=r"attachments\[0\]: its nodes are none"):
        planar_modes(mesh, (Attachment((0.0, 0.0), lambda x: x[0] > 3.0), end), 2, 0.3)


def test_without_scikit_fem(monkeypatch):
    """It is imported with what needs it, and said by name where it is absent."""
    imported = builtins.__import__

    def without(name, *rest):
        if name.partition(".")[0] == "skfem":
            raise ImportError(name)
        return imported(name, *rest)

    monkeypatch.delitem(sys.modules, "jaxbuffer.multibody.flexible.planar")
    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ImportError, match="planar shapes need scikit-fem: pip install scikit-fem"):
        importlib.import_module("jaxbuffer.multibody.flexible.planar")
