"""Random runs of each mechanism: reported maxima against the runs' own histories and against tight solves.

`python -m benchmarks campaign [--mechanism NAME] [--runs N] [--seed K]`; 10 000 runs of each study by default. For each
study it prints how the runs ended and in how many a reported maximum is

- below the largest value at the run's own accepted steps by more than 1e-4 of it ("below its history");
- below that of a solve at rtol 1e-9 with the same outcome and impacts by more than 1e-3 of the range between its
  largest and smallest value ("missed"), and in how many of these `jb.simulate` misses it too in a run that `jb.trust`
  calls trusted ("silently").

The runs concerned are listed by their numbers; ``--only NUMBER`` prints everything about one of them.
"""

import collections
import dataclasses
from collections.abc import Iterator
from typing import Annotated, Any

import jax
import jax.numpy as jnp
import numpy as np
import typer

import jaxbuffer as jb
from jaxbuffer.fields import Part
from jaxbuffer.mechanisms.mechanism import Request
from jaxbuffer.mechanisms.registry import mechanism_of
from jaxbuffer.progress import counted
from jaxbuffer.run.request import options_of, request
from jaxbuffer.run.stepper import run_of, stepped
from jaxbuffer.run.trust import trust

from .names import chosen

RUNS = 10_000
STEPS = 6000  # accepted steps looked at
BELOW_HISTORY, MISSED = 1e-4, 1e-3  # relative
TIGHT = 1e-9
Ranges = dict[str, tuple[float, float]]


@dataclasses.dataclass(frozen=True)
class Study:
    """A structure of a mechanism with ranges: drawn evenly in the logarithm, or evenly; ``duration`` [s]."""

    design: Part
    scenario: Part
    duration: float
    logarithmic: Ranges
    even: Ranges

    def drawn(self, count: int, seed: int) -> Iterator[tuple[Any, Any]]:
        """So many designs and scenarios, always the same for a seed; those out of range are left out."""
        rng = np.random.default_rng(seed)
        for _ in range(count):
            values = {path: float(np.exp(rng.uniform(*np.log(ends)))) for path, ends in self.logarithmic.items()}
            values |= {path: float(rng.uniform(*ends)) for path, ends in self.even.items()}
            met = {path.removeprefix("scenario."): x for path, x in values.items() if path.startswith("scenario.")}
            parts = {path: x for path, x in values.items() if not path.startswith("scenario.")}
            try:
                design, scenario = jb.replace(self.design, parts), jb.replace(self.scenario, met)
                mechanism_of(design).check_fit(design, scenario)
            except jb.InputError:
                continue
            yield design, scenario


DOCKING: Ranges = {
    "active.mass": (10.0, 2000.0),  # kg
    "active.inertia": (0.3, 1e6),  # kg m²
    "passive.mass": (10.0, 2000.0),
    "passive.inertia": (0.3, 1e4),
    "buffer.k_A": (20.0, 2e4),  # N/m
    "buffer.c_A": (0.3, 200.0),  # N s/m
    "buffer.k_T": (20.0, 2e4),  # N m/rad
    "buffer.c_T": (0.05, 60.0),  # N m s/rad
    "buffer.cylinder_mass": (0.3, 3.0),  # kg
    "probe.tip_mass": (0.01, 0.6),
    "probe.rod_mass": (0.05, 0.6),
    "contact.slip_speed": (2e-4, 1e-2),  # m/s
    "scenario.approach_speed": (0.02, 0.6),
}
DOCKING_EVEN: Ranges = {
    "cone.half_angle": (0.4, 1.25),  # rad
    "contact.restitution": (0.2, 0.99),
    "contact.friction": (0.0, 1.0),
    "scenario.contact_distance": (0.005, 0.07),  # m
    "scenario.misalignment": (-0.14, 0.14),  # rad
    "scenario.passive_rate": (-0.03, 0.03),  # rad/s
}
CRANK: Ranges = {
    "crank.length": (0.02, 0.2),  # m
    "rod.length": (0.06, 0.6),
    "rod.mass": (0.05, 3.0),  # kg
    "slider.mass": (0.03, 2.0),
    "crank.inertia": (1e-5, 0.1),  # kg m²
    "piston_pin.clearance": (2e-5, 1e-3),  # m
    "piston_pin.friction": (1e-3, 0.5),
    "crank_pin.clearance": (2e-5, 1e-3),
    "crank_pin.friction": (1e-3, 0.5),
    "scenario.crank_speed": (20.0, 500.0),  # rad/s
}
CRANK_EVEN: Ranges = {
    "piston_pin.restitution": (0.3, 0.95),
    "crank_pin.restitution": (0.3, 0.95),
    "scenario.crank_angle": (-3.1, 3.1),  # rad
}
DROP: Ranges = {
    "bar.length": (0.05, 1.0),  # m
    "bar.diameter": (0.002, 0.03),
    "impact.friction": (1e-3, 0.6),
    "scenario.height": (0.002, 0.049),
}
DROP_EVEN: Ranges = {"impact.restitution": (0.3, 0.99)}


def docking(**changes: Any) -> Study:
    """A docking probe in its cone."""
    return Study(jb.replace(jb.table2(), changes), jb.Scenario(), 8.0, DOCKING, DOCKING_EVEN)


def crank(**changes: Any) -> Study:
    """A slider-crank with play."""
    design = jb.replace(jb.SliderCrank(), {path.replace("__", "."): value for path, value in changes.items()})
    return Study(design, jb.SliderCrankScenario(), 0.01, CRANK, CRANK_EVEN)


def drop(**modes: int) -> Study:
    """A bar dropped on a plate by the Lankarani-Nikravesh law."""
    law = {"impact.law": "lankarani-nikravesh", "impact.exponent": 1.5, "impact.stiffness": 6.8e9}
    design = jb.replace(jb.BarDrop(), law | {f"{part}.modes": count for part, count in modes.items()})
    return Study(design, jb.BarDropScenario(), 0.3, DROP, DROP_EVEN)


STUDIES = {
    "docking": docking,
    "docking, free tip": lambda: docking(**{"probe.free_tip": True}),
    "slider-crank": lambda: crank(piston_pin__law="pereira"),
    "slider-crank, play in both pins": lambda: crank(piston_pin__law="pereira", crank_pin__joint="clearance"),
    "bar drop": drop,
    "bar drop, bending plate": lambda: drop(plate=5),
}


@jax.jit
def _measured(given: Request) -> tuple[Any, ...]:
    """Of a run: outcome, touchdowns, accepted steps, reported maxima, the range of their observables, and the largest
    values at accepted steps."""
    result = stepped(given)
    run = run_of(given._replace(options=dataclasses.replace(given.options, keep=0)), result)
    system = given.system
    steps = result.steps
    slots = jnp.arange(steps.time.shape[0] - 1)

    def observed(slot: jax.Array) -> jax.Array:
        state, active = steps.rows[slot, 0], steps.active[slot]
        return system.observables(state, system.derivative(steps.time[slot], state, active), active)

    values, contacts = jax.vmap(observed)(slots), system.impact_contacts
    force = jnp.max(values[:, :contacts], axis=1, keepdims=True)
    values = jnp.concatenate([force, values[:, contacts:]], axis=1)
    taken = (slots < steps.count)[:, None]
    highest, lowest = (jnp.max(jnp.where(taken, sign * values, -jnp.inf), axis=0) for sign in (1.0, -1.0))
    reported = jnp.stack([run.peak_force, *(run.maxima[name] for name in system.observed[contacts:])])
    return run.code, run.impact_count, run.accepted, reported, highest + lowest, highest


def measured(design: Part, scenario: Part, duration: float, rtol: float = 1e-6) -> tuple[Any, ...]:
    """`_measured` as NumPy arrays; the names of the maxima are `names`."""
    given = request(
        mechanism_of(design), design, scenario, duration, tolerances=(rtol, rtol), options=options_of(keep=STEPS)
    )
    return jax.tree.map(np.asarray, _measured(jax.tree.map(lambda x: np.asarray(x, float), given)))


def names(design: Part, scenario: Part) -> tuple[str, ...]:
    """The contact force and the other observables."""
    system = mechanism_of(design).system(design, scenario, 20.0)
    return ("peak_force", *system.observed[system.impact_contacts :])


def below(values: np.ndarray, others: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """By how much values are below others, relative to ``sizes``; 0 where they are not."""
    return np.where(sizes > 0.0, np.maximum(others - values, 0.0) / np.where(sizes > 0.0, sizes, 1.0), 0.0)


def sizes(extent: np.ndarray, history: np.ndarray) -> np.ndarray:
    """What a shortfall is compared with: the largest value or its range, whichever is less, but no rounding."""
    return np.clip(np.abs(history), 1e-6 * extent, extent)


def campaign(title: str, study: Study, count: int, seed: int) -> int:
    """Run a study and print its counts; return how many runs are below their history or missed silently."""
    ended: collections.Counter[str] = collections.Counter()
    low: list[str] = []
    missed: list[str] = []
    silent: list[str] = []
    progress, done = counted(True, "run"), 0
    for number, (design, scenario) in enumerate(study.drawn(count, seed)):
        code, impacts, _, reported, size, history = measured(design, scenario, study.duration)
        outcome = mechanism_of(design).outcomes(int(code))
        ended[outcome.name] += 1
        done += 1
        if progress is not None:
            progress(number + 1, count)
        if outcome.failed:
            continue
        called = names(design, scenario)
        short = below(reported, history, sizes(size, history))
        low += [f"{number} {name} {x:.1e}" for name, x in zip(called, short, strict=True) if x > BELOW_HISTORY]
        tight = measured(design, scenario, study.duration, TIGHT)
        if (int(tight[0]), int(tight[1])) != (int(code), int(impacts)):
            continue
        short = below(reported, tight[3], size)
        wrong = [f"{number} {name} {x:.1e}" for name, x in zip(called, short, strict=True) if x > MISSED]
        missed += wrong
        if wrong:
            trusted = _trusted_maxima(design, scenario, study.duration)
            short = below(trusted, tight[3], size) if trusted is not None else np.zeros_like(size)
            silent += [f"{number} {name} {x:.1e}" for name, x in zip(called, short, strict=True) if x > MISSED]
    print(f"{title}: {done} runs, {', '.join(f'{n} {name}' for name, n in ended.most_common())}")
    for heading, cases in (("below its history", low), ("missed", missed), ("missed silently", silent)):
        print(f"  {heading}: {len({case.split()[0] for case in cases})}  {'; '.join(cases[:8])}")
    return len(low) + len(silent)


def _trusted_maxima(design: Part, scenario: Part, duration: float) -> np.ndarray | None:
    """The maxima that `jaxbuffer.simulate` reports, or None where the trust check calls its run anything but trusted.

    It is a program of its own: where little decides, rounding makes other steps of it than `measured` has.
    """
    run, closer = (jb.simulate(design, scenario, duration, rtol=rtol) for rtol in (1e-6, 1e-7))
    if trust(run, closer).verdict != "trusted":
        return None
    return np.array([run.peak_force, *(run.maxima[name] for name in names(design, scenario)[1:])])


def show(study: Study, number: int, seed: int) -> None:
    """Print the numbers of one run and its maxima, reported, at accepted steps and tight."""
    design, scenario = dict(enumerate(study.drawn(number + 10_000, seed)))[number]
    for rtol in (1e-6, 1e-7, TIGHT):
        code, impacts, accepted, reported, _, history = measured(design, scenario, study.duration, rtol)
        print(f"rtol {rtol:g}: {mechanism_of(design).outcomes(int(code)).name}, {impacts} impacts, {accepted} steps")
        for name, value, highest in zip(names(design, scenario), reported, history, strict=True):
            print(f"  {name:20} reported {value:.9g}, at accepted steps {highest:.9g}")
    print(design, scenario, sep="\n")


def main(
    mechanism: Annotated[list[str] | None, typer.Option(help=f"study (default: all): {', '.join(STUDIES)}")] = None,
    runs: int = RUNS,
    seed: int = 0,
    only: Annotated[int | None, typer.Option(help="print everything about one run of the study")] = None,
) -> int:
    """Run what the command line asks for; the exit status."""
    titles = chosen(mechanism, STUDIES, "study")
    jb.configure()
    if only is not None:
        show(STUDIES[titles[0]](), only, seed)
        return 0
    return int(sum(campaign(title, STUDIES[title](), runs, seed) for title in titles) > 0)
