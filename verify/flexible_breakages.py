"""Flexible bodies broken on purpose, and which checks ought to notice."""

from .breakage import Breakage

TERMS = "tests/multibody/test_flexible_energy.py"
MASS = f"{TERMS}::test_the_mass_matrix_is_the_kinetic_energys"
FORCES = f"{TERMS}::test_velocity_forces_are_lagranges"
JOINTS = "tests/multibody/test_flexible_joints.py::test_jacobian_and_gamma_are_derivatives_of_the_constraint"
ELASTIC = "tests/multibody/test_flexible_joints.py::test_elastic_forces_are_minus_the_stored_energys_gradient"
DERIVATIVES = "tests/multibody/test_flexible_solution.py::test_derivatives_of_the_solution"
CRANK = "tests/multibody/test_flexible_slider_crank.py::test_all_24_published_values_at_the_end"
SPIN_UP = "tests/multibody/test_flexible_spin_up.py::test_the_tips_largest_deflection[2]"
POWER = f"{TERMS}::test_power_of_the_terms_is_balanced"
BEAM = "tests/mechanisms/test_struck_beam.py::test_a_ball_on_a_beam_of_eight_modes[A]"
SHAPE = "tests/mechanisms/test_planar_shapes.py::test_mass_and_centre_of_a_tapered_rod"
PRESSED = "tests/hybrid/test_flexible_loop.py::test_a_ball_pushes_the_bars_end_and_is_pushed"


def _lose_rotation() -> None:
    from jaxbuffer.multibody import FlexibleBody

    angular = FlexibleBody._angular

    def broken(self, q):
        rotation = self.modes.rotation
        return (
            angular(self, q) if rotation is None else [a - r for a, r in zip(angular(self, q), rotation, strict=True)]
        )

    FlexibleBody._angular = broken


def _soften() -> None:
    from jaxbuffer.multibody import FlexibleBody, flexible_body

    radial = FlexibleBody._radial

    def broken(self, q):
        geometric = self.modes.geometric
        return radial(self, q) + (0.0 if geometric is None else 2.0 * flexible_body._times(geometric, q))

    FlexibleBody._radial = broken


def _coriolis_sign() -> None:
    from jaxbuffer.multibody import FlexibleBody, flexible_body

    forces = FlexibleBody.velocity_force

    def broken(self, frame, q, rate):
        force, moment, modal = forces(self, frame, q, rate)
        if self.modes.gyroscopic is not None:
            coriolis = flexible_body._times(self.modes.gyroscopic, rate) * (2.0 * frame.spin)
            modal = tuple(m - 2.0 * c for m, c in zip(modal, coriolis, strict=True))
        return force, moment, modal

    FlexibleBody.velocity_force = broken


def _no_frame_coriolis() -> None:
    from jaxbuffer.multibody import FlexibleBody

    forces = FlexibleBody.velocity_force

    def broken(self, frame, q, rate):
        force, moment, modal = forces(self, frame, q, rate)
        if self.modes.translation is not None:
            force = force + self._momentum(frame, rate).perp() * (2.0 * frame.spin)
        return force, moment, modal

    FlexibleBody.velocity_force = broken


def _rigid_marker() -> None:
    from jaxbuffer.multibody import Kinematics

    marker = Kinematics._marker

    def broken(self, body, frame, point):
        motion = marker(self, body, frame, point)
        return motion._replace(rotations=tuple(0.0 * rotation for rotation in motion.rotations))

    Kinematics._marker = broken


def _slack_mode() -> None:
    from jaxbuffer.multibody import FlexibleBody

    forces = FlexibleBody.velocity_force

    def broken(self, frame, q, rate):
        force, moment, modal = forces(self, frame, q, rate)
        return force, moment, (*modal[:-1], modal[-1] + self.modes.stiffness[-1, -1] * q[-1])

    FlexibleBody.velocity_force = broken


def _constant_mass() -> None:
    import jax.numpy as jnp

    from jaxbuffer.multibody import augmented

    augmented._block_product = lambda mass, vector: jnp.zeros_like(vector)


def _no_modal_push() -> None:
    from jaxbuffer.mechanisms.assembled import BallContact

    loads = BallContact.loads_of
    BallContact.loads_of = lambda self, *at: tuple(load._replace(modal=()) for load in loads(self, *at))


def _unturned_mesh() -> None:
    from jaxbuffer.fields import mesh_of
    from jaxbuffer.mechanisms.slider_crank import shapes

    shapes.placed_mesh = lambda text, names: mesh_of(text)


FLEXIBLE = (
    Breakage("no turning modes", "the modes' angular momentum lost", _lose_rotation, (MASS, FORCES, CRANK, SPIN_UP)),
    Breakage("softening", "geometric stiffness with the other sign", _soften, (FORCES, SPIN_UP)),
    Breakage("Coriolis's sign", "Coriolis forces on modes with the other sign", _coriolis_sign, (FORCES, CRANK)),
    Breakage("no Coriolis", "Coriolis forces of modes on the frame lost", _no_frame_coriolis, (FORCES, CRANK, POWER)),
    Breakage("rigid marker", "a moment at a marker does not push the modes", _rigid_marker, (JOINTS,)),
    Breakage("slack mode", "the last mode without its elastic force", _slack_mode, (FORCES, ELASTIC)),
    Breakage("constant mass", "derivatives of the mass matrix lost", _constant_mass, (DERIVATIVES,)),
    Breakage("unturned mesh", "a rod's mesh not turned into its pins' line", _unturned_mesh, (SHAPE,)),
    Breakage("no modal push", "a contact's force does not push the modes", _no_modal_push, (BEAM, PRESSED)),
)
