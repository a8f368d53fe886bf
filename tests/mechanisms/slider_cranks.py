"""The slider-crank's designs of the independent programs, and its closed forms without play."""

import json
from pathlib import Path

import jax
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

import jaxbuffer as jb

REFERENCE = json.loads((Path(__file__).parent / "slider_crank_reference.json").read_text())
DESIGNS = {entry["name"]: entry for entry in REFERENCE["designs"]}
SPEED = 5000.0 * np.pi / 30.0  # rad/s
TURN = 0.012  # s
CRANK, ROD, ROD_MASS, ROD_INERTIA, SLIDER_MASS = 0.05, 0.12, 0.21, 2.5e-4, 0.14


def built(numbers):
    """Design and scenario of an entry's numbers."""
    values = {
        "crank.length": numbers["crank_radius"],
        "rod.length": numbers["rod_length"],
        "rod.centre": numbers["rod_centre"] / numbers["rod_length"],
        "rod.mass": numbers["rod_mass"],
        "rod.inertia": numbers["rod_inertia"],
        "slider.mass": numbers["slider_mass"],
    }
    for pin in ("piston_pin", "crank_pin"):
        values[f"{pin}.joint"] = "clearance" if numbers[pin] else "pinned"
        for field in ("bush_radius", "clearance", "stiffness", "restitution", "friction", "slip_speed"):
            values[f"{pin}.{field}"] = numbers[field]
    if numbers["torque_driven"]:
        values |= {
            "drive.kind": "torque",
            "crank.inertia": numbers["crank_inertia"],
            "drive.torque": numbers["stall_torque"],
            "drive.no_load_speed": numbers["no_load_speed"],
        }
    scenario = jb.SliderCrankScenario(crank_speed=numbers["speed"], gravity=numbers["gravity"])
    return jb.replace(jb.SliderCrank(), values), scenario


def slider_position(angle, crank=CRANK, rod=ROD):
    """x = r cos θ + √(l² - r² sin² θ) of the mechanism without play [m]."""
    return crank * np.cos(angle) + np.sqrt(rod**2 - (crank * np.sin(angle)) ** 2)


def pinned(angle, centre=0.5, gravity=0.0, speed=SPEED):
    """Of the mechanism without play at a constant speed: kinetic energy of rod and slider [J], and the torque [N m]
    that keeps the speed, by its power: τ ω = d(T + V)/dt with T = ω² I(θ)/2. Derivatives by θ written out."""
    r, rod, a = CRANK, ROD, centre * ROD
    cos, sin = np.cos(angle), np.sin(angle)
    sp = -r * sin / rod
    cp = np.sqrt(1.0 - sp**2)
    p1 = -r * cos / (rod * cp)  # φ'
    p2 = (r * sin / rod + sp * p1**2) / cp  # φ'', from sin φ = -r sin θ/l differentiated twice
    gx1, gy1 = -r * sin - a * sp * p1, r * cos + a * cp * p1
    gx2, gy2 = -r * cos - a * (cp * p1**2 + sp * p2), -r * sin + a * (cp * p2 - sp * p1**2)
    x1, x2 = -r * sin - rod * sp * p1, -r * cos - rod * (cp * p1**2 + sp * p2)
    inertia = ROD_MASS * (gx1**2 + gy1**2) + ROD_INERTIA * p1**2 + SLIDER_MASS * x1**2
    half_slope = ROD_MASS * (gx1 * gx2 + gy1 * gy2) + ROD_INERTIA * p1 * p2 + SLIDER_MASS * x1 * x2
    return 0.5 * speed**2 * inertia, speed**2 * half_slope + gravity * ROD_MASS * gy1


def slider_acceleration(angle, speed=SPEED):
    """Of the mechanism without play at a constant speed [m/s²]."""
    sp = -CRANK * np.sin(angle) / ROD
    cp = np.sqrt(1.0 - sp**2)
    p1 = -CRANK * np.cos(angle) / (ROD * cp)
    p2 = (CRANK * np.sin(angle) / ROD + sp * p1**2) / cp
    return speed**2 * (-CRANK * np.cos(angle) - ROD * (cp * p1**2 + sp * p2))


def first_impact(law):
    """Largest force [N] of the default design's first impact and its time [s], by SciPy's DOP853: crank at a constant
    speed, rod angle and slider as coordinates, ``law`` for the force of depth, its rate and the touchdown's speed."""
    clearance, reach = 5e-4, 0.01

    def motion(time, y):
        phi, x, spin, speed = y
        crank, rod = np.array([np.cos(SPEED * time), np.sin(SPEED * time)]), np.array([np.cos(phi), np.sin(phi)])
        off = np.array([x, 0.0]) - CRANK * crank - ROD * rod
        moving = np.array([speed, 0.0]) - SPEED * CRANK * turned(crank) - ROD * spin * turned(rod)
        return crank, rod, off, moving

    def rates(time, y, force):
        crank, rod, off, moving = motion(time, y)
        far = np.hypot(*off)
        normal = off / far if far > 0.0 else np.array([1.0, 0.0])
        push = force(far - clearance, moving @ normal) * normal  # on the rod, at the bush's surface
        arm = ROD * rod + reach * normal
        half = 0.5 * ROD
        inertial = ROD_MASS * half * turned(rod) @ (SPEED**2 * CRANK * crank)  # of the accelerated crank pin
        spin_rate = (arm[0] * push[1] - arm[1] * push[0] + inertial) / (ROD_INERTIA + ROD_MASS * half**2)
        return [y[2], y[3], spin_rate, -push[0] / SLIDER_MASS]

    def gap(time, y):
        return np.hypot(*motion(time, y)[2]) - clearance

    gap.terminal, gap.direction = True, 1.0
    options = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-13}
    free = lambda time, y: rates(time, y, lambda depth, rate: 0.0)  # noqa: E731
    start = [0.0, CRANK + ROD, -CRANK * SPEED / ROD, 0.0]
    flight = solve_ivp(free, (0.0, TURN), start, events=gap, max_step=1e-5, **options)
    (begin,), (touching,) = flight.t_events[0], flight.y_events[0]
    _, _, off, moving = motion(begin, touching)
    touchdown = moving @ off / np.hypot(*off)
    pushing = jax.jit(lambda depth, rate: law.force(depth, rate, touchdown))
    force = lambda depth, rate: float(pushing(depth, rate))  # noqa: E731
    pressed = solve_ivp(
        lambda time, y: rates(time, y, force), (begin, 3e-4), touching, dense_output=True, max_step=5e-7, **options
    )

    def force_at(time):
        _, _, off, moving = motion(time, pressed.sol(time))
        return force(np.hypot(*off) - clearance, moving @ off / np.hypot(*off))

    near = max(pressed.t, key=force_at)
    top = minimize_scalar(
        lambda t: -force_at(t), bounds=(near - 1e-6, near + 1e-6), method="bounded", options={"xatol": 1e-11}
    )
    return -top.fun, top.x


def turned(vector):
    """By a right angle, counter-clockwise."""
    return np.array([-vector[1], vector[0]])
