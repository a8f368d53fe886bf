"""Random designs far wider than an engineer would search: how many runs end how, and how well they keep energy.

`python -m benchmarks wide [--mechanism NAME] [--runs N] [--structures K] [--minutes M] [--first R] [--tight]`:
dockings, half of them with a free tip, dockings in space, and designs of each mechanism with any of its optional parts,
at default settings. With ``--tight`` each run's quantities are compared with those of its own solve at rtol 1e-10; what
a solve at 1e-11 changes by half as much is not known, and is counted beside what is wrong.
"""

import collections
import math
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer

import jaxbuffer as jb
from jaxbuffer.mechanisms.registry import mechanism_of
from jaxbuffer.progress import counted
from jaxbuffer.run.trust import changes

from . import campaign
from .campaign import ANY_PARTS, STRUCTURES
from .names import chosen
from .optional_parts import Ranges, Structure, structures
from .portions import Case, Portion, cases

RUNS = 1000
LISTED = 8
TIGHT, TIGHTER = 1e-10, 1e-11  # rtol
FAR = 1e-5  # relative, of a quantity from that of the tight solve
LOGARITHMIC: Ranges = {  # ranges
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
RATES = ("passive_rate_x", "passive_rate_y", "passive_rate_z", "active_rate_x")
LINEAR: Ranges = {
    "cone.half_angle": (0.4, 1.1),  # rad
    "contact.restitution": (0.3, 1.0),
    "contact.friction": (0.0, 0.6),
    "scenario.contact_distance": (0.015, 0.07),  # m
    "scenario.misalignment": (-0.15, 0.15),  # rad
    "scenario.passive_rate": (-0.02, 0.02),  # rad/s
}


SPACE = LOGARITHMIC | {"active.roll_inertia": (0.05, 100.0), "passive.roll_inertia": (0.05, 300.0)}  # kg m²
SPACE_LINEAR: Ranges = {
    **{path: ends for path, ends in LINEAR.items() if path not in ("scenario.misalignment", "scenario.passive_rate")},
    "scenario.azimuth": (-math.pi, math.pi),  # rad
    **{f"scenario.passive_{angle}": (-0.12, 0.12) for angle in ("yaw", "pitch")},
    **{f"scenario.{rate}": (-0.02, 0.02) for rate in RATES},
}


def docking(**changes: Any) -> Structure:
    """A docking of 8 s with wide ranges."""
    return Structure(jb.replace(jb.table2(), changes), jb.Scenario(), 8.0, LOGARITHMIC, LINEAR)


def space(**changes: Any) -> Structure:
    """A docking in space of 8 s with wide ranges."""
    return Structure(jb.replace(jb.docking3d(), changes), jb.Scenario3D(), 8.0, SPACE, SPACE_LINEAR)


STUDIES = campaign.STUDIES | {
    "docking": docking,
    "docking, free tip": lambda: docking(**{"probe.free_tip": True}),
    "docking in space": space,
}
TITLES = ("docking", "docking, free tip", "docking in space", *ANY_PARTS)


def studies_of(title: str, count: int, seed: int) -> list[Structure]:
    """The structures of a study: one, or of those with any parts so many random ones."""
    base, parts = ANY_PARTS.get(title, (title, None))
    return [STUDIES[base]()] if parts is None else list(structures(STUDIES[base](), parts, count, seed))


def shown(title: str, rows: list[tuple[Case, jb.Run]], remark: str) -> int:
    """Print how the runs ended and how well they keep energy; return how many failed."""
    ended = collections.Counter(run.outcome.name for _, run in rows)
    print(f"{title}: {len(rows)} runs, {', '.join(f'{n} {name}' for name, n in ended.most_common())}{remark}")
    failed = [(case, run) for case, run in rows if run.outcome.failed]
    solved = [(abs(float(run.balance.energy)), case, run) for case, run in rows if not run.outcome.failed]
    if solved:
        energies = np.array([energy for energy, *_ in solved])
        worst = solved[int(np.argmax(energies))][1]
        print(
            f"  energy, relative to the initial: worst {energies.max():.2g} ({worst.label}), "
            f"99 % {np.quantile(energies, 0.99):.2g}"
        )
        impacts, attempts = ([int(getattr(run, name)) for _, run in rows] for name in ("impact_count", "attempts"))
        print(f"  impacts: median {np.median(impacts):.0f}, most {max(impacts)}; attempts: most {max(attempts)}")
        print(f"  beyond a limit of the model's validity: {sum(_beyond(case, run) for _, case, run in solved)}")
    for case, run in failed[:LISTED]:
        print(f"  {run.outcome.name}: {case.label}", case.design, case.scenario, sep="\n    ", flush=True)
    return len(failed)


class Comparison(NamedTuple):
    """A run beside its tight solve: its ``label``; whether both ``agree`` on outcome and number of impacts; by how much
    the ``quantity`` that differs most does, relative; and whether tight solves ``know`` that."""

    label: str
    agree: bool
    quantity: str
    change: float
    known: bool


def compared(case: Case, run: jb.Run) -> Comparison:
    """Compare a run with its own solve at a tight tolerance."""

    def solved(rtol: float) -> jb.Run:
        return jb.simulate(case.design, case.scenario, case.study.duration, rtol=rtol)

    tight = solved(TIGHT)
    if tight.outcome.failed:
        return Comparison(case.label, False, tight.outcome.name, math.inf, True)
    agree = (tight.outcome, int(tight.impact_count)) == (run.outcome, int(run.impact_count))
    quantity, change = max(changes(run, tight).items(), key=lambda item: item[1])
    known = change <= FAR or changes(tight, solved(TIGHTER))[quantity] < 0.5 * change
    return Comparison(case.label, agree, quantity, change, known)


def show_comparisons(rows: list[Comparison]) -> int:
    """Print how far runs are from their tight solves; return how many are far from one that is known."""
    sizes = np.array([row.change for row in rows])
    quantiles = " / ".join(f"{x:.0e}" for x in np.quantile(sizes, [0.5, 0.9, 0.99, 1.0]))
    print(f"  against rtol {TIGHT:g}, the quantity farthest off: median / 90 % / 99 % / worst {quantiles}")
    far = [row for row in rows if row.change > FAR]
    for heading, listed in (
        ("another outcome or number of impacts", [row for row in rows if not row.agree]),
        (f"off by over {FAR:g}", [row for row in far if row.known]),
        (f"off by over {FAR:g}, which tight solves do not know", [row for row in far if not row.known]),
    ):
        words = [f"{row.label} {row.quantity} {row.change:.1e}" for row in sorted(listed, key=lambda row: -row.change)]
        print(f"  {heading}: {len(listed)}  {'; '.join(words[:LISTED])}", flush=True)
    return sum(row.known for row in far)


def _beyond(case: Case, run: jb.Run) -> bool:
    """Whether a run exceeds a limit that the mechanism's summaries warn of."""
    mechanism = mechanism_of(case.design)
    limits = mechanism.view.validity(case.design, {name: run.quantity(name) for name in mechanism.swept})
    return any(np.any(limit.passed) for limit in limits)


def main(
    mechanism: Annotated[list[str] | None, typer.Option(help=f"study (default: all): {', '.join(TITLES)}")] = None,
    runs: Annotated[int, typer.Option(help="of each study")] = RUNS,
    structures: Annotated[int, typer.Option(help="random structures of a study with any parts")] = STRUCTURES,
    seed: int = 0,
    minutes: Annotated[float | None, typer.Option(help="stop after so long, with the counts so far")] = None,
    first: Annotated[int, typer.Option(help="go on with this run of the (first) study")] = 0,
    tight: Annotated[bool, typer.Option("--tight", help="compare each run with a tight solve")] = False,
) -> int:
    """Print how the runs ended; the exit status."""
    titles = chosen(mechanism, TITLES, "study")
    jb.configure()
    portion, failed, progress = Portion(minutes), 0, counted(True, "run")
    for title in titles:
        rows, comparisons = [], list[Comparison]()
        for case in portion.of(cases(studies_of(title, structures, seed), runs, seed, first)):
            rows.append((case, jb.simulate(case.design, case.scenario, case.study.duration)))
            if tight and not rows[-1][1].outcome.failed:
                comparisons.append(compared(*rows[-1]))
            if progress is not None:
                progress(case.number + 1, runs)
        failed += shown(title, rows, portion.remark)
        failed += show_comparisons(comparisons) if comparisons else 0
        first = 0
        if portion.stopped:
            break
    return int(failed > 0)
