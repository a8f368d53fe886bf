"""Elasticities of random designs with any of the optional parts, against central differences of tight solves.

`python -m benchmarks elasticities [--mechanism NAME] [--runs N] [--structures K] [--minutes M] [--first R]`: of each
structure some numbers are drawn, those of its optional parts first; each elasticity of the mechanism's differentiated
quantities is compared with differences by another solver (explicit, rtol 1e-11), which know their own uncertainty. What
differences can't tell is counted as undecided. Elasticities over 100 are compared with a difference over a change that
moves the quantity by about a per cent; those over 1e6, of runs that change beyond recognition with any change, count as
undecided. The exit status is 1 where one is wrong though it is trusted.
"""

import collections
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer

import jaxbuffer as jb
from jaxbuffer.cluster.pool import Pool
from jaxbuffer.hybrid import ExplicitRungeKutta
from jaxbuffer.mechanisms.registry import mechanism_of
from jaxbuffer.progress import counted
from jaxbuffer.sensitivities.evidence import FLOOR, TightSolve, TightSolves, course_of, each

from .campaign import ANY_PARTS, STRUCTURES, STUDIES, studies_of
from .certificates import WRONG
from .names import chosen
from .optional_parts import Structure
from .portions import Case, Portion, cases

RUNS = 240
NUMBERS, OWN = 6, 4  # numbers of a structure, and at most so many of its optional parts
LISTED = 12
STEEP, CHAOTIC = 1e2, 1e6  # elasticities for which other differences are taken, and for which none can be
MOVED = 0.01  # of a quantity, by the change over which a steep one is differenced
POOL = Pool()


class Compared(NamedTuple):
    """Of one quantity of a run: the errors of its elasticities that differences can tell, by path; how many they can't;
    and its verdict."""

    quantity: str
    errors: dict[str, float]
    undecided: int
    verdict: str


def numbers_of(study: Structure, base: Structure, seed: int) -> tuple[str, ...]:
    """The numbers by which a structure is differentiated; those that the ``base`` lacks first."""
    rng = np.random.default_rng([seed, 53])
    paths, usual = [*study.logarithmic, *study.even], {*base.logarithmic, *base.even}
    own = rng.permutation([path for path in paths if path not in usual])[:OWN]
    rest = rng.permutation([path for path in paths if path in usual])
    return tuple(str(path) for path in (*own, *rest)[:NUMBERS])


def compared(case: Case, paths: tuple[str, ...]) -> tuple[Any, list[Compared]]:
    """The outcome of a run, and its quantities."""
    duration = case.study.duration
    result = jb.sensitivity(case.design, case.scenario, wrt=paths, duration=duration)
    run, names = result.run, result.quantities
    if run.outcome.failed:
        return run.outcome, []
    moves = np.where(result.values == 0.0, 1.0, np.abs(result.values))
    sizes = np.where(result.results == 0.0, 1.0, np.abs(result.results))
    claimed = result.gradients * moves / sizes[:, None]
    inputs = (mechanism_of(case.design), case.design, case.scenario, paths, names, duration, ExplicitRungeKutta())
    tight = TightSolves(TightSolve(*inputs, int(run.code), course_of(run)), result.values, moves, POOL)
    evidence = each(tight, claimed, sizes, np.zeros_like(claimed))
    least = np.maximum(np.abs(claimed), FLOOR)
    decided = (evidence.uncertainty / least < WRONG / 2) & (np.abs(claimed) < STEEP)
    errors = evidence.by_differences / least
    for k, j in zip(*np.nonzero((np.abs(claimed) >= STEEP) & (np.abs(claimed) < CHAOTIC)), strict=True):
        errors[k, j], uncertain = differenced_closely(tight, claimed[k, j], sizes[k], int(k), int(j))
        decided[k, j] = uncertain < WRONG / 2
    return run.outcome, [
        Compared(
            name,
            {path: float(errors[k, j]) for j, path in enumerate(paths) if decided[k, j]},
            int(np.sum(~decided[k])),
            result.certificate.verdicts[k].name,
        )
        for k, name in enumerate(names)
    ]


def differenced_closely(
    tight: TightSolves, claimed: float, size: float, quantity: int, parameter: int
) -> tuple[float, float]:
    """Return the error of one elasticity against a difference over a small change, relative, and its uncertainty: what
    half that change adds."""
    direction = np.zeros(len(tight.values))
    direction[parameter] = 1.0
    change = MOVED / abs(claimed)
    moves = [(direction, side * part * change) for part in (1.0, 0.5) for side in (1.0, -1.0)]
    further, back, near, near_back = (values[quantity] for values in tight.after(moves))
    coarse, fine = (further - back) / (2.0 * change * size), (near - near_back) / (change * size)
    best = fine + (fine - coarse) / 3.0
    return abs(best / claimed - 1.0), abs((fine - coarse) / claimed)


def shown(title: str, ended: collections.Counter[str], rows: list[tuple[str, Compared]], remark: str) -> int:
    """Print each quantity's errors; return how many elasticities are wrong though trusted."""
    print(f"{title}: {ended.total()} runs, {', '.join(f'{n} {name}' for name, n in ended.most_common())}{remark}")
    wrong = {True: [], False: []}
    for name in dict.fromkeys(one.quantity for _, one in rows):
        mine = [one for _, one in rows if one.quantity == name]
        errors = np.array([error for one in mine for error in one.errors.values()])
        quantiles = " / ".join(f"{x:.0e}" for x in np.quantile(errors, [0.5, 0.9, 0.99, 1.0])) if errors.size else "-"
        trusted = sum(one.verdict == "trusted" for one in mine)
        undecided = sum(one.undecided for one in mine)
        print(f"  {name}: median / 90 % / 99 % / worst {quantiles}; {trusted} trusted; {undecided} undecided")
    for label, one in rows:
        for path, error in one.errors.items():
            if error > WRONG:
                wrong[one.verdict == "trusted"].append(f"{label} {one.quantity} by {path} {error:.1e}")
    for trusted, listed in wrong.items():
        heading = "trusted" if trusted else "not trusted"
        print(f"  off by over {WRONG:g} and {heading}: {len(listed)}  {'; '.join(listed[:LISTED])}", flush=True)
    return len(wrong[True])


def main(
    mechanism: Annotated[list[str] | None, typer.Option(help=f"study (default: all): {', '.join(ANY_PARTS)}")] = None,
    runs: Annotated[int, typer.Option(help="of each study")] = RUNS,
    structures: Annotated[int, typer.Option(help="random structures of each study")] = STRUCTURES,
    seed: int = 0,
    minutes: Annotated[float | None, typer.Option(help="stop after so long, with the counts so far")] = None,
    first: Annotated[int, typer.Option(help="go on with this run of the (first) study")] = 0,
) -> int:
    """Compare what the command line asks for; the exit status."""
    titles = chosen(mechanism, ANY_PARTS, "study")
    jb.configure()
    portion, wrong, progress = Portion(minutes), 0, counted(True, "run")
    for title in titles:
        base, ended, rows = STUDIES[ANY_PARTS[title][0]](), collections.Counter[str](), []
        for case in portion.of(cases(studies_of(title, structures, seed), runs, seed, first)):
            outcome, quantities = compared(case, numbers_of(case.study, base, seed + case.structure))
            ended[outcome.name] += 1
            rows += [(case.label, one) for one in quantities]
            if progress is not None:
                progress(case.number + 1, runs)
        wrong += shown(title, ended, rows, portion.remark)
        first = 0
        if portion.stopped:
            break
    return int(wrong > 0)
