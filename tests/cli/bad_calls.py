"""Calls of Python that can't be answered, and what is said of them."""

import dataclasses
import random
from decimal import Decimal

import jax.numpy as jnp
import numpy as np
from bad_inputs import call

from jaxbuffer import (
    Case,
    CustomQuantity,
    Design,
    Limits,
    Objective,
    Problem,
    Scenario,
    SecondObjective,
    Variable,
    first_impact,
    get,
    replace,
    sensitivity,
    simulate,
    sweep,
    table2,
    tune,
)
from jaxbuffer.mechanisms.probe_cone.contact import Contact
from jaxbuffer.mechanisms.probe_cone.parts import Cone, Passive, ProbeBuffer
from jaxbuffer.tuning import Distribution, Scatter, grid

K = Variable("buffer.k_A", 100.0, 2000.0)
EFFORT = CustomQuantity(lambda peak_force, stroke: peak_force * stroke, "N m")
OWN = {"effort": EFFORT}
ONE = "simulate takes one capture: use jax.vmap or jb.sweep"


def stated(**fields):
    return Problem(**{"design": table2(), "scenarios": [Scenario()], "variables": [K], **fields})


def with_k(value):
    return replace(table2(), {"buffer.k_A": value})


NOT_K = "is not a number; expected (0, inf) N/m"
PYTHON = [
    call(lambda: Scenario(aproach_speed=1.0), "Scenario: aproach_speed is unknown; did you mean approach_speed?"),
    call(lambda: with_k("5 kg"), "buffer.k_A = '5 kg': kg is a mass, expected a number in N/m; allowed: (0, inf) N/m"),
    call(lambda: Scenario(misalignment="3 dag"), "scenario.misalignment = '3 dag': the unit dag is unknown", "deg?"),
    call(lambda: Limits(at_least={"end_time": 2.0}, at_most={"end_time": 1.0}), "at least 2 s and at most 1 s"),
    # what is no number, and what is none of the range
    *[
        call(lambda value=value: with_k(value), f"buffer.k_A: {shown}", NOT_K)
        for value, shown in [
            (b"500", "b'500'"),
            ("five N/m", "'five N/m'"),
            (500j, "500j"),
            (np.array(500j), "array(0.+500.j)"),
            (True, "True"),
            (np.array([True]), "array([ True])"),
            (None, "None"),
            ({"value": 5}, "{'value': 5}"),
            ([], "[]"),
            ([1.0, "a"], "[1.0, 'a']"),
            ([[1.0], [1.0, 2.0]], "[[1.0], [1.0, 2.0]]"),
            (np.array(["5"]), "array(['5']"),
            (object, "<class 'object'>"),
        ]
    ],
    *[
        call(lambda value=value: with_k(value), f"buffer.k_A = {shown} N/m is out of range; allowed: (0, inf) N/m")
        for value, shown in [
            (10**400, "inf"),
            (-(10**400), "-inf"),
            (Decimal("NaN"), "nan"),
            (Decimal("-0.5"), "-0.5"),
            (-0.0, "-0"),
            (np.float32(-2), "-2"),
            (np.array(0), "0"),
            (jnp.array([500.0, -3.0]), "-3"),
        ]
    ],
    # designs and scenarios
    call(lambda: replace({"buffer": 5}, {}), "{'buffer': 5} is not a Module; write replace(jb.table2()"),
    call(lambda: replace(table2(), "buffer.k_A"), "values = 'buffer.k_A' is not a Mapping; write replace("),
    call(lambda: replace(table2(), {5: 1.0}), "5 is not a dotted path such as 'buffer.k_A'"),
    call(lambda: replace(table2(), {"k_A": 1.0}), "k_A is unknown; did you mean buffer.k_A?"),
    call(lambda: replace(table2(), {"buffer": 1.0}), "buffer is a section; name one of its fields"),
    call(lambda: get(table2(), "buffer.kA"), "buffer.kA is unknown; did you mean buffer.k_A?"),
    call(lambda: get(table2(), None), "None is not a dotted path"),
    call(lambda: Design(buffer={"k_A": 5}), "buffer = {'k_A': 5} is not a ProbeBuffer"),
    call(lambda: Design(active=Passive()), "active = Passive(", "is not an Active"),
    call(lambda: Design(cone=None), "cone = None is not a Cone"),
    call(lambda: Contact(law=["hertz"]), "contact.law = ['hertz'] is unknown; choose one of lankarani-nikravesh"),
    call(lambda: ProbeBuffer(damping=None), "buffer.damping = None is unknown; choose one of physical, published"),
    call(
        lambda: Design(cone=Cone(length=[1.0, 2.0], offset=0.1, half_angle=[1.0] * 3)), "unequal shapes (2,) and (3,)"
    ),
    # one capture
    call(
        lambda: simulate(Scenario(), table2()),
        "design = Scenario(",
        "is not a design of a mechanism",
        "the design first",
    ),
    call(lambda: simulate(table2(), table2()), "scenario = Design(", "is not a Scenario", "the design first"),
    call(lambda: simulate({"buffer.k_A": 5}), "design = {'buffer.k_A': 5} is not a design of a mechanism"),
    call(lambda: simulate(Design), "design = <class", "is not a design of a mechanism"),
    call(lambda: simulate(table2(), 0.2), "scenario = 0.2 is not a Scenario"),
    call(lambda: simulate(with_k([400.0, 500.0])), "buffer.k_A has shape (2,)", ONE),
    call(lambda: simulate(table2(), Scenario([0.1, 0.2])), "approach_speed has shape (2,)", ONE),
    call(lambda: simulate(table2(), duration=[3.0, 4.0]), "duration has shape (2,)", ONE),
    call(lambda: simulate(table2(), duration=np.ones(3)), "duration has shape (3,)", ONE),
    call(lambda: simulate(table2(), duration="8 s"), "duration: '8 s' is not a number; expected (0, inf) s"),
    call(lambda: simulate(table2(), solver="implicid"), "solver = 'implicid'", "automatic, implicit, explicit"),
    call(lambda: simulate(table2(), solver=5), "solver = 5 is unknown; choose one of automatic, implicit, explicit"),
    call(lambda: simulate(table2(), rtol="1e-6"), "rtol: '1e-6' is not a number; expected [1e-13, 0.01]"),
    call(lambda: simulate(table2(), rtol=0.0), "rtol = 0 is out of range; allowed: [1e-13, 0.01]"),
    call(lambda: simulate(table2(), atol=[1e-6, 1e-7]), "atol has shape (2,)", ONE),
    call(lambda: simulate(table2(), stabilisation=-1), "stabilisation = -1 1/s", "[0, inf) 1/s"),
    call(lambda: simulate(table2(), history="yes"), "history = 'yes' must be true or false"),
    call(lambda: simulate(table2(), max_steps=2.5), "max_steps = 2.5 must be a whole number of at least 1"),
    call(lambda: simulate(table2(), max_events=[1]), "max_events = [1] must be a whole number of at least 1"),
    call(lambda: simulate(table2(), max_events=0), "max_events = 0 must be a whole number of at least 1"),
    call(
        lambda: simulate(replace(table2(), {"probe.tip_radius": 0.035}), Scenario(contact_distance=0.01)),
        "scenario.contact_distance = 0.01 m is out of range; allowed: (0.0137868, 0.0735] m",
    ),
    call(lambda: first_impact(Scenario()), "design = Scenario(", "is not a DockingDesign"),
    call(lambda: first_impact(table2(), Scenario(contact_distance=0.08)), "0.08 m", "(0, 0.0735] m"),
    call(
        lambda: simulate(table2(), Scenario(start="free", misalignment=1.0, active_angle=-1.0)),
        "scenario.misalignment = 1 rad and scenario.active_angle = -1 rad turn the probe by 2 rad from the cone's axis",
        "allowed: [0, 1.5708) rad",
    ),
    # derivatives
    call(lambda: sensitivity(Scenario(), table2()), "design = Scenario(", "is not a design of a mechanism"),
    call(
        lambda: sensitivity(table2(), wrt="buffer.k_A"), "wrt = 'buffer.k_A' is one name", "write wrt=('buffer.k_A',)"
    ),
    call(lambda: sensitivity(table2(), wrt=()), "wrt is empty; name at least one, buffer.k_A say"),
    call(lambda: sensitivity(table2(), wrt=5), "wrt = 5 is not a list of names; write wrt=('buffer.k_A',)"),
    call(lambda: sensitivity(table2(), wrt=[1, 2]), "wrt = [1, 2] is not a list of names"),
    call(lambda: sensitivity(table2(), wrt=("contact.stiffness",)), "contact.stiffness = None is not a number"),
    call(lambda: sensitivity(table2(), wrt=["buffer.c_A"] * 2), "wrt names buffer.c_A twice"),
    call(lambda: sensitivity(table2(), quantities="peak_force"), "write quantities=('peak_force',)"),
    call(lambda: sensitivity(table2(), quantities=b"x"), "quantities = b'x' is not a list of names"),
    call(lambda: sensitivity(table2(), quantities=("peek_force",)), "peek_force is unknown; did you mean peak_force?"),
    call(lambda: sensitivity(with_k([1.0, 2.0]), wrt=("buffer.k_A",)), "buffer.k_A has shape (2,)", ONE),
    call(lambda: sensitivity(table2(), duration=[1.0, 2.0]), "duration has shape (2,)", ONE),
    call(lambda: sensitivity(table2(), rtol=1), "rtol = 1 is out of range; allowed: [1e-13, 0.01]"),
    call(lambda: sensitivity(table2(), certify=True), "certify = True is unknown; choose one of quick, thorough, none"),
    call(lambda: sensitivity(table2(), solver="newton"), "solver = 'newton' is unknown", "explicit"),
    # many captures
    call(lambda: sweep(Scenario(), table2()), "design = Scenario(", "is not a design of a mechanism"),
    call(lambda: sweep(table2(), [Scenario(), Scenario()]), "scenario = [Scenario(", "is not a Scenario"),
    call(lambda: sweep(with_k([1.0, 2.0]), Scenario([0.1] * 3)), "must all have one shape (n,)", "(2,), (3,)"),
    call(lambda: sweep(table2(), Scenario(np.ones((2, 2)))), "must all have one shape (n,)", "(2, 2)"),
    call(lambda: sweep(table2(), Scenario([0.1, -0.1])), "scenario.approach_speed = -0.1 m/s", "(0, inf) m/s"),
    call(lambda: sweep(table2(), Scenario(), workers=1.5), "workers = 1.5 must be a whole number of at least 1"),
    call(lambda: sweep(table2(), Scenario(), workers=True), "workers = True must be a whole number of at least 1"),
    call(lambda: sweep(table2(), Scenario(), workers=0), "workers = 0 must be a whole number of at least 1"),
    call(lambda: sweep(table2(), Scenario(), duration=[1.0, 0.0]), "duration = 0 s", "(0, inf) s"),
    call(lambda: sweep(table2(), Scenario(), rtol=[1e-6, 1e-7]), "rtol has shape (2,)", "share it"),
    call(lambda: sweep(table2(), Scenario(), solver="newton"), "solver = 'newton' is unknown"),
    call(
        lambda: sweep(replace(table2(), {"probe.tip_radius": [0.015, 0.035]}), Scenario(contact_distance=0.01)),
        "scenario.contact_distance = 0.01 m is out of range; allowed: (0.0137868, 0.0735] m",
    ),
    # problems
    call(lambda: stated(design={"k_A": 5}), "design = {'k_A': 5} is not a design of a mechanism"),
    call(lambda: stated(scenarios=[]), "scenarios is empty; tuning needs at least one"),
    call(lambda: stated(scenarios=Scenario()), "scenarios = Scenario(", "is not a list; write [Scenario("),
    call(lambda: stated(scenarios=[0.1]), "scenario = 0.1 is not a scenario of a mechanism; write Case(Scenario("),
    call(lambda: stated(variables=K), "variables = Variable(", "is not a list; write [Variable('buffer.k_A'"),
    call(lambda: stated(variables="buffer.k_A"), "variables = 'buffer.k_A' is not a list"),
    call(lambda: stated(variables=["buffer.k_A"]), "variable = 'buffer.k_A' is not a Variable; write Variable("),
    call(lambda: stated(variables=[K, K]), "buffer.k_A is named twice among the variables"),
    call(
        lambda: stated(variables=[Variable("buffer.k_A", "100", "2000")]),
        "low bound = '100': a text needs a unit; write 100",
        "N/m",
    ),
    call(lambda: stated(variables=[Variable("buffer.k_A", 100.0, None)]), "high bound: None is not a number", "N/m"),
    call(lambda: stated(variables=[Variable("buffer.k_A", 2e3, 1e2)]), "low bound of [2000, 100] N/m", "swapped"),
    call(lambda: stated(variables=[Variable(5, 1.0, 2.0)]), "5 is not a dotted path"),
    call(
        lambda: stated(variables=[Variable("buffer.k_A", 600.0, 2000.0)]),
        "the start, buffer.k_A = 500 N/m, is outside its bounds [600, 2000] N/m",
    ),
    call(
        lambda: stated(variables=[dataclasses.replace(K, scale=3)]), "scale = 3 is unknown; choose one of log, linear"
    ),
    call(lambda: stated(objective="peak_force"), "objective = 'peak_force' is not an Objective", "Objective({'peak"),
    call(lambda: stated(limits={}), "limits = {} is not a Limits; write Limits(at_most={'stroke': 0.025})"),
    call(lambda: stated(then="stroke"), "then = 'stroke' is not a SecondObjective; write SecondObjective(Objective("),
    call(lambda: stated(duration=[1.0, 2.0]), "duration has shape (2,)"),
    call(lambda: stated(rtol=None), "rtol: None is not a number; expected [1e-13, 0.01]"),
    call(
        lambda: stated(scenarios=[Scenario(), Scenario(approach_speed=0.2, misalignment=0.8)]),
        "scenario 2 (0.2 m/s, +45.84°): scenario.misalignment = 0.8 rad is out of range",
    ),
    call(lambda: Case(0.1), "case's scenario = 0.1 is not a scenario of a mechanism"),
    call(lambda: Case(Scenario(), (("buffer.k_A", "1.1"),)), "factor on buffer.k_A: '1.1' is not a number"),
    call(lambda: Case(Scenario(), ("buffer.k_A", 1.1)), "case's factors = ('buffer.k_A', 1.1); write Case("),
    # quantities of one's own
    call(lambda: Objective({"effort": 0.0}), "objective.effort = 0 N/unit is out of range; allowed: (0, inf) N/unit"),
    call(lambda: stated(objective=Objective({"efort": 1.0}), quantities=OWN), "efort is unknown; did you mean effort?"),
    call(
        lambda: stated(quantities=[EFFORT]),
        "quantities = [CustomQuantity(",
        "is not a mapping; write quantities={'effort'",
    ),
    call(
        lambda: stated(quantities={"effort": max}),
        "quantities.effort = <built-in function max> is not a CustomQuantity",
    ),
    call(lambda: stated(quantities={"stroke": EFFORT}), "quantities.stroke: the name is taken"),
    call(lambda: stated(quantities={"values": EFFORT}), "quantities.values: the name is taken"),
    call(lambda: stated(quantities={"an effort": EFFORT}), "'an effort' is no name; write letters, digits and _"),
    call(
        lambda: stated(quantities={"own": CustomQuantity(lambda strok: 2.0 * strok, "m")}),
        "quantities.own: <lambda> asks for strok, which is unknown; did you mean stroke?",
    ),
    call(
        lambda: CustomQuantity("peak_force", "N"),
        "custom quantity's function = 'peak_force' is not a function; write CustomQuantity(lambda",
    ),
    call(lambda: CustomQuantity(lambda stroke: stroke, "Nm"), "the unit Nm is unknown; did you mean N m?"),
    call(lambda: CustomQuantity(lambda stroke: stroke, None), "unit of <lambda> = None is not a unit; write 'N m' say"),
    call(lambda: CustomQuantity(lambda: 1.0, "m"), "<lambda> has no parameter; name quantities"),
    call(lambda: CustomQuantity(lambda *stroke: stroke[0], "m"), "its parameter *stroke names no quantity"),
    call(lambda: CustomQuantity(lambda stroke, k=2.0: k * stroke, "m"), "its parameter k has a default value"),
    call(lambda: CustomQuantity(max, "m"), "its parameters are not known; write it with def or lambda"),
    call(
        lambda: CustomQuantity(lambda stroke: 2 * float(stroke), "m"),
        "takes a number out of JAX in line",
        "write jax.numpy",
    ),
    call(lambda: CustomQuantity(lambda stroke: 2 * np.sqrt(stroke), "m"), "takes a number out of JAX in line"),
    call(lambda: CustomQuantity(lambda stroke: stroke if stroke > 0 else 0, "m"), "takes a number out of JAX in line"),
    call(
        lambda: CustomQuantity(lambda stroke: 2 * jnp.floor(stroke), "m"), "its derivative by stroke is zero everywhere"
    ),
    call(lambda: CustomQuantity(lambda stroke, bending: stroke, "m"), "its derivative by bending is zero everywhere"),
    call(
        lambda: CustomQuantity(lambda stroke: 1.0, "m"), "its derivative by stroke is zero everywhere: it is not used"
    ),
    call(lambda: CustomQuantity(lambda stroke: (stroke, 1.0), "m"), "returns (", "not a number"),
    call(
        lambda: CustomQuantity(lambda stroke: stroke * jnp.ones(2), "m"), "returns an array of the shape (2,), not one"
    ),
    call(
        lambda: CustomQuantity(lambda stroke: 1j * stroke, "m"),
        "returns a number of the type complex128, not a real one",
    ),
    call(lambda: CustomQuantity(lambda stroke: stroke * random.random(), "m"), "is another one at each call"),
    call(lambda: CustomQuantity(lambda stroke: {}["k"], "m"), "<lambda> raises KeyError: 'k' in line"),
    call(lambda: Objective("peak_force"), "weights = 'peak_force' is not a Mapping; write Objective({'stroke'"),
    call(lambda: Objective({"peak_force": "1"}), "objective.peak_force: '1' is not a number; expected (0, inf) N/N"),
    call(lambda: Limits(at_most=[("stroke", 0.025)]), "at_most = [('stroke', 0.025)] is not a Mapping"),
    call(lambda: Limits({"stroke": 0.025}), "constraints.require_success = {'stroke': 0.025} must be true or false"),
    call(lambda: Limits(impacts=2.5), "constraints.impacts = 2.5 must be a whole number of at least 1"),
    call(
        lambda: SecondObjective({"stroke": 1.0}),
        "objective = {'stroke': 1.0} is not an Objective; write SecondObjective(Objective(",
    ),
    call(lambda: grid({"approach_speed": 0.1}), "grid.approach_speed = 0.1 is not a list of values in m/s"),
    call(lambda: grid({"approach_speed": ["fast"]}), "scenario.approach_speed: 'fast' is not a number", "m/s"),
    call(lambda: Scatter(2.5, {"approach_speed": Distribution("uniform", 0.1, 0.2)}), "sample.count = 2.5 must be a"),
    call(
        lambda: Scatter(2, {"approach_speed": (0.1, 0.2)}), "sample.approach_speed = (0.1, 0.2) is not a Distribution"
    ),
    call(lambda: Distribution("uniform", "a", 1.0), "uniform, first number: 'a' is not a number"),
    # tuning
    call(lambda: tune(table2()), "problem = Design(", "is not a Problem; write Problem("),
    call(lambda: tune(stated(), iterations=0), "tune.iterations = 0 must be a whole number of at least 1"),
    call(lambda: tune(stated(), workers=1.5), "workers = 1.5 must be a whole number of at least 1"),
    call(lambda: tune(stated(), tolerance="tight"), "tune.tolerance: 'tight' is not a number; expected (0, 1)"),
    call(lambda: tune(stated(), folder=""), "folder = '' is empty"),
    call(lambda: tune(stated(), resume=True), "resume needs the folder"),
]
