"""The bodies and joints of the docking in space."""

import jax.numpy as jnp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jaxbuffer import docking3d, replace
from jaxbuffer.mechanisms.docking3d.bodies import assemble_system
from jaxbuffer.mechanisms.probe_cone.bodies import B, P, probe_masses

ALPHA, BETA = 0.3, -0.2  # rad, of the hinge


@pytest.mark.parametrize("free_tip", [False, True], ids=["welded tip", "free tip"])
def test_cylinder_and_probe_have_the_probes_roll_inertia_together(free_tip):
    design = replace(docking3d(), {"probe.free_tip": free_tip})
    system = assemble_system(design, probe_masses(design), 20.0)
    roll = 0.5 * design.probe.rod_mass * 0.009**2 + (0.0 if free_tip else 0.4 * design.probe.tip_mass * 0.015**2)
    assert system.bodies[B].inertia[0] + system.bodies[P].inertia[0] == pytest.approx(roll)


@pytest.mark.parametrize("roll", [0.0, 0.01], ids=["without roll", "with roll"])
def test_the_hinge_turns_about_y_of_the_active_vehicle_and_then_about_z_of_the_cylinder(roll):
    """SciPy's R_S R_y(α) R_z(β) is on the joint; a roll of the cylinder about its own axis is not."""
    design = docking3d()
    system = assemble_system(design, probe_masses(design), 20.0)
    active = Rotation.from_rotvec([0.4, -0.7, 0.5])
    cylinder = active * Rotation.from_euler("YZX", [ALPHA, BETA, roll])
    hinge = active.apply([design.active.hinge_offset, 0.0, 0.0])
    places = [np.zeros(3), hinge - cylinder.apply([design.buffer.cylinder_length / 2, 0.0, 0.0])]
    places += [places[1] + cylinder.apply([0.1, 0.0, 0.0]), np.ones(3)]
    turns = [rotation.as_quat(scalar_first=True) for rotation in (active, cylinder, cylinder, Rotation.identity())]
    q = jnp.asarray(np.concatenate([part for pair in zip(places, turns, strict=True) for part in pair]))
    constraints = system.constraints(system.kinematics(q, jnp.zeros(24)))
    # Three rows hold the point and one the roll; those of the slide hold throughout.
    off = np.abs(np.asarray(constraints.phi))
    assert off[3] == pytest.approx(np.cos(BETA) * np.sin(roll), rel=1e-12, abs=1e-15)
    assert np.delete(off, 3) == pytest.approx(0.0, abs=1e-15)
