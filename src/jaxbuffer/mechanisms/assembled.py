"""Any planar mechanism with contacts: bodies, joints and force elements, balls on flanks and pins in holes."""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from .._types import Scalar, stacked
from ..contact import Approach
from ..hybrid import Linearisation
from ..multibody import Kinematics, MaterialPoint, Motion, System
from .ball_contact import BallContact as BallContact
from .energy import Energy
from .linearisation import ContactTerm, SpringTerm, contact_directions, contact_slopes, inverse_masses, linearised
from .snapshot import Snapshot
from .system import ContactSystem, SmoothMemory

DEEPEST = 0.99  # of a ball's radius
LOSSES = ("dampers", "hysteresis", "friction")  # where energy is lost
DRIVES = "drives"  # among what is stored: the energy that they put in, counted negative

Quantity = Callable[[System, Kinematics], Scalar]


class Posture(NamedTuple):
    """A state looked at once: the bodies' frames, and of each contact geometry, relative motion, the ball's centre and
    the origin of the shape's axes."""

    state: Float[Array, " state"]
    kin: Kinematics
    approach: tuple[Approach, ...]
    centre: tuple[MaterialPoint, ...]
    origin: tuple[MaterialPoint, ...]


class Shown(NamedTuple):
    """An observable: its ``name``; ``of``: its value from the mechanism, a posture and the state's rate; ``of_rate``:
    whether it depends on the rate; ``least``: what its largest value is at least, as a depth is 0 where nothing
    touches."""

    name: str
    of: Callable[["Assembled", Posture, Float[Array, " state"]], Scalar]
    of_rate: bool = False
    least: float = -math.inf


class Assembled(ContactSystem):
    """A mechanism ready to be stepped through time from a consistent start.

    The state is ``[q, v, energy lost (3), integrals, contact memory]``; where there are drives, the energy that they
    put in and the time stand before the integrals.

    **Arguments:** ``system``; ``q``, ``v``: positions and velocities at t = 0, on the constraints; ``contacts``;
    ``closed``: which of them are closed at t = 0 (default: none); ``integrals``: quantities whose integrals over time
    are wanted, zero at t = 0; ``ends``: quantities whose crossing of zero upwards ends the run (so
    does, after them, a ball's centre that comes to its flank: "failed_penetration"); ``end_names``: of each, the name
    of the outcome that it stands for, among the mechanism's outcomes ("ended" unless given); ``size``: magnitudes
    that matter of a coordinate and of a velocity; ``shown``: further observables; ``recorded``: what a history shows
    besides; ``parts``: whatever these need to know; ``energy_size`` [J]: magnitude of the energy; if given, steps must
    also keep the energy balance; ``memory_time`` [s]: if given, no event sets the contacts' memory: it follows the
    approach speed while the contact is open (M61).
    Observables are the contacts' normal forces [N], then those shown.
    """

    system: System
    q: Float[Array, " coordinates"]
    v: Float[Array, " coordinates"]
    contacts: tuple[BallContact, ...] = ()
    closed: tuple[bool, ...] = eqx.field(static=True, default=())
    integrals: tuple[Quantity, ...] = eqx.field(static=True, default=())
    ends: tuple[Quantity, ...] = eqx.field(static=True, default=())
    size: tuple[Scalar, Scalar] = (1.0, 1.0)
    shown: tuple[Shown, ...] = eqx.field(static=True, default=())
    recorded: tuple[Shown, ...] = eqx.field(static=True, default=())
    parts: Any = None
    energy_size: Scalar | None = None
    memory_time: Scalar | None = None
    end_names: tuple[str, ...] = eqx.field(static=True, default=())

    @property
    def coordinates(self) -> int:
        return self.system.coordinates

    @property
    def contact_count(self) -> int:
        return len(self.contacts)

    @property
    def impact_contacts(self) -> int:
        return len(self.contacts)

    @property
    def remembers(self) -> bool:
        return self.memory_time is None

    def smooth_memory(self, at: Posture) -> SmoothMemory | None:
        """How the memory follows the approach speed; None with events, which set it."""
        if self.memory_time is None:
            return None
        return SmoothMemory.of(
            self.memory(at.state), *self.gaps_at(at), self.memory_time, slowest=self.slowest_touchdown
        )

    @property
    def jumps(self) -> bool:
        return any(contact.pair.law.jumps for contact in self.contacts)

    @property
    def observed(self) -> tuple[str, ...]:
        return (*(f"contact {k + 1}" for k in range(len(self.contacts))), *(shown.name for shown in self.shown))

    @property
    def least_maxima(self) -> Mapping[str, float]:
        return {shown.name: shown.least for shown in self.shown if shown.least > -math.inf}

    @property
    def typical_speed(self) -> Scalar:
        return self.size[1]

    @property
    def energy_scale(self) -> Scalar:
        masses = sum((body.mass for body in self.system.bodies), start=jnp.zeros(()))
        return 0.5 * masses * self.size[1] ** 2 if self.energy_size is None else self.energy_size

    @property
    def balance_complete(self) -> bool:
        return self.energy_size is not None

    def kinematics(self, state: Float[Array, " state"]) -> Kinematics:
        """Frames of the bodies."""
        n = self.system.coordinates
        time = state[self.drive_work + 1] if self.system.driven else 0.0
        return self.system.kinematics(state[:n], state[n : 2 * n], time)

    @property
    def drive_work(self) -> int:
        """Where the state of a driven system has the energy that the drives put in; the time follows it."""
        return 2 * self.coordinates + len(LOSSES)

    def integral(self, state: Float[Array, " state"]) -> Float[Array, " integrals"]:
        """The integrals so far."""
        return state[self.drive_work + 2 * self.system.driven : len(state) - len(self.contacts)]

    def posture(self, state: Float[Array, " state"]) -> Posture:
        kin = self.kinematics(state)
        pairs = [contact.approach(kin) for contact in self.contacts]
        approaches, centres, origins = zip(*pairs, strict=True) if pairs else ((), (), ())
        return Posture(state, kin, approaches, centres, origins)

    def start(self) -> tuple[Float[Array, " state"], Float[Array, " contacts"]]:
        kin, closed = self.system.kinematics(self.q, self.v), self.closed or (False,) * len(self.contacts)
        # An open contact's memory only says how fast the first impact may be, for `impact_step`.
        speeds = [
            jnp.maximum(contact.approach(kin)[0].approach_speed, self.slowest_touchdown if closes else self.size[1])
            for contact, closes in zip(self.contacts, closed, strict=True)
        ]
        rest = len(LOSSES) + 2 * self.system.driven + len(self.integrals)
        state = [self.q, self.v, jnp.zeros(rest), *speeds]
        return jnp.concatenate(state), jnp.asarray(closed, float)

    def forces_at(self, at: Posture, active: Float[Array, " contacts"]) -> tuple[list[Array], list[Array]]:
        """F_n and F_t [N] of each contact, an entry long."""
        memory = self.memory(at.state)
        normal = [
            active[k] * contact.pair.normal_force(at.approach[k], memory[k : k + 1])
            for k, contact in enumerate(self.contacts)
        ]
        pairs = zip(self.contacts, at.approach, normal, strict=True)
        return normal, [contact.pair.friction_force(approach, force) for contact, approach, force in pairs]

    def motion_at(self, at: Posture, active: Float[Array, " contacts"]) -> tuple[Motion, list[Array], list[Array]]:
        """Accelerations and multipliers, and F_n and F_t [N] of each contact."""
        normal, friction = self.forces_at(at, active)
        parts = zip(self.contacts, at.approach, at.centre, at.origin, normal, friction, strict=True)
        loads = [load for contact, *part in parts for load in contact.loads(*part)]
        return self.system.motion(at.kin, tuple(loads)), normal, friction

    def derivative(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Float[Array, " state"]:
        at = self.posture(state)
        motion, normal, friction = self.motion_at(at, active)
        dampers = self.system.dissipation(at.kin)
        hysteresis = rubbing = jnp.zeros(())
        for k, contact in enumerate(self.contacts):
            power = contact.pair.hysteresis_power(at.approach[k], normal[k])
            hysteresis = hysteresis + active[k] * jnp.sum(power)
            rubbing = rubbing - jnp.sum(friction[k] * at.approach[k].slip)
        drives = [self.system.drive_power(at.kin, motion.multipliers), 1.0] if self.system.driven else []
        integrals = [quantity(self.system, at.kin) for quantity in self.integrals]
        rates = [dampers, hysteresis, rubbing, *drives, *integrals]
        memory = jnp.zeros(len(self.contacts)) if (smooth := self.smooth_memory(at)) is None else smooth.rate
        return jnp.concatenate([at.kin.v, motion.acceleration, stacked(rates), memory])

    def gaps_at(self, at: Posture) -> tuple[Float[Array, " contacts"], Float[Array, " contacts"]]:
        return _row([a.gap for a in at.approach]), _row([a.approach_speed for a in at.approach])

    def inverse_masses_at(self, at: Posture) -> Float[Array, "contacts contacts"]:
        normals = [self._directions(at, k)[0] for k in range(len(self.contacts))]
        return inverse_masses(self.system, at.kin, jnp.concatenate(normals, axis=1))

    def _directions(self, at: Posture, k: int) -> tuple[Array, Array]:
        """Columns of one contact with its closing speed and its slip."""
        side = jnp.reshape(jnp.asarray(self.contacts[k].pair.side, float), (1,))
        return contact_directions(self.system, at.approach[k], side, at.centre[k], at.origin[k])

    def normal_force_at(self, at: Posture, active: Float[Array, " contacts"]) -> Float[Array, " contacts"]:
        return _row(self.forces_at(at, active)[0])

    def terminals_at(self, at: Posture) -> Float[Array, " terminals"]:
        """Those of ``ends``, then whether a ball's centre comes to its flank: there the contact's normal turns over."""
        pairs = zip(at.approach, self.contacts, strict=True)
        deep = [-a.gap[0] - DEEPEST * jnp.asarray(contact.pair.radius) for a, contact in pairs]
        deepest = jnp.max(jnp.stack(deep)) if deep else -jnp.ones(())
        return stacked([*(quantity(self.system, at.kin) for quantity in self.ends), deepest])

    @property
    def end_outcomes(self) -> tuple[str, ...]:
        return (*(self.end_names or ("ended",) * len(self.ends)), "failed_penetration")

    def observables_at(
        self, at: Posture, rate: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Float[Array, " observables"]:
        others = [jnp.reshape(jnp.asarray(shown.of(self, at, rate)), (1,)) for shown in self.shown]
        return _row([*self.forces_at(at, active)[0], *others])

    def rate_observables(self) -> tuple[bool, ...]:
        return (*(False for _ in self.contacts), *(shown.of_rate for shown in self.shown))

    @property
    def sudden(self) -> bool:
        return True

    def snapshot_at(self, at: Posture, active: Float[Array, " contacts"]) -> Snapshot:
        motion, normal, friction = self.motion_at(at, active)
        gap, closing = self.gaps_at(at)
        slip = _row([a.slip for a in at.approach])
        rate = self.derivative(0.0, at.state, active)
        others = {shown.name: shown.of(self, at, rate) for shown in (*self.shown, *self.recorded)}
        return Snapshot(gap, closing, slip, _row(normal), _row(friction), motion.multipliers, others)

    def energy_at(self, at: Posture, active: Float[Array, " contacts"]) -> Energy:
        elastic = jnp.zeros(())
        for k, contact in enumerate(self.contacts):
            elastic = elastic + active[k] * jnp.sum(contact.pair.stored_energy(at.approach[k]))
        potential = jnp.asarray(self.system.stored_energy(at.kin))
        stored = {"kinetic": self.system.kinetic_energy(at.kin), "potential": potential, "contact": elastic}
        if self.system.driven:
            stored[DRIVES] = -at.state[self.drive_work]
        return Energy(stored, dict(zip(LOSSES, at.state[2 * self.coordinates :], strict=False)))

    def momentum(self, state: Float[Array, " state"]) -> tuple[Float[Array, " 2"], Float[Array, ""]]:
        kin = self.kinematics(state)
        return self.system.linear_momentum(kin), self.system.angular_momentum(kin)

    def constraint_errors(self, kin: Kinematics) -> Float[Array, " rows"]:
        return self.system.errors(kin)

    def penetration(self, force: Float[Array, ""]) -> Float[Array, ""]:
        depths = [jnp.asarray(contact.pair.law.depth(force)) for contact in self.contacts]
        return jnp.max(jnp.stack(depths)) if depths else jnp.zeros(())

    def scales(self) -> Float[Array, " state"]:
        n = self.system.coordinates
        place, motion = self.size
        energies, integrals = [self.energy_scale] * len(LOSSES), [1.0] * len(self.integrals)
        drives = [self.energy_scale, 1.0] * self.system.driven
        return stacked([place] * n + [motion] * n + energies + drives + integrals + [motion] * len(self.contacts))

    def impact_step(self, state: Float[Array, " state"]) -> Float[Array, ""]:
        """A fifteenth of the shortest impact of a contact's ball and its body; 1e-6 s without contacts [s]."""
        memory, steps = self.memory(state), [jnp.asarray(1e-6)]
        for k, contact in enumerate(self.contacts):
            mass = self.system.bodies[contact.body].mass
            steps.append(0.2 * jnp.asarray(contact.pair.law.time_scale(mass, memory[k])))
        return jnp.min(jnp.stack(steps[1:] or steps))

    def linearisation(
        self, time: Scalar, state: Float[Array, " state"], active: Float[Array, " contacts"]
    ) -> Linearisation:
        at, n = self.posture(state), self.coordinates
        springs = [SpringTerm(self.system.direction(s.blocks), *s[1:]) for s in self.system.springs(at.kin)]
        if not springs and not self.contacts:
            return Linearisation.none(n, n)
        if not self.contacts:
            # Seven or eight springs alone take XLA gigabytes to compile; nine do not.
            still = SpringTerm(jnp.zeros(n), 0.0, 0.0)
            springs += [still] * (9 - len(springs) if len(springs) in (7, 8) else 0)
        smooth = self.smooth_memory(at)
        decay = None if smooth is None else smooth.all_decay(state, 2 * n)
        return linearised(self.system, at.kin, springs, self._contact_term(at, active), decay=decay)

    def _contact_term(self, at: Posture, active: Float[Array, " contacts"]) -> ContactTerm:
        """All contacts together."""
        thin, none = jnp.zeros((self.coordinates, 0)), jnp.zeros(0)
        terms = [ContactTerm(thin, thin, *((none, none),) * 3)]
        memory = self.memory(at.state)
        for k, contact in enumerate(self.contacts):
            a, pair = at.approach[k], contact.pair
            terms.append(ContactTerm(*self._directions(at, k), *contact_slopes(pair, a, memory[k : k + 1], active[k])))
        return jax.tree.map(lambda *parts: jnp.concatenate(parts, axis=-1), *terms)


def _row(values: list[Array]) -> Float[Array, " n"]:
    return jnp.concatenate(values) if values else jnp.zeros(0)
