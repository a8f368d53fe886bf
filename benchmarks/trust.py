"""Whether `jb.trust` tells which numbers are wrong: wide random designs against runs at tight tolerance.

`python -m benchmarks.trust [designs]`; 1000 of them by default, a third with a free tip, some five minutes.
"""

import sys
from collections import Counter
from collections.abc import Iterator

import numpy as np

import jaxbuffer as jb
from jaxbuffer.progress import counted
from jaxbuffer.run.trust import DOUBTFUL, SMALL, trust

DESIGNS = 1000
SEED = 7
LOGARITHMIC = {  # ranges
    "buffer.k_A": (50.0, 2e4),  # N/m
    "buffer.c_A": (0.3, 200.0),  # N s/m
    "buffer.k_T": (20.0, 2e4),  # N m/rad
    "buffer.c_T": (0.05, 60.0),  # N m s/rad
    "probe.tip_mass": (0.01, 0.6),  # kg
}
LINEAR = {"contact.restitution": (0.3, 0.99), "contact.friction": (0.0, 0.7)}
SPEED = (0.02, 0.6)  # m/s, logarithmic
MISALIGNMENT, RATE, DISTANCE = (-8.0, 8.0), (-1.5, 1.5), (0.005, 0.07)  # °, °/s, m
TIGHT, TIGHTER = 1e-10, 1e-11
KNOWN = 1e-5  # relative: where the two tight runs differ by more, nobody knows the number


def drawn(count: int) -> Iterator[tuple[jb.Design, jb.Scenario]]:
    """Designs and scenarios; always the same."""
    rng = np.random.default_rng(SEED)

    def log(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    for _ in range(count):
        free = bool(rng.uniform() < 1 / 3)
        numbers = {path: log(*ends) for path, ends in LOGARITHMIC.items()}
        numbers |= {path: float(rng.uniform(*ends)) for path, ends in LINEAR.items()}
        speed, angle, rate = log(*SPEED), np.radians(rng.uniform(*MISALIGNMENT)), np.radians(rng.uniform(*RATE))
        distance = float(rng.uniform(*DISTANCE))
        scenario = jb.Scenario(
            approach_speed=speed, misalignment=float(angle), passive_rate=float(rate), contact_distance=distance
        )
        yield jb.replace(jb.table2(), numbers | {"probe.free_tip": free}), scenario


def relative(run: jb.Run, other: jb.Run) -> dict[str, float]:
    """How far a run's quantities are from another run's, over their size as `jb.trust` has it."""
    catalogue = run.mechanism.quantities
    values = {name: float(catalogue[name].of(run)) for name in run.mechanism.swept}
    largest = {
        unit: max(abs(values[name]) for name in values if catalogue[name].unit == unit)
        for unit in {catalogue[name].unit for name in values}
    }
    sizes = {name: max(abs(value), SMALL * largest[catalogue[name].unit]) for name, value in values.items()}
    return {
        name: abs(value - float(catalogue[name].of(other))) / sizes[name] if sizes[name] else 0.0
        for name, value in values.items()
    }


def main(count: int) -> None:
    verdicts, wrong, silent, unknown = Counter(), Counter(), Counter(), Counter()
    progress = counted(True, "run")
    for number, (design, scenario) in enumerate(drawn(count)):
        run, closer, *tight = (jb.simulate(design, scenario, rtol=rtol) for rtol in (1e-6, 1e-7, TIGHT, TIGHTER))
        found = trust(run, closer)
        verdicts[found.verdict] += 1
        known = relative(*tight)
        for name, error in relative(run, tight[1]).items():
            unknown[name] += known[name] > KNOWN
            wrong[name] += error > DOUBTFUL
            silent[name] += error > DOUBTFUL >= found.errors[name] and found.verdict != "ill-conditioned"
        if progress is not None:
            progress(number + 1, count)
    print(f"{count} designs: {', '.join(f'{n} {verdict}' for verdict, n in verdicts.most_common())}")
    print(f"{'quantity':20} off by > {DOUBTFUL:g}  of these silently  not known to {KNOWN:g} by tight runs")
    for name in wrong:
        print(f"{name:20} {wrong[name]:12} {silent[name]:18} {unknown[name]:16}")
    sys.exit(1 if any(silent.values()) else 0)


if __name__ == "__main__":
    jb.configure()
    main(int(sys.argv[1]) if len(sys.argv) > 1 else DESIGNS)
