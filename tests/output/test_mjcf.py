"""A docking as MuJoCo's MJCF and as tables: bodies and joints by hand, what stands in words, bad input.

That MuJoCo moves it as an independent program does is in tests/verification/test_second_opinion_space.py.
"""

import csv
import math
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from numpy.testing import assert_allclose

import jaxbuffer as jb
from jaxbuffer.cli.entry import run


def numbers(element, name):
    return [float(it) for it in element.get(name).split()]


def probe_by_hand(probe):
    """Mass, where its centre is before the rod's middle, and moment of inertia across, of rod and point-like tip."""
    mass = probe.rod_mass + probe.tip_mass
    ahead = probe.tip_mass * probe.length / 2 / mass
    across = probe.rod_mass * (probe.length**2 / 12 + ahead**2) + probe.tip_mass * (probe.length / 2 - ahead) ** 2
    return mass, ahead, across


def test_bodies_and_joints_are_those_of_the_design():
    design = jb.replace(jb.docking3d(), {"probe.free_tip": True})
    root = ET.fromstring(jb.mjcf(design, jb.Scenario3D()))
    bodies = {it.get("name"): it for it in root.iter("body")}
    assert list(bodies) == ["active", "cylinder", "probe", "tip", "passive"]
    active, cylinder, probe, tip, passive = (bodies[name] for name in bodies)
    assert active.find("freejoint") is not None and passive.find("freejoint") is not None
    half = design.buffer.cylinder_length / 2
    assert_allclose(numbers(cylinder, "pos"), [design.active.hinge_offset - half, 0, 0], rtol=1e-14)
    hinges = cylinder.findall("joint")
    assert [numbers(it, "axis") for it in hinges] == [[0, 1, 0], [0, 0, 1]]
    assert all(numbers(it, "pos") == [half, 0, 0] for it in hinges)
    assert all(float(it.get("stiffness")) == design.buffer.k_T for it in hinges)
    mass, ahead, across = probe_by_hand(design.probe)
    # The buffer begins at its free length, from the cylinder's rear end to the rod's.
    behind = -half + design.buffer.free_length + design.probe.length / 2 + ahead
    assert_allclose(numbers(probe, "pos"), [behind, 0, 0], rtol=1e-14)
    (slide,) = probe.findall("joint")
    assert (slide.get("type"), numbers(slide, "axis")) == ("slide", [1, 0, 0])
    assert (float(slide.get("stiffness")), float(slide.get("damping"))) == (design.buffer.k_A, design.buffer.c_A)
    assert_allclose(float(slide.get("springref")), 0.0, atol=1e-15)
    assert_allclose(float(probe.find("inertial").get("mass")), mass, rtol=1e-14)
    assert_allclose(numbers(probe.find("inertial"), "diaginertia")[1:], [across, across], rtol=1e-14)
    assert_allclose(numbers(tip, "pos"), [design.probe.length / 2 - ahead, 0, 0], rtol=1e-14)
    ball = 0.4 * design.probe.tip_mass * design.probe.tip_radius**2
    assert tip.find("joint").get("type") == "ball"
    assert_allclose(numbers(tip.find("inertial"), "diaginertia"), [ball] * 3, rtol=1e-14)


def test_the_start_is_a_key_frame():
    scenario = jb.Scenario3D(start="free", standoff=0.1, passive_yaw=0.2, active_rate_z=0.03, lateral_speed_y=0.01)
    key = ET.fromstring(jb.mjcf(jb.docking3d(), scenario)).find("keyframe/key")
    at, rates = numbers(key, "qpos"), numbers(key, "qvel")
    assert (len(at), len(rates)) == (17, 15)
    assert_allclose(at[10:], [0, 0, 0, math.cos(0.1), 0, 0, math.sin(0.1)], atol=1e-15)
    assert_allclose(rates[:6], [0.1, 0.01, 0, 0, 0, 0.03], atol=1e-15)
    assert_allclose(rates[6:9], 0.0, atol=1e-15)  # in line, and turning as one body


def test_in_the_plane_bodies_move_there_alone():
    design = jb.table2()
    root = ET.fromstring(jb.mjcf(design, jb.Scenario(misalignment=0.05)))
    bodies = {it.get("name"): it for it in root.iter("body")}
    free = [(it.get("type"), numbers(it, "axis")) for it in bodies["passive"].findall("joint")]
    assert free == [("slide", [1, 0, 0]), ("slide", [0, 1, 0]), ("hinge", [0, 0, 1])]
    (hinge,) = bodies["cylinder"].findall("joint")
    assert numbers(hinge, "axis") == [0, 0, 1] and float(hinge.get("damping")) == design.buffer.c_T
    assert numbers(root.find("keyframe/key"), "qpos")[-1] == 0.05


def test_what_mujoco_cannot_have_stands_in_words():
    design = jb.replace(jb.table2(), {"buffer.friction": 3.0})
    text = jb.mjcf(design, jb.Scenario(thrust=1.0, thrust_time=0.4))
    comment = text.partition("<!--")[2].partition("-->")[0]
    for words in ("tip: a ball of radius 0.015 m", "restitution 0.9", "soft constraints", "thrust:", "buffer:"):
        assert words in comment, words
    assert "--" not in comment
    (slide,) = (it for it in ET.fromstring(text).iter("joint") if it.get("name") == "probe 1")
    assert float(slide.get("stiffness")) == 0.0, "a buffer with friction is no linear spring"


def test_tables_and_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.toml").write_text('kind = "docking3d"\n')
    assert run(["export-mjcf", "study.toml", "--output", "docking.xml"]) == 0
    with open("docking.bodies.csv", newline="") as file:
        bodies = {row["body"]: row for row in csv.DictReader(file)}
    design = jb.docking3d()
    assert float(bodies["passive"]["inertia x [kg m²]"]) == design.passive.roll_inertia
    with open("docking.joints.csv", newline="") as file:
        joints = list(csv.DictReader(file))
    assert [(it["parent"], it["child"], it["type"]) for it in joints] == [
        ("active", "cylinder", "hinge"), ("active", "cylinder", "hinge"), ("cylinder", "probe", "slide"),
    ]  # fmt: skip
    assert np.isclose(float(joints[2]["stiffness [N/m, N m/rad]"]), design.buffer.k_A)
    capsys.readouterr()
    assert run(["export-mjcf", "study.toml", "--output", "docking.xml"]) == 2
    assert "docking.xml exists; --force overwrites" in capsys.readouterr().err
    assert run(["export-mjcf", "study.toml"]) == 2


def test_what_cannot_be_written_is_said():
    for design, words in (
        (jb.with_bending(jb.table2(), 200.0), "bend"),
        (jb.TankDrop(), "assembled from bodies"),
        (jb.published_slider_crank(), "tree of bodies"),
    ):
        with pytest.raises(jb.InputError, match=words):
            jb.mjcf(design)
