"""Random designs far wider than an engineer would search: how many captures end how, and how well they keep energy.

`python -m benchmarks wide [--count N]`; 2000 of them by default, half with a free tip, each of 8 s at default settings.
Designs with any of the optional parts are those of `python -m benchmarks campaign --mechanism "docking, any parts"`,
which counts their outcomes and their errors of energy too.
"""

import collections

import jax
import numpy as np

import jaxbuffer as jb
from jaxbuffer.mechanisms.probe_cone.law_validity import validity

CAPTURES = 2000
CHUNK = 50
LOGARITHMIC = {  # ranges
    "buffer.k_A": (20.0, 2e4),  # N/m
    "buffer.c_A": (0.1, 200.0),  # N s/m
    "buffer.k_T": (20.0, 5000.0),  # N m/rad
    "buffer.c_T": (0.1, 50.0),  # N m s/rad
    "active.mass": (5.0, 500.0),  # kg
    "active.inertia": (0.1, 100.0),  # kg m²
    "passive.mass": (5.0, 1000.0),  # kg
    "passive.inertia": (0.1, 300.0),  # kg m²
    "probe.tip_mass": (0.01, 0.5),  # kg
    "scenario.approach_speed": (0.02, 1.0),  # m/s
}
LINEAR = {
    "cone.half_angle": (0.4, 1.1),  # rad
    "contact.restitution": (0.3, 1.0),
    "contact.friction": (0.0, 0.6),
    "scenario.contact_distance": (0.015, 0.07),  # m
    "scenario.misalignment": (-0.15, 0.15),  # rad
    "scenario.passive_rate": (-0.02, 0.02),  # rad/s
}


def draw(count, seed=0, logarithmic=LOGARITHMIC, linear=LINEAR):
    """``count`` values of every number, shape (count,), by dotted path."""
    rng = np.random.default_rng(seed)
    values = {path: np.exp(rng.uniform(*np.log(ends), count)) for path, ends in logarithmic.items()}
    return values | {path: rng.uniform(*ends, count) for path, ends in linear.items()}


def built(values, free_tip):
    """Design and scenario with those values."""
    drawn = {path: value for path, value in values.items() if not path.startswith("scenario.")}
    met = {path.removeprefix("scenario."): value for path, value in values.items() if path.startswith("scenario.")}
    count = len(values["buffer.k_A"])
    pair = jb.replace(jb.table2(), drawn | {"probe.free_tip": free_tip}), jb.replace(jb.Scenario(), met)
    return jax.tree.map(lambda x: np.broadcast_to(np.asarray(x, float), (count,)), pair)


@jax.jit
def measured(designs, scenarios):
    """Outcome, error of energy, touchdowns, attempts, peak force and penetration of each capture."""

    def one(design, scenario):
        run = jb.simulate(design, scenario)
        return (
            run.code,
            run.balance.energy,
            run.impact_count,
            run.attempts,
            run.peak_force,
            run.penetration,
        )

    return jax.vmap(one)(designs, scenarios)


def main(count: int = CAPTURES) -> None:
    """Print how the captures ended."""
    jb.configure()
    for free_tip in (False, True):
        values = draw(count // 2, seed=int(free_tip))
        parts = []
        for first in range(0, count // 2, CHUNK):
            chunk = {path: value[first : first + CHUNK] for path, value in values.items()}
            parts.append([np.asarray(x) for x in measured(*built(chunk, free_tip))])
        code, energy, impacts, attempts, force, depth = (np.concatenate(part) for part in zip(*parts, strict=True))
        solved = np.array([not jb.Outcome(int(c)).failed for c in code])
        worst = int(np.argmax(np.where(solved, np.abs(energy), 0.0)))
        ended = collections.Counter(jb.Outcome(int(c)).name for c in code)
        beyond = validity(built(values, free_tip)[0], depth, force).too_deep
        print(f"{count // 2} captures, {'free' if free_tip else 'welded'} tip: {dict(ended.most_common())}")
        print(f"  beyond the contact law's validity: {int(np.sum(beyond & solved))}")
        print(f"  energy, relative to the initial: worst {abs(energy[worst]):.2g}, 99 % {q(energy[solved], 0.99):.2g}")
        print(f"  impacts: median {np.median(impacts):.0f}, most {impacts.max()}; attempts: most {attempts.max()}")
        for k in np.flatnonzero(~solved):
            print(
                f"  {jb.Outcome(int(code[k])).name}:",
                {path: float(f"{value[k]:.5g}") for path, value in values.items()},
            )


def q(values, share):
    """A quantile of magnitudes."""
    return float(np.quantile(np.abs(values), share))
