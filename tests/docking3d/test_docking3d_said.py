"""What is said of a docking in space before anything is computed, and in which words."""

import re
from types import SimpleNamespace

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from docking3d.reference import CASES
from jaxbuffer.cli.entry import run as command
from jaxbuffer.fields import paths
from jaxbuffer.fields.paths import meaning
from jaxbuffer.mechanisms.cautions import cautions
from jaxbuffer.mechanisms.docking3d.bodies import assemble_system
from jaxbuffer.mechanisms.docking3d.capture import Docking3D
from jaxbuffer.mechanisms.docking3d.mechanism import DOCKING3D
from jaxbuffer.mechanisms.docking3d.start import start_motion
from jaxbuffer.mechanisms.probe_cone.approach import Approach, rotation_matrix, turned
from jaxbuffer.mechanisms.probe_cone.bodies import P, T, probe_masses
from jaxbuffer.mechanisms.probe_cone.closed_form import first_impact_elasticities
from jaxbuffer.mechanisms.probe_cone.start import before_mouth
from jaxbuffer.output.animation import _title
from jaxbuffer.output.layout import width
from jaxbuffer.output.style import STYLE, drawing

LATCH = {"latch.stiffness": 2e3, "latch.turn_stiffness": 50.0, "buffer.rebound_stiffness": 1e4}


def said(changes, scenario):
    return cautions([(jb.replace(jb.docking3d(), changes), scenario)])


@pytest.mark.parametrize(
    ("offsets", "miss"),
    [
        ({"offset_y": 0.06, "offset_z": -0.06}, "84.85 mm off the axis"),  # either alone is within the rim, 67 mm
        ({"offset_y": 0.06, "offset_z": -0.04}, ""),  # 72 mm: beyond the rim by less than the ball's radius
        ({"lateral_speed_z": 0.2, "standoff": 0.1}, "230 mm off the axis"),  # 115 mm forward at 0.1 m/s
    ],
)
def test_an_approach_that_misses_the_cone_is_said(offsets, miss):
    lines = said({}, jb.Scenario3D(start="free", **offsets))
    if not miss:
        assert lines == []
        return
    assert miss in lines[0] and "scenario.offset_y is" in lines[0] and "scenario.offset_z is" in lines[0]


@eqx.filter_jit
def tip_in_the_cone(design, scenario):
    """Its place and speed at the start in axes of the cone, which turn with it."""
    masses = probe_masses(design)
    kin = assemble_system(design, masses, 20.0).kinematics(*start_motion(design, scenario, masses))
    tip, cone = kin.point(P, masses.tip_centre), kin.frame(T)
    # In such axes a point moves with its velocity less that of the cone's material under it.
    moves = cone.unturn(tip.velocity - cone.velocity_at(tip.place - cone.origin))
    return cone.unturn(tip.place - cone.origin), moves


def test_a_flight_begins_as_the_mechanism_does():
    """The tip's place and speed in the axes of the passive vehicle, all rates given, against the bodies' own motion."""
    design, scenario = CASES["free start, all rates"].design, CASES["free start, all rates"].scenario
    place, moves = (np.array(vector, float) for vector in tip_in_the_cone(design, scenario))
    x, aside = scenario.approach.flight(design, scenario, float(before_mouth(design, scenario.standoff)))
    step = 4.0 * abs(x[0]) / scenario.approach_speed / (len(x) - 1)
    assert (x[0], aside[0]) == pytest.approx((place[0], np.hypot(*place[1:])))
    rates = [np.dot([-1.5, 2.0, -0.5], values[:3]) / step for values in (x, aside)]  # of second order
    assert rates == pytest.approx([moves[0], place[1:] @ moves[1:] / np.hypot(*place[1:])], rel=1e-5)


@pytest.mark.parametrize("size", [1e-9, 0.02, 2.5])
def test_the_angle_of_a_start_is_that_of_the_rotation_between_the_vehicles(size):
    zero, passive = np.zeros(3), rotation_matrix(0.3, -0.2)
    axis = np.array([0.6, 0.0, -0.8])
    active = np.stack([turned(size * axis, column) for column in passive.T], axis=1)
    assert Approach(zero, (0.0, 0.0), active, passive, zero, zero).angle == pytest.approx(size, rel=1e-6)


def test_a_latch_that_puts_in_much_by_turning_is_said_before_a_run():
    """½ · 50 N m/rad · (0.03² + 0.04²) is 62.5 mJ: yaw and pitch count together, to second order."""
    (line,) = said(LATCH, jb.Scenario3D(passive_yaw=0.03, passive_pitch=0.04))
    assert line.startswith("closing the latch adds up to 62.5 mJ by turning the probe")
    assert "the start's angle of 2.86 deg" in line
    assert said(LATCH, jb.Scenario3D(passive_yaw=0.003, passive_pitch=0.004)) == []


def test_the_first_impact_in_closed_form_is_the_plane_s_at_any_azimuth():
    """Straight on, every azimuth is the planar lower flank, turned: the same mass is met, whatever the roll inertia."""
    flat = jb.first_impact(jb.table2(), jb.Scenario(approach_speed=0.2))
    for azimuth in (0.0, 0.7):
        first = jb.first_impact(jb.docking3d(), jb.Scenario3D(approach_speed=0.2, azimuth=azimuth))
        for name in ("effective_mass", "effective_energy", "elastic_peak", "predicted_peak", "duration"):
            assert float(getattr(first, name)) == pytest.approx(float(getattr(flat, name)), rel=1e-9), name


@pytest.mark.slow
def test_the_first_impact_s_elasticities_are_the_plane_s():
    flat = first_impact_elasticities(jb.table2(), jb.Scenario())
    assert first_impact_elasticities(jb.docking3d(), jb.Scenario3D(azimuth=0.7)) == pytest.approx(flat, rel=1e-9)
    assert len(flat) > 10


def test_a_design_in_space_takes_a_scenario_in_space():
    with pytest.raises(jb.InputError, match=r"is not a Scenario3D; .* jb.Scenario3D\(\)"):
        jb.first_impact(jb.docking3d(), jb.Scenario())


def test_the_title_of_a_film_is_broken_into_lines_that_fit():
    """A start in space has many numbers: in one line they would stand beyond both edges of the picture."""
    rates = dict.fromkeys(("active_rate_x", "active_rate_y", "active_rate_z", "passive_rate_x", "passive_rate_z"), 0.01)
    scenario = jb.Scenario3D(start="free", offset_y=0.02, offset_z=-0.03, active_yaw=0.01, **rates)
    inches, size = 9.7, 1.2 * STYLE["font.size"]  # points of a large text
    with drawing():
        title = _title(SimpleNamespace(mechanism=DOCKING3D, scenario=scenario), inches)
    lines = title.split("\n")
    assert " ".join(lines) == f"Capture in space, approach at {DOCKING3D.view.label(scenario)}"
    assert len(lines) > 1 and max(width(line, size) for line in lines) < 72.0 * inches


def test_a_scenario_in_a_few_words():
    label = DOCKING3D.view.label
    assert label(jb.Scenario3D(azimuth="40 deg", passive_pitch="1 deg")) == (
        "0.1 m/s, azimuth 40 deg, passive pitch 1 deg"
    )
    free = jb.Scenario3D(start="free", offset_y=-0.03, active_rate_x="2 deg/s")
    assert label(free) == "0.1 m/s, free start, active rate x 2 deg/s, offset y -30 mm"


@pytest.mark.parametrize(
    ("speed", "drift"),
    [(-0.012, "moving towards it at 12 mm/s"), (0.012, "moving away from it at 12 mm/s")],
)
def test_the_probes_direction_at_the_latches_is_said_without_its_roll_and_with_it(speed, drift):
    """The rotation vector's size has the roll in it: of a vehicle that rolls it is no angle against the cone's axis."""
    docking = SimpleNamespace(
        swing_miss=jnp.asarray(np.radians(0.5)), attitude_miss=jnp.radians(3.0), lateral_miss_rate=jnp.asarray(speed)
    )
    assert Docking3D.direction_text(docking) == "probe 0.5 deg against it, 3 deg with its roll"
    assert Docking3D.drift_text(docking) == drift


def test_no_text_of_space_speaks_of_flanks():
    """The cone is one of revolution: it has no upper and no lower flank."""
    fields = "".join(meaning(jb.docking3d(), path) for path in paths(jb.docking3d()))
    quantities = "".join(quantity.description for quantity in DOCKING3D.quantities.values())
    known = {"peak_force": 1e9, "penetration": 0.01}
    limits = [limit.beyond for limit in DOCKING3D.view.validity(jb.docking3d(), known)]
    assert "inertia I_S about y and z" in fields and "planar" not in "".join(DOCKING3D.view.limitations)
    assert "flank" not in fields + quantities + "".join(limits) + DOCKING3D.outcomes.failed_penetration.reason


def test_a_history_lists_no_energy_of_parts_that_space_does_not_have():
    names = jb.recorded_quantities(jb.docking3d())
    assert "energy_torsional_damper" in names and not {"energy_bending", "energy_hinge_play"} & set(names)


def test_check_explains_the_study_that_init_writes(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert command(["init", "--kind", "docking3d", "study.toml"]) == 0
    assert command(["check", "study.toml"]) == 0
    shown = capsys.readouterr().out
    assert re.search(r'mechanism\s+Capture in space, kind = "docking3d"', shown)
    assert "every load case must end held or latched" in shown
