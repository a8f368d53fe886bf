"""Motion in space broken on purpose, and which checks ought to notice."""

from .breakage import Breakage

EULER = "tests/space/test_free_body.py::test_the_spin_follows_eulers_equations"
TURNING = "tests/space/test_rotations.py::test_the_position_rate_turns_the_frames_with_their_spins"
WORK = "tests/space/test_rotations.py::test_moments_of_the_rotation_vector_are_those_of_its_potential"
ROWS = "tests/multibody/test_space_joints.py::test_rows_are_derivatives_of_the_constraint"
GEOMETRY = "tests/multibody/test_space_joints.py::test_an_assembled_joint_holds_its_geometry"
IN_A_CONE = (
    "tests/elements/test_ball_in_space.py"
    "::test_the_foot_is_the_nearest_point_and_speeds_are_those_of_the_material_there"
)
ROLLING = "tests/elements/test_ball_in_space.py::test_a_sliding_ball_comes_to_roll"
LATCHED = "tests/elements/test_elements_in_space.py::test_latches_hold_a_body_by_its_rotation_vector"
CONSERVED = (
    "tests/elements/test_elements_in_space.py::test_it_acts_on_two_bodies_and_its_energies_are_its_powers[thrust]"
)
RIGID = "tests/mechanisms/test_assembled_in_space.py::test_the_energy_of_the_whole_as_a_rigid_body_is_that_of_one_body"
CONTROLLED = "tests/elements/test_attitude_control.py::test_in_space_each_axis_of_the_body_has_its_own_limit"
TOUCHES = "tests/elements/test_attitude_control.py::test_it_ends_at_the_first_touchdown[Turned]"
NEWTON = "tests/hybrid/test_in_space.py::test_newtons_matrix_solves_with_the_stiff_part"


def _no_gyroscopic_moment() -> None:
    from jaxbuffer.space import Space

    moment = Space.gyroscopic_moment
    Space.gyroscopic_moment = lambda self, frame, inertia: moment(self, frame, inertia) * 0.0


def _spin_of_the_body() -> None:
    from jaxbuffer.space import Quaternion

    Quaternion.rate = lambda self, spin: self.after(Quaternion(0.0, 0.5 * spin.x, 0.5 * spin.y, 0.5 * spin.z))


def _sine_for_the_angle() -> None:
    from jaxbuffer.space import Quaternion

    Quaternion.rotation_vector = lambda self: self.vector * (2.0 / self.squared**0.5)


def _swapped_cross() -> None:
    from jaxbuffer.multibody import CoincidentPoints, PerpendicularVectors, Universal

    Universal.primitives = lambda self, basis: (
        CoincidentPoints(),
        PerpendicularVectors(self.second_axis, self.first_axis),
    )


def _no_coriolis() -> None:
    from jaxbuffer.multibody import PerpendicularVectors

    rows = PerpendicularVectors.rows

    def broken(self, basis, i, j):
        (row,) = rows(self, basis, i, j)
        a = i.turn(basis.vector(*self.first))
        rate = j.velocity - i.velocity if self.second is None else j.frame.rate_of(j.turn(basis.vector(*self.second)))
        return (row._replace(gamma=row.gamma + 2.0 * i.frame.rate_of(a).dot(rate)),)

    PerpendicularVectors.rows = broken


def _quaternions_as_spins() -> None:
    from jaxbuffer.space.basis import TurningRate

    velocity = TurningRate.velocity
    TurningRate.velocity = lambda self, rate: 0.5 * velocity(self, rate)


def _slip_towards_the_throat() -> None:
    from jaxbuffer.contact import Revolved
    from jaxbuffer.space import Vector
    from jaxbuffer.space.vectors import normals_to

    def broken(self, velocity, normal, side):
        tangent = Vector(*normals_to(normal)[0])
        return tangent, velocity.dot(tangent)

    Revolved.slip = broken


def _meridian_of_the_plane() -> None:
    from jaxbuffer.contact import Revolved

    nearest = Revolved.nearest
    Revolved.nearest = lambda self, place, side: nearest(self, place._replace(z=0.0), side)


def _free_ball_without_moment() -> None:
    from jaxbuffer.elements import BallContact
    from jaxbuffer.space import Vector

    moment = BallContact.spin_moment

    def broken(self, at, forces):
        whole = moment(self, at, forces)
        return Vector(whole.x, 0.0, 0.0) if isinstance(whole, Vector) else whole

    BallContact.spin_moment = broken


def _latch_without_turn() -> None:
    from jaxbuffer.elements import Latch
    from jaxbuffer.space import Vector

    evaluate = Latch.evaluate

    def broken(self, kin, own):
        at = evaluate(self, kin, own)
        return at._replace(angle=at.angle * 0.0) if isinstance(at.angle, Vector) else at

    Latch.evaluate = broken


def _thrust_about_its_body() -> None:
    from jaxbuffer.elements import Thrust

    rates = Thrust.rates
    Thrust.rates = lambda self, at, closed: [*rates(self, at, closed)[:-3], 0.0, 0.0, 0.0]


def _inertia_about_the_origin() -> None:
    from jaxbuffer.mechanisms import relative_energy

    inertia = relative_energy._central_inertia
    relative_energy._central_inertia = lambda system, turns, mass, centre, balls: inertia(
        system, turns, 0.0 * mass, centre, balls
    )


def _control_in_inertial_axes() -> None:
    from jaxbuffer.basis import components
    from jaxbuffer.elements import AttitudeControl

    evaluate = AttitudeControl.evaluate

    def broken(self, kin, own):
        at = evaluate(self, kin, own)
        return at._replace(spins=components(at.frame.spin))

    AttitudeControl.evaluate = broken


def _control_without_work() -> None:
    from jaxbuffer.elements import AttitudeControl

    rates = AttitudeControl.rates
    AttitudeControl.rates = lambda self, at, closed: [0.0, *rates(self, at, closed)[1:]]


def _control_to_the_end() -> None:
    from jaxbuffer.elements import AttitudeControl

    AttitudeControl._acting = lambda self, closed: 1.0


SPACE = (
    Breakage("gyroscopic moment", "a free body's spin stays as it is", _no_gyroscopic_moment, (EULER,)),
    Breakage("quaternion's rate", "the spin taken in the body's axes", _spin_of_the_body, (TURNING, ROWS)),
    Breakage("rotation vector", "twice the sine of half the angle for the angle", _sine_for_the_angle, (WORK,)),
    Breakage("universal joint", "each axis of the cross in the other body", _swapped_cross, (GEOMETRY,)),
    Breakage("perpendicular vectors", "the product of both vectors' rates lost in γ", _no_coriolis, (ROWS,)),
    Breakage("spin of a rate", "half the angular velocity from a quaternion's rate", _quaternions_as_spins, (NEWTON,)),
    Breakage("slip direction", "friction along one fixed tangent", _slip_towards_the_throat, (IN_A_CONE,)),
    Breakage("surface of revolution", "the foot in the plane z = 0", _meridian_of_the_plane, (IN_A_CONE,)),
    Breakage("free ball in space", "it turns about x alone", _free_ball_without_moment, (ROLLING,)),
    Breakage("latch in space", "it does not hold the rotation vector", _latch_without_turn, (LATCHED,)),
    Breakage("thrust in space", "its angular impulse is not counted", _thrust_about_its_body, (CONSERVED,)),
    Breakage("rigid motion in space", "the inertia about the origin", _inertia_about_the_origin, (RIGID,)),
    Breakage("attitude control's axes", "the spin in inertial axes", _control_in_inertial_axes, (CONTROLLED,)),
    Breakage("attitude control's work", "it is not counted", _control_without_work, (CONTROLLED,)),
    Breakage("attitude control's end", "it acts on after a touchdown", _control_to_the_end, (TOUCHES,)),
)
