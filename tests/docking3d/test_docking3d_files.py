"""What the pictures of a docking in space show."""

import numpy as np
import pytest

import jaxbuffer as jb
from docking3d.reference import CASES
from jaxbuffer.mechanisms.probe_cone.bodies import T
from jaxbuffer.output.figures import run_figure
from jaxbuffer.output.motion import motion_figure, scene

pytestmark = [pytest.mark.slow, pytest.mark.long]

CASE = CASES["table2, another azimuth"]


@pytest.fixture(scope="module")
def run():
    return jb.simulate(CASE.design, CASE.scenario, CASE.duration, history=True)


def test_the_path_is_that_of_the_ball_in_the_cones_axes(run):
    at = scene(run, [0.2, 0.5])
    others = run.history.others
    np.testing.assert_allclose(at.path, np.stack([others["tip_z"], others["tip_y"]], axis=1), atol=1e-12)
    # It begins at the azimuth, from the lower flank on, z to the right.
    start = at.path[0]
    assert np.arctan2(start[0], -start[1]) == pytest.approx(CASE.scenario.azimuth)
    # Of the passive vehicle the side view shows place and direction of its axis.
    spun = np.asarray(run.history.position)[0, T]
    assert at.drawing.frames(run.history)[0, T] == pytest.approx([spun[0], spun[1], 0.0], abs=1e-12)


def test_both_views_and_the_hinges_angles_are_drawn(run):
    motion = motion_figure(run, [0.2, 0.5])
    titles = [axes.get_title(loc="left") for axes in motion.axes]
    assert titles[1::2] == ["along the cone's axis, with the ball's path"] * 2
    assert motion.axes[1].get_xlabel() == "z [mm]" and motion.axes[1].get_ylabel() == "y [mm]"
    panels = {axes.get_title(loc="left").partition(",")[0]: axes for axes in run_figure(run).axes}
    plane = panels["Hinge angles in their plane"]
    (line,) = plane.get_lines()
    assert np.max(np.hypot(*line.get_data())) == pytest.approx(np.degrees(float(run.hinge_angle)), rel=1e-3)
    assert "gap, cone" in panels["Gap and distance to capture"].get_legend_handles_labels()[1]
