"""Random runs of each mechanism: reported maxima against the runs' own histories and against tight solves.

`python -m benchmarks campaign [--mechanism NAME] [--runs N] [--seed K]`; 10 000 runs of each study by default. For each
study it prints how the runs ended and in how many a reported maximum is

- below the largest value at the run's own accepted steps by more than 1e-4 of it ("below its history");
- below that of a solve at rtol 1e-9 with the same outcome and impacts by more than 1e-3 of the range between its
  largest and smallest value ("missed"), and in how many of these `jb.simulate` misses it too in a run that `jb.trust`
  calls trusted ("silently").

It also counts runs whose energy is off by more than 1e-6 of the initial. A study with any parts draws structures too:
which optional parts a design has, each of them once alone and then combined at random.

The runs concerned are listed by their numbers; ``--only NUMBER`` prints everything about one of them. A study that is
stopped, by ``--minutes``, Ctrl-C or a request to end, prints its counts so far and the ``--first`` to go on with.
"""

import collections
import dataclasses
import math
from typing import Annotated, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import typer

import jaxbuffer as jb
from jaxbuffer.fields import Part
from jaxbuffer.mechanisms.mechanism import Request
from jaxbuffer.mechanisms.quantity import NEGLIGIBLE
from jaxbuffer.mechanisms.registry import mechanism_of
from jaxbuffer.progress import counted
from jaxbuffer.run.request import options_of, request
from jaxbuffer.run.stepper import run_of, stepped
from jaxbuffer.run.trust import SMALL, trust

from .names import chosen
from .optional_parts import CRANK_PARTS, DOCKING_PARTS, DROP_PARTS, SPACE_PARTS, Ranges, Structure, structures
from .portions import Portion, cases

RUNS, STRUCTURES = 10_000, 60
STEPS = 6000  # accepted steps looked at
BELOW_HISTORY, MISSED = 1e-4, 1e-3  # relative
UNBALANCED = 1e-6  # of the initial energy
TIGHT = 1e-9
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
SPACE: Ranges = DOCKING | {
    "active.roll_inertia": (0.1, 1e4),  # kg m²
    "passive.roll_inertia": (0.1, 1e4),
    "probe.rod_radius": (0.003, 0.012),  # m
}
SPACE_EVEN: Ranges = {
    **{
        path: DOCKING_EVEN[path]
        for path in DOCKING_EVEN
        if path not in ("scenario.misalignment", "scenario.passive_rate")
    },
    "scenario.azimuth": (-math.pi, math.pi),  # rad
    "scenario.passive_yaw": (-0.1, 0.1),
    "scenario.passive_pitch": (-0.1, 0.1),
    **{f"scenario.passive_rate_{axis}": (-0.03, 0.03) for axis in "xyz"},  # rad/s
    "scenario.active_rate_x": (-0.03, 0.03),
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


def docking(**changes: Any) -> Structure:
    """A docking probe in its cone."""
    return Structure(jb.replace(jb.table2(), changes), jb.Scenario(), 8.0, DOCKING, DOCKING_EVEN)


def space(**changes: Any) -> Structure:
    """A docking probe in its cone, in space."""
    return Structure(jb.replace(jb.docking3d(), changes), jb.Scenario3D(), 8.0, SPACE, SPACE_EVEN)


def crank(**changes: Any) -> Structure:
    """A slider-crank with play."""
    design = jb.replace(jb.SliderCrank(), {path.replace("__", "."): value for path, value in changes.items()})
    return Structure(design, jb.SliderCrankScenario(), 0.01, CRANK, CRANK_EVEN)


def drop(**modes: int) -> Structure:
    """A bar dropped on a plate by the Lankarani-Nikravesh law."""
    law = {"impact.law": "lankarani-nikravesh", "impact.exponent": 1.5, "impact.stiffness": 6.8e9}
    design = jb.replace(jb.BarDrop(), law | {f"{part}.modes": count for part, count in modes.items()})
    return Structure(design, jb.BarDropScenario(), 0.3, DROP, DROP_EVEN)


STUDIES = {
    "docking": docking,
    "docking, free tip": lambda: docking(**{"probe.free_tip": True}),
    "docking in space": space,
    "slider-crank": lambda: crank(piston_pin__law="pereira"),
    "slider-crank, play in both pins": lambda: crank(piston_pin__law="pereira", crank_pin__joint="clearance"),
    "bar drop": drop,
    "bar drop, bending plate": lambda: drop(plate=5),
}
# Of each mechanism the study whose structure is changed by optional parts, and these.
ANY_PARTS = {
    "docking, any parts": ("docking", DOCKING_PARTS),
    "docking in space, any parts": ("docking in space", SPACE_PARTS),
    "slider-crank, any parts": ("slider-crank", CRANK_PARTS),
    "bar drop, any parts": ("bar drop", DROP_PARTS),
}
TITLES = (*STUDIES, *ANY_PARTS)


def studies_of(title: str, count: int, seed: int) -> list[Structure]:
    """The structures of a study: one, or of those with any parts so many random ones."""
    if title in STUDIES:
        return [STUDIES[title]()]
    base, parts = ANY_PARTS[title]
    return list(structures(STUDIES[base](), parts, count, seed))


class Measured(NamedTuple):
    """Of a run, an entry an observable that has a maximum.

    - ``code``, ``impacts``, ``steps``: its outcome; how many touchdowns and accepted steps.
    - ``reported``: its maxima; ``rounding``: below it a value is the error of its own computation, or `NEGLIGIBLE`.
    - ``history``: the largest values at accepted steps; ``extent``: by how much the largest exceeds the smallest.
    - ``energy``: the error of its balance, relative.
    """

    code: Any
    impacts: Any
    steps: Any
    reported: Any
    rounding: Any
    history: Any
    extent: Any
    energy: Any


@jax.jit
def _measured(given: Request) -> Measured:
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
    rounding = system.roundoff()
    rounding = jnp.append(jnp.max(rounding[:contacts]), rounding[contacts:])
    return Measured(
        run.code, run.impact_count, run.accepted, reported, rounding, highest, highest + lowest, run.balance.energy
    )


def measured(design: Part, scenario: Part, duration: float, rtol: float = 1e-6) -> Measured:
    """`_measured` as NumPy arrays; the names of the maxima are `names`. What the program counts as zero is rounding."""
    given = request(
        mechanism_of(design), design, scenario, duration, tolerances=(rtol, rtol), options=options_of(keep=STEPS)
    )
    run = jax.tree.map(np.asarray, _measured(jax.tree.map(lambda x: np.asarray(x, float), given)))
    zero = np.array([NEGLIGIBLE.get(unit_of(name), 0.0) for name in names(design, scenario)])
    return run._replace(rounding=np.maximum(run.rounding, zero))


def unit_of(observable: str) -> str:
    """The unit of what `NEGLIGIBLE` knows, "" of all else."""
    kind = observable.rsplit("_", 1)[-1]
    return {"force": "N", "stroke": "m", "extension": "m"}.get(kind, "")


def names(design: Part, scenario: Part) -> tuple[str, ...]:
    """The contact force and the other observables."""
    system = mechanism_of(design).system(design, scenario, 20.0)
    return ("peak_force", *system.observed[system.impact_contacts :])


def below(values: np.ndarray, others: np.ndarray, sizes: np.ndarray, rounding: np.ndarray) -> np.ndarray:
    """By how much values are below others, relative to ``sizes``; 0 where they are not, or by no more than rounding,
    and where the others do not exceed it: of such a quantity no maximum is located."""
    sizes = np.where((others > rounding) & (others - values > rounding), sizes, 0.0)
    return np.where(sizes > 0.0, np.maximum(others - values, 0.0) / np.where(sizes > 0.0, sizes, 1.0), 0.0)


def below_history(run: Measured) -> np.ndarray:
    """By how much reported maxima are below the largest values at the run's accepted steps, relative to `sizes`."""
    return below(run.reported, run.history, sizes(run.extent, run.history), run.rounding)


def sizes(extent: np.ndarray, history: np.ndarray) -> np.ndarray:
    """What a shortfall is compared with: the largest value or its range, whichever is less, but no rounding."""
    return np.clip(np.abs(history), 1e-6 * extent, extent)


def campaign(
    title: str, studies: list[Structure], count: int, seed: int, portion: Portion | None = None, first: int = 0
) -> int:
    """Run studies, ``count`` designs in all, as far as a portion goes, and print their counts; return how many runs are
    below their history or missed silently."""
    ended: collections.Counter[str] = collections.Counter()
    lists: dict[str, list[str]] = {"below its history": [], "missed": [], "missed silently": []}
    unbalanced: list[str] = []
    portion, progress = portion or Portion(), counted(True, "run")
    for case in portion.of(cases(studies, count, seed, first)):
        outcome, energy, shortfalls = _shortfalls(case.design, case.scenario, case.study.duration)
        ended[outcome.name] += 1
        if progress is not None:
            progress(case.number + 1, count)
        if outcome.failed:
            lists.setdefault("failed", []).append(case.label)
            continue
        if energy > UNBALANCED:
            unbalanced.append(f"{case.label} {energy:.1e}")
        for heading, short in shortfalls.items():
            lists[heading] += [f"{case.label} {each}" for each in short]
    counts = ", ".join(f"{n} {name}" for name, n in ended.most_common())
    print(f"{title}: {ended.total()} runs, {counts}{portion.remark}")
    for heading, short in (lists | {f"energy off by more than {UNBALANCED:g}": unbalanced}).items():
        runs = len({each.split()[0] for each in short})
        print(f"  {heading}: {runs}  {'; '.join(short[:8])}", flush=True)
    return len(lists["below its history"]) + len(lists["missed silently"])


def _shortfalls(design: Part, scenario: Part, duration: float) -> tuple[Any, float, dict[str, list[str]]]:
    """Of one run: its outcome, the error of its energy, and which maxima are short, by heading."""
    run = measured(design, scenario, duration)
    outcome = mechanism_of(design).outcomes(int(run.code))
    if outcome.failed:
        return outcome, 0.0, {}
    called = names(design, scenario)

    def over(short: np.ndarray, allowed: float) -> list[str]:
        return [f"{name} {x:.1e}" for name, x in zip(called, short, strict=True) if x > allowed]

    result = {"below its history": over(below_history(run), BELOW_HISTORY)}
    tight = measured(design, scenario, duration, TIGHT)
    if (int(tight.code), int(tight.impacts)) == (int(run.code), int(run.impacts)):
        result["missed"] = over(below(run.reported, tight.reported, run.extent, run.rounding), MISSED)
        trusted = _trusted(design, scenario, duration) if result["missed"] else None
        if trusted is not None:
            maxima, relative_to = trusted
            short = below(maxima, tight.reported, np.maximum(run.extent, relative_to), run.rounding)
            result["missed silently"] = over(short, MISSED)
    return outcome, abs(float(run.energy)), result


def _trusted(design: Part, scenario: Part, duration: float) -> tuple[np.ndarray, np.ndarray] | None:
    """The maxima that `jaxbuffer.simulate` reports, and what the trust check takes their errors relative to; None where
    it calls the run anything but trusted.

    It is a program of its own: where little decides, rounding makes other steps of it than `measured` has.
    """
    run, closer = (jb.simulate(design, scenario, duration, rtol=rtol) for rtol in (1e-6, 1e-7))
    if trust(run, closer).verdict != "trusted":
        return None
    called = names(design, scenario)
    maxima = np.array([run.peak_force, *(run.maxima[name] for name in called[1:])])
    # As `Trust.errors`: relative to a thousandth of the run's largest quantity of a unit at least.
    sizes = [(it.unit, np.nan_to_num(abs(float(it.of(run))))) for it in run.mechanism.quantities.values() if it.swept]
    return maxima, np.array(
        [max((SMALL * size for unit, size in sizes if unit == unit_of(name)), default=0.0) for name in called]
    )


def show(study: Structure, number: int, seed: int) -> None:
    """Print the numbers of one run and its maxima, reported, at accepted steps and tight."""
    design, scenario = dict(enumerate(study.drawn(number + 10_000, seed)))[number]
    for rtol in (1e-6, 1e-7, TIGHT):
        run = measured(design, scenario, study.duration, rtol)
        outcome = mechanism_of(design).outcomes(int(run.code)).name
        print(f"rtol {rtol:g}: {outcome}, {run.impacts} impacts, {run.steps} steps, energy off by {run.energy:.1e}")
        rows = zip(names(design, scenario), run.reported, run.history, run.rounding, strict=True)
        for name, value, highest, rounding in rows:
            print(f"  {name:20} reported {value:.9g}, at accepted steps {highest:.9g}, rounding {rounding:.1g}")
    print(design, scenario, sep="\n")


def main(
    mechanism: Annotated[list[str] | None, typer.Option(help=f"study (default: all): {', '.join(TITLES)}")] = None,
    runs: int = RUNS,
    structures: Annotated[int, typer.Option(help="random structures of a study with any parts")] = STRUCTURES,
    seed: int = 0,
    minutes: Annotated[float | None, typer.Option(help="stop after so long, with the counts so far")] = None,
    first: Annotated[int, typer.Option(help="go on with this run of the (first) study")] = 0,
    only: Annotated[int | None, typer.Option(help="print everything about one run of the study")] = None,
    structure: Annotated[int, typer.Option(help="of which structure that run is")] = 0,
) -> int:
    """Run what the command line asks for; the exit status."""
    titles = chosen(mechanism, TITLES, "study")
    jb.configure()
    if only is not None:
        show(studies_of(titles[0], structures, seed)[structure], only, seed + structure)
        return 0
    portion, wrong = Portion(minutes), 0
    for title in titles:
        wrong += campaign(title, studies_of(title, structures, seed), runs, seed, portion, first)
        first = 0
        if portion.stopped:
            break
    return int(wrong > 0)
