"""The capture built in Exudyn (Gerstmayr 2023) from its own bodies, joints and spring-dampers.

Only the contact is ours, a user force (see `contact`), with the latches of docking, and the force of a real buffer's
spring-damper. Masses are assembled otherwise than in jaxbuffer: a free tip is a ball of its own on a pin.
"""

import math
from typing import NamedTuple

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from jaxbuffer import Design, Scenario
from verification.second_opinion.contact import SLOWEST, Contact
from verification.second_opinion.docking import Latch, buffer_force

COORDINATES = exu.OutputVariableType.Coordinates
HINGE = 2  # after the two flanks
RATES = exu.OutputVariableType.Coordinates_t


class Found(NamedTuple):
    """What Exudyn found: ``outcome``, ``end_time`` [s], ``peak_force`` [N] with its time [s] and flank (0 lower),
    ``impacts``, ``stroke`` [m], ``hinge_angle`` [rad], largest hinge reaction [N] (its own joint's multipliers),
    ``latch_time`` [s] (NaN: never) and largest ``latch_force`` [N], and ``courses``: time [s], contact force of both
    flanks [N], hinge reaction [N], poses of S, B, P, T."""

    outcome: str
    end_time: float
    peak_force: float
    peak_time: float
    peak_flank: int
    impacts: int
    first_peak: float
    stroke: float
    hinge_angle: float
    hinge_force: float
    steps: int
    latch_time: float
    latch_force: float
    courses: np.ndarray


def simulate(design: Design, scenario: Scenario, step: float, duration: float = 3.0, every: float = 1e-3) -> Found:  # noqa: PLR0915 # a model written out
    """Run the capture in Exudyn with its implicit trapezoidal rule (index 2) at a fixed ``step`` [s]."""
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    probe, buffer, spins = design.probe, design.buffer, bool(design.probe.free_tip)
    rod, ball_mass, length = float(probe.rod_mass), float(probe.tip_mass), float(probe.length)
    ball_inertia = 0.4 * ball_mass * probe.tip_radius**2
    if spins:
        rear = reach = length / 2
        rod_mass, rod_inertia = rod, rod * length**2 / 12
    else:
        rod_mass = rod + ball_mass
        reach = rod * (length / 2) / rod_mass
        rear = length - reach
        rod_inertia = rod * (length**2 / 12 + (length / 2 - reach) ** 2) + ball_mass * reach**2 + ball_inertia
    contact = Contact(design, reach, spins)

    # Where everything is at t = 0: S, B and P lie along an axis through the tip and turn about S as one body.
    turn, rate = float(scenario.misalignment), float(scenario.passive_rate)
    free, radius = scenario.start == "free", contact.radius
    if free:
        lx = -contact.offset - contact.length * contact.cos - radius - float(scenario.standoff)
        ly = float(scenario.offset)
    else:
        slant = float(scenario.contact_distance)
        lx = -contact.offset - slant * contact.cos - radius * contact.sin
        ly = -contact.throat - slant * contact.sin + radius * contact.cos
    tip_x, tip_y = math.cos(turn) * lx - math.sin(turn) * ly, math.sin(turn) * lx + math.cos(turn) * ly
    cylinder = float(buffer.cylinder_length)
    angle, spin = float(scenario.active_angle), float(scenario.active_rate)
    to_cylinder = -reach - rear - float(buffer.free_length) + cylinder / 2
    to_active = to_cylinder + cylinder / 2 - float(design.active.hinge_offset)

    def pose(along):
        return [tip_x + along * math.cos(angle), tip_y + along * math.sin(angle), angle]

    def motion(along):
        arm = along - to_active
        vx = float(scenario.approach_speed) - spin * arm * math.sin(angle)
        return [vx, float(scenario.lateral_speed) + spin * arm * math.cos(angle), spin]

    def body(mass, inertia, pose, velocity):
        node = mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=pose, initialVelocities=velocity))
        return node, mbs.AddObject(item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    s_pose, b_pose, p_pose = pose(to_active), pose(to_cylinder), pose(-reach)
    n_s, b_s = body(float(design.active.mass), float(design.active.inertia), s_pose, motion(to_active))
    mass = float(buffer.cylinder_mass)
    n_b, b_b = body(mass, mass * cylinder**2 / 12, b_pose, motion(to_cylinder))
    n_p, b_p = body(rod_mass, rod_inertia, p_pose, motion(-reach))
    n_t, _ = body(float(design.passive.mass), float(design.passive.inertia), [0.0, 0.0, turn], [0.0, 0.0, rate])

    def marker(number, x):
        return mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=number, localPosition=[x, 0.0, 0.0]))

    hinge = mbs.AddObject(
        item.ObjectJointRevolute2D(
            markerNumbers=[marker(b_s, float(design.active.hinge_offset)), marker(b_b, cylinder / 2)]
        )
    )
    mbs.AddObject(
        item.ObjectJointPrismatic2D(
            markerNumbers=[marker(b_b, 0.0), marker(b_p, 0.0)],
            axisMarker0=[1.0, 0.0, 0.0],
            normalMarker1=[0.0, 1.0, 0.0],
        )
    )

    def point(number, x):
        return mbs.AddMarker(item.MarkerBodyPosition(bodyNumber=number, localPosition=[x, 0.0, 0.0]))

    mbs.AddObject(
        item.ObjectConnectorSpringDamper(
            markerNumbers=[point(b_b, -cylinder / 2), point(b_p, -rear)],
            referenceLength=float(buffer.free_length),
            **buffer_force(buffer),
        )
    )
    angles = [mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=n, coordinate=2)) for n in (n_s, n_b)]
    mbs.AddObject(
        item.ObjectConnectorCoordinateSpringDamper(
            markerNumbers=angles, stiffness=float(buffer.k_T), damping=float(buffer.c_T)
        )
    )
    n_ball = n_p
    if spins:
        n_ball, b_ball = body(ball_mass, ball_inertia, pose(0.0), motion(0.0))
        mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=[marker(b_p, reach), marker(b_ball, 0.0)]))

    # The user force acts on the nodes' displacements from their references: of the tip's bearer, the cone and, with a
    # free tip, the rod.
    bearer_reference = pose(0.0) if spins else p_pose
    cone_reference = [0.0, 0.0, turn]
    latch = Latch(design) if design.latch.stiffness is not None else None

    def push(_mbs, time, _item, q, q_t):
        bearer = [a + b for a, b in zip(bearer_reference, q[:3], strict=True)] + list(q_t[:3])
        cone = [a + b for a, b in zip(cone_reference, q[3:6], strict=True)] + list(q_t[3:6])
        total = contact.generalised(bearer, bearer, cone) + [0.0] * (3 * spins)
        if latch is not None and latch.since(time) > 0.0:
            pull = latch.generalised(time, contact.tip(bearer, bearer), bearer, cone)
            total[:6] = [a + b for a, b in zip(total[:6], pull, strict=True)]
            rod = [angle + q[8], q_t[8]] if spins else [bearer[2], bearer[5]]
            moment = latch.moment(time, rod, cone)
            total[8 if spins else 2] += moment
            total[5] -= moment
        return total

    carried = [n_ball, n_t, n_p] if spins else [n_ball, n_t]
    mbs.AddObject(item.ObjectGenericODE2(nodeNumbers=carried, forceUserFunction=push))
    mbs.Assemble()

    nodes = (n_s, n_b, n_p, n_t) + ((n_ball,) if spins else ())
    course, last = [], {"gap": [1.0, 1.0], "speed": [0.0, 0.0], "forces": [], "next": 0.0}
    tally = {"impacts": 0, "peak": (0.0, 0.0, 0), "first": 0.0, "stroke": 0.0, "angle": 0.0, "hinge": 0.0, "steps": 0}
    free_length = float(buffer.free_length)
    capture_plane = -contact.offset - radius * contact.sin
    escape = -contact.offset - 2 * contact.length - float(scenario.standoff)
    ended = {"outcome": "timeout", "time": duration}

    def visit(mbs, time):
        """At each step's start: touchdowns and releases, maxima, the end. Exudyn passes the time of the step's end."""
        time = time - step
        motion = [[*mbs.GetNodeOutput(n, COORDINATES), *mbs.GetNodeOutput(n, RATES)] for n in nodes]
        for m, n in zip(motion, nodes, strict=True):
            for k, r in enumerate(references[n]):
                m[k] += r
        s, b, p, cone = motion[:4]
        tip = contact.tip(p, motion[-1])
        forces = []
        for flank, side in enumerate((1.0, -1.0)):
            gap, approach, *_ = contact.touch(tip, cone, side)
            if gap < 0.0 and contact.open[flank]:
                before, part = last["gap"][flank], 1.0
                if before > 0.0:
                    part = before / (before - gap)
                met = last["speed"][flank] + part * (approach - last["speed"][flank]) if time > step / 2 else approach
                contact.memory[flank], contact.open[flank] = max(met, SLOWEST), False
                tally["impacts"] += 1
            elif gap >= 0.0 and not contact.open[flank] and time > step / 2:
                contact.open[flank] = True
            forces.append(contact.normal_force(flank, gap, approach))
            last["gap"][flank], last["speed"][flank] = gap, approach
        lever = cylinder / 2
        dx = p[0] - rear * math.cos(p[2]) - b[0] + lever * math.cos(b[2])
        dy = p[1] - rear * math.sin(p[2]) - b[1] + lever * math.sin(b[2])
        tally["stroke"] = max(tally["stroke"], free_length - math.hypot(dx, dy))
        tally["angle"] = max(tally["angle"], abs(b[2] - s[2]))
        reaction = math.hypot(*mbs.GetObjectOutput(hinge, exu.OutputVariableType.Force)[:2]) if time > step / 2 else 0.0
        last["forces"] = [*last["forces"][-2:], (time, *forces, reaction)]
        _largest(last["forces"], tally)
        tally["steps"] += 1
        if time >= last["next"] - step / 2:
            course.append([time, *forces, reaction, *s[:3], *b[:3], *p[:3], *cone[:3]])
            last["next"] += every
        ahead = math.cos(cone[2]) * (tip[0] - cone[0]) + math.sin(cone[2]) * (tip[1] - cone[1])
        for name, distance in (("captured", ahead - capture_plane), ("escaped", escape - ahead)):
            if distance > 0.0 and ended["outcome"] == "timeout":
                before = last.get(name, 0.0)
                if name == "captured" and latch is not None:
                    latch.close(time - step * distance / (distance - before))
                    continue
                ended.update(outcome=name, time=time - step * distance / (distance - before))
                return False
            last[name] = distance
        if latch is not None and latch.torn(time, tip, cone):
            ended.update(outcome="torn", time=time)
            return False
        return True

    references = {
        n_s: s_pose,
        n_b: b_pose,
        n_p: p_pose,
        n_t: cone_reference,
    }
    if spins:
        references[n_ball] = bearer_reference
    if not free:
        contact.open = [False, True]
        tip = contact.tip(p_pose + motion(-reach), pose(0.0) + motion(0.0))
        contact.memory[0] = max(contact.touch(tip, [0.0, 0.0, turn, 0.0, 0.0, rate], 1.0)[1], SLOWEST)
        tally["impacts"] = 1

    mbs.SetPreStepUserFunction(visit)
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps = round(duration / step)
    integration.endTime = duration
    integration.verboseMode = 0
    integration.newton.useModifiedNewton = True
    integration.newton.relativeTolerance = 1e-10
    integration.newton.absoluteTolerance = 1e-12
    integration.generalizedAlpha.computeInitialAccelerations = True
    settings.solution.file.write = False
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.TrapezoidalIndex2, showHints=False)
    peak, at, flank = tally["peak"]
    if latch is not None and latch.closed_from is not None and ended["outcome"] == "timeout":
        ended["outcome"] = "latched"
    return Found(
        outcome=ended["outcome"],
        end_time=ended["time"],
        peak_force=peak,
        peak_time=at,
        peak_flank=flank,
        impacts=tally["impacts"],
        first_peak=tally["first"],
        stroke=tally["stroke"],
        hinge_angle=tally["angle"],
        hinge_force=tally["hinge"],
        steps=tally["steps"],
        latch_time=math.nan if latch is None or latch.closed_from is None else latch.closed_from,
        latch_force=0.0 if latch is None else latch.largest,
        courses=np.array(course),
    )


def _largest(samples, tally):
    """The top of the parabola through three steps, where the middle one is the largest."""
    if len(samples) < 3:
        return
    (_, *before), (t1, *middle), (t2, *after) = samples
    for flank, (low, top, high) in enumerate(zip(before, middle, after, strict=True)):
        if top >= low and top > high:
            slope, bend = (high - low) / 2, high - 2 * top + low
            # Where the multipliers ring from step to step (the trapezoidal rule does not damp) there is no parabola.
            smooth = bend < 0.0 and min(low, high) > 0.98 * top
            force = top - slope**2 / (2 * bend) if smooth else top
            if flank == HINGE:
                tally["hinge"] = max(tally["hinge"], force)
                continue
            if tally["impacts"] == 1:
                tally["first"] = max(tally["first"], force)
            if force > tally["peak"][0]:
                tally["peak"] = (force, t1 - (t2 - t1) * slope / bend if smooth else t1, flank)
