"""The capture built in Exudyn (Gerstmayr 2023) from its own bodies, joints and spring-dampers.

Only the contact is ours, a user force (see `contact`). Masses are assembled otherwise than in jaxbuffer: a free tip
is a ball of its own on a pin.
"""

import math
from typing import NamedTuple

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np

from jaxbuffer import Design, Scenario
from verification.second_opinion.contact import SLOWEST, Contact

COORDINATES = exu.OutputVariableType.Coordinates
HINGE = 2  # after the two flanks
RATES = exu.OutputVariableType.Coordinates_t


class Found(NamedTuple):
    """What Exudyn found: ``outcome``, ``end_time`` [s], ``peak_force`` [N] with its time [s] and flank (0 lower),
    ``impacts``, ``stroke`` [m], ``hinge_angle`` [rad], largest hinge reaction [N] (its own joint's multipliers), and
    ``courses``: time [s], contact force of both flanks [N], hinge reaction [N], poses of S, B, P, T."""

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

    # Where everything is at t = 0: the tip touches the lower flank, everything behind it lies along x.
    turn, rate = float(scenario.misalignment), float(scenario.passive_rate)
    slant, radius = float(scenario.contact_distance), contact.radius
    lx = -contact.offset - slant * contact.cos - radius * contact.sin
    ly = -contact.throat - slant * contact.sin + radius * contact.cos
    tip_x, tip_y = math.cos(turn) * lx - math.sin(turn) * ly, math.sin(turn) * lx + math.cos(turn) * ly
    cylinder = float(buffer.cylinder_length)
    probe_x = tip_x - reach
    cylinder_x = probe_x - rear - float(buffer.free_length) + cylinder / 2
    active_x = cylinder_x + cylinder / 2 - float(design.active.hinge_offset)
    speed = float(scenario.approach_speed)

    def body(mass, inertia, pose, velocity):
        node = mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=pose, initialVelocities=velocity))
        return node, mbs.AddObject(item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    moving = [speed, 0.0, 0.0]
    n_s, b_s = body(float(design.active.mass), float(design.active.inertia), [active_x, tip_y, 0.0], moving)
    mass = float(buffer.cylinder_mass)
    n_b, b_b = body(mass, mass * cylinder**2 / 12, [cylinder_x, tip_y, 0.0], moving)
    n_p, b_p = body(rod_mass, rod_inertia, [probe_x, tip_y, 0.0], moving)
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
            stiffness=float(buffer.k_A),
            damping=float(buffer.c_A),
            referenceLength=float(buffer.free_length),
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
        n_ball, b_ball = body(ball_mass, ball_inertia, [tip_x, tip_y, 0.0], moving)
        mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=[marker(b_p, reach), marker(b_ball, 0.0)]))

    # The user force acts on the nodes' displacements from their references.
    bearer_reference = [tip_x if spins else probe_x, tip_y, 0.0]
    cone_reference = [0.0, 0.0, turn]

    def push(_mbs, _time, _item, q, q_t):
        bearer = [a + b for a, b in zip(bearer_reference, q[:3], strict=True)] + list(q_t[:3])
        cone = [a + b for a, b in zip(cone_reference, q[3:6], strict=True)] + list(q_t[3:6])
        return contact.generalised(bearer, bearer, cone)

    mbs.AddObject(item.ObjectGenericODE2(nodeNumbers=[n_ball, n_t], forceUserFunction=push))
    mbs.Assemble()

    nodes = (n_s, n_b, n_p, n_t) + ((n_ball,) if spins else ())
    course, last = [], {"gap": [1.0, 1.0], "speed": [0.0, 0.0], "forces": [], "next": 0.0}
    tally = {"impacts": 0, "peak": (0.0, 0.0, 0), "first": 0.0, "stroke": 0.0, "angle": 0.0, "hinge": 0.0, "steps": 0}
    free_length = float(buffer.free_length)
    capture_plane = -contact.offset - radius * contact.sin
    escape = -contact.offset - 2 * contact.length
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
                ended.update(outcome=name, time=time - step * distance / (distance - before))
                return False
            last[name] = distance
        return True

    references = {
        n_s: [active_x, tip_y, 0.0],
        n_b: [cylinder_x, tip_y, 0.0],
        n_p: [probe_x, tip_y, 0.0],
        n_t: cone_reference,
    }
    if spins:
        references[n_ball] = bearer_reference
    contact.open = [False, True]
    contact.memory[0] = max(
        contact.touch(
            contact.tip([probe_x, tip_y, 0.0, speed, 0.0, 0.0], [tip_x, tip_y, 0.0, *moving]),
            [0.0, 0.0, turn, 0.0, 0.0, rate],
            1.0,
        )[1],
        SLOWEST,
    )
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
