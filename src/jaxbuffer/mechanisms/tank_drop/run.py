"""The run of a drop onto a tank."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from ..._types import Scalar
from ..energy import Balance, Energy
from ..history import History
from ..impacts import Impacts
from .assembly import TankModel, assembled
from .design import TankDrop, TankDropScenario
from .outcome import FORMS, TankOutcome
from .section import wall_mass
from .stepping import SMOOTH, Dropped, HistoryRow
from .tank_run import TankRun


def run_of(parameters: tuple[TankDrop, TankDropScenario, Scalar], duration: Scalar, drop: Dropped) -> TankRun:
    """Return the run, from what was stepped."""
    design, scenario, _ = parameters
    parts = assembled(design, scenario)
    tally, factor, limit = drop.tally, parts.factor, parts.strength
    (history,) = drop.state.histories
    deleted = jnp.sum(jnp.all(parts.material.failed(history), axis=1))
    code = drop.outcome(deleted)
    # Failures have the highest codes. As a factor NaN reaches the derivatives of a failed run as well.
    known = jnp.where(code < int(TankOutcome.failed_steps), 1.0, jnp.nan)
    before, after = -jnp.sqrt(2.0 * scenario.gravity * scenario.height), drop.state.velocity[parts.slider, 1]
    end = jnp.where(drop.crushed, drop.state.time, duration)
    # The force also stops what the weight adds until the end.
    momentum = jnp.asarray(design.slider.mass, float) * (after - before + scenario.gravity * end)
    area, scale = jnp.sum(parts.wall.quads.area), limit / SMOOTH
    mean = tally.sharpened - jnp.log(area * end)
    # The smooth maximum is least where the largest stress is that of the smallest element for one step (M169).
    smallest = jnp.min(parts.wall.quads.area) * drop.step
    never = jnp.isinf(tally.failures)
    times = dict(zip(FORMS, jnp.where(never, jnp.nan, tally.failures), strict=True))
    return TankRun(
        **_of_every_run(parts, parameters, drop, code, known, end, momentum),
        impulse=factor * tally.impulse * known,
        momentum=momentum * known,
        peak_stress=tally.stress * known,
        stress_element=tally.stress_element,
        smooth_stress=(limit + scale * mean) * known,
        smooth_bias=scale * jnp.log(area * end / smallest),
        plastic_strain=jnp.max(history.equivalent) * known,
        plastic_work=factor * tally.energies.plastic * known,
        deleted=deleted,
        deflection=tally.deflection * known,
        travel=tally.travel * known,
        compression=(tally.compression / design.cushion.thickness if parts.system.layers else jnp.zeros(())) * known,
        yield_time=times["yield"],
        solid_time=times["solid"],
        torn_time=times["torn"],
        crack_time=times["crack"],
        # Without a liquid both are still infinite, as the tally begins.
        highest_pressure=jnp.where(jnp.isfinite(tally.highest), tally.highest, 0.0) * known,
        lowest_pressure=jnp.where(jnp.isfinite(tally.lowest), tally.lowest, 0.0) * known,
        rebound_speed=after * known,
        slide=drop.state.displacement[parts.section.numbers.outer[0], 0] * known,
        reserve=(tally.reserve if design.material.kind == "composite" else limit / tally.stress) * known,
        wall_mass=wall_mass(design),
        step=drop.step,
    )


def _of_every_run(
    parts: TankModel, parameters: Any, drop: Dropped, code: Array, known: Array, end: Array, momentum: Array
) -> dict[str, Any]:
    """Return the fields of `Run`: one impact, that of the cushion. ``known``: 1, or NaN for a failed run; ``end`` [s];
    ``momentum``: by which the slider was slowed down [N s]."""
    design, scenario, stabilisation = parameters
    tally, factor = drop.tally, parts.factor
    force, speed = factor * tally.force * known, jnp.sqrt(2.0 * scenario.gravity * scenario.height)
    touched = jnp.where(tally.force > 0.0, 1, 0)
    impacts = Impacts(
        # A run starts where the cushion would just touch the tank undeformed (see `at_rest`).
        time=jnp.zeros(1),
        contact=touched[None] - 1,
        approach_speed=speed[None] * known,
        peak_force=force[None],
        # A force that acts up to the end has not been released.
        release_time=jnp.where(tally.released < end - 2.0 * drop.step, tally.released, jnp.nan)[None],
        count=touched,
    )
    balance = Balance(
        energy=factor * tally.off / (0.5 * design.slider.mass * speed**2) * known,
        linear_momentum=jnp.abs(factor * tally.impulse - momentum) / (design.slider.mass * speed) * known,
        angular_momentum=jnp.asarray(jnp.nan),
        # Nodes are held by infinite masses: there are no constraints that could drift.
        drift=jnp.zeros(()),
    )
    return {
        "design": design,
        "scenario": scenario,
        "code": code,
        "peak_force": force,
        "peak_time": jnp.where(touched > 0, tally.force_time, jnp.nan) * known,
        "peak_contact": touched - 1,
        "peak_impact": touched - 1,
        "maxima": {},
        "penetration": tally.compression * known,
        "end_time": end * known,
        "contact_time": tally.in_contact * known,
        "impact_count": touched,
        "impacts": impacts,
        "energy": _energy(factor, tally.energies),
        "balance": balance,
        "history": None if tally.rows is None else history_of(parts, tally.rows.compacted()),
        "attempts": drop.steps,
        "accepted": drop.steps,
        "stabilisation": jnp.asarray(stabilisation, float),
        "_located": None,  # no event is located
        "_observed": (),
    }


def _energy(factor: Scalar, energies: Any) -> Energy:
    """Return the energies of the whole tank and the slider [J]."""
    whole = {name: factor * value for name, value in energies._asdict().items()}
    names = {"plastic": "plastic", "deleted": "released", "contact": "contact", "holes": "holes"}
    lost = {name: whole.pop(key) for name, key in names.items()}
    return Energy(stored={"elastic": whole.pop("stored"), **whole}, lost=lost)


def history_of(parts: TankModel, rows: HistoryRow) -> History:
    """Return the slider's motion, forces of the whole tank, and how the wall moves: its middle, column by column as of
    `NodeSets` ("wall_x", "wall_y", of a plate "plate_x", "plate_y" [m]), the ``displacement`` of all nodes [m], the
    stress [Pa] and plastic strain of all elements, and the liquid's ``pressure`` [Pa]."""
    system, section, factor = parts.system, parts.section, parts.factor
    count, zero = rows.time.shape[0], jnp.zeros(rows.time.shape)
    at = system.positions[None] + rows.displacement
    slider = at[:, parts.slider, 1]
    middle = 0.5 * (at[:, section.sets.inner] + at[:, section.sets.outer])
    compression = jax.vmap(lambda x: jnp.max(parts.compression(x)))(at)
    others = {
        "deflection": -rows.displacement[:, section.numbers.outer[-1], 1],
        "support_force": factor * rows.support,
        "peak_stress": jnp.max(rows.stress, axis=1),
        "peak_plastic_strain": jnp.max(rows.plastic_strain, axis=1),
        "wall_x": middle[..., 0],
        "wall_y": middle[..., 1],
        "stress": rows.stress,
        "plastic_strain": rows.plastic_strain,
        "displacement": rows.displacement,
    }
    if len(section.sets.plate):
        of_plate = jnp.mean(at[:, section.sets.plate], axis=2)
        others |= {"plate_x": of_plate[..., 0], "plate_y": of_plate[..., 1]}
    if system.liquid is not None:
        assert system.static_pressure is not None
        wet = (rows.pressure + system.static_pressure[None])[:, system.liquid.wet]
        others |= {"highest_pressure": jnp.max(wet, axis=1), "lowest_pressure": jnp.min(wet, axis=1)}
        others["pressure"] = rows.pressure + system.static_pressure[None]
    whole = jax.tree.map(lambda x: factor * x, rows.energies)
    # The section's force acts on the section's share of the slider, so that the factor cancels (M166).
    falling = system.gravity[1] + system.inverse_mass[parts.slider, 1] * rows.force
    return History(
        time=rows.time,
        position=jnp.stack([zero, slider, zero + parts.angle], axis=1)[:, None],
        velocity=jnp.stack([zero, rows.speed, zero], axis=1)[:, None],
        acceleration=jnp.stack([zero, falling, zero], axis=1)[:, None],
        multipliers=jnp.zeros((count, 0)),
        gap=-compression[:, None],
        approach_speed=-rows.speed[:, None],
        slip=zero[:, None],
        contact_force=factor * rows.force[:, None],
        friction_force=zero[:, None],
        others=others,
        energy=_energy(1.0, whole),
    )


def rows_of(run: TankRun) -> int:
    """Return how many rows of its history a run has filled: time rises up to there."""
    assert run.history is not None
    return 1 + int(np.count_nonzero(np.diff(np.asarray(run.history.time)) > 0.0))
