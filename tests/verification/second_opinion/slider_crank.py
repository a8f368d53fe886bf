"""The slider-crank with clearance in Exudyn: its own bodies, joints and contact of a sphere in a hollow sphere.

Its Hunt-Crossley damping 3/2 (1 - e') δ̇/δ̇⁻ is Lankarani and Nikravesh's 3/4 (1 - e²) for e' = (1 + e²)/2. The approach
speed is sampled where a step ends, so that a peak is off by the order of the step, up or down as touchdown falls.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import exudyn as exu
import exudyn.itemInterface as item
import numpy as np


class Peaks(NamedTuple):
    """Impacts in the order of their touchdowns: ``time`` [s] (first step in contact), ``peak_force`` [N], ``joint``
    (0 crank pin, 1 piston pin)."""

    time: np.ndarray
    peak_force: np.ndarray
    joint: np.ndarray


class Extrapolated(NamedTuple):
    """What runs at several steps tend to: peaks [N] at step zero by a straight line, with the line's standard error."""

    peak_force: np.ndarray
    error: np.ndarray
    joint: np.ndarray


def simulate(numbers: Mapping[str, float], step: float, duration: float) -> Peaks:
    """Run by the implicit trapezoidal rule (index 2) at a fixed ``step`` [s]; ``numbers`` as in the reference file."""
    n = numbers
    container = exu.SystemContainer()
    mbs = container.AddSystem()
    crank, rod, slider, ground = _bodies(mbs, n)
    _drive(mbs, n, crank, ground, slider)
    watched = []
    for joint, (loose, pin, bush) in enumerate(
        [
            (n["crank_pin"], _marker(mbs, crank[1], n["crank_radius"]), _marker(mbs, rod[1], -n["rod_centre"])),
            (n["piston_pin"], _marker(mbs, slider[1]), _marker(mbs, rod[1], n["rod_length"] - n["rod_centre"])),
        ]
    ):
        if loose:
            watched.append((joint, _contact(mbs, n, pin, bush)))
        else:
            mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=[pin, bush]))
    mbs.Assemble()
    settings = exu.SimulationSettings()
    time = settings.timeIntegration
    time.numberOfSteps = int(np.ceil(duration / step))
    time.endTime = time.numberOfSteps * step
    time.verboseMode = 0
    time.adaptiveStep = False
    time.discontinuous.useRecommendedStepSize = False
    time.newton.relativeTolerance, time.newton.absoluteTolerance = 1e-6, 1e-8
    time.newton.useModifiedNewton = False
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = step
    mbs.SolveDynamic(settings, solverType=exu.DynamicSolverType.TrapezoidalIndex2, showHints=False)
    found = []
    for joint, sensors in watched:
        force, pin, bush = (mbs.GetSensorStoredData(sensor) for sensor in sensors)
        found += [(at, peak, joint) for at, peak in _peaks(force[:, 0], _normal(force, pin - bush))]
    touched, peaks, joints = zip(*sorted(found), strict=True)
    return Peaks(np.array(touched), np.array(peaks), np.array(joints))


def extrapolate(numbers: Mapping[str, float], steps: Sequence[float], duration: float, impacts: int) -> Extrapolated:
    """The first ``impacts`` peaks at step zero, by least squares over the ``steps`` [s]."""
    runs = [simulate(numbers, step, duration) for step in steps]
    peaks = np.array([run.peak_force[:impacts] for run in runs])
    line = np.vander(np.asarray(steps) / max(steps), 2)
    fit, squares, _, _ = np.linalg.lstsq(line, peaks, rcond=None)
    deviation = np.sqrt(squares / (len(steps) - 2))
    return Extrapolated(fit[1], deviation * np.sqrt(np.linalg.inv(line.T @ line)[1, 1]), runs[-1].joint[:impacts])


def _bodies(mbs, n):
    """Crank, rod and slider as (node, body), and the ground."""

    def body(mass, inertia, pose, velocity):
        node = mbs.AddNode(item.NodeRigidBody2D(referenceCoordinates=pose, initialVelocities=velocity))
        return node, mbs.AddObject(item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    radius, length, centre = n["crank_radius"], n["rod_length"], n["rod_centre"]
    swing = -n["speed"] * radius / length
    # The crank is balanced: its mass is of no effect. At constant speed neither is its inertia.
    crank = body(0.1, n["crank_inertia"] or 1e-4, [0.0, 0.0, 0.0], [0.0, 0.0, n["speed"]])
    rise = n["speed"] * radius + swing * centre
    rod = body(n["rod_mass"], n["rod_inertia"], [radius + centre, 0.0, 0.0], [0.0, rise, swing])
    slider = body(n["slider_mass"], 1e-3, [radius + length, 0.0, 0.0], [0.0, 0.0, 0.0])
    weight = mbs.AddMarker(item.MarkerBodyMass(bodyNumber=rod[1]))
    mbs.AddLoad(item.LoadMassProportional(markerNumber=weight, loadVector=[0.0, -n["gravity"], 0.0]))
    return crank, rod, slider, mbs.AddObject(item.ObjectGround())


def _drive(mbs, n, crank, ground, slider):
    """Crank on its pivot and driven, slider on the x-axis."""
    still = mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=mbs.AddNode(item.NodePointGround()), coordinate=0))

    def coordinate(node, place):
        return mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=place))

    mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=[_marker(mbs, ground), _marker(mbs, crank[1])]))
    for place in (1, 2):
        mbs.AddObject(item.ObjectConnectorCoordinate(markerNumbers=[still, coordinate(slider[0], place)]))
    turning = coordinate(crank[0], 2)
    if n["torque_driven"]:  # M0 (1 - ω/ω0): a constant torque and a damper
        drag = n["stall_torque"] / n["no_load_speed"]
        mbs.AddLoad(item.LoadCoordinate(markerNumber=turning, load=n["stall_torque"]))
        mbs.AddObject(item.ObjectConnectorCoordinateSpringDamper(markerNumbers=[still, turning], damping=drag))
    else:
        mbs.AddObject(
            item.ObjectConnectorCoordinate(markerNumbers=[still, turning], velocityLevel=True, offset=n["speed"])
        )


def _marker(mbs, body, x=0.0):
    return mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=body, localPosition=[x, 0.0, 0.0]))


def _contact(mbs, n, pin, bush):
    """Contact of a pin with its bush; sensors of the force on the one and of both centres."""
    memory = mbs.AddNode(item.NodeGenericData(initialCoordinates=[0.0] * 4, numberOfDataCoordinates=4))
    contact = mbs.AddObject(
        item.ObjectContactSphereSphere(
            markerNumbers=[pin, bush],
            nodeNumber=memory,
            spheresRadii=[n["bush_radius"] - n["clearance"], n["bush_radius"]],
            isHollowSphere1=True,
            dynamicFriction=n["friction"],
            frictionProportionalZone=n["slip_speed"],
            contactStiffness=n["stiffness"],
            contactStiffnessExponent=1.5,
            restitutionCoefficient=(1.0 + n["restitution"] ** 2) / 2.0,
            minimumImpactVelocity=1e-5,
            impactModel=1,
        )
    )
    kept = {"storeInternal": True, "writeToFile": False}
    force, position = exu.OutputVariableType.Force, exu.OutputVariableType.Position
    sensors = [mbs.AddSensor(item.SensorObject(objectNumber=contact, outputVariableType=force, **kept))]
    for marker in (pin, bush):
        sensors.append(mbs.AddSensor(item.SensorMarker(markerNumber=marker, outputVariableType=position, **kept)))
    return sensors


def _normal(force, apart):
    """Normal force [N] by time: the component along the line of centres."""
    far = np.maximum(np.hypot(apart[:, 1], apart[:, 2]), 1e-300)
    return np.abs(np.sum(force[:, 1:3] * apart[:, 1:3], axis=1)) / far


def _peaks(time, force):
    """First step and peak of each contact, the peak by the parabola through the three highest steps."""
    edges = np.flatnonzero(np.diff((force > 0.0).astype(int)))
    found = []
    for begin, end in zip(edges[::2], [*edges[1::2], len(force) - 1][: len(edges[::2])], strict=True):
        top = begin + int(np.argmax(force[begin : end + 1]))
        if not begin < top < len(force) - 1:
            continue
        low, middle, high = force[top - 1 : top + 2]
        slope, bend = (high - low) / 2, high - 2 * middle + low
        found.append((time[begin + 1], middle - slope**2 / (2 * bend)))
    return found
