"""Every way to work with a mechanism that has no contact, and whose quantities are its own alone."""

import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.elements import Buffer
from jaxbuffer.fields import NON_NEGATIVE, POSITIVE, Part, number
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Defaults, Mechanism
from jaxbuffer.mechanisms.quantity import Quantity
from jaxbuffer.mechanisms.view import Names
from jaxbuffer.multibody import GROUND, AxialSpringDamper, Body, Prismatic, System
from registration import registered

pytestmark = pytest.mark.slow
SPEED, MASS, SPRING, DAMPER = 0.5, 2.0, 200.0, 3.0


class Cart(Part):
    section = "cart"
    mass: float = number(MASS, "kg", **POSITIVE)
    spring: float = number(SPRING, "N/m", **POSITIVE)
    damper: float = number(DAMPER, "N s/m", **NON_NEGATIVE)


class Track(Part):
    cart: Cart = Cart()


class Kick(Part):
    section = "scenario"
    speed: float = number(SPEED, "m/s", doc="to the spring")


def on_track(design, scenario, stabilisation=20.0):
    """A cart on a spring and a damper, nothing else."""
    cart = design.cart
    spring = AxialSpringDamper(GROUND, 0, (1.0, 0.0), (0.0, 0.0), cart.spring, damping=cart.damper, free_length=1.0)
    system = System((Body(cart.mass, inertia=1.0),), (Prismatic(GROUND, 0),), stabilisation=stabilisation)
    v = jnp.zeros(3).at[0].set(scenario.speed)
    return Assembled(system, jnp.zeros(3), v, elements=(Buffer(spring),), size=(1e-3, 0.1), energy_size=0.1)


STROKE = Quantity("m", lambda run: run.maxima["stroke"], "largest stroke", "stroke", swept=True, tuned=True)


@pytest.fixture(scope="module")
def track():
    """The mechanism, with the default view."""
    defaults = Defaults(duration=0.5, differentiated=("stroke",), mapped=("stroke",))
    with registered(Mechanism("cart_on_track", Track, Kick, {"stroke": STROKE}, on_track, defaults=defaults)):
        yield Track()


def largest(spring):
    """The closed form of the largest stroke: x at the first instant of v = 0."""
    omega, zeta = np.sqrt(spring / MASS), DAMPER / (2.0 * np.sqrt(spring * MASS))
    return SPEED / omega * np.exp(-zeta / np.sqrt(1.0 - zeta**2) * np.arccos(zeta))


def test_a_run_is_saved_with_its_history_and_its_tables(track, tmp_path):
    run = jb.simulate(track, Kick(), history=True)
    run.save(tmp_path / "run")
    assert {"run.json", "run.nc", "run.png", "motion.png"} <= {file.name for file in (tmp_path / "run").iterdir()}
    assert run.to_xarray().sizes["contact"] == 0
    assert abs(float(run.to_xarray()["stroke"]) / largest(SPRING) - 1.0) < 1e-5
    assert not [name for name in run.to_dataframe().columns if name.startswith(("gap", "contact"))]
    assert not [name for name in jb.recorded_quantities(track, Kick()) if name.startswith(("gap", "contact"))]


def test_the_extension_is_that_of_the_swing_back(track):
    """Half a period after the largest stroke the cart is as far out, but for the decay; pushed the other way, the two
    change places; and with more than the critical damping it never comes out."""
    zeta = DAMPER / (2.0 * np.sqrt(SPRING * MASS))
    decayed = largest(SPRING) * np.exp(-np.pi * zeta / np.sqrt(1.0 - zeta**2))
    into, out = (jb.simulate(track, Kick(speed=speed), rtol=1e-9) for speed in (SPEED, -SPEED))
    for run, stroke, extension in ((into, largest(SPRING), decayed), (out, decayed, largest(SPRING))):
        assert float(run.maxima["stroke"]) == pytest.approx(stroke, rel=1e-8)
        assert float(run.maxima["extension"]) == pytest.approx(extension, rel=1e-8)
        assert f"{1e3 * extension:.6g} mm beyond the free length at {run.maximum_times['extension']:.6g} s" in repr(run)
    half = np.pi / np.sqrt(SPRING / MASS - (DAMPER / (2.0 * MASS)) ** 2)
    assert into.maximum_times["extension"] - into.maximum_times["stroke"] == pytest.approx(half, rel=1e-7)
    damped = jb.simulate(jb.replace(track, {"cart.damper": 100.0}), Kick(), rtol=1e-9)
    assert float(damped.maxima["extension"]) == 0.0 and "beyond the free length" not in repr(damped)


def test_a_sweep_has_a_summary_figures_and_files(track, tmp_path):
    springs = np.array([100.0, 200.0, 400.0])
    table = jb.sweep(track, Kick(), over={"cart.spring": springs})
    np.testing.assert_allclose(table.columns["stroke"], largest(springs), rtol=1e-5)
    table.save(tmp_path / "sweep")
    assert "stroke" in str(table)


def test_it_is_tuned_chosen_and_varied(track, tmp_path):
    variables = [jb.Variable("cart.spring", 100.0, 400.0)]
    problem = jb.Problem(track, [Kick()], variables, jb.Objective({"stroke": 1.0}), duration=0.5)
    tuned = jb.tune(problem, starts=1, iterations=5)
    assert abs(tuned.design.cart.spring / 400.0 - 1.0) < 1e-6  # the stiffest one is the best
    tuned.save(tmp_path / "tuned")
    parts = {"spring": {"soft": {"cart.spring": 150.0}, "stiff": {"cart.spring": 300.0}}}
    chosen = jb.choose(
        jb.Problem(track, [Kick()], [], jb.Objective({"stroke": 1.0}), duration=0.5), parts, optimum=False
    )
    assert chosen.best.names == ("stiff",)
    chosen.save(tmp_path / "choice")
    jb.what_if(problem, runs=32)


def test_contacts_without_a_name_are_numbered():
    names = Names(contacts=("lower",))
    assert names.of_contacts(0) == () and names.of_contacts(2) == ("lower", "contact 2") and names.contact(-1) == ""
