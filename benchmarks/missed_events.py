"""Random mechanisms whose motion is known in closed form: is an end or a touchdown ever missed?

`python -m benchmarks missed_events [--runs N] [--seed K]`; 10 000 runs by default. Thrown balls, pendulums, carriages
on a spring, rotors and pairs of carriages, each with a mark that ends the run or with a wall that a ball touches. The
mark lies a random share of the motion's extent, from a hundred-thousandth to a third, below or above the highest place
that is reached. For each mechanism it prints in how many runs an event was missed, was found where there is none, or
was found at another place than the mark, each by more than the run's tolerance explains.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from scipy.special import ellipj

import jaxbuffer as jb
from jaxbuffer.contact import BallPair, RegularisedCoulomb, Segment
from jaxbuffer.contact.laws import Hertz
from jaxbuffer.hybrid import Kind, Options, StepTolerance, solve
from jaxbuffer.mechanisms.assembled import Assembled, BallContact
from jaxbuffer.multibody import GROUND, AppliedForce, AxialSpringDamper, Body, Prismatic, Revolute, System

RUNS = 10_000
GRAVITY = 9.81  # m/s²
RADIUS = 0.01  # m, of each ball
LOOKS = 40_001  # at the closed form of a run
GLOBAL_ERROR = 300.0  # times the tolerance of a step: how far a run may be off at its end, of the motion's extent
Numbers = dict[str, float]


@dataclasses.dataclass(frozen=True)
class Family:
    """Mechanisms of one structure: ``ranges`` of its numbers, drawn evenly in the logarithm; ``parts``: bodies, joints,
    forces, positions and velocities at t = 0; ``place``: the guarded coordinate [m or rad] at times [s], in closed
    form; ``guarded``: the same from the positions."""

    ranges: dict[str, tuple[float, float]]
    parts: Callable[[Any], tuple[tuple, tuple, tuple, list, list]]
    place: Callable[[Numbers, np.ndarray], np.ndarray]
    guarded: Callable[[Any], Any]


def ball() -> Body:
    """The body of which all families are made."""
    return Body(0.2, 1e-3)


def thrown_parts(p: Any) -> tuple:
    return (ball(),), (), (AppliedForce(0, (0.0, -GRAVITY * 0.2)),), [0.0, 0.0, 0.0], [p["sideways"], p["speed"], 1.0]


def thrown_place(p: Numbers, t: np.ndarray) -> np.ndarray:
    return p["speed"] * t - 0.5 * GRAVITY * t**2


def pendulum_parts(p: Any) -> tuple:
    """A ball on a light rod that hangs from the origin and is struck."""
    joint = Revolute(GROUND, 0, second_point=(0.0, p["length"]))
    weight = AppliedForce(0, (0.0, -GRAVITY * 0.2))
    start = [0.0, -p["length"], 0.0]
    return (ball(),), (joint,), (weight,), start, [p["rate"] * p["length"], 0.0, p["rate"]]


def pendulum_angle(p: Numbers, t: np.ndarray) -> np.ndarray:
    """From hanging, where it moves fastest: sin(θ/2) = k sn(ω t, k), or beyond the top θ/2 = am(Ω t/2, 1/k)."""
    own = np.sqrt(GRAVITY * 0.2 * p["length"] / (0.2 * p["length"] ** 2 + 1e-3))
    k = 0.5 * p["rate"] / own
    if k < 1.0:
        return 2.0 * np.arcsin(k * ellipj(own * t, k**2)[0])
    return 2.0 * ellipj(0.5 * p["rate"] * t, 1.0 / k**2)[3]


def carriage(k: int, stiffness: Any, damping: Any) -> tuple:
    """Guide and spring of a carriage on the x-axis at rest in the origin."""
    guide = Prismatic(GROUND, k, (0.0, 0.0), (0.0, 0.0), (0.0, 1.0))
    spring = AxialSpringDamper(GROUND, k, (-1.0, 0.0), (0.0, 0.0), stiffness, damping, 1.0, guide=(1.0, 0.0))
    return guide, spring


def carriage_parts(p: Any) -> tuple:
    guide, spring = carriage(0, p["stiffness"], p["damping"])
    return (ball(),), (guide,), (spring,), [-0.5 * p["speed"], 0.0, 0.0], [p["speed"], 0.0, 0.0]


def swing(stiffness: float, damping: float, x: float, v: float, t: np.ndarray) -> np.ndarray:
    """Place of a carriage that starts at x with v, weakly damped."""
    decay = 0.5 * damping / 0.2
    rate = np.sqrt(stiffness / 0.2 - decay**2)
    return np.exp(-decay * t) * (x * np.cos(rate * t) + (v + decay * x) / rate * np.sin(rate * t))


def carriage_place(p: Numbers, t: np.ndarray) -> np.ndarray:
    return swing(p["stiffness"], p["damping"], -0.5 * p["speed"], p["speed"], t)


def rotor_parts(p: Any) -> tuple:
    """A ball at the end of a light rod that turns evenly about the origin, in the plane of no weight."""
    joint = Revolute(GROUND, 0, second_point=(0.0, p["length"]))
    return (ball(),), (joint,), (), [0.0, -p["length"], 0.0], [p["rate"] * p["length"], 0.0, p["rate"]]


def rotor_place(p: Numbers, t: np.ndarray) -> np.ndarray:
    return p["length"] * np.sin(p["rate"] * t)


def pair_parts(p: Any) -> tuple:
    (one, soft), (two, stiff) = carriage(0, p["stiffness"], p["damping"]), carriage(1, p["other"], p["damping"])
    zero = 0.0 * p["speed"]
    return (ball(), ball()), (one, two), (soft, stiff), [zero] * 6, [p["speed"], 0.0, 0.0, -0.7 * p["speed"], 0.0, 0.0]


def pair_place(p: Numbers, t: np.ndarray) -> np.ndarray:
    """The sum of both carriages' places: a beat."""
    one = swing(p["stiffness"], p["damping"], 0.0, p["speed"], t)
    return one + swing(p["other"], p["damping"], 0.0, -0.7 * p["speed"], t)


CARRIAGE = {"stiffness": (10.0, 1e3), "damping": (1e-3, 0.3), "speed": (0.1, 2.0), "duration": (0.3, 3.0)}
ROD = {"length": (0.1, 1.0), "rate": (0.5, 20.0), "duration": (0.3, 3.0)}
FAMILIES = {
    "thrown ball": Family(
        {"speed": (0.1, 10.0), "sideways": (0.01, 1.0), "duration": (0.3, 3.0)},
        thrown_parts,
        thrown_place,
        lambda q: q[1],
    ),
    "pendulum": Family(ROD, pendulum_parts, pendulum_angle, lambda q: q[2]),
    "carriage": Family(CARRIAGE, carriage_parts, carriage_place, lambda q: q[0]),
    "rotor": Family(ROD, rotor_parts, rotor_place, lambda q: q[0]),
    "pair of carriages": Family(CARRIAGE | {"other": (10.0, 1e3)}, pair_parts, pair_place, lambda q: q[0] + q[3]),
}
# Where a ball touches: a wall at a distance, long enough for any run, its front towards where the ball comes from.
UPRIGHT, CEILING = (lambda d: Segment(d, -500.0, 0.0, 1.0, 1e3)), (lambda d: Segment(500.0, d, -1.0, 0.0, 1e3))
WALLS = {"thrown ball": CEILING, "carriage": UPRIGHT, "rotor": UPRIGHT}


def assembled(name: str, p: Any, mark: Any, touches: bool) -> Assembled:
    """A mechanism of a family that ends at the ``mark``, or has a wall there that its ball touches."""
    family = FAMILIES[name]
    bodies, joints, forces, q, v = family.parts(p)
    start = {"q": jnp.stack([jnp.asarray(x, float) for x in q]), "v": jnp.stack([jnp.asarray(x, float) for x in v])}
    system = System(bodies, joints, forces, 20.0)
    if not touches:
        return Assembled(system, **start, ends=(lambda system, kin: family.guarded(kin.q) - mark,), size=(1e-2, 1.0))
    pair = BallPair(
        RADIUS, WALLS[name](mark + RADIUS), side=-1.0, law=Hertz(1e9), friction=RegularisedCoulomb(0.0, 1e-3)
    )
    return Assembled(system, **start, elements=(BallContact(0, GROUND, pair),), size=(1e-2, 1.0))


def program(name: str, touches: bool) -> Callable[..., Any]:
    """Compiled: when and at which value of the guarded coordinate the first event was, and whether there was one."""

    @jax.jit
    def run(p: Numbers, mark: jax.Array, rtol: jax.Array) -> Any:
        options = Options(tolerance=StepTolerance(rtol, rtol), max_events=16)
        result = solve(lambda p, mark: assembled(name, p, mark, touches), (p, mark), p["duration"], options)
        log = result.log
        wanted = (log.kind == (Kind.TOUCHDOWN if touches else Kind.END)) & (log.which >= 0)
        first = jnp.argmax(wanted)
        return jnp.any(wanted), log.time[first], result.status

    return run


@dataclasses.dataclass
class Count:
    """How many runs a family made, and how many had an event, failed, missed one, made one up, or misplaced it."""

    runs: int = 0
    events: int = 0
    failed: int = 0
    missed: int = 0
    untrue: int = 0
    misplaced: int = 0


def campaign(name: str, touches: bool, runs: int, seed: int) -> tuple[Count, list[Any]]:
    """Count the runs of a family that went wrong, and return their numbers."""
    family, rng, run = FAMILIES[name], np.random.default_rng(seed), program(name, touches)
    count, bad = Count(), []
    for _ in range(runs):
        p = {key: float(np.exp(rng.uniform(*np.log(ends)))) for key, ends in family.ranges.items()}
        rtol = float(10.0 ** rng.uniform(-9.0, -4.0))
        t = np.linspace(0.0, p["duration"], LOOKS)
        place = family.place(p, t)
        extent = float(np.ptp(place))
        height = extent * float(rng.choice([-1.0, 1.0]) * 10.0 ** rng.uniform(-5.0, -0.5))
        allowed = extent * (GLOBAL_ERROR * rtol + (place[1:] - place[:-1]).max() ** 2 / extent**2)
        mark = float(place.max()) - height
        if abs(height) < allowed or place[0] > mark - allowed:
            continue
        there, time, status = (x.item() for x in run(p, jnp.asarray(mark), jnp.asarray(rtol)))
        before = place[t < (time if there else np.inf)]
        wrong = {
            "failed": status > 100,
            "missed": bool(np.any(before > mark + allowed)),
            "untrue": there and height < 0.0,
            "misplaced": there and abs(float(family.place(p, np.asarray(time))) - mark) > allowed,
        }
        count.runs += 1
        count.events += there
        for kind, is_so in wrong.items():
            setattr(count, kind, getattr(count, kind) + is_so)
        if any(wrong.values()):
            bad.append((p, mark, rtol, [kind for kind, is_so in wrong.items() if is_so]))
    return count, bad


def main(runs: int = RUNS, seed: int = 0) -> int:
    jb.configure()
    cases = [(name, touches) for name in FAMILIES for touches in (False, True) if not touches or name in WALLS]
    print(f"{'':18} {'event':10} {'runs':>6} {'events':>7} {'failed':>7} {'missed':>7} {'untrue':>7} {'misplaced':>10}")
    total = 0
    for k, (name, touches) in enumerate(cases):
        count, bad = campaign(name, touches, runs // len(cases), seed + k)
        total += count.failed + count.missed + count.untrue + count.misplaced
        print(
            f"{name:18} {'touchdown' if touches else 'end':10} {count.runs:6} {count.events:7} {count.failed:7} "
            f"{count.missed:7} {count.untrue:7} {count.misplaced:10}"
        )
        for one in bad[:3]:
            print("   ", *one)
    return int(total > 0)
