"""A tank without air, one with air shut in, and a slider without a cushion."""

import numpy as np
import pytest

import jaxbuffer as jb
from jaxbuffer.mechanisms.tank_drop.numbering import Numbering
from jaxbuffer.mechanisms.tank_drop.run import rows_of
from jaxbuffer.mechanisms.tank_drop.section import section
from jaxbuffer.output.style import png
from jaxbuffer.papers.study import Studied, StudyCase
from jaxbuffer.papers.tank.figures import figure
from jaxbuffer.papers.tank.rows import COLUMNS, row
from jaxbuffer.papers.tank.studies import STUDIES

ELASTIC = {"material.yield_stress": 1e9}
SOUND, DENSITY = 1150.0, 740.0


def area(x, y):
    """Of a polygon, by the shoelace formula [m²]."""
    return 0.5 * np.sum(x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1), axis=-1)


@pytest.fixture(scope="module")
def full():
    design = jb.replace(jb.TankDrop(), ELASTIC | {"contents.kind": "full"})
    return jb.simulate(design, jb.TankDropScenario(height=0.5, fill=1.0), 0.02, history=True)


def test_a_full_tank_carries_by_its_liquid(full, evidence):
    """The mean pressure beyond the static one is ρ c² times the share of the inside that is lost, by the shoelace
    formula; energy is kept."""
    numbers, rows = Numbering.of(full.design), slice(rows_of(full))
    seen = section(full.design, 1.0)
    moved = np.asarray(full.history.others["displacement"])[rows][:, numbers.inner]
    at = np.asarray(seen.positions)[numbers.inner] + moved
    inside = area(at[..., 0], at[..., 1])
    corners = np.asarray(seen.liquid)[numbers.liquid_corners]
    quarter = 0.25 * area(corners[..., 0], corners[..., 1])
    weight = np.zeros(numbers.liquid.size)
    np.add.at(weight, numbers.liquid_corners, quarter[:, None])
    high = np.asarray(seen.liquid)[:, 1]
    static = DENSITY * 9.81 * (high[numbers.liquid[0, -1]] - high)
    mean = (np.asarray(full.history.others["pressure"])[rows] - static) @ weight / weight.sum()
    rigid = DENSITY * SOUND**2 * (inside[0] - inside) / weight.sum()
    assert mean.max() > 2e4, "the liquid carries"
    off = np.max(np.abs(mean - rigid)) / mean.max()
    evidence(
        "Drop onto a tank", "a full tank's mean pressure, by its volume", off, 0.01, "bulk modulus times lost area"
    )
    energy = float(full.balance.energy)
    evidence("Drop onto a tank", "a full tank keeps its energy", energy, 1e-4, "sum of all energies")


def test_its_studies_are_drawn(full):
    case = StudyCase("full", 1.0, full.design, full.scenario)
    made = row(case, full)
    assert set(made) == set(COLUMNS) and made["order"] == "none"
    studied = Studied(STUDIES[0]._replace(cases=(case,)), (full,), (made,))
    assert png(figure(studied)).startswith(b"\x89PNG")


def test_without_a_cushion_the_slider_stops_at_the_wall():
    """By defence nodes it enters the wall by no more than nodes that share it cost, some millionth of a penalty's."""
    bare = {"contents.kind": "full", "cushion.kind": "none", "support.method": "defence node"}
    run = jb.simulate(
        jb.replace(jb.TankDrop(), ELASTIC | bare), jb.TankDropScenario(height=0.05, fill=1.0), 4e-3, history=True
    )
    assert float(run.peak_force) > 0.0 and float(run.penetration) < 1e-6
    assert float(run.balance.energy) < 1e-2 and float(run.compression) == 0.0
