"""The mesh of a tank that is drawn: both halves, and a liquid that goes with the wall."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.picture import Meshed
from jaxbuffer.mechanisms.tank_drop.meshes import meshes
from jaxbuffer.mechanisms.tank_drop.numbering import Numbering
from jaxbuffer.mechanisms.tank_drop.section import wall_mass
from jaxbuffer.output.animation import Stage
from jaxbuffer.output.motion import scene

MOVED = 0.01  # m, upwards and all alike


class Kept:
    """A run of two instants, the first with the largest stress and the wall moved."""

    def __init__(self) -> None:
        self.design, self.scenario = jb.TankDrop(), jb.TankDropScenario(fill=0.5)
        numbers = Numbering.of(self.design)
        moved = np.zeros((2, numbers.wall.size + 2, 2))  # of the slider and the baffle too
        moved[0, :, 1] = MOVED
        elements, liquid = len(numbers.corners), numbers.liquid.size
        self.history = self
        self.time = np.array([0.0, 1e-3])
        self.others = {
            "displacement": moved,
            "peak_stress": np.array([2e6, 1e6]),
            "stress": np.full((2, elements), 2e6),
            "plastic_strain": np.zeros((2, elements)),
            "pressure": np.full((2, liquid), 3e3),
        }


def areas(mesh: Meshed) -> np.ndarray:
    x, y = np.moveaxis(mesh.nodes[mesh.cells], -1, 0)
    return 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)


def test_both_halves_make_the_whole_section():
    run = Kept()
    worst, last = meshes(run)
    assert (worst.title, last.title) == ("largest stress, 0 ms", "end, 1 ms")
    of_wall = ~np.isnan(worst.values["stress after von Mises [MPa]"])
    wall = float(wall_mass(run.design)) / 950.0 / 0.7  # m², by the middle surface
    ring = np.pi * (0.04**2 - 0.035**2)  # of all corners; chords across up to 39° take off up to 7.5 % of it
    inside = (0.6 - 0.01) * (0.3 - 0.01)  # less its corners
    level = 0.5 * (0.3 - 0.01)
    for mesh in (worst, last):
        area = areas(mesh)
        assert np.all(area > 0.0)
        assert wall - 0.075 * ring < area[of_wall].sum() < wall
        corners = 2.0 * (1.0 - 0.25 * np.pi) * 0.035**2  # of two corners, whose inner radius is 35 mm
        assert np.isclose(area[~of_wall].sum(), inside * level / 0.29 - corners, rtol=2e-3)


@pytest.mark.quick
def test_at_times_it_is_drawn_in_the_nearest_rows():
    first, second = meshes(Kept(), times=[4e-4, 6e-4])
    assert (first.title, second.title) == ("0 ms", "1 ms")
    assert np.allclose(first.nodes - second.nodes, [0.0, MOVED], atol=1e-12)


def test_an_animation_colours_each_frame_by_the_stress_then():
    run = jb.simulate(jb.TankDrop(), jb.TankDropScenario(height=0.1), 2e-3, history=True)
    stage = Stage(scene(run, np.array([0.0, 2e-3])))
    for k in (0, 1):
        stage.show(k, 1.0)
        (cells,) = (each for each in stage.whole.collections if each.get_array() is not None)
        row = int(np.argmin(np.abs(np.asarray(run.history.time) - stage.at.times[k])))
        stress = 1e-6 * np.asarray(run.history.others["stress"])[row]
        assert np.array_equal(cells.get_array(), np.concatenate([stress, stress]))
        assert cells.get_clim()[1] >= stress.max()


@pytest.mark.quick
def test_the_liquid_goes_with_the_wall():
    worst, last = meshes(Kept())
    assert np.allclose(worst.nodes - last.nodes, [0.0, MOVED], atol=1e-12)
    assert np.nanmax(worst.values["stress after von Mises [MPa]"]) == 2.0
    assert np.nanmax(worst.values["pressure of the liquid [kPa]"]) == 3.0
