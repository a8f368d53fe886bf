"""What time stepping needs to know of a mechanism whose contacts come and go."""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, Int

from .._types import Scalar
from ..basis import PositionRate

# Times the rate of a follower, for `Linearisation.fastest`: explicit steps are then shorter than the way from a maximum
# of its acceleration's size to the next minimum, a quarter of its period, and no maximum hides between their ends.
RESOLVED = 4.0

State = Float[Array, " state"]
Active = Float[Array, " contacts"]


class PassiveOscillators(eqx.Module):
    """Oscillators that velocities of the system shake and that do not act back, in what follows these in the state.

    Of each, the deflection u and the absolute velocity z: u̇ = z - w, ż = -2ζω(z - w) - ω²u.

    - ``first``: where the deflections stand after the velocities; all z follow them.
    - ``shaken_by``: which velocity w shakes each.
    - ``rates``: ω [rad/s]; ``damping``: ζ [-].
    """

    first: int = eqx.field(static=True)
    shaken_by: tuple[int, ...] = eqx.field(static=True)
    rates: Float[Array, " oscillators"]
    damping: Scalar

    def solve(
        self, rest: Float[Array, "rest columns"], velocities: Float[Array, "velocities columns"], shift: Scalar
    ) -> Float[Array, "rest columns"]:
        """Return the solution of (I - shift J) x = ``rest`` for them, that of the ``velocities`` being known."""
        count = len(self.shaken_by)
        # Each oscillator's two equations are solved by hand: u̇ gives u in terms of z, ż then is one equation for z.
        deflections, ends = slice(self.first, self.first + count), self.first + 2 * count
        base = jnp.stack([velocities[k] for k in self.shaken_by])
        stiff = (shift * self.rates**2)[:, None]
        answer = shift * (2.0 * (self.damping * self.rates)[:, None] + stiff)
        right = rest[self.first + count : ends] + answer * base - stiff * rest[deflections]
        z = right / (1.0 + answer)
        u = rest[deflections] + shift * (z - base)
        return jnp.concatenate([rest[: self.first], u, z, rest[ends:]])


class Linearisation(eqx.Module):
    """The stiff part of the velocities' equation: ẇ ≈ -X (K B_qᵀ δq + C Bᵀ δw), of low rank.

    ``directions`` B: how each of ``rank`` scalar forces acts on the velocities w (its first rows, B_q, on the
    coordinates' own; where q̇ = N w, of ``position_rate``, they take N⁻¹ δq for δq); ``response`` X: the accelerations a
    unit of each causes, constraints included; ``stiffness`` K and ``damping`` C: how the forces answer to motion. Only
    forces that act on coordinates alone may have a stiffness.
    ``decay`` [1/s]: rates at which what follows the velocities in the state decays by itself, None for zeros;
    ``followers``: oscillators there.
    """

    directions: Float[Array, "velocities rank"]
    response: Float[Array, "velocities rank"]
    stiffness: Float[Array, "rank rank"]
    damping: Float[Array, "rank rank"]
    coordinates: int = eqx.field(static=True)
    decay: Float[Array, " rest"] | None = None
    followers: PassiveOscillators | None = None
    position_rate: PositionRate = PositionRate()

    @staticmethod
    def none(velocities: int, coordinates: int) -> "Linearisation":
        """Return the linearisation of a system without stiff forces, or whose stiff forces are not known."""
        thin, nothing = jnp.zeros((velocities, 0)), jnp.zeros((0, 0))
        return Linearisation(thin, thin, nothing, nothing, coordinates)

    @property
    def rank(self) -> int:
        """Return the number of stiff forces."""
        return self.damping.shape[0]

    def fastest(self) -> Float[Array, ""]:
        """Return an upper bound of the rates at which the stiff forces let anything decay or ring [1/s].

        The sums over the forces are traces of X C Bᵀ and X K B_qᵀ: no smaller than their largest eigenvalue, and near
        it where one force is stiffest. Of one mode neither root of λ² + d λ + k exceeds max(d, √k).
        """
        n, moved = self.coordinates - self.position_rate.surplus, self.directions * self.response
        damping = jnp.sum(jnp.diagonal(self.damping) * jnp.sum(moved, axis=0))
        stiffness = jnp.sum(jnp.diagonal(self.stiffness) * jnp.sum(moved[:n], axis=0))
        fastest = jnp.maximum(damping, jnp.sqrt(jnp.maximum(stiffness, 0.0)))
        if self.followers is None:
            return fastest
        return jnp.maximum(fastest, RESOLVED * jnp.max(self.followers.rates))


class EventValues(NamedTuple):
    """All that is watched of a state for events, looked at together: gaps with their rates, guards of the run's end,
    observables, `HybridSystem.reversals` and `HybridSystem.invariant`."""

    gap: Float[Array, " contacts"]
    gap_rate: Float[Array, " contacts"]
    terminal: Float[Array, " terminals"]
    value: Float[Array, " observables"]
    reversals: Float[Array, "reversing axes"]
    invariant: tuple[Float[Array, ""], Float[Array, ""]]


class HybridSystem(eqx.Module):
    """A mechanism in modes: each contact is open or closed, and the motion is smooth while none changes.

    The state is one vector: coordinates first, then velocities, then anything else (a contact memory, dissipated
    energies). Subclasses are pytrees of the numbers sensitivities may be asked for.
    """

    @property
    def coordinates(self) -> int:
        """Return how many coordinates the state begins with; `velocities` follow."""
        raise NotImplementedError

    @property
    def velocities(self) -> int:
        """Return how many velocities follow the coordinates: as many, where they are the coordinates' rates."""
        return self.coordinates

    def position_rate(self, q: Float[Array, " coordinates"]) -> PositionRate:
        """Return how the coordinates change with the velocities, q̇ = N(q) v: in the plane q̇ is v itself."""
        return PositionRate()

    def moving(self, state: State) -> State:
        """Return the rate of the coordinates within a state, zero for all that follows them."""
        n, m = self.coordinates, self.velocities
        return jnp.zeros_like(state).at[:n].set(self.position_rate(state[:n]).of(state[n : n + m]))

    def position_acceleration(self, state: State, rate: State) -> Float[Array, " coordinates"]:
        """Return q̈ from a state and its rate."""
        n, m = self.coordinates, self.velocities
        of = lambda q, v: self.position_rate(q).of(v)  # noqa: E731
        return jax.jvp(of, (state[:n], state[n : n + m]), (rate[:n], rate[n : n + m]))[1]

    @property
    def jumps(self) -> bool:
        """Return whether the state's rate jumps when a contact closes; `touchdown` must then make the sensitivities
        jump."""
        return False

    @property
    def contact_observables(self) -> int | None:
        """Return how many of the first contacts have their force among the observables, in order; None means all."""
        return None

    def start(self) -> tuple[State, Active]:
        """Return the state and the open (0) or closed (1) contacts at t = 0."""
        raise NotImplementedError

    def derivative(self, time: Scalar, state: State, active: Active) -> State:
        """Return dy/dt within a mode."""
        raise NotImplementedError

    def gaps(self, state: State) -> Float[Array, " contacts"]:
        """Return the distance of each contact [m], a function of the coordinates alone; crossing zero downwards closes
        it (touchdown), upwards opens it (release)."""
        raise NotImplementedError

    def touchdown(self, state: State, approach_acceleration: Float[Array, ""], contact: Int[Array, ""]) -> State:
        """Return the state just after a contact closes, from the state at the crossing; ``approach_acceleration``: the
        rate of its approach speed there [m/s²]."""
        raise NotImplementedError

    def touching(self, active: Active) -> Bool[Array, ""]:
        """Return whether what counts as contact time passes while these contacts are closed."""
        return jnp.any(active > 0.5)

    def terminals(self, state: State) -> Float[Array, " terminals"]:
        """Return the functions whose crossing of zero upwards ends the run."""
        raise NotImplementedError

    def gaps_and_terminals(self, state: State) -> tuple[Float[Array, " contacts"], Float[Array, " terminals"]]:
        """Return `gaps` and `terminals`; a system may override it to compute them together."""
        return self.gaps(state), self.terminals(state)

    def observables(self, state: State, rate: State, active: Active) -> Float[Array, " observables"]:
        """Return the quantities whose maxima over time are wanted; the first ones belong to the contacts, in order."""
        raise NotImplementedError

    def observables_anew(self, time: Scalar, state: State, active: Active) -> Float[Array, " observables"]:
        """Return the `observables` of a state whose rate is not known yet."""
        return self.observables(state, self.derivative(time, state, active), active)

    def rate_observables(self) -> tuple[bool, ...]:
        """Return which observables depend on the state's rate, not only on the state."""
        raise NotImplementedError

    @property
    def observes_rate(self) -> bool:
        """Return whether any observable depends on the state's rate."""
        return any(self.rate_observables())

    @property
    def has_impulsive_reactions(self) -> bool:
        """Return whether an observable of the state's rate may rise within a step from far below its largest value to
        above it, as a reaction does where something rings. It is then followed closely at every step, not only near its
        largest value, which takes two right-hand sides more."""
        return False

    @property
    def observed(self) -> tuple[str, ...]:
        """Return a name for each of `observables`, in order."""
        return tuple(f"observable_{k}" for k in range(len(self.rate_observables())))

    def roundoff(self) -> Float[Array, "..."]:
        """Return the values of the observables below which no maximum matters, one for each or one for all: what
        rounding makes of them where nothing acts."""
        return jnp.asarray(-jnp.inf)

    def gap_depths(self) -> Float[Array, "..."]:
        """Return how far below zero each gap still tells that its contact should have closed [m], one for each or one
        for all: a ball that is carried farther through a thin wall is on its other side."""
        return jnp.asarray(jnp.inf)

    def scales(self) -> State:
        """Return the magnitude below which an error in each component of the state does not matter in itself."""
        raise NotImplementedError

    def scale_limits(self) -> State | None:
        """Return the largest magnitude that an error in each component of the state may be relative to, where a force
        changes with far less than the component itself; infinite of other components, None if of all."""
        return None

    def invariant(self, state: State, active: Active) -> tuple[Float[Array, ""], Float[Array, ""]]:
        """Return what the motion within a mode does not change, of the order of one, and how much of it may be
        rounding: a step that changes it by more is wrong by that. Both are zero where nothing of the kind is known."""
        return jnp.zeros(()), jnp.zeros(())

    @property
    def reversals_shape(self) -> tuple[int, int]:
        """Return the shape of `reversals`."""
        return (0, 1)

    def reversals(self, state: State, active: Active) -> Float[Array, "reversing axes"]:
        """Return x, a row each, of forces that reverse where x passes through zero, as the friction ∝ tanh x of a slip
        of x slip speeds does; zeros where none acts."""
        return jnp.zeros(self.reversals_shape)

    @property
    def tolerance_share(self) -> float:
        """Return the share of a run's tolerance that its steps keep to: less where the state's rate is not smooth."""
        return 1.0

    @property
    def invariant_change(self) -> float:
        """Return by how much a step may change the `invariant`, as a share of the relative tolerance."""
        return 0.03

    def watched(self, state: State, rate: State, active: Active) -> EventValues:
        """Return `gaps` and what follows it, together; a mechanism may look at the state once for all of them. Nothing
        needs to know how the invariant changes: it may be held fixed."""
        # Gaps depend on the coordinates alone, so the velocities are all of the motion that counts.
        gap, gap_rate = jax.jvp(self.gaps, (state,), (self.moving(state),))
        # The push-forward that gives the rates of all else stops here: the invariant's own rate is of no use.
        invariant = self.invariant(jax.lax.stop_gradient(state), active)
        reversals = self.reversals(state, active)
        return EventValues(
            gap, gap_rate, self.terminals(state), self.observables(state, rate, active), reversals, invariant
        )

    def event_time(self, state: State, rtol: Scalar) -> Scalar:
        """Return how closely steps of a run from a state end on events [s], at a relative tolerance.

        A force that begins τ late with the 3/2 power of time gives an impact of duration T the fraction (τ/T)^{5/2}
        less impulse, which is held to a ten-thousandth of the tolerance: of a bar that bends, impacts are several times
        shorter than those of its whole mass, of which the duration is estimated. One that begins with a jump gives τ/T.
        """
        duration = 15.0 * self.impact_step(state)
        return duration * (rtol if self.jumps else (1e-4 * rtol) ** 0.4)

    def impact_step(self, state: State) -> Float[Array, ""]:
        """Return a first step after a touchdown [s]: a fifteenth of the impact's duration."""
        raise NotImplementedError

    def linearisation(self, time: Scalar, state: State, active: Active) -> Linearisation:
        """Return the stiff part of the Jacobian at a state, for implicit solvers; an approximation is allowed."""
        raise NotImplementedError
