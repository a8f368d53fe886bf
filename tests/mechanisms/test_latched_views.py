"""What people see of a run with latches, from a free start, and of one that no latch follows."""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.errors import InputError
from jaxbuffer.mechanisms.probe_cone.drawing import drawing
from jaxbuffer.mechanisms.probe_cone.label import scenario_label
from jaxbuffer.mechanisms.probe_cone.outcome import Outcome
from jaxbuffer.mechanisms.probe_cone.panels import panels
from jaxbuffer.mechanisms.probe_cone.sanity_checks import sanity_checks
from jaxbuffer.mechanisms.probe_cone.summary import summary
from jaxbuffer.output.animation import frames_of
from jaxbuffer.output.figures import run_figure
from jaxbuffer.output.motion import telling_times
from jaxbuffer.output.page_data import force_record
from jaxbuffer.output.records import run_record
from made_up import made_up_capture

LATCH = {"latch.stiffness": 2e3, "latch.damping": 50.0, "latch.strength": 30.0}
ENERGIES = {"latch": 0.02, "latch_closing": -0.05, "latch_damper": 0.03}  # J, at the end
TAIL = 0.5  # s


@pytest.fixture
def latched():
    """A made-up run that lasts long after its impact, with latches."""
    run = made_up_capture(design=jb.replace(jb.table2(), LATCH), outcome=Outcome.held)
    energy = run.history.energy
    for name, end in ENERGIES.items():
        part = energy.lost if name == "latch_damper" else energy.stored
        part[name] = end * jnp.linspace(0.0, 1.0, len(run.history.time))
    for name, end in ENERGIES.items():
        (run.energy.lost if name == "latch_damper" else run.energy.stored)[name] = jnp.asarray(end)
    time = jnp.where(run.history.time > 0.03, run.history.time * TAIL / 0.04, run.history.time)
    changed = (time, jnp.asarray(0.03), jnp.asarray(0.47), jnp.asarray(20.0), jnp.asarray(TAIL))
    docked = (jnp.asarray(0.004), jnp.asarray(0.01), jnp.asarray(0.02), jnp.asarray(0.0))
    return eqx.tree_at(
        lambda c: (
            *(c.history.time, c.docking.latch_time, c.docking.settling_time, c.peak_latch_force, c.end_time),
            *(
                c.docking.lateral_miss,
                c.docking.lateral_miss_rate,
                c.docking.attitude_miss,
                c.docking.attitude_miss_rate,
            ),
        ),
        run,
        (*changed, *docked),
    )


def test_panels_of_a_latched_run_go_to_its_end(latched):
    shown = {panel.title.partition(",")[0]: panel for panel in panels(latched)}
    assert [panel.title for panel in shown.values() if not panel.to_end] == ["Gap and distance to capture"]
    assert {level.label for level in shown["Latch force"].levels} >= {"largest, 20 N", "strength, 30 N"}
    titles = {axes.get_title(loc="left"): axes for axes in run_figure(latched).axes}
    latch, force = titles["Latch force"], titles["Contact force"]
    assert latch.get_xlabel() == "time [s]" and latch.get_xlim()[1] > TAIL
    assert force.get_xlabel() == "time [ms]" and force.get_xlim()[1] < 0.1e3 * TAIL


def test_the_energy_panel_has_the_energy_of_relative_motion_and_no_common_one(latched):
    energy = next(panel for panel in panels(latched) if panel.stacked)
    parts = {curve.label: np.asarray(curve.values) for curve in energy.curves}
    many = 1e3 if "[mJ]" in energy.axis else 1.0
    stored = np.asarray(latched.history.energy.spring + latched.history.energy.latch)
    moving = np.maximum(np.asarray(latched.history.relative_energy) - stored, 0.0)
    np.testing.assert_allclose(parts["relative motion"] / many, moving, atol=1e-12)
    assert parts["in the latches"][-1] == pytest.approx(many * 0.05)


@pytest.mark.quick
def test_no_panel_of_latches_without_any():
    assert not any(panel.to_end or "Latch" in panel.title for panel in panels(made_up_capture()))


def test_the_summary_says_when_it_was_latched_and_what_the_closing_put_in(latched):
    text = summary(latched)
    assert "latched              at 0.03 s, held 0.47 s later; latch force at most 20 N of 30 N strength" in text
    assert "4 mm off the axis" in text and "0.05 J put in by the closing of the latches" in text
    assert "ends at capture" not in text


def test_a_run_without_latches_says_what_it_leaves_open():
    run = made_up_capture()
    text, record = summary(run), run_record(run)
    assert "at capture, where the run ends, 30 mJ of relative motion, 30 % of that at the start" in text
    assert "it may take up to 20 mm of stroke" in text
    assert (record["energy_left"]["value"], record["relative_energy"]["value"]) == pytest.approx((0.03, 0.3))
    assert record["arrest_stroke"]["value"] == pytest.approx(0.02)


def test_frames_of_an_animation_hurry_after_the_last_contact(latched):
    frames = frames_of(latched)
    assert frames.times[-1] == pytest.approx(TAIL) and np.all(np.diff(frames.times) > 0.0)
    assert np.sum(frames.times < 0.03) > 80 and np.sum(frames.times > 0.03) >= 80
    assert telling_times(latched)[[0, -1]] == pytest.approx([0.0, TAIL]) and len(telling_times(latched)) == 4


def test_latches_are_drawn_open_before_and_closed_after(latched):
    picture = drawing(latched.design)
    frames = picture.frames(latched.history)
    teeth = [shape for shape in picture.shapes if shape.part == "latch"]
    assert len(teeth) == 1 and frames.shape[1] == teeth[0].body + 2
    cone = frames[:, 3]
    away = np.hypot(*(frames[:, teeth[0].body] - cone)[:, :2].T)
    assert away[0] > latched.design.cone.throat_radius and away[-1] == pytest.approx(0.0)
    assert not any(shape.part == "latch" for shape in drawing(jb.table2()).shapes)


def test_the_page_has_stroke_angle_and_latch_force_to_the_end(latched):
    more = force_record({"capture": latched}, "0.1 m/s")["more"]
    assert [chart["axis"] for chart in more] == ["stroke [mm]", "hinge angle [°]", "latch force [N]"]
    assert [chart["unit"] for chart in more] == ["mm", "°", "N"]
    for chart in more:
        (curve,) = chart["curves"]
        assert curve["time"][-1] == pytest.approx(TAIL) and len(curve["time"]) == len(curve["values"])
    assert force_record({"capture": made_up_capture()}, "")["more"] == []


def test_a_run_that_touches_nothing_is_told_and_drawn(latched):
    nothing = (jnp.zeros(()), jnp.asarray(0), jnp.asarray(0), 0.0 * latched.history.contact_force)
    run = eqx.tree_at(
        lambda c: (c.peak_force, c.impact_count, c.impacts.count, c.history.contact_force), latched, nothing
    )
    assert "peak contact force   none: the tip did not touch a flank" in summary(run)
    assert run_record(run)["peak_flank"] is None
    assert run_figure(run).axes[0].get_title(loc="left") == "Contact force: nothing touches"


@pytest.mark.parametrize(("angle", "lever"), [(0.3, "latch.turn_stiffness"), (0.001, "latch.stiffness")])
def test_much_energy_of_the_latch_names_the_larger_part_and_its_lever(latched, angle, lever):
    """½ k_t φ² with 50 N m/rad and 0.3 rad is 2.25 J, ½ k r² with 20 kN/m and 4 mm is 160 mJ; 25 µJ at 0.001 rad."""
    design = jb.replace(latched.design, {"latch.stiffness": 2e4, "latch.turn_stiffness": 50.0, "latch.preload": 0.0})
    run = eqx.tree_at(
        lambda c: (c.design, c.docking.lateral_miss, c.docking.attitude_miss),
        latched,
        (jb.replace(design, {"latch.depth": 0.0}), jnp.asarray(0.004), jnp.asarray(angle)),
    )
    (line,) = (line for line in summary(run).splitlines() if "sanity check: closing" in line)
    assert "pulling the tip to its seat 160 mJ" in line
    assert f"turning the probe {'2.25 J' if angle == 0.3 else '25 µJ'}" in line
    advice = line.partition(";")[2]
    assert lever in advice and ("turn_stiffness" in advice) == (angle == 0.3)


def test_what_closing_the_latches_adds_has_a_line_of_its_own_and_much_is_a_warning(latched):
    """50 mJ beside 100 mJ of the vehicles (30 mJ left are three tenths); 200 mJ beside them; 5 mJ beside them."""
    text = summary(latched)
    assert "energy of the latch  closing the latch added 50 mJ, 50 % of what the vehicles brought (100 mJ)" in text
    assert "sanity check: closing the latch added 50 mJ" in text
    assert float(latched.quantity("latch_energy")) == pytest.approx(0.05)
    assert float(latched.quantity("latch_energy_share")) == pytest.approx(0.5)
    latched.energy.stored["latch_closing"] = jnp.asarray(-0.6)
    assert "added 600 mJ, 6 times what the vehicles brought (100 mJ)" in summary(latched)
    latched.energy.stored["latch_closing"] = jnp.asarray(-0.005)
    text = summary(latched)
    assert "added 5 mJ, 5 % of what" in text and "sanity check" not in text
    assert "latch" not in "".join(run_record(made_up_capture())["outside_validity"])


def test_the_energy_left_is_told_beside_that_of_one_speed_for_all_approaches(latched):
    """M182: 30 mJ over half the reduced mass of Table 2's vehicles times the square of 0.1 m/s."""
    design = latched.design
    active = 21.9706 + 1.0 + float(design.probe.rod_mass) + float(design.probe.tip_mass)
    reference = 0.5 * active * 23.5731 / (active + 23.5731) * 0.01
    assert float(latched.quantity("reference_energy_left")) == pytest.approx(0.03 / reference)


def test_the_headline_names_the_force_on_a_vehicle_that_exceeds_the_contacts(latched):
    """Peak contact 250 N and hinge 375 N of the made-up run; then 636 N in the latch, and less than the contact's."""

    def told(latch, hinge):
        run = eqx.tree_at(lambda c: (c.peak_latch_force, c.peak_hinge_force), latched, (latch, hinge))
        return run, run_record(run)["larger_force"], float(run.quantity("peak_vehicle_force"))

    assert told(20.0, 375.0)[1:] == ("the largest force on a vehicle is the hinge's, 375 N", 375.0)
    run, headline, largest = told(jnp.asarray(636.0), jnp.asarray(636.0))
    assert (headline, largest) == ("the largest force on a vehicle is the latch's, 636 N", 636.0)
    assert headline in summary(run)
    assert told(20.0, 30.0)[1:] == ("", 250.0)


def test_the_label_says_what_is_free_of_a_free_start():
    start = jb.Scenario(
        start="free", offset="-20 mm", active_angle="1 deg", passive_rate="2 deg/s", approach_speed=0.05
    )
    label = "0.05 m/s, 0°, free start, offset -20 mm, active angle 1 deg, passive rate 2 deg/s"
    assert scenario_label(start) == label
    assert scenario_label(jb.Scenario(thrust=1.0, thrust_time=1.5)) == "0.1 m/s, 0°, thrust 1 N for 1.5 s"
    assert scenario_label(jb.Scenario(start="free")) == "0.1 m/s, 0°, free start"
    assert scenario_label(start, [start, jb.Scenario()]) == label
    # What all have in common tells none from another.
    assert scenario_label(start, [start, jb.Scenario(start="free")]) == label.replace(", free start", "")


@pytest.mark.quick
def test_what_a_heavy_design_keeps_of_the_laboratory_model_is_listed():
    heavy = {"active.mass": 8000.0, "passive.mass": 8000.0, "active.inertia": 2e4, "passive.inertia": 2e4}
    heading, *lines = sanity_checks(jb.replace(jb.table2(), heavy))
    assert "far from the laboratory model's 22 kg and 23.6 kg" in heading
    listed = [line.partition(" ")[0] for line in lines]
    assert {"cone.offset", "buffer.free_length", "probe.tip_radius", "contact.friction"} <= set(listed)
    assert not {"active.inertia", "passive.inertia"} & set(listed), "they are given"
    assert lines[listed.index("cone.offset")].endswith("grown with the mass 670 mm")  # 96 mm (8000/23.57)^(1/3)
    assert sanity_checks(jb.table2()) == []


def test_a_restitution_that_the_law_does_not_deliver_is_said():
    (line,) = sanity_checks(jb.replace(jb.table2(), {"contact.restitution": 0.5}))
    assert line.startswith("contact.restitution 0.5: the law lankarani-nikravesh delivers 0.73;")
    assert sanity_checks(jb.replace(jb.table2(), {"contact.restitution": 0.5, "contact.law": "exact"})) == []


def test_times_of_maxima_are_those_of_one_solved_run():
    run = jb.simulate(jb.table2(), jb.Scenario(), 0.2)
    history = jb.simulate(jb.table2(), jb.Scenario(), 0.2, history=True).history
    at, seen = run.maximum_times, np.asarray(history.stroke)
    assert at["stroke"] == pytest.approx(float(history.time[int(np.argmax(seen))]), abs=2e-3)
    assert float(run.quantity("stroke_time")) == at["stroke"]
    assert run_record(run)["maximum_times"]["stroke"]["value"] == at["stroke"]
    assert np.isnan(float(run.quantity("peak_latch_force_time")))
    with pytest.raises(InputError, match="stroke_time has no derivatives"):
        jb.sensitivity(jb.table2(), quantities=("stroke_time",))
    with pytest.raises(InputError, match="no derivatives"):
        eqx.filter_jit(
            lambda k: jb.simulate(jb.replace(jb.table2(), {"buffer.k_A": k}), jb.Scenario(), 0.2).maximum_times
        )(jnp.asarray(500.0))
