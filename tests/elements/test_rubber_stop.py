"""An end stop of rubber: its law by its formula, and a mass that runs into it by energy."""

from types import SimpleNamespace

import jax
import jax.numpy as jnp
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import jaxbuffer as jb
from jaxbuffer.elements import EndStop, RubberBlock
from jaxbuffer.fields import Part, number
from jaxbuffer.mechanisms.assembled import Assembled
from jaxbuffer.mechanisms.mechanism import Mechanism
from jaxbuffer.mechanisms.probe_cone.assembly import assemble
from jaxbuffer.multibody import GROUND, AxialSpringDamper, Body, Prismatic, System
from registration import registered

MASS, SPEED, STIFFNESS, THICKNESS, PLACE = 3.0, 0.4, 2e3, 0.02, 0.01  # kg, m/s, N/m, m, m


class Wagon(Part):
    damping: float = number(0.0, "N s/m")


class Start(Part):
    section = "scenario"


def into_rubber(design, scenario, stabilisation=20.0):
    guide = AxialSpringDamper(GROUND, 0, (1.0, 0.0), (0.0, 0.0), stiffness=0.0, damping=0.0, free_length=1.0)
    stop = EndStop(guide, RubberBlock(STIFFNESS, design.damping, THICKNESS), PLACE)
    system, v = System((Body(MASS, 1.0),), (Prismatic(GROUND, 0),)), jnp.array([SPEED, 0.0, 0.0])
    return Assembled(system, jnp.zeros(3), v, elements=(stop,), size=(1e-3, SPEED), energy_size=0.5 * MASS * SPEED**2)


def force(depth):
    stretch = 1.0 - depth / THICKNESS
    return STIFFNESS * THICKNESS / 3.0 * (1.0 / stretch**2 - stretch)


def test_a_mass_into_rubber_by_energy():
    """The largest compression is where the force, summed up, has taken the mass's energy."""
    depth = brentq(lambda end: quad(force, 0.0, end)[0] - 0.5 * MASS * SPEED**2, 0.0, 0.9 * THICKNESS, xtol=1e-14)
    assert force(depth) > 1.5 * STIFFNESS * depth, "far from linear"
    with registered(Mechanism("wagon", Wagon, Start, {}, into_rubber)):
        run = jb.simulate(Wagon(), Start(), 0.25)
        damped = jb.simulate(Wagon(damping=20.0), Start(), 0.25)
    assert float(run.maxima["stop_force"]) == pytest.approx(force(depth), rel=1e-6)
    assert abs(float(run.balance.energy)) < 1e-6
    assert float(damped.energy.stop_damper) > 0.05 * 0.5 * MASS * SPEED**2
    assert abs(float(damped.balance.energy)) < 1e-6


@pytest.mark.parametrize("depth", [1e-6, 0.5 * THICKNESS, 1.5 * THICKNESS])
def test_its_force_is_the_slope_of_its_energy_also_where_a_step_goes_through_it(depth):
    law = RubberBlock(STIFFNESS, 0.0, THICKNESS)
    assert float(law.elastic(jnp.asarray(depth))) == pytest.approx(float(jax.grad(law.energy)(depth)), rel=1e-6)
    assert float(law.elastic(jnp.asarray(1e-9))) == pytest.approx(STIFFNESS * 1e-9, rel=1e-6)


def test_a_docking_has_it_by_its_thickness():
    design = jb.replace(jb.table2(), {"buffer.stop_stiffness": 2e4, "buffer.stop_thickness": "15 mm"})
    assert float(assemble(design, jb.Scenario()).element("stop").law.thickness) == 0.015


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_beyond_half_of_its_thickness_it_warns(share):
    law, most = RubberBlock(STIFFNESS, 0.0, THICKNESS), share * force(0.5 * THICKNESS)
    run = SimpleNamespace(mechanism=SimpleNamespace(quantities={}), maxima={"stop_force": most})
    lines = EndStop(None, law, 0.01).report.warnings(run)
    assert [line.startswith("the rubber of the end stop takes") for line in lines] == [True] * (share > 1.0)
