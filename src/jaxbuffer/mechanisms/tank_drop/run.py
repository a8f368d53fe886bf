"""The run of a drop onto a tank."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from ..._types import Scalar
from ..energy import Balance, Energy
from ..run import Impacts, Run
from .assembly import assembled
from .design import TankDrop, TankDropScenario
from .outcome import TankOutcome
from .stepping import SMOOTH, Dropped, Row


class TankRun(Run):
    """A drop onto a tank. Print it for a summary. Forces, masses and energies are those of the whole tank.

    Besides what every `Run` has:

    - ``impulse``: of the contact force on the slider [N s].
    - ``momentum``: by which the slider was slowed down, its weight's share included [N s].
    - ``peak_stress``: largest stress after von Mises in the wall [Pa], in element ``stress_element``.
    - ``smooth_stress``: the smooth maximum of the stress: above the mean of its area and time, by up to
      ``smooth_bias`` below the largest [Pa].
    - ``plastic_strain``: largest equivalent plastic strain at the end [-]; ``plastic_work`` [J]; ``deleted``: elements.
    - ``deflection``: largest, of the middle of the top downwards [m]; ``travel`` of the slider [m].
    - ``compression``: largest, of the cushion over its thickness [-].
    - ``highest_pressure``, ``lowest_pressure``: of the liquid on the wall, with the static one [Pa].
    - ``rebound_speed``: of the slider at the end, upwards [m/s].
    - ``reserve``: the yield stress over the largest stress [-].
    - ``step``: of the time stepping [s].
    - ``positions``, ``corners``: the wall's mesh [m]; ``frames``: a history of it, or None.
    """

    impulse: Float[Array, ""]
    momentum: Float[Array, ""]
    peak_stress: Float[Array, ""]
    stress_element: Int[Array, ""]
    smooth_stress: Float[Array, ""]
    smooth_bias: Float[Array, ""]
    plastic_strain: Float[Array, ""]
    plastic_work: Float[Array, ""]
    deleted: Int[Array, ""]
    deflection: Float[Array, ""]
    travel: Float[Array, ""]
    compression: Float[Array, ""]
    highest_pressure: Float[Array, ""]
    lowest_pressure: Float[Array, ""]
    rebound_speed: Float[Array, ""]
    reserve: Float[Array, ""]
    wall_mass: Float[Array, ""]
    step: Float[Array, ""]
    positions: Float[Array, "nodes 2"]
    frames: Row | None


def run_of(parameters: tuple[TankDrop, TankDropScenario, Scalar], duration: Scalar, found: Dropped) -> TankRun:
    """The run, from what was stepped."""
    design, scenario, stabilisation = parameters
    parts = assembled(design, scenario)
    seen, state, factor = found.seen, found.state, parts.factor
    code = _code(found)
    known = jnp.where(code < int(TankOutcome.failed_steps), 1.0, jnp.nan)
    force = factor * seen.force * known
    (history,), (wall,) = state.histories, parts.system.elements
    gone = jnp.all(wall.material.failed(history), axis=1)
    energy = _energy(factor, seen.energies)
    before = -jnp.sqrt(2.0 * scenario.gravity * scenario.height)
    after = state.velocity[parts.slider, 1]
    end = jnp.asarray(duration, float)
    momentum = jnp.asarray(design.slider.mass, float) * (after - before + scenario.gravity * end)
    impulse = factor * seen.impulse
    area = jnp.sum(wall.quads.area)
    scale = wall.material.yield_stress / SMOOTH
    mean = jnp.log(jnp.maximum(seen.sharpened, 1e-300) / (area * end))
    initial = 0.5 * design.slider.mass * before**2
    touched = jnp.where(seen.force > 0.0, 1, 0)
    return TankRun(
        design=design,
        scenario=scenario,
        code=code,
        peak_force=force,
        peak_time=seen.force_time * known,
        peak_contact=jnp.asarray(0),
        peak_impact=touched - 1,
        maxima={},
        penetration=seen.compression * known,
        end_time=end * known,
        contact_time=seen.in_contact * known,
        impact_count=touched,
        impacts=Impacts(
            jnp.zeros(1),
            jnp.where(touched > 0, jnp.zeros(1, int), -1),
            -before[None] * known,
            force[None],
            jnp.where(seen.released < end - 2.0 * found.step, seen.released, jnp.nan)[None],
            touched,
        ),
        energy=energy,
        balance=Balance(
            factor * seen.off / initial * known,
            jnp.abs(impulse - momentum) / jnp.abs(design.slider.mass * before) * known,
            jnp.asarray(jnp.nan),
            jnp.zeros(()),
        ),
        history=None,
        attempts=found.steps,
        accepted=found.steps,
        stabilisation=jnp.asarray(stabilisation, float),
        _located=None,
        impulse=impulse * known,
        momentum=momentum * known,
        peak_stress=seen.stress * known,
        stress_element=seen.stress_element,
        smooth_stress=(wall.material.yield_stress + scale * mean) * known,
        smooth_bias=scale * jnp.log(area * end / (jnp.min(wall.quads.area) * found.step)),
        plastic_strain=jnp.max(history.equivalent) * known,
        plastic_work=factor * seen.energies.plastic * known,
        deleted=jnp.sum(gone),
        deflection=seen.deflection * known,
        travel=seen.travel * known,
        compression=seen.compression / design.cushion.thickness * known,
        highest_pressure=jnp.where(jnp.isfinite(seen.highest), seen.highest, 0.0) * known,
        lowest_pressure=jnp.where(jnp.isfinite(seen.lowest), seen.lowest, 0.0) * known,
        rebound_speed=after * known,
        reserve=wall.material.yield_stress / seen.stress * known,
        wall_mass=jnp.asarray(design.wall_mass, float),
        step=found.step,
        positions=parts.section.positions,
        frames=seen.rows,
    )


def _code(found: Dropped) -> Int[Array, ""]:
    finite = jnp.all(jnp.isfinite(found.state.displacement)) & jnp.isfinite(found.seen.stress)
    gone = jnp.any(jnp.isfinite(found.state.released) & (found.state.released > 0.0))
    code = jnp.where(gone, int(TankOutcome.holed), int(TankOutcome.whole))
    code = jnp.where(finite, code, int(TankOutcome.failed_not_finite))
    code = jnp.where(found.too_many, int(TankOutcome.failed_steps), code)
    return jnp.where(found.allowed, code, int(TankOutcome.failed_input))


def _energy(factor: Scalar, energies: Any) -> Energy:
    """Of the whole tank and the slider [J]."""
    whole = {name: factor * value for name, value in energies._asdict().items()}
    lost = {"plastic": whole.pop("plastic"), "deleted": whole.pop("released"), "contact": whole.pop("contact")}
    return Energy(stored={**whole}, lost=lost)


def frames_of(run: TankRun) -> Row:
    """The history's rows that were filled."""
    assert run.frames is not None
    rows = np.count_nonzero(np.asarray(run.frames.time) > 0.0) + 1
    import jax

    return jax.tree.map(lambda x: np.asarray(x)[:rows], run.frames)
