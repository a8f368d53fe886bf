"""Docking broken on purpose, and which checks ought to notice."""

from .breakage import Breakage

LATCH = "tests/docking/test_latch.py"
REACTION = f"{LATCH}::test_it_acts_on_both_vehicles"
SHARED = f"{LATCH}::test_force_and_moment_by_hand"
CLOSING = f"{LATCH}::test_what_closing_puts_in_stands_in_the_ledger"
FORMULAS = "tests/docking/test_buffer_force.py::test_forces_are_those_of_the_formulas"
STRAIGHT = "tests/docking/test_curve.py::test_it_goes_on_straight_beyond_both_ends"
TORN = "tests/docking/test_runs.py::test_how_a_run_ends[the strength is exceeded]"
RIGID = "tests/docking/test_relative_energy.py::test_a_rigid_motion_of_the_whole_has_none"
TWO_BODIES = "tests/docking/test_relative_energy.py::test_two_bodies_by_hand"
THRUST = f"{LATCH}::test_a_thrusts_impulse_and_work_stand_in_the_ledgers"
FIRST = "tests/verification/test_first_impact.py::test_two_materials"
MATERIALS = "tests/docking/test_two_materials.py::test_every_law_with_a_stiffness_takes_both_materials[hertz]"
SWING = "tests/docking/test_oscillators.py::test_a_half_sine_in_any_direction_by_closed_form"
LOCKOUT = "tests/elements/test_lockout.py"
HELD, LOCKED_GRADIENTS = (
    f"{LOCKOUT}::test_a_mass_is_held_where_it_crosses",
    f"{LOCKOUT}::test_its_gradients_are_those_of_the_closed_form",
)
RUBBER = "tests/elements/test_rubber_stop.py::test_a_mass_into_rubber_by_energy"
CURVED = (
    "tests/verification/test_optional_parts.py"
    "::test_a_largest_value_under_a_measured_curve_is_no_less_than_its_own_history"
)
PRINTED = "tests/verification/test_printed_forces.py::test_the_programs_published_forces_are_the_corrected_ones"


def _threshold_of_nothing() -> None:
    from jaxbuffer.elements import Buffer
    from jaxbuffer.mechanisms import assembled

    Buffer.stiffness_at_rest = float("nan")
    assembled.check_magnitudes = lambda *given, **others: None  # which would refuse it


def _one_body() -> None:
    from jaxbuffer.elements import Latch

    loads = Latch.loads
    Latch.loads = lambda self, at, closed: tuple(load for load in loads(self, at, closed) if load.body == self.first)


def _closed_at_once() -> None:
    import jax.numpy as jnp

    from jaxbuffer.elements import Latch

    Latch._share = lambda self, since: (jnp.ones(()), jnp.zeros(()))


def _closing_unpaid() -> None:
    from jaxbuffer.elements import Latch

    Latch.rates = lambda self, at, closed: [closed[0], 0.0 * at.share]


def _rebound_inwards() -> None:
    from jaxbuffer.elements import BufferForce

    force = BufferForce.damper_force
    BufferForce.damper_force = lambda self, speed: -force(self, -speed)


def _along_the_spring() -> None:
    from jaxbuffer.multibody import AxialSpringDamper

    state = AxialSpringDamper.state

    def along(self, kin):  # type: ignore[no-untyped-def]
        axial = state(self, kin)
        return axial._replace(separation_rate=axial.along * axial.rate)

    AxialSpringDamper.state = along


def _flat_curve() -> None:
    import jax.numpy as jnp

    from jaxbuffer.fields import MonotoneCubic

    summed = MonotoneCubic._summed
    MonotoneCubic._summed = lambda self, at: summed(self, jnp.clip(at, 0.0, self.places[-1]))


def _untearable() -> None:
    from jaxbuffer.elements import Latch

    Latch.guards = lambda self, at: [-1.0]


def _turning_counts() -> None:
    import jax.numpy as jnp

    from jaxbuffer.mechanisms import assembled, relative_energy

    def broken(system, kin, spins=()):
        return 0.5 * jnp.sum(system.linear_momentum(kin) ** 2) / sum(body.mass for body in system.bodies)

    relative_energy.rigid_energy = assembled.rigid_energy = broken


def _endless_thrust() -> None:
    from jaxbuffer.elements import Thrust

    force = Thrust.force
    Thrust.force = lambda self, at, closed: force(self, at, 0.0 * closed)


def _one_direction() -> None:
    from jaxbuffer.elements import Oscillators

    along_x = lambda self, at, closed: dict(zip(self.names, abs(self.acceleration(at))[::2], strict=True))  # noqa: E731
    Oscillators.observables = along_x


def _soft_rubber() -> None:
    from jaxbuffer.elements import RubberBlock

    RubberBlock.elastic = lambda self, penetration: self.linear_stiffness * penetration


def _held_at_nothing() -> None:
    from jaxbuffer.elements import Lockout

    Lockout.after_closing = lambda self, at, own, closing, speed: own


def _held_at_a_fixed_time() -> None:
    import jax

    from jaxbuffer.elements import Lockout

    closing = Lockout.after_closing
    Lockout.after_closing = lambda self, at, own, closed, speed: closing(
        self, at._replace(before=jax.lax.stop_gradient(at.before)), own, closed, speed
    )


def _one_material() -> None:
    from jaxbuffer.mechanisms.probe_cone.design import Design

    Design.materials = property(lambda self: (self.contact.young_modulus, self.contact.poisson_ratio) * 2)


DOCKING = (
    Breakage("latch on one body", "the latches push the probe and not the cone", _one_body, (REACTION, CLOSING)),
    Breakage("closed at once", "the share with which latches close forgotten", _closed_at_once, (SHARED, CLOSING)),
    Breakage("closing for nothing", "the work of closing latches not booked", _closing_unpaid, (CLOSING,)),
    Breakage("printed damper", "equation 10's damper damps the length alone", _along_the_spring, (PRINTED,)),
    Breakage("rebound inwards", "the rebound factor on the way in", _rebound_inwards, (FORMULAS,)),
    Breakage("one material", "the cone of the tip's material, whatever its own", _one_material, (MATERIALS, FIRST)),
    Breakage("threshold of nothing", "the threshold of a force's rounding is NaN", _threshold_of_nothing, (CURVED,)),
    Breakage("flat curve", "a measured curve is constant beyond its last point", _flat_curve, (STRAIGHT,)),
    Breakage("soft rubber", "an end stop of rubber that does not stiffen", _soft_rubber, (RUBBER,)),
    Breakage("held at nothing", "a lockout that does not keep the stroke it holds", _held_at_nothing, (HELD,)),
    Breakage(
        "held at a fixed time",
        "the stroke that is held does not move with its instant",
        _held_at_a_fixed_time,
        (LOCKED_GRADIENTS,),
    ),
    Breakage("torn unseen", "latches hold whatever pulls at them", _untearable, (TORN,)),
    Breakage("turning counts", "turning of the whole counts as relative motion", _turning_counts, (RIGID, TWO_BODIES)),
    Breakage("shock along x", "the shock of equipment in one direction alone", _one_direction, (SWING,)),
    Breakage("endless thrust", "a thrust that goes on after its time", _endless_thrust, (THRUST,)),
)
