"""``PYTHONPATH=src:tests python -m verification.second_opinion.drop``: felupe's opinion on a drop onto the empty tank.

Two minutes or so: deviations from felupe's finest [%], then what a change of 2 % does to our figures [%].
"""

import jaxbuffer.programs.process

jaxbuffer.programs.process.configure(cache=None)

from verification.second_opinion import dropped_tank as drop  # noqa: E402
from verification.second_opinion.felupe_drop import dropped as dropped_by_felupe  # noqa: E402

THEIRS = ((3, 1000), (3, 500), (2, 1000))  # elements across, and steps


def line(name, found, reference):
    moved = drop.deviations(found, reference)
    print(f"{name:30s}" + "".join(f"{100.0 * x:+12.3f}" for x in moved), flush=True)


def main() -> None:
    print(f"{'':30s}" + "".join(f"{name:>12s}" for name in drop.Dropped._fields))
    reference, *others = (dropped_by_felupe(drop.case(1), drop.SCENARIO, drop.DURATION, *given) for given in THEIRS)
    print(f"{'felupe 3, 1000 steps':30s}" + "".join(f"{x:12.6g}" for x in reference), flush=True)
    for (fine, steps), found in zip(THEIRS[1:], others, strict=True):
        line(f"felupe {fine}, {steps} steps", found, reference)
    ours = {fine: drop.dropped(fine) for fine in (1, 2, 4)}
    for fine, found in ours.items():
        line(f"refinement {fine}", found, reference)
    line("refinement 2, steps halved", drop.dropped(2, rtol=2.5e-7), reference)
    line("extrapolated", drop.extrapolated(ours[2], ours[4]), reference)
    for name in (*drop.NOTICED, "support.stiffness"):
        line(f"{name} + 2 %", drop.dropped(2, drop.altered(name)), ours[2])


main()
