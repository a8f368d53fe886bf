"""What an engineer may get wrong, and what the program answers: field, value, unit and range, or the nearest name."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from jaxbuffer import InputError, Scenario, rigid_probe, simulate, table2
from jaxbuffer.fields import get, paths, replace, unit
from jaxbuffer.mechanisms.probe_cone.contact import Contact
from jaxbuffer.mechanisms.probe_cone.design import Design, check_fit, valid
from jaxbuffer.mechanisms.probe_cone.parts import ProbeBuffer

OUT_OF_RANGE = [
    ("probe.tip_mass", -0.1, "probe.tip_mass = -0.1 kg is out of range; allowed: (0, inf) kg"),
    ("buffer.k_A", 0.0, "buffer.k_A = 0 N/m is out of range; allowed: (0, inf) N/m"),
    ("buffer.c_T", -2, "buffer.c_T = -2 N m s/rad is out of range; allowed: [0, inf) N m s/rad"),
    ("active.inertia", math.inf, "active.inertia = inf kg m² is out of range; allowed: (0, inf) kg m²"),
    ("passive.mass", math.nan, "passive.mass = nan kg is out of range; allowed: (0, inf) kg"),
    ("contact.restitution", 1.01, "contact.restitution = 1.01 is out of range; allowed: (0, 1]"),
    ("contact.restitution", 0.0, "contact.restitution = 0 is out of range; allowed: (0, 1]"),
    ("contact.poisson_ratio", 0.6, "contact.poisson_ratio = 0.6 is out of range; allowed: (-1, 0.5]"),
    ("contact.stiffness", 0.0, "contact.stiffness = 0 N/m^1.5 is out of range; allowed: (0, inf) N/m^1.5"),
    (
        "cone.half_angle",
        2.0,
        'cone.half_angle = 2 rad is out of range; allowed: (0, 1.5708) rad; "2 deg" if that is meant',
    ),
    # The mouth's radius is 0.015 m + 0.0735 m sin 45°.
    (
        "probe.tip_radius",
        0.07,
        "probe.tip_radius = 0.07 m is out of range; allowed: (0, 0.0669723) m; the ball must pass the mouth of"
        " cone.throat_radius and cone.length",
    ),
]


@pytest.mark.quick
@pytest.mark.parametrize(("path", "value", "message"), OUT_OF_RANGE)
def test_out_of_range_names_field_value_unit_and_range(path, value, message):
    with pytest.raises(InputError) as caught:
        replace(table2(), {path: value})
    assert str(caught.value) == message


@pytest.mark.quick
@pytest.mark.parametrize("value", [True, None, {}, 1j])
def test_what_is_not_a_number_is_shown_as_given(value):
    with pytest.raises(InputError) as caught:
        ProbeBuffer(k_A=value)
    assert str(caught.value).startswith(f"buffer.k_A: {value!r} is not a number; expected (0, inf) N/m")


def test_one_bad_entry_of_an_array_is_enough():
    with pytest.raises(InputError, match=r"buffer\.k_A = -3 N/m is out of range"):
        replace(table2(), {"buffer.k_A": jnp.array([500.0, -3.0, 700.0])})


def test_input_errors_are_value_errors():
    assert issubclass(InputError, ValueError)


@pytest.mark.quick
@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"buffer.kA": 1.0}, "buffer.kA is unknown; did you mean buffer.k_A?"),
        ({"probe.tipmass": 1.0}, "probe.tipmass is unknown; did you mean probe.tip_mass?"),
        (
            {"zzz": 1.0},
            "zzz is unknown; known: active, passive, buffer, probe, cone, contact, hinge, latch, lockout, shock,"
            " control",
        ),
        ({"buffer": 1.0}, "buffer is a section; name one of its fields"),
        (
            {"contact.memory": "evnt"},
            "contact.memory = 'evnt' is unknown; choose one of event, smooth; did you mean event?",
        ),
        ({"buffer.damping": "none"}, "buffer.damping = 'none' is unknown; choose one of physical, published"),
        ({"probe.free_tip": 1}, "probe.free_tip = 1 must be true or false"),
    ],
)
def test_unknown_names_and_words(values, message):
    with pytest.raises(InputError) as caught:
        replace(table2(), values)
    assert str(caught.value) == message


OPTIONAL = (
    *(
        "buffer.max_stroke",
        "buffer.stop_stiffness",
        "buffer.stop_thickness",
        "contact.stiffness",
        "contact.yield_stress",
        "buffer.spring_curve",
        "buffer.damper_curve",
        "buffer.preload",
        "buffer.c_A2",
        "buffer.rebound_factor",
        "buffer.friction",
        "buffer.rebound_stiffness",
        "latch.stiffness",
        "latch.strength",
        "lockout.stiffness",
        "control.stiffness",
        "control.limit",
    ),
    *("hinge.play", "probe.bending_stiffness", "cone.young_modulus", "cone.poisson_ratio"),
    *(f"shock.{vehicle}_{k}" for vehicle in ("active", "passive") for k in (1, 2, 3)),
)


@pytest.mark.parametrize("reader", [get, lambda design, path: replace(design, {path: 1.0})])
def test_reading_and_writing_know_the_same_paths(reader):
    for path in paths(table2()):
        assert get(table2(), path) is not None or path in OPTIONAL
    with pytest.raises(InputError, match=r"cone\.lenght is unknown; did you mean cone\.length\?"):
        reader(table2(), "cone.lenght")


def test_every_number_declares_its_unit():
    numbers = [path for path in paths(table2()) if not isinstance(get(table2(), path), (str, bool))]
    assert len(numbers) == 80
    without = ["buffer.spring_curve", "buffer.damper_curve", "probe.bending_modes"]  # a curve's points have units
    assert [path for path in numbers if not unit(table2(), path)] == without
    assert unit(table2(), "buffer.c_T") == "N m s/rad"
    assert unit(table2(), "buffer.damping") == ""


@pytest.mark.quick
@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        ({"approach_speed": 0.0}, "scenario.approach_speed = 0 m/s is out of range; allowed: (0, inf) m/s"),
        ({"contact_distance": -0.01}, "scenario.contact_distance = -0.01 m is out of range; allowed: (0, inf) m"),
        (
            {"misalignment": 1.6},
            "scenario.misalignment = 1.6 rad is out of range; allowed: (-1.5708, 1.5708) rad;"
            ' "1.6 deg" if that is meant',
        ),
        ({"passive_rate": math.nan}, "scenario.passive_rate = nan rad/s is out of range; allowed: (-inf, inf) rad/s"),
    ],
)
def test_scenario_out_of_range(scenario, message):
    with pytest.raises(InputError) as caught:
        Scenario(**scenario)
    assert str(caught.value) == message


@pytest.mark.quick
@pytest.mark.parametrize(
    ("scenario", "message"),
    [
        (
            {"contact_distance": 0.08},
            "scenario.contact_distance = 0.08 m is out of range; allowed: (0, 0.0735] m; the flank ends at cone.length",
        ),
        (
            {"misalignment": -0.8},
            "scenario.misalignment = -0.8 rad is out of range; allowed: (-0.785398, 0.785398) rad;"
            ' "-0.8 deg" if that is meant',
        ),
    ],
)
def test_scenario_that_does_not_fit_the_design(scenario, message):
    with pytest.raises(InputError) as caught:
        check_fit(table2(), Scenario(**scenario))
    assert str(caught.value) == message
    with pytest.raises(InputError):
        simulate(table2(), Scenario(**scenario))


@pytest.mark.quick
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"duration": 0.0}, "duration = 0 s is out of range; allowed: (0, inf) s"),
        ({"rtol": 0.5}, "rtol = 0.5 is out of range; allowed: [1e-13, 0.01]"),
        ({"atol": -1.0}, "atol = -1 is out of range; allowed: [1e-13, 0.01]"),
        ({"stabilisation": -1.0}, "stabilisation = -1 1/s is out of range; allowed: [0, inf) 1/s"),
    ],
)
def test_simulate_checks_its_options(options, message):
    with pytest.raises(InputError) as caught:
        simulate(table2(), **options)
    assert str(caught.value) == message


def test_simulate_takes_one_capture():
    many = replace(table2(), {"buffer.k_A": jnp.array([400.0, 500.0])})
    with pytest.raises(InputError, match=r"buffer\.k_A has shape \(2,\); simulate takes one capture"):
        simulate(many)


def test_replace_changes_the_named_fields_only():
    changed = replace(table2(), {"buffer.k_A": 800.0, "probe.tip_mass": 0.05, "probe.free_tip": True})
    for path in paths(table2()):
        expected = {"buffer.k_A": 800.0, "probe.tip_mass": 0.05, "probe.free_tip": True}.get(path, get(table2(), path))
        assert get(changed, path) == expected, path


def test_replace_works_on_traced_values_and_their_derivatives():
    @jax.jit
    def weight(mass):
        return get(replace(table2(), {"probe.tip_mass": mass, "active.mass": 2.0 * mass}), "active.mass")

    assert float(weight(3.0)) == 6.0
    assert float(jax.grad(weight)(3.0)) == 2.0


def test_stiffness_is_computed_unless_given():
    assert table2().contact.stiffness is None
    np.testing.assert_allclose(table2().contact_stiffness, 6.43328e9, rtol=7.8e-7)  # six digits are given
    assert replace(table2(), {"contact.stiffness": 1e9}).contact_stiffness == 1e9
    softer = Design(contact=Contact(young_modulus=71.7e8))
    np.testing.assert_allclose(softer.contact_stiffness, table2().contact_stiffness / 10, rtol=1e-14)


def test_defaults_are_table_2():
    """The model's table, by path."""
    table = {
        "active.mass": 21.9706,
        "active.inertia": 0.445,
        "active.hinge_offset": 0.1365,
        "passive.mass": 23.5731,
        "passive.inertia": 0.5206,
        "buffer.k_A": 500.0,
        "buffer.c_A": 5.0,
        "buffer.k_T": 300.0,
        "buffer.c_T": 2.0,
        "buffer.free_length": 0.1365,
        "buffer.cylinder_mass": 1.0,
        "buffer.cylinder_length": 0.1365,
        "probe.length": 0.2,
        "probe.tip_radius": 0.015,
        "cone.half_angle": math.pi / 4,
        "cone.offset": 0.096,
        "cone.throat_radius": 0.015,
        "cone.length": 0.0735,
        "contact.restitution": 0.9,
        "contact.friction": 0.33,
        "contact.slip_speed": 1e-3,
    }
    for path, value in table.items():
        assert get(table2(), path) == value, path
    assert Scenario() == Scenario(0.1, 0.0435, 0.0, 0.0)


def test_rigid_probe_differs_in_the_buffer_only():
    rigid, plain = rigid_probe(), table2()
    changed = {path for path in paths(plain) if get(rigid, path) != get(plain, path)}
    assert changed == {"buffer.k_A", "buffer.c_A", "buffer.k_T", "buffer.c_T"}
    assert rigid.buffer.k_A == 1e10


def gap_to_the_other_flank(design, scenario):
    """Distance of the tip from the upper flank at the start [m], rims included, by M31 and M62 of docs/model.md: the
    flank sampled point by point, everything turned by the misalignment."""
    cone, radius, b = design.cone, design.probe.tip_radius, scenario.contact_distance
    sine, cosine = math.sin(cone.half_angle), math.cos(cone.half_angle)
    centre = np.array([-cone.offset - b * cosine - radius * sine, -cone.throat_radius - b * sine + radius * cosine])
    slant = np.linspace(0.0, cone.length, 20001)[:, None]
    flank = np.array([-cone.offset, cone.throat_radius]) + slant * np.array([-cosine, sine])
    turn = np.array(
        [
            [math.cos(scenario.misalignment), -math.sin(scenario.misalignment)],
            [math.sin(scenario.misalignment), math.cos(scenario.misalignment)],
        ]
    )
    return np.min(np.linalg.norm(flank @ turn.T - turn @ centre, axis=1)) - radius


@pytest.mark.quick
def test_a_start_in_the_other_flank_is_refused_wherever_it_is():
    """300 random cones, tips and contacts: refused exactly where the sampled flank is nearer than the tip's radius."""
    random, refused, accepted = np.random.default_rng(16), 0, 0
    while refused < 100 or accepted < 200:
        angle, throat, length = random.uniform(0.05, 1.5), random.uniform(0.002, 0.05), random.uniform(0.02, 0.2)
        radius = random.uniform(0.05, 0.99) * (throat + length * math.sin(angle))
        contact = random.uniform(0.01, 1.0) * length
        limit = 0.9 * min(angle, math.pi / 2 - angle)
        design = replace(
            table2(),
            {
                "cone.half_angle": angle,
                "cone.throat_radius": throat,
                "cone.length": length,
                "probe.tip_radius": radius,
            },
        )
        scenario = Scenario(contact_distance=contact, misalignment=random.uniform(-limit, limit))
        gap = gap_to_the_other_flank(design, scenario)
        if abs(gap) < 1e-5:  # m, what sampling the flank leaves open
            continue
        try:
            check_fit(design, scenario)
            accepted += 1
            assert gap > 0.0
        except InputError as error:
            refused += 1
            assert gap < 0.0 and "the other flank" in str(error)


def test_the_least_contact_distance_is_where_both_flanks_are_touched():
    """(R cos β - R_c)/sin β of a tip of 35 mm: there the gap to the other flank is zero."""
    design = replace(table2(), {"probe.tip_radius": 0.035})
    least = (0.035 * math.cos(math.pi / 4) - 0.015) / math.sin(math.pi / 4)
    assert abs(gap_to_the_other_flank(design, Scenario(contact_distance=least))) < 1e-9
    check_fit(design, Scenario(contact_distance=1.0001 * least))
    with pytest.raises(InputError, match=r"contact_distance = 0\.0137854 m .* allowed: \(0\.0137868, 0\.0735\] m"):
        check_fit(design, Scenario(contact_distance=0.9999 * least))


def test_each_scenario_of_many_meets_its_own_design():
    wide = replace(table2(), {"cone.length": [0.05, 0.08], "probe.tip_radius": [0.015, 0.035]})
    check_fit(wide, Scenario(contact_distance=[0.045, 0.07]))
    with pytest.raises(InputError, match=r"0\.07 m is out of range; allowed: \(0, 0\.05\] m"):
        check_fit(wide, Scenario(contact_distance=[0.07, 0.045]))
    with pytest.raises(InputError, match=r"0\.01 m is out of range; allowed: \(0\.0137868, 0\.08\] m"):
        check_fit(wide, Scenario(contact_distance=0.01))


def test_inside_compiled_code_the_start_in_the_other_flank_is_seen_too():
    seen = jax.jit(lambda radius, b: valid(replace(table2(), {"probe.tip_radius": radius}), Scenario(0.1, b)))
    assert bool(seen(0.035, 0.02)) and not bool(seen(0.035, 0.01))
