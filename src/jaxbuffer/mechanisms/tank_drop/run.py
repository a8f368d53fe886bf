"""The run of a drop onto a tank."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Int

from ..._types import Scalar
from ..energy import Balance, Energy
from ..history import History
from ..impacts import Impacts
from .assembly import Assembled, assembled
from .design import TankDrop, TankDropScenario
from .outcome import FORMS, TankOutcome
from .section import Section, wall_mass
from .stepping import SMOOTH, Dropped, Row
from .tank_run import TankRun


def run_of(parameters: tuple[TankDrop, TankDropScenario, Scalar], duration: Scalar, found: Dropped) -> TankRun:
    """The run, from what was stepped."""
    design, scenario, _ = parameters
    parts = assembled(design, scenario)
    seen, factor, limit = found.seen, parts.factor, parts.strength
    (history,) = found.state.histories
    deleted = jnp.sum(jnp.all(parts.material.failed(history), axis=1))
    code = _code(found, deleted)
    known = jnp.where(code < int(TankOutcome.failed_steps), 1.0, jnp.nan)
    before, after = -jnp.sqrt(2.0 * scenario.gravity * scenario.height), found.state.velocity[parts.slider, 1]
    end = jnp.where(found.crushed, found.state.time, duration)
    momentum = jnp.asarray(design.slider.mass, float) * (after - before + scenario.gravity * end)
    area, scale = jnp.sum(parts.wall.quads.area), limit / SMOOTH
    mean = seen.sharpened - jnp.log(area * end)
    smallest = jnp.min(parts.wall.quads.area) * found.step
    never = jnp.isinf(seen.failures)
    times = dict(zip(FORMS, jnp.where(never, jnp.nan, seen.failures), strict=True))
    return TankRun(
        **_of_every_run(parts, parameters, found, code, known, end, momentum),
        impulse=factor * seen.impulse * known,
        momentum=momentum * known,
        peak_stress=seen.stress * known,
        stress_element=seen.stress_element,
        smooth_stress=(limit + scale * mean) * known,
        smooth_bias=scale * jnp.log(area * end / smallest),
        plastic_strain=jnp.max(history.equivalent) * known,
        plastic_work=factor * seen.energies.plastic * known,
        deleted=deleted,
        deflection=seen.deflection * known,
        travel=seen.travel * known,
        compression=(seen.compression / design.cushion.thickness if parts.system.layers else jnp.zeros(())) * known,
        yield_time=times["yield"],
        solid_time=times["solid"],
        torn_time=times["torn"],
        crack_time=times["crack"],
        highest_pressure=jnp.where(jnp.isfinite(seen.highest), seen.highest, 0.0) * known,
        lowest_pressure=jnp.where(jnp.isfinite(seen.lowest), seen.lowest, 0.0) * known,
        rebound_speed=after * known,
        slide=found.state.displacement[parts.section.numbers.outer[0], 0] * known,
        reserve=(seen.reserve if design.material.kind == "composite" else limit / seen.stress) * known,
        wall_mass=wall_mass(design),
        step=found.step,
    )


def _of_every_run(
    parts: Assembled, parameters: Any, found: Dropped, code: Array, known: Array, end: Array, momentum: Array
) -> dict[str, Any]:
    """The fields of `Run`: one impact, that of the cushion. ``known``: 1, or NaN for a failed run; ``end`` [s];
    ``momentum``: by which the slider was slowed down [N s]."""
    design, scenario, stabilisation = parameters
    seen, factor = found.seen, parts.factor
    force, speed = factor * seen.force * known, jnp.sqrt(2.0 * scenario.gravity * scenario.height)
    touched = jnp.where(seen.force > 0.0, 1, 0)
    impacts = Impacts(
        time=jnp.zeros(1),
        contact=touched[None] - 1,
        approach_speed=speed[None] * known,
        peak_force=force[None],
        release_time=jnp.where(seen.released < end - 2.0 * found.step, seen.released, jnp.nan)[None],
        count=touched,
    )
    balance = Balance(
        energy=factor * seen.off / (0.5 * design.slider.mass * speed**2) * known,
        linear_momentum=jnp.abs(factor * seen.impulse - momentum) / (design.slider.mass * speed) * known,
        angular_momentum=jnp.asarray(jnp.nan),
        drift=jnp.zeros(()),
    )
    return {
        "design": design,
        "scenario": scenario,
        "code": code,
        "peak_force": force,
        "peak_time": seen.force_time * known,
        "peak_contact": jnp.asarray(0),
        "peak_impact": touched - 1,
        "maxima": {},
        "penetration": seen.compression * known,
        "end_time": end * known,
        "contact_time": seen.in_contact * known,
        "impact_count": touched,
        "impacts": impacts,
        "energy": _energy(factor, seen.energies),
        "balance": balance,
        "history": None if seen.rows is None else history_of(parts, _close_up(seen.rows)),
        "attempts": found.steps,
        "accepted": found.steps,
        "stabilisation": jnp.asarray(stabilisation, float),
        "_located": None,  # no event is located
    }


def _code(found: Dropped, deleted: Int[Array, ""]) -> Int[Array, ""]:
    finite = jnp.all(jnp.isfinite(found.state.displacement)) & jnp.isfinite(found.seen.stress)
    finite = finite & jnp.isfinite(found.step)  # a mesh that is folded has no stable step
    code = jnp.where(deleted > 0, int(TankOutcome.holed), int(TankOutcome.whole))
    code = jnp.where(found.crushed, int(TankOutcome.crushed), code)
    code = jnp.where(finite, code, int(TankOutcome.failed_not_finite))
    code = jnp.where(found.too_many, int(TankOutcome.failed_steps), code)
    return jnp.where(found.allowed, code, int(TankOutcome.failed_input))


def _energy(factor: Scalar, energies: Any) -> Energy:
    """Of the whole tank and the slider [J]."""
    whole = {name: factor * value for name, value in energies._asdict().items()}
    names = {"plastic": "plastic", "deleted": "released", "contact": "contact", "holes": "holes"}
    lost = {name: whole.pop(key) for name, key in names.items()}
    return Energy(stored={"elastic": whole.pop("stored"), **whole}, lost=lost)


def history_of(parts: Assembled, rows: Row) -> History:
    """The slider's motion, forces of the whole tank, and how the wall moves: its middle, column by column as of
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
        **_plate(at, section),
        "stress": rows.stress,
        "plastic_strain": rows.plastic_strain,
        "displacement": rows.displacement,
    }
    if system.liquid is not None:
        assert system.static_pressure is not None
        wet = (rows.pressure + system.static_pressure[None])[:, system.liquid.wet]
        others |= {"highest_pressure": jnp.max(wet, axis=1), "lowest_pressure": jnp.min(wet, axis=1)}
        others["pressure"] = rows.pressure + system.static_pressure[None]
    whole = jax.tree.map(lambda x: factor * x, rows.energies)
    return History(
        time=rows.time,
        position=jnp.stack([zero, slider, zero + parts.angle], axis=1)[:, None],
        velocity=jnp.stack([zero, rows.speed, zero], axis=1)[:, None],
        multipliers=jnp.zeros((count, 0)),
        gap=-compression[:, None],
        approach_speed=-rows.speed[:, None],
        slip=zero[:, None],
        contact_force=factor * rows.force[:, None],
        friction_force=zero[:, None],
        others=others,
        energy=_energy(1.0, whole),
    )


def _plate(at: Array, section: Section) -> dict[str, Array]:
    """How the plate moves, if there is one: its middle, row by row [m]. ``at``: (rows of the history, nodes, 2) [m]."""
    if not len(section.sets.plate):
        return {}
    middle = jnp.mean(at[:, section.sets.plate], axis=2)
    return {"plate_x": middle[..., 0], "plate_y": middle[..., 1]}


def _close_up(rows: Row) -> Row:
    """The rows that were filled, the first one always, then the last of them again: a run with fewer steps than rows,
    or one that ends early, leaves some empty."""
    places = np.arange(rows.time.shape[0])
    filled = (rows.time > 0.0) | (places == 0)
    order = jnp.argsort(jnp.where(filled, places, len(places) + places))
    chosen = order[jnp.minimum(places, jnp.sum(filled) - 1)]
    return jax.tree.map(lambda row: row[chosen], rows)


def rows_of(run: TankRun) -> int:
    """How many rows of its history a run has filled: time rises up to there."""
    assert run.history is not None
    return 1 + int(np.count_nonzero(np.diff(np.asarray(run.history.time)) > 0.0))
