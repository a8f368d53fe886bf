"""Whether `jb.trust` tells which numbers are wrong: wide random designs against runs at tight tolerance.

`python -m benchmarks trust [--count N]`; 1000 of them by default, a third with a free tip. A few minutes.
"""

from collections import Counter
from collections.abc import Iterator

import jax
import numpy as np

import jaxbuffer as jb
from jaxbuffer.progress import counted
from jaxbuffer.run.trust import DOUBTFUL, changes, trust

DESIGNS = 1000
LOGARITHMIC = {  # ranges
    "buffer.k_A": (50.0, 2e4),  # N/m
    "buffer.c_A": (0.3, 200.0),  # N s/m
    "buffer.k_T": (20.0, 2e4),  # N m/rad
    "buffer.c_T": (0.05, 60.0),  # N m s/rad
    "probe.tip_mass": (0.01, 0.6),  # kg
    "scenario.approach_speed": (0.02, 0.6),  # m/s
}
LINEAR = {
    "contact.restitution": (0.3, 0.99),
    "contact.friction": (0.0, 0.7),
    "scenario.contact_distance": (0.005, 0.07),  # m
    "scenario.misalignment": (-np.radians(8.0), np.radians(8.0)),  # rad
    "scenario.passive_rate": (-np.radians(1.5), np.radians(1.5)),  # rad/s
}
TIGHT, TIGHTER = 1e-10, 1e-11
KNOWN = 1e-5  # relative: where the two tight runs differ by more, nobody knows the number


def draw(count, seed):
    """``count`` values of every number, shape (count,), by dotted path."""
    rng = np.random.default_rng(seed)
    values = {path: np.exp(rng.uniform(*np.log(ends), count)) for path, ends in LOGARITHMIC.items()}
    return values | {path: rng.uniform(*ends, count) for path, ends in LINEAR.items()}


def built(values, free_tip):
    """Design and scenario with those values."""
    drawn = {path: value for path, value in values.items() if not path.startswith("scenario.")}
    met = {path.removeprefix("scenario."): value for path, value in values.items() if path.startswith("scenario.")}
    count = len(values["buffer.k_A"])
    pair = jb.replace(jb.table2(), drawn | {"probe.free_tip": free_tip}), jb.replace(jb.Scenario(), met)
    return jax.tree.map(lambda x: np.broadcast_to(np.asarray(x, float), (count,)), pair)


def drawn(count: int) -> Iterator[tuple[jb.Design, jb.Scenario]]:
    """The first so many designs and scenarios, of which every third has a free tip; always the same."""
    values = draw(DESIGNS, 0)
    pairs = [built(values, free_tip) for free_tip in (True, False, False)]
    for number in range(count):
        yield jax.tree.map(lambda x, k=number: float(x[k]), pairs[number % 3])


def main(count: int = DESIGNS) -> int:
    jb.configure()
    verdicts, wrong, silent, unknown = Counter(), Counter(), Counter(), Counter()
    progress = counted(True, "run")
    for number, (design, scenario) in enumerate(drawn(count)):
        run, closer, *tight = (jb.simulate(design, scenario, rtol=rtol) for rtol in (1e-6, 1e-7, TIGHT, TIGHTER))
        result = trust(run, closer)
        verdicts[result.verdict] += 1
        known = changes(*tight)
        for name, error in changes(run, tight[1]).items():
            unknown[name] += known[name] > KNOWN
            wrong[name] += error > DOUBTFUL
            silent[name] += error > DOUBTFUL >= result.errors[name] and result.verdict != "ill-conditioned"
        if progress is not None:
            progress(number + 1, count)
    print(f"{count} designs: {', '.join(f'{n} {verdict}' for verdict, n in verdicts.most_common())}")
    print(f"{'quantity':20} off by > {DOUBTFUL:g}  of these silently  not known to {KNOWN:g} by tight runs")
    for name in wrong:
        print(f"{name:20} {wrong[name]:12} {silent[name]:18} {unknown[name]:16}")
    return int(any(silent.values()))
