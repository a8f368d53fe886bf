"""The drop onto a tank in time, observed step by step (M126, M169)."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.special import logsumexp
from jaxtyping import Array, Bool, Float, Int

from ..._types import Scalar
from ...hybrid import Options
from ...structures import Orthotropic, State, at_faces, march, mises
from ...structures.central_differences import BLOCK
from ...structures.contact import SOLID
from ...structures.system import SAFETY, Energies, Instant
from .assembly import TankModel, assembled
from .design import TankDrop, TankDropScenario
from .laminate import least_reserve
from .outcome import FORMS, TankOutcome
from .start import falling

# Tolerances above this use the stability limit; below it the step scales with √rtol.
TOLERANCE = 1e-6
TIGHT = 0.25 * TOLERANCE  # steps half as long
GRADES = 8.0  # numbers of steps in a factor of two, so that small changes of a design leave them alone
# Walls do not touch each other: a little further, and the top would go through the bottom.
CRUSHED = 0.95  # of the inner height: how far the top may come down
SMOOTH = 20.0  # the smooth maximum of the stress is sharp to so small a part of the yield stress
ROWS = 800  # of a history, evenly spread over the duration
ATMOSPHERE = 1.013e5  # Pa: a liquid under less than minus this is torn


class HistoryRow(NamedTuple):
    """What a history keeps of an instant.

    - ``time``: [s].
    - ``displacement``: (nodes, 2) [m]; ``speed``: of the slider, upwards [m/s].
    - ``force``: on the slider, ``support``: on the baffle, of the section and a metre of length [N].
    - ``pressure``: (liquid,) beyond the static one [Pa].
    - ``stress``: (elements,) after von Mises [Pa]; ``plastic_strain``: (elements,) [-].
    - ``energies``: as `Energies`.
    """

    time: Float[Array, ""]
    displacement: Float[Array, "nodes 2"]
    speed: Float[Array, ""]
    force: Float[Array, ""]
    support: Float[Array, ""]
    pressure: Float[Array, " liquid"]
    stress: Float[Array, " elements"]
    plastic_strain: Float[Array, " elements"]
    energies: Energies

    def compacted(self) -> "HistoryRow":
        """Compact the filled rows of a history; pad with the last one.

        A run with fewer steps than rows, or one that ends early, leaves some empty; the first one always counts as
        filled.
        """
        places = np.arange(self.time.shape[0])
        filled = (self.time > 0.0) | (places == 0)
        order = jnp.argsort(jnp.where(filled, places, len(places) + places))
        chosen = order[jnp.minimum(places, jnp.sum(filled) - 1)]
        return jax.tree.map(lambda row: row[chosen], self)


class Tally(NamedTuple):
    """What is known of a run so far, of the section and a metre of length.

    - ``force``: largest on the slider [N]; ``force_time``: of that [s]; ``impulse``: [N s].
    - ``released``: when the force was last above zero [s]; ``in_contact``: for how long it was [s].
    - ``stress``: largest after von Mises on the wall's faces [Pa]; ``stress_element``: where.
    - ``sharpened``: logarithm of the integral over wall and time that is the smooth maximum of the stress [ln m² s].
    - ``reserve``: the least of a composite's plies [-].
    - ``deflection``: largest, of the middle of the top downwards [m]; ``travel``: of the slider, downwards [m].
    - ``compression``: largest, of the cushion, or of the wall into the slider without one [m].
    - ``failures``: (forms,) when each of `FORMS` first happened, infinite before [s].
    - ``highest``, ``lowest``: pressures of the liquid on the wall, with the static one [Pa].
    - ``first``: all energies together at the first instant; ``off``: the furthest from it later [J].
    - ``energies``: at the last instant [J].
    - ``rows``: a history, or None.
    """

    force: Float[Array, ""]
    force_time: Float[Array, ""]
    impulse: Float[Array, ""]
    released: Float[Array, ""]
    in_contact: Float[Array, ""]
    stress: Float[Array, ""]
    stress_element: Int[Array, ""]
    sharpened: Float[Array, ""]
    reserve: Float[Array, ""]
    deflection: Float[Array, ""]
    travel: Float[Array, ""]
    compression: Float[Array, ""]
    failures: Float[Array, " forms"]
    highest: Float[Array, ""]
    lowest: Float[Array, ""]
    first: Float[Array, ""]
    off: Float[Array, ""]
    energies: Energies
    rows: HistoryRow | None

    @staticmethod
    def empty(parts: TankModel, start: State, history: bool) -> "Tally":
        """Return the tally of a run that has not begun; ``history``: whether it keeps one."""
        zero, most = jnp.zeros(()), jnp.asarray(jnp.inf)
        energies = Energies(*(zero,) * len(Energies._fields))
        rows = None
        if history:
            of_elements = jnp.zeros((ROWS, len(parts.section.sets.corners)))
            column = jnp.zeros(ROWS)
            rows = HistoryRow(
                time=column,
                displacement=jnp.zeros((ROWS, *start.displacement.shape)),
                speed=column,
                force=column,
                support=column,
                pressure=jnp.zeros((ROWS, *start.pressure.shape)),
                stress=of_elements,
                plastic_strain=of_elements,
                energies=Energies(*(column,) * len(energies)),
            )
        return Tally(
            force=zero,
            force_time=zero,
            impulse=zero,
            released=zero,
            in_contact=zero,
            stress=zero,
            stress_element=jnp.asarray(0),
            sharpened=-most,
            reserve=most,
            deflection=zero,
            travel=zero,
            compression=zero,
            failures=jnp.full(len(FORMS), jnp.inf),
            highest=-most,
            lowest=most,
            first=zero,
            off=zero,
            energies=energies,
            rows=rows,
        )


class Dropped(NamedTuple):
    """A run as it was stepped.

    - ``state``: at its end; ``tally``: until then.
    - ``steps``: taken; ``step``: their length [s].
    - ``crushed``: whether it ended because the top came down onto the bottom.
    - ``too_many``: whether there were too many steps; ``allowed``: whether it was to be stepped at all.
    """

    state: State
    tally: Tally
    steps: Int[Array, ""]
    step: Float[Array, ""]
    crushed: Bool[Array, ""]
    too_many: Bool[Array, ""]
    allowed: Bool[Array, ""]

    def outcome(self, deleted: Int[Array, ""]) -> Int[Array, ""]:
        """Return the outcome's number. ``deleted``: how many elements failed altogether."""
        finite = jnp.all(jnp.isfinite(self.state.displacement)) & jnp.isfinite(self.tally.stress)
        finite = finite & jnp.isfinite(self.step)  # a mesh that is folded has no stable step
        # Each line takes precedence over those before it.
        code = jnp.where(deleted > 0, int(TankOutcome.holed), int(TankOutcome.whole))
        code = jnp.where(self.crushed, int(TankOutcome.crushed), code)
        code = jnp.where(finite, code, int(TankOutcome.failed_not_finite))
        code = jnp.where(self.too_many, int(TankOutcome.failed_steps), code)
        return jnp.where(self.allowed, code, int(TankOutcome.failed_input))


def dropped(
    parameters: tuple[TankDrop, TankDropScenario, Scalar],
    duration: Scalar,
    options: Options,
    allowed: Bool[Array, ""] | bool = True,
    *,
    backwards: bool = False,
) -> Dropped:
    """Step a drop.

    **Arguments:** ``parameters``: design, scenario, and a gain that means nothing here; ``duration`` [s]; ``options``:
    of them the tolerance, the most steps and whether a history is kept; ``allowed``: whether to step at all;
    ``backwards``: as of `march`.
    """
    design, scenario, _ = parameters
    parts = assembled(design, scenario)
    start = falling(parts, scenario)
    share = jnp.sqrt(jnp.minimum(jnp.asarray(options.tolerance.rtol, float) / TOLERANCE, 1.0))
    # How long steps are is a choice of the method, through which nothing is differentiated.
    longest = jax.lax.stop_gradient(SAFETY * share * parts.system.stable_step())
    blocks = duration / (BLOCK * longest)
    # Rounded up to one of a few numbers of blocks (`GRADES`), so that steps are never longer than they may be.
    blocks = jax.lax.stop_gradient(jnp.ceil(2.0 ** (jnp.ceil(GRADES * jnp.log2(blocks)) / GRADES)))
    too_many = blocks * BLOCK > options.max_steps
    step = duration / (BLOCK * blocks)
    # A folded mesh has no stable step, and its number of blocks is not finite, which no integer can be.
    count = jnp.where(jnp.asarray(allowed) & ~too_many & jnp.isfinite(blocks), blocks, 0.0).astype(int)
    first = Tally.empty(parts, start, options.keep > 0)

    crushed = CRUSHED * (design.tank.height - design.wall.bottom - design.wall.top)

    def observe(tally: Tally, instant: Instant) -> Tally:
        return _next_tally(parts, design, step, duration, tally, instant)

    def until(tally: Tally) -> Array:
        return tally.deflection >= crushed

    state, tally = march(parts.system, start, step, count, observe, first, until=until, backwards=backwards)
    # The time is a sum of steps, whose rounding must not cost one of them.
    steps = jnp.round(state.time / step).astype(int)
    return Dropped(state, tally, steps, step, until(tally), too_many, jnp.asarray(allowed))


def _next_tally(
    parts: TankModel, design: TankDrop, step: Scalar, duration: Scalar, tally: Tally, instant: Instant
) -> Tally:
    system, section = parts.system, parts.section
    (wall,) = instant.resistances
    force = parts.force(instant)
    stress = jnp.max(mises(at_faces(wall.stress)), axis=1)
    highest_stress, limit = jnp.max(stress), parts.strength
    # In logarithms, because the exponential of a stress far beyond the yield stress overflows.
    sharpened = logsumexp((stress - limit) / (limit / SMOOTH), b=step * parts.wall.quads.area)
    higher, lower = tally.highest, tally.lowest
    if system.liquid is not None:
        assert system.static_pressure is not None
        wet = (instant.pressure + system.static_pressure)[system.liquid.wet]
        higher, lower = jnp.maximum(higher, jnp.max(wet)), jnp.minimum(lower, jnp.min(wet))
    total = sum(instant.energies, jnp.zeros(()))
    # What is known of an instant takes its step (`Instant`): only the loop itself meets the first energies.
    first = jnp.where(instant.time == 0.0, total, tally.first)
    compressed = jnp.max(parts.compression(system.positions + instant.displacement))
    reserve = jnp.asarray(jnp.inf)  # of a plastic wall the largest stress tells it in the end
    if isinstance(parts.material, Orthotropic):
        reserve = least_reserve(design.composite, design.mesh.refinement, wall.stress, parts.material)
    happens = jnp.stack([
        # Of a composite the limit is a size of stress alone; whether a ply fails is told by its reserve.
        (highest_stress >= limit) & (design.material.kind == "plastic") | (reserve < 1.0),
        compressed >= SOLID * design.cushion.thickness if system.layers else jnp.asarray(False),
        lower < -ATMOSPHERE,
        jnp.any(parts.material.failed(wall.history)),
    ])  # fmt: skip
    return Tally(
        force=jnp.maximum(tally.force, force),
        force_time=jnp.where(force > tally.force, instant.time, tally.force_time),
        impulse=tally.impulse + step * force,
        released=jnp.where(force > 0.0, instant.time, tally.released),
        in_contact=tally.in_contact + step * (force > 0.0),
        stress=jnp.maximum(tally.stress, highest_stress),
        stress_element=jnp.where(highest_stress > tally.stress, jnp.argmax(stress), tally.stress_element),
        sharpened=jnp.logaddexp(tally.sharpened, sharpened),
        reserve=jnp.minimum(tally.reserve, reserve),
        deflection=jnp.maximum(tally.deflection, -instant.displacement[section.numbers.outer[-1], 1]),
        travel=jnp.maximum(tally.travel, -instant.displacement[parts.slider, 1]),
        compression=jnp.maximum(tally.compression, compressed),
        failures=jnp.where(happens & jnp.isinf(tally.failures), instant.time, tally.failures),
        highest=higher,
        lowest=lower,
        first=first,
        off=jnp.maximum(tally.off, jnp.abs(total - first)),
        energies=instant.energies,
        rows=None if tally.rows is None else _with_row(parts, duration, tally.rows, instant, force, stress),
    )


def _with_row(
    parts: TankModel, duration: Scalar, rows: HistoryRow, instant: Instant, force: Array, stress: Array
) -> HistoryRow:
    """Return the history with this instant in the row of its share of the duration: the last one there stays."""
    (wall,) = instant.resistances
    place = jnp.clip(jnp.floor(instant.time / duration * ROWS).astype(int), 0, ROWS - 1)
    row = HistoryRow(
        time=jnp.asarray(instant.time),
        displacement=instant.displacement,
        speed=instant.velocity[parts.slider, 1],
        force=force,
        support=jnp.sum(instant.contacts[0].normal),
        pressure=instant.pressure,
        stress=stress,
        plastic_strain=jnp.max(wall.history.equivalent, axis=1),
        energies=instant.energies,
    )
    return jax.tree.map(lambda values, new: values.at[place].set(new), rows, row)
