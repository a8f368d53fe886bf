"""What every mechanism with contacts shares as a hybrid system: touchdown, saltation, guards, conservation."""

from collections.abc import Mapping
from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._types import Scalar
from ..hybrid import EventValues, HybridSystem
from ..multibody import Kinematics
from .energy import Energy
from .snapshot import Snapshot

ROUNDED = 1e-14  # m, and relative: rounding of positions of the order of a metre, with some to spare

State = Float[Array, " state"]
Active = Float[Array, " contacts"]


class ContactSystem(HybridSystem):
    """A multibody mechanism with contacts.

    The contacts that have impacts come first. A mechanism looks at a state once, by `evaluate`; what is named ``…_at``
    takes that.
    """

    # --- what a mechanism says of itself ------------------------------------------------------------------------------

    @property
    def places(self) -> Mapping[str, slice]:
        """Return where each part of the state stands, by name: "q" the coordinates, "v" the velocities, and others."""
        raise NotImplementedError

    @property
    def observed(self) -> tuple[str, ...]:
        """Return what `observables` are; the first ones are the contact forces of the contacts that have impacts."""
        raise NotImplementedError

    @property
    def lower_bounds(self) -> Mapping[str, float]:
        """Return what the largest values of some observables are at least, by name."""
        return {}

    @property
    def contact_count(self) -> int:
        """Return how many contacts there are."""
        raise NotImplementedError

    @property
    def impact_contacts(self) -> int:
        """Return how many contacts have impacts, the first ones."""
        raise NotImplementedError

    @property
    def one_way(self) -> tuple[bool, ...]:
        """Return which contacts never open again once they are closed; () for none."""
        return ()

    def evaluate(self, state: State) -> Any:
        """Return a state evaluated once: it has ``state`` and ``kin``, the bodies' `Kinematics`."""
        raise NotImplementedError

    def rate_at(self, at: Any, active: Active) -> State:
        """Return the `derivative` of an evaluated state."""
        raise NotImplementedError

    def rate_and_masses(self, at: Any, active: Active, directions: Array) -> tuple[State, Array]:
        """Return `rate_at`, and the mass that a force along each of the ``directions``, a column each, meets through
        the joints [kg]."""
        raise NotImplementedError

    def evaluate_contacts(self, state: State) -> Any:
        """Return a state evaluated for its gaps, its contacts' forces and its constraints alone."""
        return self.evaluate(state)

    def gaps_at(self, at: Any) -> tuple[Active, Active]:
        """Return the distance of each contact [m], and how fast it closes [m/s]."""
        raise NotImplementedError

    def inverse_masses_at(self, at: Any) -> Float[Array, "contacts contacts"]:
        """Return A M_c⁻¹ Aᵀ along the normals of the contacts that have impacts [1/kg] (M200)."""
        raise NotImplementedError

    def normal_force(self, state: State, active: Active) -> Float[Array, " contacts"]:
        """Return `normal_force_at` a state."""
        return self.normal_force_at(self.evaluate_contacts(state), active)

    def normal_force_at(self, at: Any, active: Active) -> Float[Array, " contacts"]:
        """Return F_n [N] of the contacts that have impacts."""
        raise NotImplementedError

    def terminals_at(self, at: Any) -> Float[Array, " terminals"]:
        """Return the `terminals` of an evaluated state."""
        raise NotImplementedError

    def observables_at(self, at: Any, rate: State, active: Active) -> Float[Array, " observables"]:
        """Return the `observables` of an evaluated state."""
        raise NotImplementedError

    @property
    def end_outcomes(self) -> tuple[str, ...]:
        """Return the name of the outcome that each of `terminals` stands for, in order."""
        raise NotImplementedError

    def snapshot_at(self, at: Any, active: Active) -> Snapshot:
        """Return all that a history shows of an evaluated state."""
        raise NotImplementedError

    def energy_at(self, at: Any, active: Active) -> Energy:
        """Return the energies of an evaluated state, stored and lost."""
        raise NotImplementedError

    @property
    def typical_speed(self) -> Scalar:
        """Return the speed [m/s] that the mechanism's velocities are of the order of."""
        return 1.0

    @property
    def energy_scale(self) -> Scalar:
        """Return the energy [J] that changes of the total energy are compared with."""
        raise NotImplementedError

    @property
    def balance_complete(self) -> bool:
        """Return whether `energy_at` holds the work of all forces."""
        return True

    def stiff_forces_at(self, at: Any, active: Active) -> Scalar:
        """Return the sum of the sizes of stiff forces [N], for the rounding in `invariant`."""
        raise NotImplementedError

    def reversals_at(self, at: Any, active: Active) -> Float[Array, "reversing axes"]:
        """Return the `reversals` of an evaluated state."""
        return jnp.zeros(self.reversals_shape)

    @property
    def momentum_scale(self) -> Scalar | None:
        """Return the momentum [kg m/s] that changes are compared with; None where the ground takes part."""
        return None

    def momentum_at(self, at: Any) -> tuple[Float[Array, " dimensions"], Float[Array, "..."]]:
        """Return linear [kg m/s] and angular momentum about the origin [kg m²/s], in space a vector."""
        raise NotImplementedError

    def constraint_errors(self, kin: Kinematics) -> Float[Array, " rows"]:
        """Return how far the joints are from holding [m, rad]."""
        raise NotImplementedError

    def penetration(self, force: Float[Array, ""]) -> Float[Array, ""]:
        """Return the depth [m] at which the contact's spring alone exerts a force [N]."""
        raise NotImplementedError

    def first_evaluation(self) -> tuple[Any, Active]:
        """Return the evaluated `start`, and which contacts are closed there."""
        state, active = self.start()
        return self.evaluate(state), active

    # --- what follows -------------------------------------------------------------------------------------------------

    def memory(self, state: State) -> Float[Array, " contacts"]:
        """Return δ̇⁻, the approach speed at the last touchdown, of each contact that has impacts [m/s]."""
        raise NotImplementedError

    def derivative(self, time: Scalar, state: State, active: Active) -> State:
        return self.rate_at(self.evaluate(state), active)

    def momentum(self, state: State) -> tuple[Float[Array, " dimensions"], Float[Array, "..."]]:
        """Return `momentum_at` a state."""
        return self.momentum_at(self.evaluate(state))

    def gaps(self, state: State) -> Active:
        return self.gaps_at(self.evaluate_contacts(state))[0]

    def touching(self, active: Active) -> Bool[Array, ""]:
        return jnp.any(active[: self.impact_contacts] > 0.5)

    def touchdown(self, state: State, acceleration: Float[Array, ""], contact: Int[Array, ""]) -> State:
        """Make sensitivities jump where a force does; a mechanism that remembers its touchdowns does so first."""
        return state + self.saltation(state, contact) if self.jumps else state

    def saltation(self, closed: State, contact: Int[Array, ""]) -> State:
        """Return how sensitivities at fixed time jump where a force jumps: (f⁻ - f⁺) dt_c (M86); its value is zero."""
        return _saltation(self.time_to_contact(closed, contact), self, closed, contact)

    def time_to_contact(self, state: State, contact: Int[Array, ""]) -> Float[Array, ""]:
        """Return gap / δ̇ of one contact [s]."""
        return self.until_contact_at(self.evaluate_contacts(state), contact)[0]

    def until_contact_at(self, at: Any, contact: Int[Array, ""]) -> tuple[Array, Array]:
        """Return gap / δ̇ [s] and δ̇ [m/s] of one contact."""
        gaps, closing = self.gaps_at(at)
        mine = jnp.arange(gaps.shape[0]) == contact
        gap, speed = (jnp.sum(jnp.where(mine, x, 0.0)) for x in (gaps, closing))
        # Where nothing moves there is no such time; a division by zero would make derivatives NaN.
        return gap / jnp.where(speed == 0.0, 1.0, speed), speed

    def terminals(self, state: State) -> Float[Array, " terminals"]:
        return self.terminals_at(self.evaluate(state))

    def gaps_and_terminals(self, state: State) -> tuple[Active, Float[Array, " terminals"]]:
        at = self.evaluate(state)
        return self.gaps_at(at)[0], self.terminals_at(at)

    def observables(self, state: State, rate: State, active: Active) -> Float[Array, " observables"]:
        return self.observables_at(self.evaluate(state), rate, active)

    def observables_anew(self, time: Scalar, state: State, active: Active) -> Float[Array, " observables"]:
        at = self.evaluate(state)
        return self.observables_at(at, self.rate_at(at, active), active)

    def watched(self, state: State, rate: State, active: Active) -> EventValues:
        # One look serves gaps, guards and observables, which a step's end needs together.
        at = self.evaluate(state)
        gap, closing = self.gaps_at(at)
        if any(self.one_way):  # closed, they are far from opening
            closed = jnp.asarray(self.one_way) & (active > 0.5)
            gap, closing = jnp.where(closed, -1.0, gap), jnp.where(closed, 0.0, closing)
        return EventValues(
            gap=gap,
            gap_rate=-closing,
            terminal=self.terminals_at(at),
            value=self.observables_at(at, rate, active),
            reversals=self.reversals_at(at, active),
            invariant=self.invariant_at(jax.lax.stop_gradient(at), active),
        )

    def reversals(self, state: State, active: Active) -> Float[Array, "reversing axes"]:
        return self.reversals_at(self.evaluate(state), active)

    def invariant(self, state: State, active: Active) -> tuple[Float[Array, ""], Float[Array, ""]]:
        return self.invariant_at(self.evaluate(state), active)

    def invariant_at(self, at: Any, active: Active) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """Return energy, losses included, over its scale, and how much of that may be rounding: of the positions times
        the forces, and of the energies themselves, which may be far above the scale (a heavy flywheel at a steady
        speed). Both are zero where forces do work that `energy_at` does not hold."""
        if not self.balance_complete:
            return jnp.zeros(()), jnp.zeros(())
        scale = self.energy_scale
        forces = self.stiff_forces_at(at, active)
        energy = self.energy_at(at, active)
        size = jnp.maximum(energy.size / scale, 1.0)
        return energy.total / scale, ROUNDED * (size + forces / scale)


# A rule of its own, so that runs without derivatives do not compile the two right-hand sides: a fifth of the loop of a
# docking in space. That the state lies a little beside the touchdown, as locating leaves it, is of second order.
@eqx.filter_custom_jvp
def _saltation(late: Float[Array, ""], system: ContactSystem, closed: State, contact: Int[Array, ""]) -> State:
    """Return zero, with the derivative of a state whose ``contact`` closes after a time ``late`` [s]."""
    return jnp.zeros_like(closed)


@_saltation.def_jvp
def _saltation_jvp(primals: tuple, tangents: tuple) -> tuple[Array, Array]:
    (_, system, closed, contact), (later, *_) = primals, tangents
    if later is None:
        return jnp.zeros_like(closed), jnp.zeros_like(closed)
    # What the other contacts exert is the same on both sides of the jump: the difference is found with all of them
    # open. Its own change counts only with the time that locating the event leaves open, which is next to nothing.
    none, time = jnp.zeros(system.contact_count), jnp.zeros(())
    alone = jnp.where(jnp.arange(system.contact_count) == contact, 1.0, none)
    # One after the other, so that the right-hand side is compiled once.
    with_it, without = jax.lax.map(lambda active: system.derivative(time, closed, active), jnp.stack([alone, none]))
    return jnp.zeros_like(closed), -(with_it - without) * later
