"""Flexible bars: integrals, couplings, static and spinning cases in closed form, derivatives."""

from functools import cache

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.integrate import quad
from scipy.linalg import eigh

from jaxbuffer.multibody.flexible import (
    Bar,
    axial_force,
    bending_moment,
    cantilever_bar,
    deflection,
    free_bar,
    modal_damping,
    pinned_bar,
    plate_strip,
    rayleigh_damping,
    stress,
)
from jaxbuffer.multibody.flexible.bar_elements import quadrature

TOPIC = "Modes of bars and shapes"
UNIT = Bar(1.0, 1.0, 1.0, 1.0, 1.0)
STEEL = Bar.rectangle(0.6, 0.02, 0.01, 7850.0, 2.07e11)
BUILDERS = {
    "free": lambda bar: free_bar(bar, 3, 1),
    "cantilever": lambda bar: cantilever_bar(bar, 2, 1),
    "cantilever with a tip": lambda bar: cantilever_bar(
        bar,
        2,
        1,
        tip_mass=0.7 * bar.mass,
        tip_inertia=0.02 * bar.mass * bar.length**2,
    ),
    "pinned": lambda bar: pinned_bar(bar, 3, True),
    "strip": lambda bar: plate_strip(bar, 3),
    "clamped strip": lambda bar: plate_strip(bar, (1, 3), support="clamped"),
}
SPINNING = {
    "free and spinning": lambda bar: free_bar(bar, 3, 1, geometric=True),
    "blade": lambda bar: cantilever_bar(bar, 2, geometric=True, tip_mass=0.7 * bar.mass, hub_radius=0.3 * bar.length),
}
each_builder = pytest.mark.parametrize("kind", BUILDERS)


@eqx.filter_jit
def built(build, *arguments, **options):
    """A builder's body, in one program in place of its many operations."""
    return build(*arguments, **options)


@eqx.filter_jit
def frequencies(modes, spin=0.0):
    return modes.frequencies(spin)


@cache
def of_kind(kind):
    """A bar, and what `of_markers` tells of it."""
    body = built(BUILDERS[kind], STEEL)
    return body, *of_markers(body)


def of_markers(body):
    """(stations, 2) places, (2, stations, modes) shapes and masses at the quadrature's stations, by markers alone."""
    stations, weights = quadrature(60)
    markers = [body.marker(float(xi)) for xi in stations]
    places = np.array([[m.x, m.y] for m in markers], float)
    shapes = np.array([[m.displacement_x for m in markers], [m.displacement_y for m in markers]])
    return places, shapes, np.asarray(weights * body.bar.mass)


def energy_by_integrals(modes, spin, velocity, q, rate):
    """M113 with the frame along the inertial axes."""
    zero = np.zeros(modes.size)
    translation = np.zeros((2, modes.size)) if modes.translation is None else np.asarray(modes.translation)
    rotation = zero if modes.rotation is None else np.asarray(modes.rotation)
    radial = zero if modes.radial is None else np.asarray(modes.radial)
    geometric = np.zeros((modes.size, modes.size)) if modes.geometric is None else np.asarray(modes.geometric)
    gyroscopic = np.zeros((modes.size, modes.size)) if modes.gyroscopic is None else np.asarray(modes.gyroscopic)
    mass = np.asarray(modes.mass_matrix)
    first = translation @ q
    moving = spin * np.array([-first[1], first[0]]) + translation @ rate
    return (
        0.5 * modes.mass * velocity @ velocity
        + 0.5 * spin**2 * (modes.inertia + 2.0 * radial @ q + q @ (mass - geometric) @ q)
        + 0.5 * rate @ mass @ rate
        + spin * (rotation + gyroscopic.T @ q) @ rate
        + velocity @ moving
    )


@each_builder
def test_kinetic_energy_by_integrals_and_by_points(kind, evidence):
    """All couplings at once: ½ ∫ |ṙ + ω (x + Φq)^⊥ + Φq̇|² dm over points of the bar."""
    body, places, shapes, masses = of_kind(kind)
    rng = np.random.default_rng(1)
    q, rate = rng.normal(size=(2, body.modes.size)) * 0.1
    spin, velocity = 1.7, rng.normal(size=2)
    moved = places + np.moveaxis(shapes @ q, 0, 1)
    points = velocity + spin * np.stack([-moved[:, 1], moved[:, 0]], 1) + np.moveaxis(shapes @ rate, 0, 1)
    expected = 0.5 * masses @ (points**2).sum(1)
    if "tip" in kind:
        tip = body.end
        at = tip.place(jnp.asarray(q))
        moving = tip.displacement(jnp.asarray(rate))
        v = velocity + spin * np.array([-at.y, at.x]) + np.array(moving)
        turning = spin + tip.turn(jnp.asarray(rate))
        expected += 0.35 * STEEL.mass * v @ v + 0.01 * STEEL.mass * STEEL.length**2 * turning**2
    found = energy_by_integrals(body.modes, spin, velocity, q, rate)
    evidence(
        TOPIC, "kinetic energy by shape integrals", abs(found / expected - 1.0), 1e-10, "points of the bar", detail=kind
    )


@each_builder
def test_the_frames_origin_is_the_centre_of_mass(kind):
    body, places, _, masses = of_kind(kind)
    tip = 0.7 * STEEL.mass * float(body.end.x) if "tip" in kind else 0.0
    assert body.modes.static_moment is None
    assert abs(masses @ places[:, 0] + tip) < 1e-12
    inertia = masses @ places[:, 0] ** 2 + (STEEL.mass * (0.7 * float(body.end.x) ** 2 + 0.02 * 0.36) if tip else 0.0)
    np.testing.assert_allclose(body.modes.inertia, inertia, rtol=1e-12)


@each_builder
def test_orthogonal_modes_are_said_to_be(kind):
    modes = of_kind(kind)[0].modes
    diagonal = all(np.count_nonzero(np.asarray(m)) == modes.size for m in (modes.mass_matrix, modes.stiffness))
    assert modes.orthogonal == diagonal


def test_what_mean_axes_leave_out(evidence):
    """A free bar's modes carry no momentum: their integrals are left out, and are zero by the markers."""
    body = built(free_bar, STEEL, 6, 2)
    assert body.modes.translation is None and body.modes.rotation is None
    places, shapes, masses = of_markers(body)
    linear = np.abs(np.einsum("p,dpn->dn", masses, shapes)).max() / STEEL.mass
    angular = np.abs(masses * places[:, 0] @ shapes[1]).max() / (STEEL.mass * STEEL.length)
    evidence(TOPIC, "momentum of a free bar's modes", max(linear, angular), 1e-12, "zero")
    alone = built(free_bar, STEEL, 6)
    assert alone.modes.radial is None and alone.modes.gyroscopic is None and alone.modes.geometric is None


@pytest.mark.quick
def test_simeons_rod(evidence):
    """Two sines and two quadratic nodes, with the data of the slider crank in the IVP test set."""
    bar = Bar.rectangle(0.3, 0.008, 0.008, 7870.0, 2e11)
    bar = Bar(bar.length, bar.area, bar.second_moment, bar.density, bar.youngs_modulus, rotary_inertia=True)
    modes = pinned_bar(bar, 2, True).modes
    about_start = modes.inertia + modes.mass * 0.15**2
    evidence(TOPIC, "Simeon's rod: mass", abs(modes.mass - 0.151104), 1e-12, "IVP test set", "kg")
    evidence(
        TOPIC,
        "Simeon's rod: inertia about the crank pin",
        abs(about_start - 0.0045339259),
        5e-11,
        "IVP test set",
        "kg m²",
    )
    bending = 2e11 * 0.008**4 / 12 * np.pi**4 / 2 / 0.3**3 * np.array([1.0, 16.0])
    np.testing.assert_allclose(modes.stiffness[:2, :2], np.diag(bending), rtol=1e-12)
    np.testing.assert_allclose(modes.mass_matrix[:2, :2], 0.075552 * np.eye(2), rtol=1e-12)
    np.testing.assert_allclose(modes.mass_matrix[2:, 2:], 0.151104 / 15 * np.array([[8, 1], [1, 2]]), rtol=1e-12)
    stretching = 2e11 * 0.008**2 / 0.9 * np.array([[16, -8], [-8, 7]])
    np.testing.assert_allclose(modes.stiffness[2:, 2:], stretching, rtol=1e-12)
    moments = [quad(lambda x, k=k: (x - 0.5) * np.sin(k * np.pi * x), 0, 1)[0] for k in (1, 2)]
    np.testing.assert_allclose(modes.rotation[:2], 0.151104 * 0.3 * np.array(moments), atol=1e-16)
    means = [0.151104 * (1 - np.cos(k * np.pi)) / (k * np.pi) for k in (1, 2)]
    np.testing.assert_allclose(modes.translation, [[0, 0, 0.151104 * 2 / 3, 0.151104 / 6], [*means, 0, 0]], atol=1e-15)
    np.testing.assert_allclose(modes.radial[2:], 0.151104 * 0.3 * np.array([0.0, 1 / 12]), atol=1e-15)
    products = [quad(lambda x, k=k: 4 * x * (1 - x) * np.sin(k * np.pi * x), 0, 1)[0] for k in (1, 2)]
    np.testing.assert_allclose(modes.gyroscopic[2, :2], 0.151104 * np.array(products), atol=1e-15)
    np.testing.assert_allclose(modes.gyroscopic + modes.gyroscopic.T, 0.0)


def test_integrals_of_a_cantilevers_first_modes(evidence):
    """∫ φ dξ = 2σ/β and ∫ ξ φ dξ = 2/β² of clamped-free modes with ∫ φ² dξ = 1, to the fixed-interface modes kept."""
    body = built(cantilever_bar, UNIT, 12)
    beta = np.array([1.875104068711961, 4.694091132974175])
    sigma = (np.sinh(beta) - np.sin(beta)) / (np.cosh(beta) + np.cos(beta))
    translation = np.asarray(body.modes.translation)[1]
    mean, moment = translation[:2], (np.asarray(body.modes.rotation) + 0.5 * translation)[:2]
    signs = np.sign(mean)
    evidence(TOPIC, "∫φ of a cantilever's modes", np.abs(mean * signs - 2 * sigma / beta).max(), 1e-6, "closed form")
    evidence(TOPIC, "∫ξφ of a cantilever's modes", np.abs(moment * signs - 2 / beta**2).max(), 1e-6, "closed form")


WRIGHT = {0: 3.5160, 1: 3.6816, 2: 4.1373, 3: 4.7973, 4: 5.5850, 5: 6.4495, 12: 13.1702}


@pytest.mark.quick
@pytest.mark.parametrize("spin", WRIGHT)
def test_a_rotating_beam_stiffens(spin, evidence):
    """Out of the plane of rotation ω² is greater by Ω² than in it. Unit bar, hub radius 0, 18 modes."""
    body = cantilever_bar(UNIT, 16, geometric=True)
    found = np.sqrt((2.0 * np.pi * float(body.modes.frequencies(float(spin))[0])) ** 2 + spin**2)
    source = "Wright, Smith, Thresher and Wang 1982"
    evidence(TOPIC, "frequency of a rotating cantilever", abs(found - WRIGHT[spin]), 5e-5, source, detail=f"η = {spin}")


def ritz(hub, tip, inertia, spin, terms=9):
    """ω of a rotating unit cantilever with a tip, in its plane, by the polynomials ξ², ξ³, …"""
    basis = [Polynomial([0.0] * power + [1.0]) for power in range(2, 2 + terms)]
    tension = Polynomial([0.5 + hub + tip * (1 + hub), -hub, -0.5])

    def matrix(form):
        return np.array([[form(a, b) for b in basis] for a in basis])

    mass = matrix(lambda a, b: (a * b).integ()(1.0) + tip * a(1.0) * b(1.0))
    turning = matrix(lambda a, b: inertia * a.deriv()(1.0) * b.deriv()(1.0))
    stiffness = matrix(lambda a, b: (a.deriv(2) * b.deriv(2)).integ()(1.0))
    geometric = matrix(lambda a, b: (tension * a.deriv() * b.deriv()).integ()(1.0))
    return np.sqrt(eigh(stiffness + spin**2 * (geometric - mass), mass + turning)[0])


@pytest.mark.parametrize(
    ("hub", "tip", "inertia"), [(0.0, None, None), (1.0, None, None), (0.5, 0.8, 0.05), (0.0, None, 0.03)]
)
def test_hub_radius_and_tip(hub, tip, inertia, evidence):
    """Against polynomials, which know nothing of elements."""
    body = built(cantilever_bar, UNIT, 12, tip_mass=tip, tip_inertia=inertia, hub_radius=hub, geometric=True)
    for spin in (0.0, 3.0):
        found = 2.0 * np.pi * np.asarray(frequencies(body.modes, np.array(spin)))[:2]
        error = np.abs(found / ritz(hub, tip or 0.0, inertia or 0.0, spin)[:2] - 1.0).max()
        evidence(
            TOPIC, "cantilever with hub and tip", error, 1e-5, "Ritz's method with polynomials", detail=f"{hub} {tip}"
        )


def test_tension_of_a_free_bar():
    """½ ω² m L (ξ - ξ²), by another quadrature than the builder's."""
    body = built(free_bar, UNIT, 8, geometric=True)
    stations, weights = quadrature(60, 7)
    slopes = body.shapes.lateral(stations, 1)
    expected = slopes.T @ (slopes * (weights * 0.5 * stations * (1.0 - stations))[:, None])
    np.testing.assert_allclose(body.modes.geometric, expected, atol=1e-10)


@pytest.mark.quick
def test_statics_of_a_cantilever(evidence):
    """A tip force bends it to P L³/3EI by the constraint modes alone; a pull stretches it by N L/EA."""
    body = cantilever_bar(STEEL, 0, 0)
    pull, push = 2000.0, 35.0
    load = np.asarray(body.end.displacement_x) * pull + np.asarray(body.end.displacement_y) * push
    q = jnp.asarray(np.linalg.solve(np.asarray(body.modes.stiffness), load))
    length, rigidity = STEEL.length, STEEL.bending_stiffness
    xi = np.array([0.0, 0.25, 0.6, 1.0])
    expected = push * length**3 / 6 / rigidity * xi**2 * (3 - xi)
    moved = np.asarray(deflection(body, q, xi))
    source = "Euler-Bernoulli"
    evidence(
        TOPIC,
        "deflection of a loaded cantilever",
        np.abs(moved[:, 1] / expected[-1] - expected / expected[-1]).max(),
        1e-9,
        source,
    )
    assert expected[-1] == pytest.approx(push * length**3 / 3 / rigidity)
    stretched = pull * length / STEEL.axial_stiffness
    evidence(TOPIC, "stretching of a cantilever", np.abs(moved[:, 0] / stretched - xi).max(), 1e-9, source)
    moment = np.abs(np.asarray(bending_moment(body, q, xi)) / (push * length) - (1 - xi)).max()
    evidence(TOPIC, "bending moment of a cantilever", moment, 1e-7, source)
    evidence(
        TOPIC,
        "axial force of a cantilever",
        np.abs(np.asarray(axial_force(body, q, xi)) / pull - 1).max(),
        1e-9,
        source,
    )
    root = float(stress(body, q, [0.0], 0.005)[0])
    expected = pull / STEEL.area - push * length * 0.005 / STEEL.second_moment
    evidence(TOPIC, "stress at the root", abs(root / expected - 1.0), 1e-7, source)
    slope = float(body.end.turn(q)) / (push * length**2 / 2 / rigidity)
    evidence(TOPIC, "slope at the tip", abs(slope - 1.0), 1e-9, source)


@pytest.mark.parametrize(("support", "share"), [("supported", 48.0), ("clamped", 192.0)])
def test_statics_of_a_strip(support, share, evidence):
    """A force at mid-span: the modes' sum tends to P L³/48EI or /192EI with the third power of their number."""
    expected = STEEL.length**3 / share / STEEL.bending_stiffness
    errors = []
    for count in (20, 40):
        body = built(plate_strip, STEEL, tuple(range(1, 2 * count, 2)), support=support)
        shape = np.asarray(body.middle.displacement_y)
        errors.append(1.0 - shape**2 @ (1.0 / np.diag(body.modes.stiffness)) / expected)
    evidence(TOPIC, f"mid-span deflection of a {support} strip, 40 odd modes", abs(errors[1]), 2e-5, "Euler-Bernoulli")
    order = abs(np.log2(errors[0] / errors[1]) - 3.0)
    evidence(TOPIC, f"its order in the number of modes, {support}", order, 0.05, "theory: 3")


@pytest.mark.parametrize("support", ["supported", "clamped"])
def test_a_strips_modes(support, evidence):
    body = built(plate_strip, UNIT, 40, support=support)
    beta = np.sqrt(2.0 * np.pi * np.asarray(frequencies(body.modes)))
    exact = np.pi * np.arange(1, 41) + (np.pi / 2 if support == "clamped" else 0.0)
    first = 3 if support == "clamped" else 0
    evidence(TOPIC, f"β of a {support} strip", np.abs(beta / exact - 1)[first:].max(), 1e-6, "closed form")
    stations, weights = quadrature(200)
    shapes, slopes = body.shapes.lateral(stations, 0), body.shapes.lateral(stations, 2)
    np.testing.assert_allclose(shapes.T @ (weights[:, None] * shapes), np.eye(40), atol=1e-9)
    overlap = slopes.T @ (weights[:, None] * slopes) / np.sqrt(np.outer(beta**4, beta**4))
    np.testing.assert_allclose(overlap, np.eye(40), atol=1e-8)
    if support == "clamped":
        assert np.abs(body.shapes.lateral(np.array([0.0, 1.0]), 0)).max() < 1e-12
        assert np.abs(body.shapes.lateral(np.array([0.0, 1.0]), 1)).max() < 1e-10


def test_an_unknown_support():
    with pytest.raises(ValueError, match="support: 'free' is none of supported, clamped"):
        plate_strip(UNIT, 2, support="free")
    with pytest.raises(ValueError, match=r"station: 1\.2 is not between 0 and 1"):
        plate_strip(UNIT, 2).marker(1.2)


def ratios(modes):
    """(modes,) damping ratios of the eigenvalues of the second-order system, by ascending frequency."""
    n = modes.size
    mass, damping, stiffness = (np.asarray(m) for m in (modes.mass_matrix, modes.damping, modes.stiffness))
    lower = np.linalg.solve(mass, np.concatenate([-stiffness, -damping], 1))
    values = np.linalg.eigvals(np.concatenate([np.concatenate([np.zeros((n, n)), np.eye(n)], 1), lower]))
    values = values[values.imag > 0]
    return (-values.real / np.abs(values))[np.argsort(np.abs(values))]


@pytest.mark.parametrize(
    "build",
    [
        lambda: free_bar(STEEL, 2, 1, damping_ratio=0.02),
        lambda: cantilever_bar(STEEL, 2, 0, tip_mass=0.3, tip_inertia=1e-4, damping_ratio=0.02),
        lambda: pinned_bar(STEEL, 3, True, damping_ratio=0.02),
        lambda: plate_strip(STEEL, 3, damping_ratio=0.02),
    ],
    ids=["free", "tip", "pinned", "strip"],
)
def test_damping_ratios(build, evidence):
    off = np.abs(ratios(built(build).modes) / 0.02 - 1).max()
    evidence(TOPIC, "damping ratio of each mode", off, 1e-7, "eigenvalues")


def test_modal_damping_of_each_mode_and_rayleighs(evidence):
    modes = built(cantilever_bar, STEEL, 2, tip_mass=0.3).modes
    asked = np.array([0.01, 0.02, 0.03, 0.04])
    found = ratios(modes.with_damping(jax.jit(modal_damping)(modes.mass_matrix, modes.stiffness, asked)))
    evidence(TOPIC, "damping ratios asked one by one", np.abs(found / asked - 1).max(), 1e-7, "eigenvalues")
    found = ratios(modes.with_damping(jax.jit(rayleigh_damping)(modes.mass_matrix, modes.stiffness, 3.0, 1e-6)))
    omega = 2.0 * np.pi * np.asarray(frequencies(modes))
    error = np.abs(found / (1.5 / omega + 5e-7 * omega) - 1).max()
    evidence(TOPIC, "Rayleigh's damping", error, 1e-7, "½ (α/ω + β ω)")


EXPONENTS = {  # of length, area, second moment, density, modulus
    "bending": (-2.0, -0.5, 0.5, -0.5, 0.5),
    "stretching": (-1.0, 0.0, 0.0, -0.5, 0.5),
    "geometric": (1.0, 1.0, 0.0, 1.0, 0.0),
    "inertia": (3.0, 1.0, 0.0, 1.0, 0.0),
    "rotation": (-1.0, 0.0, 0.0, 0.0, 0.0),
}


@pytest.mark.parametrize("kind", {**BUILDERS, **SPINNING})
def test_derivatives_to_length_section_and_material(kind, evidence):
    """d ln y/d ln p by JAX is the exponent that similarity gives."""

    def quantities(log):
        body = {**BUILDERS, **SPINNING}[kind](Bar(*jnp.exp(log)))
        mass, stiffness = body.modes.mass_matrix, body.modes.stiffness
        last = body.modes.size - 1
        found = {
            "bending": 0.5 * jnp.log(stiffness[0, 0] / mass[0, 0]),
            "inertia": jnp.log(body.modes.inertia),
            "rotation": jnp.log(jnp.abs(body.end.rotation[0] + 0.1 * body.marker(0.7).rotation[0])),
        }
        if body.modes.radial is not None:
            found["stretching"] = 0.5 * jnp.log(stiffness[last, last] / mass[last, last])
        if body.modes.geometric is not None:
            found["geometric"] = jnp.log(body.modes.geometric[0, 0])
        return found

    point = np.log(np.array([STEEL.length, STEEL.area, STEEL.second_moment, STEEL.density, STEEL.youngs_modulus]))
    for name, slopes in jax.jit(jax.jacfwd(quantities))(point).items():
        error = np.abs(np.asarray(slopes) - np.array(EXPONENTS[name])).max()
        evidence(TOPIC, "derivatives to length, section, material", error, 1e-9, "similarity", detail=f"{kind}: {name}")


def test_derivatives_through_frequencies_and_damping(evidence):
    """Where an eigenproblem is solved, too."""

    def first(mass):
        modes = cantilever_bar(STEEL, 2, tip_mass=mass, damping_ratio=0.03).modes
        return jnp.stack([modes.frequencies()[0], jnp.trace(modes.damping)])

    both = jax.jit(lambda mass: jax.jvp(first, (mass,), (jnp.ones(()),)))  # the value and its derivative
    above, (_, slope), below = (both(mass) for mass in (0.4 + 1e-5, 0.4, 0.4 - 1e-5))
    differences = np.asarray(above[0] - below[0]) / 2e-5
    evidence(
        TOPIC, "derivative to the tip's mass", np.abs(np.asarray(slope) / differences - 1).max(), 1e-7, "differences"
    )


def test_sections():
    """Of textbooks: a tube is the difference of two circles, and a strip bends about its flat side."""
    outside, inside = Bar.circle(1.0, 0.03, 1.0, 1.0), Bar.circle(1.0, 0.026, 1.0, 1.0)
    tube = Bar.tube(1.0, 0.03, 0.002, 1.0, 1.0)
    np.testing.assert_allclose(tube.area, outside.area - inside.area, rtol=1e-12)
    np.testing.assert_allclose(tube.second_moment, outside.second_moment - inside.second_moment, rtol=1e-12)
    assert Bar.rectangle(1.0, 0.1, 0.006, 1.0, 1.0).second_moment == pytest.approx(0.1 * 0.006**3 / 12)
