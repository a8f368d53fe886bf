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
CROSS = "tests/multibody/test_space_forces.py::test_the_angles_of_a_cross"
DOCKING = "tests/docking3d"
HINGE = (
    f"{DOCKING}/test_docking3d_bodies.py"
    "::test_the_hinge_turns_about_y_of_the_active_vehicle_and_then_about_z_of_the_cylinder"
)
ROLL = f"{DOCKING}/test_docking3d_bodies.py::test_cylinder_and_probe_have_the_probes_roll_inertia_together"
BEGUN = f"{DOCKING}/test_docking3d_start.py::test_joints_hold_and_the_tip_is_where_the_scenario_puts_it"
ONE_BODY = f"{DOCKING}/test_docking3d_start.py::test_active_side_turns_as_one_body"
AT_AN_INSTANT = f"{DOCKING}/test_docking3d_instant.py::test_momenta_and_energy_are_kept[all parts]"
MISSED = f"{DOCKING}/test_docking3d_instant.py::test_misses_by_hand"
IN_THE_PLANE = f"{DOCKING}/test_docking3d_in_the_plane.py::test_all_bodies_accelerate_as_in_the_plane"


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
    Revolved.nearest = lambda self, place, side, radius: nearest(self, place._replace(z=0.0), side, radius)


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
    relative_energy._central_inertia = lambda about_origin, mass, centre, balls: inertia(
        about_origin, 0.0 * mass, centre, balls
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


def _latch_in_its_own_axes() -> None:
    from jaxbuffer.elements import Latch
    from jaxbuffer.space import Vector

    evaluate = Latch.evaluate

    def broken(self, kin, own):
        at = evaluate(self, kin, own)
        return at._replace(angle=kin.frame(self.second).unturn(at.angle)) if isinstance(at.angle, Vector) else at

    Latch.evaluate = broken


def _hinge_about_z_first() -> None:
    from jaxbuffer.mechanisms.docking3d import bodies

    universal = bodies.Universal
    bodies.Universal = lambda *ends, **points: universal(
        *ends, **points, first_axis=(0.0, 0.0, 1.0), second_axis=(0.0, 1.0, 0.0)
    )


def _half_of_the_roll() -> None:
    from jaxbuffer.mechanisms.docking3d import bodies

    body = bodies.Body
    bodies.Body = lambda mass, inertia: body(mass, (0.5 * inertia[0], *inertia[1:]))


def _slope_of_the_hinge_lost() -> None:
    from jaxbuffer.multibody import CrossSpringDamper

    state = CrossSpringDamper.state

    def broken(self, kin):
        at = state(self, kin)
        return at._replace(angles=(at.angles[0], 0.9 * at.angles[1]))

    CrossSpringDamper.state = broken


def _pitch_after_yaw() -> None:
    from jaxbuffer.mechanisms.docking3d import design
    from jaxbuffer.space import Quaternion, Vector

    def broken(yaw, pitch):
        about_y = Quaternion.of_rotation_vector(Vector(0.0, pitch, 0.0))
        return about_y.after(Quaternion.of_rotation_vector(Vector(0.0, 0.0, yaw)))

    design.rotation = broken


def _azimuth_the_other_way() -> None:
    from jaxbuffer.mechanisms.docking3d import start

    tip = start._tip_at_start

    def broken(design, scenario):
        place = tip(design, scenario)
        return place._replace(z=-place.z)

    start._tip_at_start = broken


def _bodies_beside_each_other() -> None:
    from jaxbuffer.mechanisms.docking3d import start
    from jaxbuffer.space import Frame

    class Broken(Frame):
        def rate_of(self, vector):
            return vector * 0.0

    start.Frame = Broken


def _miss_along_y() -> None:
    from jaxbuffer.mechanisms.docking3d import misses

    size = misses._size
    misses._size = lambda vector, rate: size(vector._replace(z=0.0), rate._replace(z=0.0))


def _swing_with_the_roll() -> None:
    from jaxbuffer.mechanisms.docking3d import misses

    measured = misses.misses

    def broken(mechanism, at):
        found = measured(mechanism, at)
        return found | {"swing_miss": found["attitude_miss"]}

    misses.misses = broken


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
    Breakage(
        "latch's axes", "its rotation vector in those of the body that holds", _latch_in_its_own_axes, (AT_AN_INSTANT,)
    ),
    Breakage("hinge's order", "first about z, then about y", _hinge_about_z_first, (HINGE,)),
    Breakage("roll inertia in space", "half of each body's", _half_of_the_roll, (ROLL,)),
    Breakage("hinge in space", "its second angle a tenth too small", _slope_of_the_hinge_lost, (CROSS, IN_THE_PLANE)),
    Breakage("attitude at the start", "pitch after yaw", _pitch_after_yaw, (BEGUN,)),
    Breakage("azimuth", "the other way about", _azimuth_the_other_way, (BEGUN,)),
    Breakage("spin at the start", "all three bodies at one velocity", _bodies_beside_each_other, (ONE_BODY,)),
    Breakage("lateral miss in space", "along y alone", _miss_along_y, (MISSED,)),
    Breakage("swing miss", "with the roll", _swing_with_the_roll, (MISSED,)),
)
